"""The representation `Tree AMR Volume`."""

import os
import sys

import numpy
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy

import scene


class TestVolume(scene.TestCase):
    def setUp(self):
        super().setUp()
        self.source = simple.TreeAMRExample(Dataset="Synthetic")
        self.view = scene.view()
        self.representation = simple.Show(self.source, self.view)

    def picture(self, name):
        return scene.picture(self.view, "volume-" + name)

    def show(self, rgb=(1, 0, 0), opacity=0.5):
        simple.ColorBy(self.representation, ("CELLS", "xyz"))
        self.representation.SetRepresentationType("Tree AMR Volume")
        scene.set_colour(self.representation.LookupTable, 0, 64, rgb)
        scene.set_opacity(self.representation.ScalarOpacityFunction, 0, 64, opacity)
        scene.look(self.view)

    def warnings_of_the_mapper(self):
        """Those to come."""
        volumes = self.view.GetRenderer().GetVolumes()
        volumes = [volumes.GetItemAsObject(i) for i in range(volumes.GetNumberOfItems())]
        warnings = []
        next(v for v in volumes if v.GetVisibility()).GetMapper().AddObserver(
            "WarningEvent", lambda *_: warnings.append(1))
        return warnings

    def look_along_z(self):
        """In parallel projection, 6 units high."""
        simple.ResetCamera(self.view)
        camera = self.view.GetActiveCamera()
        camera.SetPosition(2, 2, 20)
        camera.SetFocalPoint(2, 2, 2)
        camera.SetViewUp(0, 1, 0)
        self.view.CameraParallelProjection = 1
        self.view.CameraParallelScale = 3

    def test_colours_of_the_colour_map(self):
        self.show(rgb=(1, 0, 0))
        red = self.picture("red")
        drawn = scene.drawn(red)
        self.assertGreater(drawn.mean(), 0.1)
        self.assertFalse(drawn.all())
        self.assertEqual(0, red[..., 1:].max())
        scene.set_colour(self.representation.LookupTable, 0, 64, (0, 0, 1))
        blue = self.picture("blue")
        self.assertTrue(scene.close((red[..., 0], blue[..., 2])))
        self.assertEqual(0, blue[..., :2].max())

    def test_opacity_over_the_unit_distance(self):
        """Along the axis of a parallel projection every ray crosses 4: opacity 1 - (1 - 0.5)^(4 / unit)."""
        self.show(opacity=0.5)
        self.look_along_z()
        for unit in (1.0, 4.0):
            self.representation.ScalarOpacityUnitDistance = unit
            image = self.picture(f"unit-{unit:g}")
            rows, columns = image.shape[:2]
            centre = image[rows // 2 - 40:rows // 2 + 40, columns // 2 - 40:columns // 2 + 40, 0]
            expected = 255 * (1 - 0.5 ** (4 / unit))
            self.assertLess(numpy.abs(centre - expected).max(), 1.5)

    def test_opacity_by_another_array(self):
        """Of an array that is 10 everywhere: 0.5 over a unit, which no value of the coloured one has for long."""
        ten = simple.ProgrammableFilter(Input=self.source, OutputDataSetType="Same as Input", Script="""
from vtkmodules.vtkCommonCore import vtkDoubleArray
output = self.GetOutputDataObject(0)
output.ShallowCopy(self.GetInputDataObject(0, 0))
array = vtkDoubleArray()
array.SetName("ten")
array.SetNumberOfValues(output.GetNumberOfCells())
array.Fill(10)
output.GetCellData().AddArray(array)
""")
        simple.Hide(self.source, self.view)
        self.representation = simple.Show(ten, self.view)
        self.show()
        self.look_along_z()
        self.representation.ScalarOpacityFunction.Points = [
            0, 0, 0.5, 0, 9, 0, 0.5, 0, 10, 0.5, 0.5, 0, 11, 0, 0.5, 0, 64, 0, 0.5, 0]
        self.representation.ScalarOpacityUnitDistance = 1
        one = self.picture("one-array")
        self.assertEqual(0, self.representation.UseSeparateOpacityArray)
        self.representation.OpacityArrayName = ["CELLS", "ten"]
        self.assertTrue(scene.close((self.picture("not-separate"), one)))
        self.representation.UseSeparateOpacityArray = 1
        two = self.picture("two-arrays")
        rows, columns = two.shape[:2]
        centre = two[rows // 2 - 40:rows // 2 + 40, columns // 2 - 40:columns // 2 + 40]
        self.assertLess(numpy.abs(centre[..., 0] - 255 * (1 - 0.5 ** 4)).max(), 1.5)
        self.assertEqual(0, centre[..., 1:].max())
        self.assertFalse(scene.close((two, one)))
        # What was chosen for another array: the magnitude, as ParaView's Volume has it, which is said.
        warnings = self.warnings_of_the_mapper()
        self.representation.OpacityComponent = 3
        self.assertTrue(scene.close((self.picture("two-arrays-magnitude"), two)))
        self.assertEqual(1, len(warnings))
        # The colour is the other's.
        scene.set_colour(self.representation.LookupTable, 0, 64, (0, 1, 0))
        self.assertTrue(scene.close((self.picture("two-arrays-green")[..., 1], two[..., 0])))
        self.representation.UseSeparateOpacityArray = 0

    def test_function_of_two_values(self):
        """The second axis is the gradient's length, or an array: x, of which one half is drawn."""
        with_x = simple.ProgrammableFilter(Input=self.source, OutputDataSetType="Same as Input", Script="""
from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkCommonDataModel import vtkHyperTreeGridNonOrientedGeometryCursor
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
x = vtkDoubleArray()
x.SetName("x")
x.SetNumberOfValues(grid.GetNumberOfCells())
cursor = vtkHyperTreeGridNonOrientedGeometryCursor()
def visit():
    bounds = [0.0] * 6
    cursor.GetBounds(bounds)
    x.SetValue(cursor.GetGlobalNodeIndex(), (bounds[0] + bounds[1]) / 2)
    for child in range(0 if cursor.IsLeaf() else cursor.GetNumberOfChildren()):
        cursor.ToChild(child)
        visit()
        cursor.ToParent()
for tree in range(grid.GetMaxNumberOfTrees()):
    grid.InitializeNonOrientedGeometryCursor(cursor, tree)
    visit()
grid.GetCellData().AddArray(x)
""")
        simple.Hide(self.source, self.view)
        self.representation = simple.Show(with_x, self.view)
        self.show(rgb=(1, 0, 0))
        self.look_along_z()
        one = self.picture("one-value")
        self.assertEqual((0, 1), (self.representation.UseTransfer2D, self.representation.UseGradientForTransfer2D))
        function = self.representation.TransferFunction2D
        function.Range = [0, 64, 0, 4]
        function.OutputDimensions = [64, 64]
        function.Boxes = [-64, -4, 192, 12, 0, 1, 0, 0.9]  # wider than its range, or its middle alone is opaque
        self.assertTrue(scene.close((self.picture("not-two"), one)))
        self.representation.UseTransfer2D = 1
        gradients = self.picture("by-gradients")
        self.assertGreater(scene.drawn(gradients).mean(), 0.1)
        self.assertEqual(0, gradients[..., 0].max())
        self.assertGreater(gradients[..., 1].max(), 100)
        self.representation.UseGradientForTransfer2D = 0
        self.representation.ColorArray2Name = ["CELLS", "x"]
        function.Boxes = [-64, 0, 192, 1.5, 0, 0, 1, 0.9]
        half = self.picture("by-x")
        columns = half[..., 2].max(axis=0)
        middle = len(columns) // 2
        self.assertGreater(columns[:middle].max(), 100)
        self.assertEqual(0, half[..., :2].max())
        self.assertEqual(0, columns[middle:].max())
        # What was chosen for another array: the magnitude, as of opacities, which is said.
        warnings = self.warnings_of_the_mapper()
        self.representation.ColorArray2Component = 3
        self.assertTrue(scene.close((self.picture("by-x-magnitude"), half)))
        self.assertEqual(1, len(warnings))
        self.representation.UseTransfer2D = 0
        self.assertTrue(scene.close((self.picture("one-value-again"), one)))

    def test_components(self):
        """Four of them are red, green, blue and opacity by its function; ParaView's names and defaults."""
        vectors = simple.ProgrammableFilter(Input=self.source, OutputDataSetType="Same as Input", Script="""
import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
values = numpy.tile([1.0, 0.5, 0.0, 3.0], (grid.GetNumberOfCells(), 1))
values[0] = [0, 0, 0, 3]  # the root's, which is not drawn: the ends of the ranges
values[1:2] = [1, 1, 1, 3]
array = numpy_to_vtk(values, deep=1)
array.SetName('rgba')
grid.GetCellData().AddArray(array)
""")
        simple.Hide(self.source, self.view)
        self.representation = simple.Show(vectors, self.view)
        self.representation.SetRepresentationType("Tree AMR Volume")
        simple.ColorBy(self.representation, ("CELLS", "rgba"))
        scene.set_colour(self.representation.LookupTable, 0, 64, (0, 0, 1))
        scene.set_opacity(self.representation.ScalarOpacityFunction, 0, 64, 0.5)
        self.look_along_z()
        self.assertEqual((1, 0), (self.representation.MapScalars, self.representation.MultiComponentsMapping))
        mapped = self.picture("rgba-mapped")
        self.assertEqual(0, mapped[..., :2].max())
        self.representation.MultiComponentsMapping = 1
        direct = self.picture("rgba")
        self.assertGreater(direct[..., 0].max(), 100)
        self.representation.MultiComponentsMapping = 0
        self.representation.MapScalars = 0
        self.assertTrue(scene.close((self.picture("rgba-not-mapped"), direct)))
        self.representation.MapScalars = 1
        self.assertTrue(scene.close((self.picture("rgba-mapped-again"), mapped)))

    def test_what_has_no_effect_is_said_once(self):
        """Three components are no colour with an opacity; interpolation is nearest or linear."""
        vectors = simple.ProgrammableFilter(Input=self.source, OutputDataSetType="Same as Input", Script="""
import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
array = numpy_to_vtk(numpy.ones((grid.GetNumberOfCells(), 3)), deep=1)
array.SetName('velocity')
grid.GetCellData().AddArray(array)
""")
        simple.Hide(self.source, self.view)
        self.representation = simple.Show(vectors, self.view)
        self.representation.SetRepresentationType("Tree AMR Volume")
        simple.ColorBy(self.representation, ("CELLS", "velocity"))
        simple.Render(self.view)
        owner = self.representation.GetClientSideObject().GetActiveRepresentation()
        warnings = []
        owner.AddObserver("WarningEvent", lambda *_: warnings.append(1))
        for name, value in (("MapScalars", 0), ("MultiComponentsMapping", 1), ("InterpolationType", 7)):
            with self.subTest(name=name):
                default = getattr(self.representation, name)
                setattr(self.representation, name, value)
                simple.Render(self.view)
                simple.Render(self.view)
                self.assertEqual(1, len(warnings))
                setattr(self.representation, name, default)
                simple.Render(self.view)
                self.assertEqual(1, len(warnings))
                warnings.clear()
        self.representation.MapScalars = 0
        simple.Render(self.view)
        simple.ColorBy(self.representation, ("CELLS", "xyz"))
        simple.Render(self.view)
        self.assertEqual(2, len(warnings))

    def test_cropping(self):
        """As ParaView's Volume has it: the data's bounds, here 0 to 4, scaled and then moved."""
        self.show(opacity=0.9)
        self.look_along_z()
        self.assertEqual(0, self.representation.UseCropping)
        # Whose bounds the box in the window starts from.
        self.assertEqual(1, self.representation.SMProxy.GetProperty("DummyInput").GetNumberOfProxies())
        whole = self.picture("not-cropped")
        self.representation.CroppingOrigin = [1, 0.5, 0]
        self.representation.CroppingScale = [0.5, 0.25, 2]
        self.assertTrue(scene.close((self.picture("cropping-off"), whole)))
        self.representation.UseCropping = 1
        drawn = scene.drawn(self.picture("cropped"))
        rows, columns = drawn.shape
        pixel = 6 / rows
        where = numpy.argwhere(drawn)
        low, high = where.min(axis=0), where.max(axis=0) + 1
        expected = numpy.array([[0.5, 1], [1.5, 3]])  # y, x of the corners
        for found, corner in zip((low, high), expected):
            place = 2 + (found - [rows / 2, columns / 2]) * pixel
            self.assertLess(numpy.abs(place - corner).max(), 1.5 * pixel)
        self.assertTrue(drawn[low[0]:high[0], low[1]:high[1]].all())

    def test_transparent(self):
        self.show(opacity=0)
        self.assertFalse(scene.drawn(self.picture("transparent")).any())

    def test_checkpoint_of_dealii(self):
        """Opened by its .info alone, drawn by the values of its cells, where Origin and Spacing say."""
        self.representation.Visibility = 0
        folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../Data/DealII/Checkpoints")
        reader = simple.OpenDataFile(os.path.join(folder, "cube.info"))
        self.assertEqual("TreeAMRP4estReader", reader.GetXMLName())
        reader.Payload = "double average = FE_DGQ(0); double now, before = FE_Q(1)"
        reader.Origin, reader.Spacing = [-1, -1, -1], [2, 2, 2]
        self.representation = simple.Show(reader, self.view)
        self.assertEqual({"average", "now", "before"}, set(reader.CellData.keys()))
        self.assertEqual((-1, 1) * 3, reader.GetDataInformation().GetBounds())
        table = numpy.loadtxt(os.path.join(folder, "cube.txt"))
        self.assertEqual(len(table), servermanager.Fetch(reader).GetNumberOfLeaves())
        low, high = table[:, 4].min(), table[:, 4].max()
        simple.ColorBy(self.representation, ("CELLS", "now"))
        self.representation.SetRepresentationType("Tree AMR Volume")
        self.representation.LookupTable.RescaleTransferFunction(low, high)
        scene.set_opacity(self.representation.ScalarOpacityFunction, low, high, 0.5)
        scene.look(self.view)
        self.assertGreater(scene.drawn(self.picture("dealii")).mean(), 0.1)

    def test_hidden(self):
        self.show()
        self.representation.Visibility = 0
        self.assertFalse(scene.drawn(self.picture("hidden")).any())

    def test_unit_distance_starts_at_a_tenth_of_the_longest_side(self):
        self.assertAlmostEqual(0.4, self.representation.ScalarOpacityUnitDistance)

    def test_without_an_array(self):
        """The first array with default colours, when the one that was seen is gone: as with those colours chosen."""
        self.show()
        simple.ColorBy(self.representation, None)
        self.source.Dataset = "Mandelbulb"
        self.source.MinimumLevel, self.source.MaximumLevel = 2, 4
        scene.look(self.view)
        default = self.picture("default")
        self.assertGreater(scene.drawn(default).mean(), 0.1)
        simple.ColorBy(self.representation, ("CELLS", "mandelbulb"))
        # The range of all cells, coarse ones included, as ParaView has it.
        low, high = self.source.CellData["mandelbulb"].GetRange()
        table = self.representation.LookupTable
        table.Discretize = 0
        table.ColorSpace = "Diverging"
        table.RGBPoints = [low, 0.231373, 0.298039, 0.752941, high, 0.705882, 0.0156863, 0.14902]
        self.representation.ScalarOpacityFunction.Points = [low, 0, 0.5, 0, high, 1, 0.5, 0]
        self.assertTrue(scene.close((default, self.picture("chosen"))))

    def test_component_of_the_colour_map(self):
        """A vector array is drawn by the component, or the magnitude, that the colour map has chosen."""
        vectors = simple.ProgrammableFilter(Input=self.source, OutputDataSetType="Same as Input", Script="""
import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
values = numpy.tile([3.0, 4.0, 0.0], (grid.GetNumberOfCells(), 1))
array = numpy_to_vtk(values, deep=1)
array.SetName('v')
grid.GetCellData().AddArray(array)
""")
        simple.Hide(self.source, self.view)
        self.representation = simple.Show(vectors, self.view)
        self.representation.SetRepresentationType("Tree AMR Volume")
        scene.look(self.view)
        for component, channel in (("Y", 1), ("X", 0), ("Magnitude", 2)):
            simple.ColorBy(self.representation, ("CELLS", "v", component))
            table = self.representation.LookupTable
            # Red at 3, green at 4, blue at 5.
            table.ColorSpace = "RGB"
            table.RGBPoints = [3, 1, 0, 0, 4, 0, 1, 0, 5, 0, 0, 1]
            scene.set_opacity(self.representation.ScalarOpacityFunction, 0, 5, 0.5)
            image = self.picture("component-" + component)
            self.assertEqual(channel, image.max(axis=(0, 1)).argmax(), component)

    def test_moved(self):
        self.show()
        image = self.picture("still")
        setattr(self.representation, scene.TRANSLATION, [0, 0, 1000])
        self.assertFalse(scene.drawn(self.picture("away")).any())
        setattr(self.representation, scene.TRANSLATION, [0, 0, 0])
        self.assertTrue(scene.close((image, self.picture("back"))))

    def test_changed_input(self):
        """A new grid, smaller than the first, is drawn in its place."""
        self.show()
        before = scene.drawn(self.picture("before"))
        self.source.Dataset = "Mandelbulb"
        self.source.MaximumLevel = 5
        self.source.UpdatePipeline()
        simple.ColorBy(self.representation, ("CELLS", "mandelbulb"))
        after = scene.drawn(self.picture("after"))
        self.assertTrue(after.any())
        self.assertLess(after.sum(), before.sum())

    def test_error_and_target(self):
        """Both are there as soon as a still picture is."""
        self.show()
        self.representation.ScalarOpacityFunction.Points = [0, 0, 0.5, 0, 20, 0.9, 0.5, 0, 64, 0.1, 0.5, 0]
        simple.Render(self.view)
        self.assertEqual(-1, self.representation.EstimatedError)
        self.assertGreater(self.representation.FrameSeconds, 0)
        self.representation.SamplesPerCell = 0.5
        self.representation.EstimateError = 1
        simple.Render(self.view)
        error = self.representation.EstimatedError
        self.assertGreater(error, 0)
        self.representation.EstimateError = 0
        self.representation.TargetError = error / 10
        simple.Render(self.view)
        self.assertGreater(self.representation.EstimatedError, 0)
        self.assertLessEqual(self.representation.EstimatedError, error / 10)
        self.representation.TargetError = 0
        simple.Render(self.view)
        self.assertEqual(-1, self.representation.EstimatedError)

    def test_isosurfaces(self):
        """One colour all over: each pixel lets through what the volume and the surfaces let through."""
        self.show(rgb=(1, 0, 0), opacity=0.5)
        self.representation.ShadeIsosurfaces = 0
        self.representation.ScalarOpacityUnitDistance = 4
        volume = self.picture("no-isosurfaces")
        low, high = self.source.CellData["xyz"].GetRange()
        self.assertAlmostEqual((low + high) / 2, self.representation.IsosurfaceValues[0], places=5)
        self.representation.ShowIsosurfaces = 1
        self.representation.IsosurfaceValues = [6.5, 20]
        self.representation.IsosurfaceOpacityScale = 0.5
        both = self.picture("isosurfaces-inside")
        self.representation.BlendMode = "Isosurface"
        alone = self.picture("isosurfaces-alone")
        self.assertLessEqual({0, 64, 112}, set(numpy.unique(alone[..., 0])))
        self.assertLess(numpy.abs(both - (volume + alone - volume * alone / 255)).max(), 1.6)
        self.representation.IsosurfaceValues = [20]
        one = self.picture("one-isosurface")
        self.assertLess(scene.drawn(one).sum(), scene.drawn(alone).sum())
        self.representation.IsosurfaceValues = []
        self.assertFalse(scene.drawn(self.picture("none-alone")).any())
        self.representation.BlendMode = "Composite"
        self.assertTrue(scene.close((volume, self.picture("volume-again"))))

    def test_isosurfaces_are_occluded(self):
        """As Tree AMR Isosurface's, whose properties they share."""
        self.show(rgb=(1, 1, 1), opacity=1)
        self.representation.BlendMode = "Isosurface"
        self.representation.IsosurfaceValues = [6.5, 7.5]
        bright = self.picture("open")
        self.representation.AmbientOcclusionSamples = 32
        self.representation.AmbientOcclusionRadius = 0.3
        self.representation.Shadows = 1
        dark = self.picture("occluded")
        self.assertTrue((dark <= bright).all())
        self.assertLess(dark.sum(), 0.97 * bright.sum())
        self.representation.ShadeIsosurfaces = 0
        flat = self.picture("unlit")
        self.representation.AmbientOcclusionSamples = 0
        self.assertTrue(scene.close((flat, self.picture("unlit-again"))))

    def test_isosurfaces_are_shaded(self):
        self.show(rgb=(1, 1, 1), opacity=1)
        self.representation.BlendMode = "Isosurface"
        self.representation.IsosurfaceValues = [6.5]
        shaded = self.picture("shaded")
        self.representation.ShadeIsosurfaces = 0
        flat = self.picture("flat")
        self.assertEqual({0, 255}, set(numpy.unique(flat)))
        self.assertGreater(len(numpy.unique(shaded)), 10)
        self.assertTrue((scene.drawn(flat) == scene.drawn(shaded)).all())

    def test_light(self):
        """ParaView's Shade, off by default: what faces away from the lights is darker, all is without their light."""
        self.show(rgb=(1, 1, 1), opacity=0.9)
        self.assertEqual(0, self.representation.Shade)
        flat = self.picture("unlit-volume")
        self.representation.Shade = 1
        lit = self.picture("lit-volume")
        self.assertTrue((lit <= flat + 1.6).all())
        self.assertLess(lit.sum(), 0.98 * flat.sum())
        self.representation.Diffuse = 0
        self.assertEqual(0, self.picture("dark").max())

    def test_scattered_light(self):
        """Of a light behind the eye, dimmed on its way as what is seen of it: all of an even volume's light, of which what
        is nearer than a 96th of its width dims nothing. By ParaView's names."""
        self.show(rgb=(1, 1, 1), opacity=0.5)
        self.look_along_z()
        self.representation.ScalarOpacityUnitDistance = 1
        self.view.UseLight = 0
        light = simple.AddLight(view=self.view)
        light.Coords = "Scene"
        light.Type = "Directional"
        light.Position = [2, 2, 20]
        light.FocalPoint = [2, 2, 2]
        self.assertEqual(0, self.representation.VolumetricScatteringBlending)
        self.representation.Shade = 1
        self.representation.VolumetricScatteringBlending = 2
        self.representation.Diffuse = 0.8
        ways = (numpy.arange(4000) + 0.5) / 1000
        extinction = numpy.log(2)
        for reach, anisotropy in ((1, 0), (1, 0.5), (0, 0)):
            self.representation.GlobalIlluminationReach = reach
            self.representation.VolumeAnisotropy = anisotropy
            dimming = numpy.clip(ways - 4 / 96, 0, None if reach == 1 else 0.5) # the finest cells' width
            back = (1 - anisotropy ** 2) / (1 + anisotropy) ** 3 # of Henyey and Greenstein
            expected = 255 * 0.8 * back * numpy.sum(extinction * numpy.exp(-extinction * (ways + dimming))) / 1000
            image = self.picture(f"scattered-{reach}-{anisotropy}")
            rows, columns = image.shape[:2]
            centre = image[rows // 2 - 20:rows // 2 + 20, columns // 2 - 20:columns // 2 + 20, 0]
            self.assertLess(numpy.abs(centre - expected).max(), 2, (reach, anisotropy))

    def test_blend_modes(self):
        """Of one value everywhere they are known."""
        self.show(rgb=(1, 0, 0), opacity=0.5)
        self.representation.ScalarOpacityUnitDistance = 4
        for mode in ("Maximum Intensity", "Minimum Intensity"):
            self.representation.BlendMode = mode
            picture = self.picture(mode)
            drawn = picture[scene.drawn(picture)]
            self.assertTrue((abs(drawn - numpy.array([127.5, 0, 0])) < 1.6).all(), mode)
        for mode in ("Average Intensity", "Additive"):
            self.representation.BlendMode = mode
            picture = self.picture(mode)
            self.assertTrue((picture[..., 0] == picture[..., 1]).all(), mode)
            self.assertGreater(len(numpy.unique(picture)), 10)

    def test_slice(self):
        """Of one value everywhere: the plane alone, whatever the unit distance; ParaView's name, plane and default."""
        self.show(rgb=(1, 0, 0), opacity=0.5)
        self.look_along_z()
        self.assertEqual("Plane", self.representation.SliceFunction.SMProxy.GetXMLName())
        self.representation.BlendMode = "Slice"
        self.representation.SliceFunction.Origin = [2, 2, 1.3]
        self.representation.SliceFunction.Normal = [0, 0, 1]
        for unit in (0.5, 7):
            self.representation.ScalarOpacityUnitDistance = unit
            picture = self.picture(f"slice-{unit}")
            drawn = picture[scene.drawn(picture)]
            self.assertGreater(len(drawn), 1000)
            self.assertTrue((abs(drawn - numpy.array([127.5, 0, 0])) < 1.6).all())
        self.representation.SliceFunction.Origin = [2, 2, 5]
        self.assertFalse(scene.drawn(self.picture("slice-beside")).any())

    def test_interpolation_type(self):
        """Linear is ParaView's default. Nearest has few colours: those of the cells that are seen."""
        self.show()
        self.assertEqual("Linear", self.representation.InterpolationType)
        table = self.representation.LookupTable
        table.ColorSpace = "RGB"
        table.RGBPoints = [0, 0, 0, 0, 64, 1, 1, 1]
        self.representation.ScalarOpacityFunction.Points = [0, 1, 0.5, 0, 64, 1, 0.5, 0]
        self.look_along_z()
        continuous = self.picture("linear")
        self.representation.InterpolationType = "Nearest"
        nearest = self.picture("nearest")
        values = numpy.unique(nearest)
        self.assertLess(len(values), 0.5 * len(numpy.unique(continuous)))
        # Seen from above, the cells of a layer have the values of their centres.
        cells = vtk_to_numpy(servermanager.Fetch(self.source).GetCellData().GetArray("xyz"))
        colours = numpy.concatenate([[0], cells * 255 / 64])
        for value in values:
            self.assertLess(abs(colours - value).min(), 1.1)
        self.representation.InterpolationType = "Linear"
        self.assertTrue(scene.close((self.picture("linear-again"), continuous)))

    def test_categories(self):
        """Opaque, they are seen as on the surface of the grid."""
        categories = scene.with_categories(self.source)
        simple.Hide(self.source, self.view)
        self.representation = simple.Show(categories, self.view)
        self.representation.SetRepresentationType("Surface")
        simple.ColorBy(self.representation, ("CELLS", "id"))
        scene.set_categories(self.representation.LookupTable)
        self.representation.Diffuse, self.representation.Ambient = 0.0, 1.0
        scene.look(self.view)
        surface = self.picture("categories-surface")
        self.assertEqual(1 + 6, len(scene.colours(surface)))
        self.representation.SetRepresentationType("Tree AMR Volume")
        scene.set_opacity(self.representation.ScalarOpacityFunction, 0, 5, 1)
        volume = self.picture("categories")
        self.assertEqual(scene.colours(surface), scene.colours(volume))
        # Rasterised edges may lie a pixel beside those of rays.
        self.assertLess((surface != volume).any(axis=2).mean(), 1e-3)
        # Only those of 2.
        self.representation.ScalarOpacityFunction.Points = [1, 0, 0.5, 0, 2, 1, 0.5, 0, 3, 0, 0.5, 0]
        self.assertEqual({(0, 0, 0), (0, 0, 255)}, scene.colours(self.picture("category")))
        self.representation.LookupTable.InterpretValuesAsCategories = 0
        self.assertLess(6, len(scene.colours(self.picture("no-categories"))))

    def test_values_that_float_merges(self):
        """As volume, isosurface and contour, with all defaults for the range, the picture of them less their mean."""
        source = scene.with_pressure(self.source)
        simple.Hide(self.source, self.view)
        pictures = {}
        for name, mean in ("less", 0), ("pressure", 101325):
            display = simple.Show(source, self.view)
            simple.ColorBy(display, ("CELLS", name))
            display.SetRepresentationType("Tree AMR Volume")
            scene.look(self.view)
            low, high = source.GetDataInformation().GetArrayInformation(name, 1).GetComponentRange(0)
            self.assertAlmostEqual(mean, low + high - mean, delta=0.001)
            self.assertEqual([low, high], [display.LookupTable.RGBPoints[i] for i in (0, -4)])
            volume = self.picture(name)
            display.SetRepresentationType("Tree AMR Isosurface")
            display.IsosurfaceArray = ["CELLS", name]
            middle = (low + high) / 2
            self.assertAlmostEqual(middle, display.FirstIsovalue, delta=1e-9)
            display.Isovalues = [middle]
            isosurface = self.picture(name + "-isosurface")
            contour = simple.TreeAMRContour(Input=source, ContourBy=["CELLS", name], Isosurfaces=[middle])
            simple.Hide(source, self.view)
            simple.ColorBy(simple.Show(contour, self.view), ("POINTS", "xyz"))
            pictures[name] = (volume, isosurface, self.picture(name + "-contour"))
            simple.Delete(contour)
        for less, pressure in zip(*pictures.values()):
            self.assertGreater(scene.drawn(less).mean(), 0.05)
            self.assertGreater(len(scene.colours(less)), 15)
            self.assertLess(numpy.abs(less - pressure).mean(), 0.02)

    def test_hexahedra(self):
        """Saved as hexahedra and read again: one grid, from a collection too, that is drawn as the one it came from."""
        pictures = {}
        for source in (self.source, *self.from_hexahedra()):
            simple.HideAll(self.view)
            self.representation = simple.Show(source, self.view)
            self.show()
            volume = self.picture(f"hexahedra-{len(pictures)}")
            self.representation.SetRepresentationType("Tree AMR Isosurface")
            self.representation.Isovalues = [6.5]
            pictures[source] = (volume, self.picture(f"hexahedra-{len(pictures)}-isosurface"))
        whole, *others = pictures.values()
        self.assertEqual(2, len(others))
        for other in others:
            for images in zip(whole, other):
                self.assertTrue(scene.drawn(images[0]).any())
                self.assertTrue(scene.close(images))

    def from_hexahedra(self):
        path = os.path.join(sys.argv[-1], "hexahedra.pvtu")
        hexahedra = simple.HyperTreeGridToUnstructuredGrid(Input=self.source)
        simple.SaveData(path, hexahedra)
        read = simple.XMLPartitionedUnstructuredGridReader(FileName=[path])
        # Twice the same cells; ParaView 5.11's Threshold of them, for parts, crashes now and then.
        for data in (read, simple.GroupDatasets(Input=[read, hexahedra])):
            data.UpdatePipeline()
            grid = simple.TreeAMRFromUnstructured(Input=data)
            grid.UpdatePipeline()
            self.assertEqual(288, servermanager.Fetch(grid).GetNumberOfLeaves())
            self.assertIn("xyz", grid.CellData.keys())
            yield grid

    def test_overlapping_amr(self):
        """Blocks with layers of copies are drawn as ParaView's Surface and as hexahedra of those without."""
        array = ("CELLS", "Fractal Volume Fraction")
        options = {"TwoDimensional": 0, "Dimensions": 6, "MaximumLevel": 2, "Asymetric": 0}
        blocks = simple.HierarchicalFractal(GhostLevels=1, **options)
        alone = simple.HierarchicalFractal(GhostLevels=0, **options)
        hexahedra = simple.MergeBlocks(Input=simple.ConvertAMRdatasettoMultiblock(Input=alone))
        self.assertTrue(self.is_offered("TreeAMRFromOverlappingAMR", blocks))
        self.assertFalse(self.is_offered("TreeAMRFromOverlappingAMR", hexahedra))
        all_kinds = ("Surface", "Tree AMR Volume", "Tree AMR Isosurface")
        pictures = {
            name: self.amr_pictures(name, source, array, kinds)
            for name, source, kinds in (
                ("blocks", alone, ("Surface",)),
                ("tree", simple.TreeAMRFromOverlappingAMR(Input=blocks), all_kinds),
                ("hexahedra", simple.TreeAMRFromUnstructured(Input=hexahedra), all_kinds))}
        for others in pictures.values():
            for images in zip(pictures["hexahedra"], others):
                self.assertGreater(scene.drawn(images[0]).mean(), 0.02)
                self.assertTrue(scene.close(images))

    def amr_pictures(self, name, source, array, representations):
        source.UpdatePipeline()
        simple.HideAll(self.view)
        self.representation = simple.Show(source, self.view)
        simple.ColorBy(self.representation, array)
        scene.look(self.view)
        pictures = []
        for kind in representations:
            self.representation.SetRepresentationType(kind)
            if kind == "Tree AMR Isosurface":
                self.representation.IsosurfaceArray = array
                self.representation.Isovalues = [1]
            pictures.append(self.picture(f"amr-{name}-{kind.split()[-1]}"))
        return pictures

    @staticmethod
    def is_offered(name, source):
        """Whether ParaView's menu has a filter for what a source gives."""
        source.UpdatePipeline()
        prototype = servermanager.ProxyManager().GetPrototypeProxy("filters", name)
        prototype.GetProperty("Input").AddUncheckedInputConnection(source.SMProxy, 0)
        offered = prototype.GetProperty("Input").IsInDomains()
        prototype.GetProperty("Input").RemoveAllUncheckedProxies()
        return bool(offered)

    def test_group_of_one(self):
        self.show()
        alone = self.picture("alone")
        group = simple.GroupDatasets(Input=[self.source])
        group.UpdatePipeline()
        simple.Hide(self.source, self.view)
        self.representation = simple.Show(group, self.view)
        self.show()
        self.assertTrue(scene.close((alone, self.picture("group"))))


if __name__ == "__main__":
    scene.main()
