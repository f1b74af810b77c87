"""The plugin in the real GUI: menus, Apply, the representation's combo box, the panel, the colour map editor.

TestGui.py <paraview> <folder for screenshots>

Screenshots of the whole display are volume.png, colours.png, isosurface.png, swept.png, completed.png, rendered.png
and dragged.png.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import unittest

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

PARAVIEW, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
PICTURES = ["volume.png", "colours.png", "isosurface.png", "swept.png", "completed.png", "rendered.png",
            "dragged.png"]
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

Show(TreeAMRExample()).SetRepresentationType("Tree AMR Isosurface")
Render()
sys.exit(0)
"""
# Run by ParaView itself, so that nothing moves on meanwhile.
MACROS = {
    "screenshot": f"""
import os
import subprocess

picture = next(p for p in {[str(FOLDER / p) for p in PICTURES]} if not os.path.exists(p))
subprocess.run(['import', '-window', 'root', picture], check=True)
""",
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


def is_yellow_or_green(red, green, blue):
    return (green > 130) & (green > blue + 40) & (green > 0.8 * red)


class TestGui(unittest.TestCase):
    @staticmethod
    def run_paraview(*arguments):
        return subprocess.run(
            [PARAVIEW, "--dr", *arguments],
            env=os.environ | {"HOME": str(FOLDER / "home"), "XDG_RUNTIME_DIR": str(FOLDER / "run")},
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(FOLDER, ignore_errors=True)
        macros = FOLDER / "home" / ".config" / "ParaView" / "Macros"
        macros.mkdir(parents=True)
        for name, text in MACROS.items():
            (macros / f"{name}.py").write_text(text, encoding="utf-8")
        (FOLDER / "run").mkdir(mode=0o700)
        script = pathlib.Path(__file__).parent / "gui.xml"
        cls.done = cls.run_paraview(f"--test-directory={FOLDER}", f"--test-script={script}", "--exit")
        print(cls.done.stdout, cls.done.stderr)

    def test_ends_without_an_error(self):
        self.assertEqual(0, self.done.returncode)
        self.assertNotRegex(self.done.stderr, r"ERR\||WARN\||critical:")
        self.assertNotIn("critical:", self.done.stdout)

    def test_colours_follow_the_colour_map_editor(self):
        """From the default map, blue to red, to Viridis, violet to yellow."""
        red = [count(picture, is_red) for picture in ("volume.png", "colours.png")]
        yellow = [count(picture, is_yellow_or_green) for picture in ("volume.png", "colours.png")]
        self.assertGreater(red[0], 5000)
        self.assertLess(red[1], 0.1 * red[0])
        self.assertGreater(yellow[1], 5 * yellow[0])

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
        """What is shown then outlives the libraries that drew it."""
        script = FOLDER / "ends.py"
        script.write_text(END, encoding="utf-8")
        done = self.run_paraview(f"--script={script}")
        self.assertEqual(0, done.returncode, done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
