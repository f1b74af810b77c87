"""Forest files as time series, the choice of arrays, and what a forest looks like when it is shown.

TestSeries.py <treeamr-demo-forest> <folder>   a series of forests, and 100 steps of them in the same memory
TestSeries.py <folder>                         run by pvbatch, on one rank or more, after the other: errors of a
                                               file are told, and the others are drawn
"""

import json
import os
import subprocess
import sys

from paraview import servermanager, simple

import scene

FOLDER = sys.argv[-1]
LEVELS = (2, 3, 6)
FILES = [os.path.join(FOLDER, f"series_{level}.p8est") for level in LEVELS]
CELLS = [64, 470, 59228]  # as treeamr-demo-forest says
KINDS = ("Surface", "Tree AMR Volume", "Tree AMR Isosurface")

# As it was saved when the reader took one file.
OLD_STATE = """<ParaView><ServerManagerState version="5.11.0">
  <Proxy group="sources" type="TreeAMRP4estReader" id="1000" servers="1">
    <Property name="FileName" id="1000.FileName" number_of_elements="1">
      <Element index="0" value="{}"/>
    </Property>
    <Property name="GenerateLevel" id="1000.GenerateLevel" number_of_elements="1">
      <Element index="0" value="1"/>
    </Property>
    <Property name="Payload" id="1000.Payload" number_of_elements="1">
      <Element index="0" value="float a; float b"/>
    </Property>
  </Proxy>
  <ProxyCollection name="sources"><Item id="1000" name="Forest"/></ProxyCollection>
</ServerManagerState></ParaView>"""


def leaves(reader, time=None):
    reader.UpdatePipeline(time) if time is not None else reader.UpdatePipeline()
    return servermanager.Fetch(reader).GetNumberOfLeaves()


