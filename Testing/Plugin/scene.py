"""What the tests of the plugin share: a small view, its picture as an array, colour maps of one colour, memory."""

import ctypes
import gc
import json
import os
import sys
import unittest

import numpy
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkHyperTreeGridNonOrientedGeometryCursor
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkFeatureEdges
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

BACKGROUND = (0, 0, 0)

PARAVIEW = (servermanager.vtkSMProxyManager.GetVersionMajor(), servermanager.vtkSMProxyManager.GetVersionMinor())
VIRIDIS = "Viridis" if PARAVIEW >= (6, 1) else "Viridis (matplotlib)"
# The property of displays that moves their data.
TRANSLATION = "Translation" if PARAVIEW >= (5, 13) else "Position"


def of_display(name):
    """What displays call a property of their representations."""
    return TRANSLATION if name == "Position" else name


class TestCase(unittest.TestCase):
    """Each test has a session of its own. What it keeps in its attributes must be released before the next
    one: a view that outlives its session takes the OpenGL context with it."""

    def setUp(self):
        simple.ResetSession()
        self.kept = set(vars(self))

    def tearDown(self):
        for name in set(vars(self)) - self.kept:
            delattr(self, name)


def main():
    """Runs the tests of the script with their report on stdout: on stderr it would pass for an error."""
    # Not by sys.exit(): pvpython then dies of an X error when there has been more than one session.
    program = unittest.main(
        argv=sys.argv[:1], testRunner=unittest.TextTestRunner(stream=sys.stdout, verbosity=2), exit=False)
    if not program.result.wasSuccessful():
        sys.exit(1)


def view(width=240, height=180):
    """A view with a black background and nothing but the data in it."""
    result = simple.CreateView(
        "RenderView", ViewSize=[width, height], UseColorPaletteForBackground=0,
        Background=[c / 255 for c in BACKGROUND], OrientationAxesVisibility=0, UseFXAA=0)
    simple.SetActiveView(result)
    return result


def look(render_view, direction=(1, 0.8, 2)):
    """A camera that shows all the data from this direction."""
    camera = render_view.GetActiveCamera()
    camera.SetFocalPoint(0, 0, 0)
    camera.SetPosition(*direction)
    camera.SetViewUp(0, 1, 0)
    simple.ResetCamera(render_view)


def picture(render_view, name):
    """The picture as load() has it, also saved as <name>.png in the folder that is the last argument."""
    path = os.path.join(sys.argv[-1], name + ".png")
    simple.SaveScreenshot(path, render_view)
    return load(path)


def load(path):
    """A saved picture as an array [row, column, rgb] of 0 to 255."""
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    return array(reader.GetOutput())


def shown(window):
    """What a window shows, the same kind of array; nothing is rendered, as it would be for a screenshot."""
    picture = vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ShouldRerenderOff()
    picture.ReadFrontBufferOff()
    picture.Update()
    return array(picture.GetOutput())


def exported(path, render_view):
    """What a glTF exporter writes: the numbers of points, of colours and of triangles; zeros when nothing is written."""
    simple.ExportView(path, view=render_view)
    with open(path, encoding="utf-8") as file:
        gltf = json.load(file)
    meshes = gltf.get("meshes") or []
    if not meshes:
        return 0, 0, 0
    ((primitive,),) = (mesh["primitives"] for mesh in meshes)
    points, colours, corners = (
        gltf["accessors"][accessor]["count"] if accessor is not None else 0
        for accessor in (primitive["attributes"]["POSITION"], primitive["attributes"].get("COLOR_0"),
                         primitive["indices"]))
    return points, colours, corners // 3


def contoured(source, **arguments):
    """How many points and triangles a Tree AMR Contour has, on all ranks."""
    contour = simple.TreeAMRContour(Input=source, **arguments)
    contour.UpdatePipeline()
    information = contour.GetDataInformation()
    numbers = information.GetNumberOfPoints(), information.GetNumberOfCells()
    simple.Delete(contour)
    return numbers


