"""Draws the paper's figure 10: an isosurface across a level boundary by each method of interpolation.

The synthetic data are 4 x 4 x 4 cells on [0, 4]^3, the half x > 2 refined once, with xyz at the cells'
centres; the isovalue is 6.5. Each method is sampled on a fine grid on either side of x = 2, so that cracks
stay open (the steps of Nearest are walls everywhere), and within the outermost centres of the coarse cells, where
nothing depends on the domain's end. There the trilinear interpolation of the unrefined grid, the paper's
reference, is xyz itself. Prints the distances of the surfaces' points from
xyz = 6.5, in widths of a coarse cell, and saves FOLDER/methods.png.

usage: pvpython methods.py FOLDER [SAMPLES]
"""

import pathlib
import sys

import numpy
from paraview.vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from treeamr.vtkTreeAMRReader import vtkTreeAMRExampleSource, vtkTreeAMRProbeFilter
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkFlyingEdges3D
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkTextActor, vtkWindowToImageFilter)
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2

ISOVALUE = 6.5
METHODS = ["Nearest", "Current", "Finest", "Octant", "GTI", "Reference"]
HALVES = [(0.5, 2 - 1e-9), (2 + 1e-9, 3.5)]  # in x

folder = pathlib.Path(sys.argv[1])
samples = int(sys.argv[2]) if len(sys.argv) > 2 else 200  # along each axis


def sample_points(low, high):
    """All of y and z, in x those from low to high."""
    count = round(samples * (high - low) / 3)
    image = vtkImageData()
    image.SetDimensions(count, samples, samples)
    image.SetOrigin(low, 0.5, 0.5)
    image.SetSpacing((high - low) / (count - 1), 3 / (samples - 1), 3 / (samples - 1))
    return image


def reference(image):
    """xyz at the points of an image."""
    x, y, z = (image.GetOrigin()[a] + image.GetSpacing()[a] * numpy.arange(image.GetDimensions()[a])
               for a in range(3))
    values = numpy_to_vtk((z[:, None, None] * y[:, None] * x).ravel(), deep=True)
    values.SetName("xyz")
    image.GetPointData().SetScalars(values)
    return image


def interpolated(image, source, method):
    probe = vtkTreeAMRProbeFilter()
    probe.SetInputData(image)
    probe.SetSourceConnection(source.GetOutputPort())
    probe.SetInterpolationMethod(METHODS.index(method))
    probe.Update()
    return probe.GetOutput()


def surface(source, method):
    both = vtkAppendPolyData()
    for low, high in [(0.5, 3.5)] if method == "Nearest" else HALVES:
        image = sample_points(low, high)
        contour = vtkFlyingEdges3D()
        contour.SetInputData(
            reference(image) if method == "Reference" else interpolated(image, source, method))
        contour.SetInputArrayToProcess(0, 0, 0, 0, "xyz")
        contour.SetValue(0, ISOVALUE)
        both.AddInputConnection(contour.GetOutputPort())
    both.Update()
    return both.GetOutput()


def distances(mesh):
    """Of the points from the exact surface, to first order: along the gradient."""
    x, y, z = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float).T
    gradient = numpy.sqrt((y * z) ** 2 + (x * z) ** 2 + (x * y) ** 2)
    return abs(x * y * z - ISOVALUE) / gradient


def show(mesh, title):
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.9, 0.7, 0.4)
    actor.GetProperty().SetSpecular(0.4)
    actor.GetProperty().SetSpecularPower(20)
    text = vtkTextActor()
    text.SetInput(title)
    text.SetPosition(20, 15)
    text.GetTextProperty().SetFontSize(26)
    text.GetTextProperty().SetColor(0, 0, 0)
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    renderer.AddActor(text)
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(2.05, 1.95, 1.95)
    camera.SetPosition(3.5, 7, 8.5)
    camera.SetViewAngle(29)
    renderer.ResetCameraClippingRange()
    return renderer


source = vtkTreeAMRExampleSource()
source.SetDataset(vtkTreeAMRExampleSource.SYNTHETIC)
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(1500, 900)
print(f"{'':<10} {'max':>8} {'mean':>8}")
for i, method in enumerate(METHODS):
    mesh = surface(source, method)
    distance = distances(mesh)
    print(f"{method:<10} {distance.max():8.1e} {distance.mean():8.1e}")
    renderer = show(mesh, method)
    column, row = i % 3, i // 3
    renderer.SetViewport(column / 3, (1 - row) / 2, (column + 1) / 3, (2 - row) / 2)
    window.AddRenderer(renderer)

picture = vtkWindowToImageFilter()
picture.SetInput(window)
picture.ReadFrontBufferOff()
folder.mkdir(exist_ok=True)
writer = vtkPNGWriter()
writer.SetFileName(str(folder / "methods.png"))
writer.SetInputConnection(picture.GetOutputPort())
writer.Write()
print(f"  {folder / 'methods.png'}")
