"""The plugin in the real GUI: menus, Apply, the representation's combo box, the panel, the colour map editor.

TestGui.py <paraview> <folder for screenshots>

Screenshots of the whole window are volume.png, colours.png, isosurface.png and swept.png.
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
PICTURES = ["volume.png", "colours.png", "isosurface.png", "swept.png"]
# Run by ParaView itself, so that nothing moves on meanwhile.
MACRO = f"""
import os
import subprocess

picture = next(p for p in {[str(FOLDER / p) for p in PICTURES]} if not os.path.exists(p))
subprocess.run(['import', '-window', 'root', picture], check=True)
"""


def pixels(name):
    reader = vtkPNGReader()
    reader.SetFileName(str(FOLDER / name))
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())[:, :3].astype(int).T


def count(name, condition):
    red, green, blue = pixels(name)
    return condition(red, green, blue).sum()


def is_red(red, green, blue):
    return (red > 140) & (green < 90) & (blue < 100)


def is_yellow_or_green(red, green, blue):
    return (green > 130) & (green > blue + 40) & (green > 0.8 * red)


class TestGui(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(FOLDER, ignore_errors=True)
        macros = FOLDER / "home" / ".config" / "ParaView" / "Macros"
        macros.mkdir(parents=True)
        (macros / "screenshot.py").write_text(MACRO, encoding="utf-8")
        run = FOLDER / "run"
        run.mkdir(mode=0o700)
        script = pathlib.Path(__file__).parent / "gui.xml"
        cls.done = subprocess.run(
            [PARAVIEW, "--dr", f"--test-directory={FOLDER}", f"--test-script={script}", "--exit"],
            env=os.environ | {"HOME": str(FOLDER / "home"), "XDG_RUNTIME_DIR": str(run)},
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
