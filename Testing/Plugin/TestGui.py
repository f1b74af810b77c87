"""The plugin in the real GUI: menus, Apply, the representation's combo box, the panel, the colour map editor.

TestGui.py <paraview> <folder for screenshots> <folder with mandelbulb.p8est>

Screenshots of the whole display are PICTURES for the clicks of gui.xml, SESSION for those of session.xml.
"""

import itertools
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import numpy as np
from paraview import simple
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

import scene

PARAVIEW, FOLDER, DATA = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
SESSION_FOLDER = FOLDER / "session"
PICTURES = ["volume.png", "colours.png", "isosurface.png", "swept.png", "completed.png", "rendered.png",
            "dragged.png"]
BLEND_MODES = ["maximum.png", "minimum.png", "average.png", "additive.png", "isosurface.png", "slice.png"]
SESSION = ["surface.png", "volume.png", "viridis.png", "shaded.png", "shadows.png", *BLEND_MODES, "composite.png", "cropped.png",
           "undone.png", "redone.png", "empty.png", "loaded.png",
           "clipped.png", "clipped-isosurface.png"]
TELL_DISTANCE = f"""
from paraview.simple import *
import treeamr.vtkTreeAMRRendering

display, view = GetDisplayProperties(), GetActiveView()

def tell_distance():
    "Of the last frame, in pixels between rays: 1 of a full picture, more of a draft."
    props = view.GetRenderer().GetViewProps()
    props = [props.GetItemAsObject(i) for i in range(props.GetNumberOfItems())]
    mapper = next(p.GetMapper() for p in props if p.IsA("vtkTreeAMRIsosurfaceActor"))
    with open({str(FOLDER / "distances")!r}, "a", encoding="utf-8") as file:
        print(mapper.GetLastImageSampleDistance(), file=file)
"""
END = """
import sys
from paraview.simple import *

{}
Render()
sys.exit(0)
"""
SCREENSHOT = """
import os
import subprocess

picture = next(p for p in {} if not os.path.exists(p))
subprocess.run(['import', '-window', 'root', picture], check=True)
"""
# Run by ParaView itself, so that nothing moves on meanwhile.
MACROS = {
    "screenshot": SCREENSHOT.format([str(FOLDER / p) for p in PICTURES]),
    "sweep": TELL_DISTANCE + f"""
display.InteractiveRenderTime = 1e-9  # as few rays as allowed
Render()
tell_distance()
display.FirstIsovalue += 0.1
Render()
tell_distance()
display.FirstIsovalue += 0.1
SaveScreenshot({str(FOLDER / "captured.png")!r}, view)
tell_distance()
display.FirstIsovalue += 0.1
Render()
SaveScreenshot({str(FOLDER / "captured.png")!r}, view)
""",
    "render": TELL_DISTANCE + """
tell_distance()
Render()
""",
    "drag": """
from paraview.simple import *

display = GetDisplayProperties()
display.GetProperty("FirstIsovalue").SMProperty.SetUncheckedElement(0, display.FirstIsovalue - 0.3)
""",
    "leave": """
from paraview.simple import *

GetDisplayProperties().FirstIsovalue -= 0.1
Render()
Delete(GetActiveSource())
""",
}
SESSION_MACROS = {
    "screenshot": SCREENSHOT.format([str(SESSION_FOLDER / p) for p in SESSION]),
    "trace": f"""
from paraview import smtrace
from paraview.modules.vtkRemotingServerManager import vtkSMTrace
from paraview.simple import *

if vtkSMTrace.GetActiveTracer() is None:
    smtrace.start_trace()
else:
    with open({str(SESSION_FOLDER / "trace.py")!r}, "w", encoding="utf-8") as file:
        file.write(smtrace.stop_trace())
    SaveScreenshot({str(SESSION_FOLDER / "traced.png")!r}, GetActiveView())
""",
}


