"""The representation `Tree AMR Isosurface`."""

import os
import sys

import numpy
from paraview import simple

import scene
from treeamr.vtkTreeAMRRendering import vtkTreeAMRIsosurfaceMapper


class TestIsosurface(scene.TestCase):
    def setUp(self):
        super().setUp()
        self.source = simple.TreeAMRExample(Dataset="Synthetic")
        self.view = scene.view()
        self.representation = simple.Show(self.source, self.view)
        simple.ColorBy(self.representation, None)
        self.representation.SetRepresentationType("Tree AMR Isosurface")
        scene.look(self.view)

    def picture(self, name):
        return scene.picture(self.view, "isosurface-" + name)

    def test_isovalue_starts_in_the_middle(self):
        low, high = self.source.CellData["xyz"].GetRange()
        (isovalue,) = self.representation.Isovalues
        self.assertAlmostEqual((low + high) / 2, isovalue, places=5)
        self.assertTrue(scene.drawn(self.picture("middle")).any())

    def test_isovalue_outside_the_range(self):
        self.representation.Isovalues = [-1.0]
        self.assertFalse(scene.drawn(self.picture("outside")).any())

    def test_several_isovalues(self):
        self.representation.Isovalues = [30.0]
        one = scene.drawn(self.picture("one"))
        self.representation.Isovalues = [30.0, 2.0]
        two = scene.drawn(self.picture("two"))
        self.assertTrue((two | ~one).all())
        self.assertLess(one.sum(), two.sum())
        simple.ColorBy(self.representation, ("CELLS", "xyz"))
        self.representation.LookupTable.RGBPoints = [2, 0, 0, 1, 30, 1, 0, 0]
        self.representation.Diffuse, self.representation.Ambient = 0.0, 1.0
        scene.look(self.view, (-1, -1, 2))
        coloured = self.picture("coloured")
        self.assertEqual({(0, 0, 0), (0, 0, 255), (255, 0, 0)}, {tuple(p) for p in coloured.reshape(-1, 3)})
        self.representation.Isovalues = []
        self.assertFalse(scene.drawn(self.picture("none")).any())

    def test_categories(self):
        """Each point in the colour of its cell, whichever array the surface is of."""
        categories = scene.with_categories(self.source)
        simple.Hide(self.source, self.view)
        self.representation = simple.Show(categories, self.view)
        self.representation.SetRepresentationType("Tree AMR Isosurface")
        simple.ColorBy(self.representation, ("CELLS", "id"))
        scene.set_categories(self.representation.LookupTable)
        self.representation.Diffuse, self.representation.Ambient = 0.0, 1.0
        scene.look(self.view)
        ids = {(0, 0, 0), (255, 0, 0), (0, 255, 0), (0, 0, 255), (0, 255, 255), (255, 0, 255), (255, 255, 0)}
        for array, isovalue in (("xyz", 6.5), ("id", 2.5)):
            self.representation.IsosurfaceArray = ["CELLS", array]
            self.representation.Isovalues = [isovalue]
            self.assertEqual(ids, scene.colours(self.picture("categories-" + array)))
        self.representation.Isovalues = [2]
        self.assertEqual({(0, 0, 0), (0, 0, 255)}, scene.colours(self.picture("category")))

    def test_defaults_are_those_of_the_mapper(self):
        mapper = vtkTreeAMRIsosurfaceMapper()
        for name in ("AmbientOcclusionSamples", "AmbientOcclusionRadius", "Shadows"):
            self.assertEqual(getattr(mapper, "Get" + name)(), getattr(self.representation, name), name)

    def test_ambient_occlusion(self):
        """ParaView renders a still frame once: it has all samples."""
        self.representation.Isovalues = [6.5, 7.5]
        simple.Render(self.view)
        window = self.view.GetRenderWindow()
        bright = scene.shown(window)
        self.representation.AmbientOcclusionSamples = 32
        self.representation.AmbientOcclusionRadius = 0.3
        simple.Render(self.view)
        dark = scene.shown(window)
        self.assertTrue((dark <= bright).all())
        self.assertLess(dark.sum(), 0.95 * bright.sum())
        look = self.view.CameraPosition[:]
        self.view.CameraPosition = [x + 1e-3 for x in look]
        self.view.SMProxy.InteractiveRender()
        self.view.CameraPosition = look
        self.view.SMProxy.InteractiveRender()
        self.assertFalse((scene.shown(window) == dark).all())
        self.view.SMProxy.StillRender()
        self.assertTrue((scene.shown(window) == dark).all())

    def test_shadows(self):
        """Of the lower surface in the light of a lamp beyond the upper one."""
        self.representation.Isovalues = [2.0, 30.0]
        self.view.UseLight = 0
        lamp = simple.AddLight(view=self.view)
        lamp.Type, lamp.Position, lamp.FocalPoint = "Directional", [4, 4, 4], [0, 0, 0]
        scene.look(self.view, (-1, -1, 2))
        bright = self.picture("unshadowed")
        self.representation.Shadows = 1
        dark = self.picture("shadowed")
        self.assertTrue((dark <= bright).all())
        self.assertLess(dark.sum(), bright.sum())

    def test_isovalue_follows_another_array(self):
        arrays = simple.ProgrammableFilter(Input=self.source, OutputDataSetType="Same as Input", Script="""
import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
n = grid.GetNumberOfCells()
for name, values in (('big', numpy.linspace(100, 200, n)), ('v', numpy.linspace([0, 10, 0], [0, 20, 0], n))):
    array = numpy_to_vtk(values, deep=1)
    array.SetName(name)
    grid.GetCellData().AddArray(array)
""")
        simple.Hide(self.source, self.view)
        representation = simple.Show(arrays, self.view)
        representation.SetRepresentationType("Tree AMR Isosurface")
        representation.IsosurfaceArray = ["CELLS", "big"]
        self.assertAlmostEqual(150, *representation.Isovalues)
        representation.Isovalues = [120]
        representation.IsosurfaceArray = ["CELLS", "v"]
        representation.IsosurfaceComponent = "Magnitude"
        self.assertAlmostEqual(15, *representation.Isovalues)
        # The mapper finds the same values in the magnitude: the surface is there.
        self.assertTrue(scene.drawn(self.picture("magnitude")).any())
        representation.Isovalues = [11]
        representation.IsosurfaceComponent = "Y"
        self.assertEqual([11], list(representation.Isovalues))

    def test_solid_colour(self):
        self.representation.DiffuseColor = self.representation.AmbientColor = [1, 0, 0]
        image = self.picture("red")
        self.assertGreater(image[..., 0].max(), 100)
        self.assertEqual(0, image[..., 1:].max())

    def test_colours_of_the_colour_map(self):
        simple.ColorBy(self.representation, ("CELLS", "xyz"))
        scene.set_colour(self.representation.LookupTable, 0, 64, (0, 1, 0))
        green = self.picture("green")
        self.assertGreater(green[..., 1].max(), 100)
        self.assertEqual(0, green[..., ::2].max())
        scene.set_colour(self.representation.LookupTable, 0, 64, (0, 0, 1))
        blue = self.picture("blue")
        self.assertGreater(blue[..., 2].max(), 100)
        self.assertEqual(0, blue[..., :2].max())
        self.assertTrue((scene.drawn(green) == scene.drawn(blue)).all())

    def test_lighting(self):
        bright = self.picture("lit")
        self.representation.Diffuse = 0.0
        self.representation.Ambient = 0.0
        self.assertFalse(scene.drawn(self.picture("unlit")).any())
        self.representation.Ambient = 1.0
        self.representation.AmbientColor = self.representation.DiffuseColor = [1, 1, 1]
        flat = self.picture("flat")
        self.assertEqual({0, 255}, set(flat.ravel()))
        self.assertTrue((scene.drawn(flat) == scene.drawn(bright)).all())

    def test_interpolation(self):
        """The edges of coarse pieces show in flat interpolation only."""
        self.assertEqual("Gouraud", self.representation.Interpolation)
        smooth = self.picture("smooth")
        self.representation.Interpolation = "Flat"
        flat = self.picture("pieces")
        self.assertTrue((scene.drawn(flat) == scene.drawn(smooth)).all())
        steps = [abs(numpy.diff(image[..., 0].astype(int), axis=1)) for image in (smooth, flat)]
        inside = scene.drawn(smooth)[:, 1:] & scene.drawn(smooth)[:, :-1]
        self.assertLess(1.5 * steps[0][inside].max(), steps[1][inside].max())

    def test_opacity(self):
        self.representation.Ambient, self.representation.Diffuse = 1.0, 0.0
        self.representation.AmbientColor = self.representation.DiffuseColor = [1, 1, 1]
        self.representation.Opacity = 0.5
        image = self.picture("translucent")
        self.assertLess(abs(int(image.max()) - 127.5), 1)

    def test_depth(self):
        """A ball in the corner that the surface cuts off: in front of the surface or behind it."""
        self.representation.DiffuseColor = self.representation.AmbientColor = [1, 0, 0]
        ball = simple.Sphere(Center=[4, 4, 4], Radius=1, ThetaResolution=32, PhiResolution=32)
        shown = simple.Show(ball, self.view)
        shown.DiffuseColor = shown.AmbientColor = [0, 0, 1]
        for direction, hidden in (((1, 1, 1), "surface"), ((-1, -1, -1), "ball")):
            scene.look(self.view, direction)
            image = self.picture("behind-" + hidden)
            centre = image[image.shape[0] // 2, image.shape[1] // 2]
            self.assertEqual(hidden == "surface", centre[0] == 0)
            self.assertEqual(hidden == "ball", centre[2] == 0)

    def test_exporters(self):
        """They write both surfaces, as triangles in the colours of the array."""
        self.representation.Isovalues = [30.0, 2.0]
        simple.ColorBy(self.representation, ("CELLS", "xyz"))
        self.representation.LookupTable.RGBPoints = [2, 0, 0, 1, 30, 1, 0, 0]
        simple.Render(self.view)
        points, triangles = scene.contoured(
            self.source, ContourBy=["CELLS", "xyz"], Isosurfaces=[30.0, 2.0])

        def path(extension):
            return os.path.join(sys.argv[-1], "isosurface." + extension)

        def exported(extension):
            simple.ExportView(path(extension), view=self.view)
            with open(path(extension), encoding="utf-8") as file:
                return file.read()

        self.assertEqual((points, points, triangles), scene.exported(path("gltf"), self.view))
        self.assertEqual(triangles, exported("vrml").count(", -1,\n"))
        self.assertIn("<Color ", exported("x3d"))
        # In their solid colour: that of the material alone.
        simple.ColorBy(self.representation, None)
        self.representation.DiffuseColor = [0, 1, 0]
        self.assertEqual((points, 0, triangles), scene.exported(path("gltf"), self.view))
        self.assertNotIn("<Color ", exported("x3d"))
        self.assertIn("diffuseColor 0 1 0\n", exported("vrml"))
        self.representation.Visibility = 0
        self.assertEqual((0, 0, 0), scene.exported(path("gltf"), self.view))


if __name__ == "__main__":
    scene.main()
