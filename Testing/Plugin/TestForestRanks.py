"""A forest's file on many ranks: each reads its part, and the pictures are those of one rank.

TestForestRanks.py <forest> <folder>           saves the pictures on one rank, compares with them on others
TestForestRanks.py <forest> <folder> <port>    a client of serve.py
"""

import os
import sys

import numpy
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy

import scene

FOREST = sys.argv[1]
is_client = len(sys.argv) > 3
if is_client:
    simple.Connect("localhost", int(sys.argv.pop()))
    ranks = servermanager.ActiveConnection.GetNumberOfDataPartitions()
else:
    ranks = servermanager.vtkProcessModule.GetProcessModule().GetNumberOfLocalPartitions()


# Largest and mean differences, of 255, from one rank's: a picture that goes from rank to rank in floats is rounded once, and once
# more over the background.
RELAYED = 1, 0.006
# Where each rank rounds its colours and opacities before they are composited.
ROUNDED = 2 + (ranks > 2), 0.1
# Where each rank, besides, takes samples as if nothing hid its box.
BY_ITSELF = 7, 0.1


def check(name, view, bounds):
    kind = "client" if is_client else ranks
    image = scene.picture(view, f"forest-{name}-{kind}")
    assert scene.drawn(image).mean() > 0.05, name
    if ranks > 1:
        difference = abs(image - scene.load(os.path.join(sys.argv[-1], f"forest-{name}-1.png")))
        print(name, "largest difference", difference.max(), "mean", difference.mean())
        assert difference.max() <= bounds[0] and difference.mean() <= bounds[1], name
    return image


view = scene.view()
reader = simple.TreeAMRP4estReader(FileName=FOREST, Payload="double rho")
display = simple.Show(reader, view)
simple.ColorBy(display, ("CELLS", "rho"))
display.RescaleTransferFunctionToDataRange(False, True)
# Differences are those of colours, whatever a release's default: the bounds are for these.
display.LookupTable.ApplyPreset("Cool to Warm", True)
display.SetRepresentationType("Tree AMR Volume")
display.ScalarOpacityUnitDistance = 0.05
low, high = display.LookupTable.RGBPoints[0], display.LookupTable.RGBPoints[-4]
display.ScalarOpacityFunction.Points = [low, 0, 0.5, 0, high, 0.9, 0.5, 0]
scene.look(view)
check("few-samples", view, RELAYED)
# Pixels of a draft are mixed when it is enlarged: those of all ranks.
display.AutoAdjustSampleDistances = 0
display.ImageSampleDistance = 5
check("draft", view, RELAYED)
display.BlendMode = "Maximum Intensity"
check("draft-maximum", view, RELAYED)
display.BlendMode = "Composite"
display.ImageSampleDistance = 1
display.AutoAdjustSampleDistances = 1
display.SamplesPerCell = 8
volume = check("volume", view, RELAYED)
# Values from rank to rank, whose parts of the forest have ranges of their own.
for blend in "Maximum Intensity", "Minimum Intensity", "Average Intensity", "Additive":
    display.BlendMode = blend
    check(blend.split()[0].lower(), view, RELAYED)
display.BlendMode = "Composite"
assert reader.GetDataInformation().GetNumberOfCells() > 0

display.LookupTable.ApplyPreset(scene.VIRIDIS, True)
check("colours", view, RELAYED)
camera = view.CameraPosition[:]
view.CameraPosition = [0.3, 2.5, -1.2]
check("moved", view, RELAYED)
view.CameraPosition = camera
display.Shade = 1
check("shade", view, RELAYED)
display.Shade = 0
display.UseCropping = 1
display.CroppingScale = [0.5, 0.8, 0.8]
display.CroppingOrigin = [0.2, 0.1, 0.1]
check("cropped", view, RELAYED)
display.UseCropping = 0
display.ShowIsosurfaces = 1
display.IsosurfaceValues = [0.5]
check("both", view, RELAYED)
display.ShowIsosurfaces = 0

display.SetRepresentationType("Tree AMR Isosurface")
display.Isovalues = [0.5]
check("isosurface", view, (1, 0.01))
simple.ColorBy(display, None)
display.Isovalues = [0.3, 0.6]
display.Opacity = 0.4
check("translucent", view, ROUNDED)
display.Opacity = 1

# A volume and the layers of another display are drawn together, with and without depth peeling.
simple.ColorBy(display, ("CELLS", "rho"))
display.SetRepresentationType("Tree AMR Volume")
layers = simple.Show(simple.PassThrough(Input=reader), view)
layers.SetRepresentationType("Tree AMR Isosurface")
simple.ColorBy(layers, None)
layers.Isovalues = [0.3, 0.6]
layers.Opacity = 0.4
for peeling in 1, 0:
    simple.GetSettingsProxy("RenderViewSettings").DepthPeeling = peeling
    check(f"together-{peeling}", view, RELAYED)
simple.GetSettingsProxy("RenderViewSettings").DepthPeeling = 1
layers.Visibility = 0

# Polygons end rays on the rank that has them; translucent ones are peeled, and volumes with them.
for opacity, bounds in (1, RELAYED), (0.4, BY_ITSELF):
    ball = simple.Sphere(Center=[0.45, 0.5, 0.6], Radius=0.3, ThetaResolution=64, PhiResolution=64)
    shown = simple.Show(ball, view)
    shown.Opacity = opacity
    check(f"polygons-{opacity}", view, bounds)
    simple.Hide(ball, view)

