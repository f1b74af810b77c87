"""The source and the filter of the plugin, through ParaView's server manager."""

import os
import sys

import numpy as np
from paraview import servermanager, simple, smstate
from paraview.vtk.util.numpy_support import vtk_to_numpy

import scene
import treeamr
from treeamr.vtkTreeAMRReader import vtkTreeAMRExampleSource

FOREST = sys.argv[1]


class TestProxies(scene.TestCase):
    def test_plugin_is_loaded_from_the_path(self):
        loaded = servermanager.vtkSMProxyManager.GetProxyManager().GetPluginManager().GetLocalInformation()
        names = [loaded.GetPluginName(i) for i in range(loaded.GetNumberOfPlugins())
                 if loaded.GetPluginLoaded(i)]
        self.assertIn("TreeAMR", names)

    def test_plugin_loads_by_name(self):
        folder = os.environ["PV_PLUGIN_PATH"].split(":")[0]
        simple.LoadPlugin(os.path.join(folder, "TreeAMR", "TreeAMR.so"), remote=False, ns=globals())

    def test_example(self):
        source = simple.TreeAMRExample(Dataset="Synthetic")
        source.UpdatePipeline()
        grid = servermanager.Fetch(source)
        self.assertEqual("vtkHyperTreeGrid", grid.GetClassName())
        self.assertEqual(288, grid.GetNumberOfLeaves())
        self.assertEqual(["xyz"], source.CellData.keys())
        self.assertEqual((0, 4) * 3, source.GetDataInformation().GetBounds())

    def test_example_defaults_are_those_of_the_class(self):
        proxy, source = simple.TreeAMRExample(), vtkTreeAMRExampleSource()
        self.assertEqual("Sheet", proxy.Dataset)
        self.assertEqual(source.GetDataset(), vtkTreeAMRExampleSource.SHEET)
        self.assertEqual(source.GetMinimumLevel(), proxy.MinimumLevel)
        self.assertEqual(source.GetMaximumLevel(), proxy.MaximumLevel)
        self.assertEqual(source.GetRefinementThreshold(), proxy.RefinementThreshold)

    def test_example_levels(self):
        source = simple.TreeAMRExample(MinimumLevel=2, MaximumLevel=2)
        source.UpdatePipeline()
        self.assertEqual(8 ** 2, servermanager.Fetch(source).GetNumberOfLeaves())

    def test_p4est_reader(self):
        """A forest that libp4est has saved, opened by its name, is the example of the same levels."""
        example = simple.TreeAMRExample(Dataset="Mandelbulb", MinimumLevel=2, MaximumLevel=4)
        for reader in (simple.OpenDataFile(FOREST), simple.TreeAMRP4estReader(FileName=FOREST)):
            self.assertEqual("TreeAMRP4estReader", reader.GetXMLName())
            reader.Payload = "double bulb"
            reader.GenerateLevel = 1
            reader.UpdatePipeline()
            self.assertEqual({"bulb", "level", "treeid"}, set(reader.CellData.keys()))
            grid, expected = servermanager.Fetch(reader), servermanager.Fetch(example)
            self.assertEqual(expected.GetNumberOfLeaves(), grid.GetNumberOfLeaves())
            self.assertEqual(expected.GetCellData().GetArray("mandelbulb").GetRange(),
                             grid.GetCellData().GetArray("bulb").GetRange())

    def test_states_keep_all_arrays_off(self):
        """Python states give an empty list before the payload whose arrays it means."""
        for payload in ("double bulb", "float low; float high"):
            for suffix in ("pvsm", "py"):
                with self.subTest(payload=payload, suffix=suffix):
                    simple.ResetSession()
                    reader = simple.TreeAMRP4estReader(FileName=FOREST, Payload=payload, GenerateLevel=1)
                    reader.UpdatePipeline()
                    full = simple.TreeAMRP4estReader(FileName=FOREST, Payload="double bulb", GenerateLevel=1)
                    full.UpdatePipeline()
                    contour = simple.TreeAMRContour(Input=full, ContourBy=["CELLS", "bulb"])
                    reader.CellArrayStatus = contour.CellDataArrays = []
                    reader.UpdatePipeline()
                    if suffix == "pvsm":
                        path = FOREST + "-state.pvsm"
                        simple.SaveState(path)
                        simple.ResetSession()
                        simple.LoadState(path)
                    else:
                        state = smstate.get_state()
                        simple.ResetSession()
                        exec(compile(state, "state", "exec"), {})
                    sources = list(simple.GetSources().values())
                    (contour,) = [source for source in sources if source.GetXMLName() == "TreeAMRContour"]
                    contour.UpdatePipeline()
                    self.assertEqual({"bulb", "Normals"}, set(contour.PointData.keys()))
                    (reader,) = [source for source in sources if source not in (contour, contour.Input)]
                    reader.UpdatePipeline()
                    self.assertEqual(payload, reader.Payload)
                    self.assertEqual([], list(reader.CellArrayStatus))
                    self.assertEqual([], reader.CellData.keys())

    def test_probe(self):
        grid = simple.TreeAMRExample(Dataset="Synthetic")
        points = simple.Line(Point1=[1.0, 1.2, 0.9], Point2=[3.0, 2.8, 3.1], Resolution=100)
        probe = simple.TreeAMRProbe(Input=points, Source=grid, ComputeGradients=1)
        self.assertEqual("GTI", probe.InterpolationMethod)
        result = servermanager.Fetch(probe)
        x, y, z = vtk_to_numpy(result.GetPoints().GetData()).astype(float).T
        values = vtk_to_numpy(result.GetPointData().GetArray("xyz"))
        # GTI reproduces trilinear fields, here x y z with values up to 64, away from the edge of the domain.
        self.assertLess(abs(values - x * y * z).max(), 64e-6)
        gradients = vtk_to_numpy(result.GetPointData().GetArray("xyz_gradient"))
        self.assertLess(abs(gradients[:, 2] - x * y).max(), 64e-5)
        self.assertTrue(vtk_to_numpy(result.GetPointData().GetArray("vtkValidPointMask")).all())

    def test_probe_methods(self):
        grid = simple.TreeAMRExample(Dataset="Synthetic")
        points = simple.Line(Point1=[0.6, 0.6, 0.6], Point2=[0.6, 0.6, 0.6], Resolution=1)
        probe = simple.TreeAMRProbe(Input=points, Source=grid)
        self.assertEqual(["Nearest", "Current", "Finest", "Octant", "GTI"],
                         list(probe.GetProperty("InterpolationMethod").Available))
        probe.InterpolationMethod = "Nearest"
        self.assertEqual(0.125, servermanager.Fetch(probe).GetPointData().GetArray("xyz").GetValue(0))
        probe.InterpolationMethod = "GTI"
        value = servermanager.Fetch(probe).GetPointData().GetArray("xyz").GetValue(0)
        self.assertAlmostEqual(0.216, value, delta=64e-6)

    def test_filters_take_the_chosen_arrays(self):
        forest = simple.TreeAMRP4estReader(FileName=FOREST, Payload="double bulb", GenerateLevel=1)
        forest.UpdatePipeline()
        probe = simple.TreeAMRProbe(Input=simple.PointSource(), Source=forest)
        contour = simple.TreeAMRContour(Input=forest, ContourBy=["CELLS", "bulb"])
        for proxy, own in ((probe, {"vtkValidPointMask"}), (contour, {"bulb", "Normals"})):
            self.assertEqual({"bulb", "level", "treeid"}, set(proxy.CellDataArrays))
            proxy.UpdatePipeline()
            self.assertEqual({"bulb", "level", "treeid"} | own, set(proxy.PointData.keys()))
            proxy.CellDataArrays = ["level"]
            proxy.UpdatePipeline()
            self.assertEqual({"level"} | own, set(proxy.PointData.keys()))
        contour.CellDataArrays = []
        contour.UpdatePipeline()
        self.assertEqual({"bulb", "Normals"}, set(contour.PointData.keys()))

    def test_contour(self):
        grid = simple.TreeAMRExample(Dataset="Synthetic")
        contour = simple.TreeAMRContour(Input=grid, ContourBy=["CELLS", "xyz"], Isosurfaces=[8.0, 20.0])
        result = servermanager.Fetch(contour)
        scalars = vtk_to_numpy(result.GetPointData().GetScalars())
        self.assertEqual({8.0, 20.0}, set(scalars))
        points = vtk_to_numpy(result.GetPoints().GetData())
        inner = (points > 0.51).all(axis=1) & (points < 3.49).all(axis=1)
        self.assertGreater(inner.sum(), 100)
        self.assertLess(abs(points.prod(axis=1) - scalars)[inner].max(), 64e-6)
        normals = vtk_to_numpy(result.GetPointData().GetNormals())
        gradients = points.prod(axis=1)[:, None] / points
        expected = -gradients / (gradients ** 2).sum(axis=1)[:, None] ** 0.5
        self.assertLess(abs(normals - expected)[inner].max(), 1e-4)
        contour.ComputeGradients, contour.ComputeNormals, contour.ComputeScalars = 1, 0, 0
        result = servermanager.Fetch(contour)
        self.assertEqual(1, result.GetPointData().GetNumberOfArrays())
        self.assertEqual("Gradients", result.GetPointData().GetArrayName(0))

    def test_contour_defaults(self):
        grid = simple.TreeAMRExample(Dataset="Synthetic")
        grid.UpdatePipeline()
        contour = simple.TreeAMRContour(Input=grid)
        self.assertEqual(["CELLS", "xyz"], list(contour.ContourBy))
        self.assertEqual(1, len(contour.Isosurfaces))
        self.assertEqual((1, 0, 1), (contour.ComputeNormals, contour.ComputeGradients, contour.ComputeScalars))

    def test_contour_of_an_input_that_is_not_up_to_date(self):
        contour = simple.TreeAMRContour(Input=simple.TreeAMRExample(Dataset="Synthetic"), Isosurfaces=[8.0])
        self.assertEqual("", contour.ContourBy[1])
        contour.UpdatePipeline()
        self.assertEqual({"xyz", "Normals"}, set(contour.PointData.keys()))
        self.assertGreater(contour.GetDataInformation().GetNumberOfPoints(), 100)

    def test_contour_of_a_component(self):
        """Planes of x, of y, and a sphere, of the points themselves."""
        ijk = np.stack(np.meshgrid(*3 * [np.arange(16)], indexing="ij"), axis=-1).reshape(-1, 3)
        places = 2 * (ijk + 0.5) / 16 - 1
        source = simple.TrivialProducer()
        source.GetClientSideObject().SetOutput(
            treeamr.from_cells(4, ijk, {"places": places}, origin=(-1, -1, -1), spacing=2))
        contour = simple.TreeAMRContour(Input=source, ContourBy=["CELLS", "places"], Isosurfaces=[0.5])
        for component, of_points in enumerate([
                lambda p: p[:, 0], lambda p: p[:, 1], lambda p: p[:, 2], lambda p: np.linalg.norm(p, axis=1)]):
            contour.Component = component
            points = vtk_to_numpy(servermanager.Fetch(contour).GetPoints().GetData())
            self.assertGreater(len(points), 100)
            np.testing.assert_allclose(of_points(points), 0.5, atol=0.01)


if __name__ == "__main__":
    scene.main()