def open_edges(source, low, high):
    """Of the triangles of all ranks, when equal points are one: how many points there are, how many edges have one triangle
    alone, and how many of these do not lie in the faces of the cube from low to high."""
    clean = vtkCleanPolyData()
    clean.SetInputData(servermanager.Fetch(source))
    clean.SetTolerance(0)
    edges = vtkFeatureEdges()
    edges.SetInputConnection(clean.GetOutputPort())
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.Update()
    inside = 0
    for i in range(edges.GetOutput().GetNumberOfCells()):
        bounds = edges.GetOutput().GetCell(i).GetBounds()
        inside += not any(
            bounds[2 * a] == bounds[2 * a + 1] and bounds[2 * a] in (low, high) for a in range(3))
    return clean.GetOutput().GetNumberOfPoints(), edges.GetOutput().GetNumberOfCells(), inside


def leaf_boxes(grid):
    """[[xmin, ymin, zmin], [xmax, ymax, zmax]] of the leaves, but for masked ones, by their place in the cell arrays."""
    boxes = {}

    def add(cursor):
        if cursor.IsMasked():
            return
        if cursor.IsLeaf():
            bounds = [0] * 6
            cursor.GetBounds(bounds)
            boxes[cursor.GetGlobalNodeIndex()] = numpy.reshape(bounds, (3, 2)).T
            return
        for child in range(8):
            cursor.ToChild(child)
            add(cursor)
            cursor.ToParent()

    cursor = vtkHyperTreeGridNonOrientedGeometryCursor()
    for tree in range(grid.GetMaxNumberOfTrees()):
        cursor.Initialize(grid, tree, False)
        if cursor.HasTree():
            add(cursor)
    return boxes


def extracted(grid):
    """The leaves that Extract Selection gives. Before ParaView 5.13 it marks them; since then all others are masked."""
    if PARAVIEW < (5, 13):
        return set(numpy.nonzero(vtk_to_numpy(grid.GetCellData().GetArray("vtkInsidedness")))[0])
    return set(leaf_boxes(grid))


def extracted_alone(marked):
    """What shows the cells that Extract Selection gives, and no others."""
    if PARAVIEW < (5, 13):
        return simple.Threshold(
            Input=marked, Scalars=["CELLS", "vtkInsidedness"], LowerThreshold=1, UpperThreshold=1)
    return marked


def array(image):
    columns, rows, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(rows, columns, -1).astype(int)


def drawn(image):
    """Which pixels differ from the background."""
    return (image != BACKGROUND).any(axis=2)


def set_colour(lookup_table, low, high, rgb):
    """One colour for all values."""
    lookup_table.RGBPoints = [low, *rgb, high, *rgb]


def set_opacity(function, low, high, opacity):
    """One opacity for all values."""
    function.Points = [low, opacity, 0.5, 0.0, high, opacity, 0.5, 0.0]


def with_categories(source):
    """The grids of a source with an array of whole numbers, "id", from 0 to 5."""
    return simple.ProgrammableFilter(Input=source, OutputDataSetType="Same as Input", Script="""
import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
ids = numpy_to_vtk(numpy.arange(grid.GetNumberOfCells()) * 7 % 6, deep=1)
ids.SetName('id')
grid.GetCellData().AddArray(ids)
""")


def with_pressure(source):
    """The grids of a source with the arrays "less", from -0.001 to 0.001, and "pressure", 101325 more."""
    return simple.ProgrammableFilter(Input=source, OutputDataSetType="Same as Input", Script="""
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
less = 0.001 * (vtk_to_numpy(grid.GetCellData().GetArray('xyz')) / 32 - 1)
for name, values in ('less', less), ('pressure', 101325 + less):
    array = numpy_to_vtk(values, deep=1)
    array.SetName(name)
    grid.GetCellData().AddArray(array)
""")


def set_categories(lookup_table):
    """Of the "id" from 0 to 4; 5 is not listed: yellow."""
    lookup_table.InterpretValuesAsCategories = 1
    lookup_table.Annotations = ["0", "a", "1", "b", "2", "c", "3", "d", "4", "e"]
    lookup_table.IndexedColors = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1, 0, 1]
    lookup_table.NanColor = [1, 1, 0]


def colours(image):
    return {tuple(pixel) for pixel in image.reshape(-1, 3)}


def close(images):
    """Whether two pictures agree up to the rounding of a colour."""
    first, second = images
    return numpy.abs(first - second).max() <= 1


def resident_mib():
    """Of this process, after all that can be given back is."""
    gc.collect()
    ctypes.CDLL("libc.so.6").malloc_trim(0)
    with open("/proc/self/statm") as pages:
        return int(pages.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