# What cannot be drawn as one picture is drawn rank by rank: two volumes, blends of values, estimates of errors.
display.EstimateError = 1
check("estimate", view, BY_ITSELF)
display.EstimateError = 0
display.BlendMode = "Maximum Intensity"
simple.Render(view)
display.BlendMode = "Composite"
again = simple.Show(simple.PassThrough(Input=reader), view)
simple.ColorBy(again, ("CELLS", "rho"))
again.SetRepresentationType("Tree AMR Volume")
simple.Render(view)
again.Visibility = 0
check("alone-again", view, RELAYED)

# Another array makes the ranks' grids anew, of which a server's client has to know.
reader.GenerateLevel = 1
simple.Render(view)
simple.ColorBy(display, ("CELLS", "level"))
display.RescaleTransferFunctionToDataRange(False, True)
display.LookupTable.ApplyPreset("Cool to Warm", True)
lowest, highest = display.LookupTable.RGBPoints[0], display.LookupTable.RGBPoints[-4]
display.ScalarOpacityFunction.Points = [lowest, 0.1, 0.5, 0, highest, 0.7, 0.5, 0]
check("level", view, RELAYED)
simple.ColorBy(display, ("CELLS", "rho"))
check("rho-again", view, RELAYED)

# A camera among the boxes, one that sees few of them, one that sees none, and both eyes of a stereo window.
simple.ResetCamera(view)
for name, position, focus in (("inside", [0.5, 0.45, 0.55], [0, 0, 0]), ("beside", [0.5, 0.5, 0.9], [0.9, 0.6, 0.7])):
    view.CameraPosition, view.CameraFocalPoint = position, focus
    check(name, view, RELAYED)
view.CameraPosition, view.CameraFocalPoint = [2, 2, 2], [3, 3, 3]
simple.Render(view)
scene.look(view)
view.StereoRender = 1
view.StereoType = "Anaglyph"
check("stereo", view, (2, 0.006))  # of two pictures
view.StereoRender = 0
view.CameraParallelProjection = 1
check("parallel", view, RELAYED)
view.CameraParallelProjection = 0

# Triangles of all ranks close.
contour = simple.TreeAMRContour(Input=reader, ContourBy=["CELLS", "rho"], Isosurfaces=[0.3, 0.6])
contour.UpdatePipeline()
points, boundary, inside = scene.open_edges(contour, 0, 1)
print("points", points, "edges on the boundary and inside", boundary, inside)
assert points > 500 and inside == 0
simple.Hide(reader, view)
shown = simple.Show(contour, view)
simple.ColorBy(shown, None)
check("contour", view, ROUNDED)
simple.Hide(contour, view)
simple.Show(reader, view)

# So do those of values that floats would not tell apart: all ranks round them alike.
pressure = simple.ProgrammableFilter(Input=reader, OutputDataSetType="Same as Input", Script="""
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
if grid.GetCellData().HasArray('rho'):
    array = numpy_to_vtk(101325 + 0.001 * vtk_to_numpy(grid.GetCellData().GetArray('rho')), deep=1)
    array.SetName('pressure')
    grid.GetCellData().AddArray(array)
""")
contour = simple.TreeAMRContour(
    Input=pressure, ContourBy=["CELLS", "pressure"], Isosurfaces=[101325.0003, 101325.0006])
contour.UpdatePipeline()
points, boundary, inside = scene.open_edges(contour, 0, 1)
print("points", points, "edges on the boundary and inside", boundary, inside)
assert points > 500 and inside == 0

# Points of all ranks get the values of whichever rank has them, and those outside none.
for name, points in (("sphere", simple.Sphere(
        Center=[0.5, 0.5, 0.5], Radius=0.55, ThetaResolution=64, PhiResolution=64)),
                     ("line", simple.Line(Point1=[0, 0, 0], Point2=[1, 1, 1], Resolution=1000))):
    probe = simple.TreeAMRProbe(Input=points, Source=reader, ComputeGradients=1)
    probe.UpdatePipeline()
    data = servermanager.Fetch(probe)
    arrays = [vtk_to_numpy(data.GetPoints().GetData())] + [
        vtk_to_numpy(data.GetPointData().GetArray(array)) for array in ("rho", "rho_gradient", "vtkValidPointMask")]
    rows = numpy.unique(numpy.column_stack([array.reshape(len(arrays[0]), -1) for array in arrays]), axis=0)
    print(name, "points", len(rows), "inside", int(rows[:, -1].sum()))
    assert 0.2 * len(rows) < rows[:, -1].sum() <= len(rows)
    path = os.path.join(sys.argv[-1], f"forest-{name}.npy")
    if ranks == 1:
        numpy.save(path, rows)
    else:
        assert (rows == numpy.load(path)).all()

# Ranks whose points lie outside have the arrays, too: none is partial.
outside = simple.TreeAMRProbe(
    Input=simple.Wavelet(WholeExtent=[0, 20, 0, 3, 0, 3]), Source=reader)
outside.UpdatePipeline()
information = outside.SMProxy.GetDataInformation(0).GetPointDataInformation().GetArrayInformation("rho")
assert information and not information.GetIsPartial(), "the probe's array is partial"

# All cells are counted once: they fill the unit cube.
integral = simple.IntegrateVariables(Input=simple.HyperTreeGridToUnstructuredGrid(Input=reader))
integral.UpdatePipeline()
volume = servermanager.Fetch(integral).GetCellData().GetArray("Volume").GetValue(0)
print("volume of all cells", volume)
assert abs(volume - 1) < 1e-9