class TestSeries(scene.TestCase):
    @classmethod
    def setUpClass(cls):
        for level, path in zip(LEVELS, FILES):
            subprocess.run([sys.argv[1], path, "2", str(level), "0.05"], check=True)

    def expect_series(self, reader, times):
        self.assertEqual("TreeAMRP4estReader", reader.GetXMLName())
        reader.Payload = "double bulb"
        reader.UpdatePipelineInformation()
        self.assertEqual(times, list(reader.TimestepValues))
        self.assertEqual(CELLS, [leaves(reader, time) for time in times])
        self.assertEqual(CELLS[1], leaves(reader, times[1]))
        self.assertEqual(times[1], reader.GetDataInformation().DataInformation.GetTime())

    def test_list_of_files(self):
        self.expect_series(simple.OpenDataFile(FILES), [0, 1, 2])
        reader = simple.TreeAMRP4estReader(FileName=FILES)
        self.assertEqual(FILES, list(reader.FileName))
        self.expect_series(reader, [0, 1, 2])

    def test_meta_file(self):
        path = os.path.join(FOLDER, "series.p8est.series")
        times = [0.25, 2.0, 1e3]
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"file-series-version": "1.0",
                       "files": [{"name": os.path.basename(name), "time": time}
                                 for name, time in zip(FILES, times)]}, file)
        self.expect_series(simple.OpenDataFile(path), times)

    def test_one_file_has_no_time(self):
        for reader in (simple.OpenDataFile(FILES[2]), simple.TreeAMRP4estReader(FileName=FILES[2])):
            reader.Payload = "double bulb"
            self.assertEqual(CELLS[2], leaves(reader))
            self.assertEqual([], list(reader.TimestepValues))
        reader.FileName = FILES
        self.expect_series(reader, [0, 1, 2])
        reader.FileName = FILES[1]
        self.assertEqual(CELLS[1], leaves(reader))

    def test_animation_in_the_same_memory(self):
        reader = simple.TreeAMRP4estReader(FileName=FILES * 34, Payload="double bulb")
        view = scene.view()
        shown = simple.Show(reader, view)
        shown.SetRepresentationType("Tree AMR Volume")
        simple.ColorBy(shown, ("CELLS", "bulb"))
        scene.look(view)
        animation = simple.GetAnimationScene()
        animation.UpdateAnimationUsingDataTimeSteps()
        self.assertEqual(102, len(animation.TimeKeeper.TimestepValues))
        pictures, resident = [], []
        animation.GoToFirst()
        for step in range(102):
            self.assertEqual(step, animation.TimeKeeper.Time)
            if step in (0, 1, 2, 99, 100, 101):
                pictures.append(scene.picture(view, f"series-{step}"))
            else:
                simple.Render(view)
            if step in (50, 101):
                resident.append(scene.resident_mib())
            animation.GoToNext()
        for first, second in ((0, 1), (1, 2)):
            self.assertGreater((pictures[first] != pictures[second]).mean(), 0.01)
        for step in range(3):
            self.assertTrue((pictures[step] == pictures[3 + step]).all())
        print("resident MiB:", resident)
        # Measured 1 to 3, where the windows of any animation do the same. The grids alone of the 17 largest steps
        # between would be 20.
        self.assertLess(resident[1] - resident[0], 8)

    def test_selected_arrays(self):
        reader = simple.TreeAMRP4estReader(FileName=FILES, Payload="float a; float b", GenerateLevel=1)
        reader.UpdatePipeline()
        self.assertEqual(["a", "b", "level", "treeid"], list(reader.CellArrayStatus))
        self.assertEqual(["a", "b", "level", "treeid"], list(reader.CellArrayStatus.Available))
        reader.CellArrayStatus = ["b", "level"]
        for time in (0, 2):
            reader.UpdatePipeline(time)
            self.assertEqual({"b", "level"}, set(reader.CellData.keys()))
        reader.CellArrayStatus = []
        reader.UpdatePipeline(1)
        self.assertEqual([], list(reader.CellData.keys()))
        # Told when nothing is known of the payload yet.
        reader = simple.TreeAMRP4estReader(FileName=FILES[0], CellArrayStatus=["b"], Payload="float a; float b")
        reader.UpdatePipeline()
        self.assertEqual(["b"], list(reader.CellData.keys()))

    def test_states(self):
        path = os.path.join(FOLDER, "series.pvsm")
        with open(path, "w", encoding="utf-8") as file:
            file.write(OLD_STATE.format(FILES[1]))
        simple.LoadState(path)
        (reader,) = simple.GetSources().values()
        self.assertEqual(CELLS[1], leaves(reader))
        self.assertEqual({"a", "b", "level", "treeid"}, set(reader.CellData.keys()))

        simple.ResetSession()
        simple.TreeAMRP4estReader(FileName=FILES, Payload="float a; float b", CellArrayStatus=["b"])
        simple.SaveState(path)
        simple.ResetSession()
        simple.LoadState(path)
        (reader,) = simple.GetSources().values()
        self.assertEqual(FILES, list(reader.FileName))
        self.assertEqual(CELLS, [leaves(reader, time) for time in (0, 1, 2)])
        self.assertEqual(["b"], list(reader.CellData.keys()))

    def test_shown_by_its_first_array(self):
        for forest in (simple.TreeAMRP4estReader(FileName=FILES[1], Payload="float a; float b"),
                       simple.TreeAMRExample(Dataset="Synthetic")):
            view = scene.view()
            shown = simple.Show(forest, view)
            self.assertEqual(["CELLS", forest.CellData.GetArray(0).Name], list(shown.ColorArrayName))
            simple.ColorBy(shown, None)
            self.assertEqual("", shown.ColorArrayName[1])


def play_with_an_error():
    spoilt = os.path.join(FOLDER, "spoilt.p8est")
    with open(FILES[1], "rb") as good, open(spoilt, "wb") as bad:
        bad.write(good.read()[:-100])
    reader = simple.TreeAMRP4estReader(FileName=[FILES[0], spoilt, FILES[2]], Payload="double bulb")
    view = scene.view()
    shown = simple.Show(reader, view)
    scene.look(view)
    animation = simple.GetAnimationScene()
    animation.UpdateAnimationUsingDataTimeSteps()
    for kind in KINDS:
        shown.SetRepresentationType(kind)
        simple.ColorBy(shown, ("CELLS", "bulb"))
        drawn = []
        for time in (0, 1, 2):
            animation.AnimationTime = time
            drawn.append(scene.drawn(scene.picture(view, f"series-error-{time}")).mean())
        print(kind, drawn)
        assert drawn[0] > 0.01 and drawn[1] == 0 and drawn[2] > 0.01


if len(sys.argv) > 2:
    scene.main()
else:
    play_with_an_error()
