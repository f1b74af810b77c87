"""What a representation does of its own when it is chosen: bounds, the array to colour by, isovalues."""

import numpy
from paraview import servermanager, simple

import scene

KINDS = ("Tree AMR Volume", "Tree AMR Isosurface")


def with_array(name, values):
    """A grid of n cells with one cell array; values: an expression of n that gives it."""
    return simple.ProgrammableFilter(
        Input=simple.TreeAMRExample(Dataset="Synthetic"), OutputDataSetType="Same as Input", Script=f"""
import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
n = grid.GetNumberOfCells()
array = numpy_to_vtk(numpy.ascontiguousarray({values}), deep=1)
array.SetName('{name}')
grid.GetCellData().Initialize()
grid.GetCellData().AddArray(array)
""")


def vectors():
    """A grid with vectors whose first component is 3 and whose magnitude goes from 3 to 5."""
    return with_array("v", "numpy.stack([numpy.full(n, 3.0), numpy.linspace(0, 4, n), numpy.zeros(n)], axis=1)")


class TestDisplay(scene.TestCase):
    def show(self, source):
        self.view = scene.view()
        self.representation = simple.Show(source, self.view)

    def picture(self, name):
        return scene.picture(self.view, "display-" + name)

    def test_bounds(self):
        """From Show on, and after the data have moved: the camera is where it is for the bounds alone."""
        for low, high, moved in ((100, 101, 200), (0, 1e-9, -1e-9)):
            for kind in KINDS:
                for before in (None, "Surface"):
                    with self.subTest(low=low, kind=kind, before=before):
                        simple.ResetSession()
                        source = simple.HyperTreeGridRandom(Dimensions=[3, 3, 3], OutputBounds=[low, high] * 3)
                        self.show(source)
                        self.view.AxesGrid.Visibility = 1
                        if before:
                            self.representation.SetRepresentationType(before)
                            simple.Render(self.view)
                        self.representation.SetRepresentationType(kind)
                        for corner in (low, moved):
                            width = high - low
                            source.OutputBounds = [corner, corner + width] * 3
                            simple.ResetCamera(self.view)
                            offset = numpy.array(self.view.CameraFocalPoint) - corner - 0.5 * width
                            self.assertLess(abs(offset).max(), 1e-5 * width)
                            distance = numpy.linalg.norm(
                                numpy.subtract(self.view.CameraPosition, self.view.CameraFocalPoint))
                            self.assertLess(abs(distance / width - 3.3461), 0.005)
                            self.assertGreater(scene.drawn(self.picture("bounds")).mean(), 0.1)

    def test_a_threshold_that_keeps_nothing_is_drawn_as_nothing(self):
        """Without a message."""
        source = simple.TreeAMRExample(Dataset="Synthetic")
        threshold = simple.Threshold(
            Input=source, Scalars=["CELLS", "xyz"], LowerThreshold=1, UpperThreshold=1e6)
        self.show(threshold)
        for kind in KINDS:
            with self.subTest(kind=kind):
                self.representation.SetRepresentationType(kind)
                simple.ResetCamera(self.view)
                threshold.LowerThreshold = 1e5
                self.assertFalse(scene.drawn(self.picture("nothing")).any())
                threshold.LowerThreshold = 1
                self.assertTrue(scene.drawn(self.picture("something")).any())

    def test_volume_chooses_an_array(self):
        """As ParaView's own type Volume does. The grid has no active scalars: Show leaves it uncoloured."""
        self.show(simple.HyperTreeGridRandom())
        self.assertEqual("", self.representation.ColorArrayName[1])
        self.representation.SetRepresentationType("Tree AMR Volume")
        self.assertEqual(["CELLS", "Depth"], list(self.representation.ColorArrayName))
        colours = self.representation.LookupTable.RGBPoints
        self.assertEqual([0, 5], [colours[0], colours[-4]])
        self.assertEqual([0, 5], self.representation.ScalarOpacityFunction.Points[::4])

    def test_volume_prefers_the_active_scalars(self):
        example = simple.TreeAMRExample(Dataset="Synthetic")
        arrays = simple.ProgrammableFilter(Input=example, OutputDataSetType="Same as Input", Script="""
from vtkmodules.vtkCommonCore import vtkDoubleArray
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
first = vtkDoubleArray()
first.SetName('a')
first.SetNumberOfTuples(grid.GetNumberOfCells())
first.Fill(1)
grid.GetCellData().AddArray(first)
""")
        self.show(arrays)
        simple.ColorBy(self.representation, None)
        self.representation.SetRepresentationType("Tree AMR Volume")
        self.assertEqual(["CELLS", "xyz"], list(self.representation.ColorArrayName))

    def test_volume_keeps_a_range_that_was_given(self):
        """A script that restores a state sets the colours first."""
        table = simple.GetColorTransferFunction("Depth")
        table.RGBPoints = [1, 0, 0, 1, 2, 1, 0, 0]
        table.ScalarRangeInitialized = 1
        self.show(simple.HyperTreeGridRandom())
        self.representation.Representation = "Tree AMR Volume"
        self.assertEqual(["CELLS", "Depth"], list(self.representation.ColorArrayName))
        self.assertEqual([1, 2], table.RGBPoints[::4])

    def test_colours_stay_without_an_array(self):
        self.show(simple.HyperTreeGridRandom())
        self.representation.SetRepresentationType("Tree AMR Volume")
        scene.look(self.view)
        plain = self.picture("plain")
        self.representation.LookupTable.ApplyPreset(scene.VIRIDIS, True)
        preset = self.picture("preset")
        self.assertFalse(scene.close((plain, preset)))
        simple.ColorBy(self.representation, None)
        self.assertTrue(scene.close((preset, self.picture("no-array"))))

    def test_isosurfaces_start_in_the_middle(self):
        """At once when they are switched on; what was given, or nothing, stays."""
        for name, value in (("ShowIsosurfaces", 1), ("BlendMode", "Isosurface")):
            simple.ResetSession()
            self.show(simple.HyperTreeGridRandom())
            self.representation.SetRepresentationType("Tree AMR Volume")
            scene.look(self.view)
            before = self.picture("no-isosurfaces")
            setattr(self.representation, name, value)
            self.assertEqual([2.5], list(self.representation.IsosurfaceValues))
            middle = self.picture("isosurfaces")
            self.assertTrue(scene.drawn(middle).any())
            self.assertFalse(scene.close((before, middle)))
        for given in ([], [7.0]):
            self.representation.BlendMode = "Composite"
            self.representation.IsosurfaceValues = given
            self.representation.BlendMode = "Isosurface"
            self.assertEqual(given, list(self.representation.IsosurfaceValues))

    def test_isosurfaces_of_vectors_start_in_the_middle_of_what_is_drawn(self):
        self.show(vectors())
        self.representation.SetRepresentationType("Tree AMR Volume")
        self.representation.ShowIsosurfaces = 1
        self.assertAlmostEqual(4, *self.representation.IsosurfaceValues)

    def test_infinite_values(self):
        """Isovalues start in the middle of the finite values; a NaN among them is for the mapper to refuse."""
        source = with_array(
            "f", "numpy.concatenate([[numpy.inf, -numpy.inf, numpy.nan], numpy.linspace(2, 6, n - 3)])")
        self.show(source)
        self.assertEqual(list(self.representation.Isovalues), [4])
        contour = simple.TreeAMRContour(Input=source)
        self.assertEqual(list(contour.Isosurfaces), [4])
        for name in ("Isovalues", "FirstIsovalue", "IsosurfaceValues", "FirstIsosurfaceValue"):
            setattr(self.representation, name, numpy.nan)
            self.assertTrue(numpy.isnan(numpy.atleast_1d(getattr(self.representation, name))).all())
        contour.Isosurfaces = [numpy.nan]

    def test_first_isosurface(self):
        """The slider's property and the list follow each other."""
        source = simple.HyperTreeGridRandom()
        self.show(source)
        contour = simple.TreeAMRContour(Input=source)
        for proxy, first, values in ((self.representation, "FirstIsovalue", "Isovalues"),
                                     (self.representation, "FirstIsosurfaceValue", "IsosurfaceValues"),
                                     (contour, "FirstIsosurface", "Isosurfaces")):
            with self.subTest(first=first):
                setattr(proxy, values, [1.0, 2.0, 3.0])
                self.assertEqual(1, getattr(proxy, first))
                setattr(proxy, first, 4.0)
                self.assertEqual([4, 2, 3], list(getattr(proxy, values)))
                setattr(proxy, values, [])
                self.assertEqual(4, getattr(proxy, first))
                setattr(proxy, first, 1.5)
                self.assertEqual([1.5], list(getattr(proxy, values)))
        self.assertEqual({1.5}, set(servermanager.Fetch(contour).GetPointData().GetScalars().GetRange()))

    def test_isovalues_of_the_other_representation(self):
        """Their names are easily mistaken: said once, unless the right ones were given, too."""
        for kind, wrong, right in (("Tree AMR Isosurface", "IsosurfaceValues", "Isovalues"),
                                   ("Tree AMR Volume", "Isovalues", "IsosurfaceValues")):
            with self.subTest(kind=kind):
                simple.ResetSession()
                self.show(simple.HyperTreeGridRandom())
                self.representation.SetRepresentationType(kind)
                warnings = []
                for name in (wrong, right):
                    owner = self.representation.GetProperty(name).SMProperty.GetParent()
                    owner.AddObserver("WarningEvent", lambda *_: warnings.append(name))
                    setattr(self.representation, name, [1.0 if name == wrong else 2.0])
                simple.Render(self.view)
                self.representation.IsosurfaceArray = ["CELLS", "vtkGhostType"]
                self.representation.IsosurfaceArray = ["CELLS", "Depth"]
                simple.Render(self.view)
                if kind == "Tree AMR Volume":
                    setattr(self.representation, wrong, [1.5])
                    simple.Render(self.view)
                    self.representation.ShowIsosurfaces = 1
                    simple.Render(self.view)
                self.assertEqual(0, len(warnings))
                for value in (3.0, 4.0):
                    setattr(self.representation, wrong, [value])
                    simple.Render(self.view)
                    simple.Render(self.view)
                    self.assertEqual(1, len(warnings))


if __name__ == "__main__":
    scene.main()
