"""Point data of finite elements through Tree AMR From Unstructured: exact, and coloured as one scalar."""

import sys

import numpy
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy

import scene

DATA = sys.argv[1]


def wave(x, y, z):
    """What Testing/Data/DealII/waves.cc wrote."""
    return 0.5 + x + 2 * y - z + 3 * x * y * z


class TestCorners(scene.TestCase):
    def setUp(self):
        super().setUp()
        self.input = simple.OpenDataFile(DATA + "/DealII/cube_0.pvtu")
        self.grid = simple.TreeAMRFromUnstructured(Input=self.input)
        self.grid.UpdatePipeline()

    def test_arrays(self):
        self.assertEqual({"wave", "level"}, set(self.grid.CellData.keys()))
        self.assertEqual(8, self.grid.CellData["wave"].GetNumberOfComponents())
        self.assertEqual("111", self.grid.CellData["wave"].GetComponentName(7))
        self.assertEqual(1, self.grid.CellData["level"].GetNumberOfComponents())
        self.grid.PointDataArrays = ["level"]
        self.grid.UpdatePipeline()
        self.assertEqual(["level"], self.grid.CellData.keys())
        self.grid.PointDataArrays = []
        self.grid.UpdatePipeline()
        self.assertEqual([], self.grid.CellData.keys())

    def test_probe(self):
        points = simple.Line(Point1=[-0.99, -0.9, -0.95], Point2=[0.97, 0.8, 0.9], Resolution=1000)
        result = servermanager.Fetch(simple.TreeAMRProbe(Input=points, Source=self.grid))
        x, y, z = vtk_to_numpy(result.GetPoints().GetData()).astype(float).T
        values = vtk_to_numpy(result.GetPointData().GetArray("wave"))
        self.assertEqual(1, values.ndim)
        self.assertLess(abs(values - wave(x, y, z)).max(), 1e-6 * 14)

    def test_probe_behind_a_threshold(self):
        """ParaView's own filters keep the mark."""
        threshold = simple.Threshold(Input=self.grid, Scalars=["CELLS", "level"], LowerThreshold=2, UpperThreshold=9)
        points = simple.Line(Point1=[-0.99, -0.9, -0.95], Point2=[0.97, 0.8, 0.9], Resolution=1000)
        result = servermanager.Fetch(simple.TreeAMRProbe(Input=points, Source=threshold))
        x, y, z = vtk_to_numpy(result.GetPoints().GetData()).astype(float).T
        values = vtk_to_numpy(result.GetPointData().GetArray("wave"))
        valid = vtk_to_numpy(result.GetPointData().GetArray("vtkValidPointMask")) == 1
        self.assertGreater(valid.sum(), 100)
        self.assertLess(abs(values - wave(x, y, z))[valid].max(), 1e-6 * 14)

    def test_contour(self):
        contour = simple.TreeAMRContour(Input=self.grid, ContourBy=["CELLS", "wave"], Isosurfaces=[1])
        result = servermanager.Fetch(contour)
        x, y, z = vtk_to_numpy(result.GetPoints().GetData()).astype(float).T
        self.assertGreater(len(x), 100)
        self.assertLess(numpy.median(abs(wave(x, y, z) - 1)), 1e-6)
        self.assertLess(abs(wave(x, y, z) - 1).max(), 1e-2)

    def test_range_is_that_of_the_values(self):
        view = scene.view()
        display = simple.Show(self.grid, view)
        simple.ColorBy(display, ("CELLS", "wave"))
        display.SetRepresentationType("Tree AMR Volume")
        display.RescaleTransferFunctionToDataRange()
        simple.Render(view)
        corners = [wave(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        points = simple.GetColorTransferFunction("wave").RGBPoints
        self.assertAlmostEqual(min(corners), points[0], 5)
        self.assertAlmostEqual(max(corners), points[-4], 5)

    def test_component_makes_no_difference(self):
        view = scene.view()
        display = simple.Show(self.grid, view)
        display.SetRepresentationType("Tree AMR Volume")
        simple.ColorBy(display, ("CELLS", "wave"))
        display.RescaleTransferFunctionToDataRange()
        scene.look(view)
        expected = scene.picture(view, "magnitude")
        self.assertGreater(expected.any(axis=2).sum(), 5000)
        colors = simple.GetColorTransferFunction("wave")
        colors.VectorMode = "Component"
        for component in (0, 5):
            colors.VectorComponent = component
            display.RescaleTransferFunctionToDataRange()
            self.assertTrue((scene.picture(view, f"component{component}") == expected).all())

    def test_pictures_are_those_of_hexahedra(self):
        """The isosurface is where ParaView's own contour of the hexahedra is, and coloured alike by position."""
        view = scene.view(480, 360)
        scene.look(view)
        pictures = {}
        for name in ("hexahedra", "isosurface", "volume"):
            for source in simple.GetSources().values():
                simple.Hide(source, view)
            if name == "hexahedra":
                contour = simple.Contour(Input=self.input, ContourBy=["POINTS", "wave"], Isosurfaces=[1])
                display = simple.Show(contour, view)
                simple.ColorBy(display, None)
                display.DiffuseColor = display.AmbientColor = [1, 0.5, 0.2]
            else:
                display = simple.Show(self.grid, view)
                display.SetRepresentationType("Tree AMR Isosurface" if name == "isosurface" else "Tree AMR Volume")
                simple.ColorBy(display, ("CELLS", "wave") if name == "volume" else None)
                display.DiffuseColor = display.AmbientColor = [1, 0.5, 0.2]
                display.IsosurfaceArray = ["CELLS", "wave"]
                display.Isovalues = [1]
                if name == "volume":
                    display.RescaleTransferFunctionToDataRange()
            scene.look(view)
            pictures[name] = scene.picture(view, name)
        covered = {name: picture.any(axis=2) for name, picture in pictures.items()}
        self.assertGreater(covered["isosurface"].sum(), 5000)
        # ParaView's triangles cut the curves of the trilinear pieces at silhouettes.
        self.assertLess((covered["isosurface"] ^ covered["hexahedra"]).mean(), 0.005)
        both = covered["isosurface"] & covered["hexahedra"]
        difference = abs(pictures["isosurface"] - pictures["hexahedra"]).max(axis=2)[both]
        self.assertLess(numpy.percentile(difference, 90), 24)
        self.assertGreater(covered["volume"].sum(), 20000)


if __name__ == "__main__":
    scene.main()