def pixels(name):
    reader = vtkPNGReader()
    reader.SetFileName(str(FOLDER / name))
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())[:, :3].astype(int).T


def inside_view(name):
    return pixels(name).reshape(3, 1200, 1600)[:, 640:840, 430:630]


def count(name, condition):
    red, green, blue = pixels(name)
    return condition(red, green, blue).sum()


def is_red(red, green, blue):
    return (red > 140) & (green < 90) & (blue < 100)


def is_green(red, green, blue):
    """As Viridis is, and no pale yellow between blue and red."""
    return (green > 130) & (green > red) & (blue < 0.7 * green)


def run_paraview(folder, *arguments):
    return subprocess.run(
        [PARAVIEW, "--dr", *arguments],
        env=os.environ | {"HOME": str(folder / "home"), "XDG_RUNTIME_DIR": str(folder / "run")},
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def play(clicks, folder, macros):
    shutil.rmtree(folder, ignore_errors=True)
    # From 5.13 on they are looked for beside the test directory, from 6.1 on in it.
    for macro_folder in folder / "home" / ".config" / "ParaView" / "Macros", folder / "Macros", folder / "test" / "Macros":
        macro_folder.mkdir(parents=True)
        for name, text in macros.items():
            (macro_folder / f"{name}.py").write_text(text, encoding="utf-8")
    (folder / "run").mkdir(mode=0o700)
    script = (pathlib.Path(__file__).parent / clicks).read_text(encoding="utf-8")
    script = script.replace("Viridis (matplotlib)", scene.VIRIDIS)
    if scene.PARAVIEW >= (6, 1):
        script = script.replace(
            "InteractiveBox/scaleX", "InteractiveBox/tabWidget/qt_tabwidget_stackedwidget/fieldsPage/scaleX")
    (folder / clicks).write_text(script, encoding="utf-8")
    done = run_paraview(folder, f"--test-directory={folder / 'test'}", f"--data-directory={DATA}",
                        f"--test-script={folder / clicks}", "--exit")
    print(done.stdout, done.stderr)
    return done


class TestGui(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.done = play("gui.xml", FOLDER, MACROS)

    def test_ends_without_an_error(self):
        self.assertEqual(0, self.done.returncode)
        self.assertNotRegex(self.done.stderr, r"ERR\||WARN\||critical:")
        self.assertNotIn("critical:", self.done.stdout)

    def test_colours_follow_the_colour_map_editor(self):
        """From the default map, blue to red, to Viridis, violet to green and yellow."""
        red = [count(picture, is_red) for picture in ("volume.png", "colours.png")]
        green = [count(picture, is_green) for picture in ("volume.png", "colours.png")]
        self.assertGreater(red[0], 2500)
        self.assertLess(red[1], 0.1 * red[0])
        self.assertGreater(green[1], 5 * green[0])

    def test_isosurface_replaces_the_volume(self):
        volume, isosurface = pixels("colours.png"), pixels("isosurface.png")
        self.assertGreater((volume != isosurface).any(axis=0).sum(), 20000)

    def test_slider_sweeps_the_isosurface(self):
        before, after = pixels("isosurface.png"), pixels("swept.png")
        self.assertGreater((before != after).any(axis=0).sum(), 20000)

    def test_still_frames_of_other_isovalues_are_drafts_that_are_completed(self):
        """But not captured pictures."""
        before, draft, captured, completed = map(float, (FOLDER / "distances").read_text(encoding="utf-8").split())
        self.assertGreater(draft, 1)
        self.assertEqual([1, 1, 1], [before, captured, completed])
        swept, shown, rendered = (inside_view(p) for p in ("swept.png", "completed.png", "rendered.png"))
        self.assertGreater((swept != shown).any(axis=0).mean(), 0.2)
        self.assertTrue((shown == rendered).all())

    def test_slider_is_followed_while_it_is_dragged(self):
        rendered, dragged = inside_view("rendered.png"), inside_view("dragged.png")
        self.assertGreater((rendered != dragged).any(axis=0).mean(), 0.2)

    def test_scripts_may_end_the_program(self):
        """What is shown then outlives the libraries that drew it. ParaView 5.13 stops in its own when it shows anything."""
        script = FOLDER / "ends.py"
        ends = []
        for shows in 'Show(TreeAMRExample()).SetRepresentationType("Tree AMR Isosurface")', "Show(Sphere())":
            script.write_text(END.format(shows), encoding="utf-8")
            ends.append(run_paraview(FOLDER, f"--script={script}"))
        self.assertEqual(ends[1].returncode, ends[0].returncode, ends[0].stderr)
        self.assertNotIn("TreeAMR", ends[0].stderr)


def left_and_right(name):
    """Of the volume, what the message window does not hide of it."""
    first, last = (358, 750) if scene.PARAVIEW >= (6, 1) else (310, 740)
    view = pixels(f"session/{name}").reshape(3, 1200, 1600)[:, 720:980, first:last]
    return np.split(view, 2, axis=2)


def differ(first, second):
    """The share of pixels."""
    return (first != second).any(axis=0).mean()


class TestSession(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.done = play("session.xml", SESSION_FOLDER, SESSION_MACROS)
        cls.views = {name: np.concatenate(left_and_right(name), axis=2) for name in SESSION}

    def test_ends_with_the_messages_of_paraview_alone(self):
        """Which offers every grid to representations that take no hyper tree grid, at undo and when a state is loaded."""
        self.assertEqual(0, self.done.returncode)
        messages = re.findall(r"(?:ERR|WARN)\|.*", self.done.stderr)
        own = r"vtk(PolarAxes|PointGaussian|DataLabel)Representation .* vtkHyperTreeGrid, but a vtkDataSet is required"
        self.assertEqual([], [message for message in messages if not re.search(own, message)])

    def test_each_choice_is_seen(self):
        """The representation, the preset, light, shadows."""
        for before, after in itertools.pairwise(SESSION[:5]):
            self.assertGreater(differ(self.views[before], self.views[after]), 0.2, after)

    def test_each_blend_mode_is_its_own(self):
        for first, second in itertools.combinations(["shaded.png", *BLEND_MODES], 2):
            self.assertGreater(differ(self.views[first], self.views[second]), 0.1, f"{first} {second}")
        self.assertEqual(0, differ(self.views["shaded.png"], self.views["composite.png"]))

    def test_cropping_leaves_nothing_of_a_half(self):
        kept, cut = left_and_right("cropped.png")
        background = left_and_right("empty.png")
        self.assertGreater(differ(kept, background[0]), 0.3)
        self.assertLess(differ(cut, background[1]), 0.05)

    def test_clip_leaves_one_half(self):
        """Whole cells, a few of which reach across."""
        background = left_and_right("empty.png")
        for name in ("clipped.png", "clipped-isosurface.png"):
            cut, kept = left_and_right(name)
            self.assertGreater(differ(kept, background[1]), 0.2, name)
            self.assertLess(differ(cut, background[0]), 0.2, name)

    def test_undo_redo_and_state_give_the_same_pictures(self):
        for name in ("undone.png", "loaded.png"):
            self.assertEqual(0, differ(self.views["cropped.png"], self.views[name]), name)
        self.assertEqual(0, differ(self.views["composite.png"], self.views["redone.png"]))

    def test_trace_draws_what_was_traced(self):
        exec((SESSION_FOLDER / "trace.py").read_text(encoding="utf-8"), {})
        simple.SaveScreenshot(str(SESSION_FOLDER / "replayed.png"), simple.GetActiveView())
        off = np.abs(pixels("session/traced.png") - pixels("session/replayed.png"))
        self.assertLess((off > 2).any(axis=0).mean(), 0.002)


if __name__ == "__main__":
    scene.main()
