"""A linear field by ParaView's Volume, from the points of a uniform grid, and by TreeAMR, from the cells of a hyper tree
grid, with transfer functions of every kind, against the integral along each ray in double precision.

The field rises along x from a millionth, as logarithms need it, to 1, and both interpolate it exactly. Rays are parallel
and cross a slab, so that each sees the field change by the same amount; the pixels of a row begin at other values. Rays
that leave through the domain's ends are left out.

Adds the errors to FILE as "function_peers", and the rows of pixels: "exact", "treeamr" and "volume".

usage: pvpython --force-offscreen-rendering function_peers.py FILE
"""

import dataclasses
import json
import pathlib
import random
import sys

import numpy

LOWEST = 1e-6  # the field at x = 0; 1 at x = 1
CELLS = 32  # along x
DEPTH = 0.25  # of the slab, along z, which the rays go down
COLUMNS, ROWS = 500, 20


@dataclasses.dataclass
class Function:
    """Points with linear pieces between them, in the value or, `logarithmic`, in its logarithm."""
    opacities: list  # (value, opacity over `unit`)
    colours: list  # (value, r, g, b)
    unit: float = 0.1  # of length
    logarithmic: bool = False
    change: float = 0.1  # of the field along a ray
    widths: tuple = (1,)  # of pictures that begin at x = 0


def functions():
    """By name; the same kinds as in Testing/Support/VolumeCases.cpp."""
    ramp = [(0, 0, 1, 0.5), (1, 1, 0, 0.5)]
    beside = 1e-9  # ParaView 5.11 joins points at one value

    def spikes(count, half_width, unit):
        points = [(0, 0)]
        for i in range(count):
            at = (i + 0.37) / count
            points += [(at - half_width, 0), (at, 0.9), (at + half_width, 0)]
        return Function([*points, (1, 0)], ramp, unit)

    uniform = random.Random(5).random
    noise = [i / 999 for i in range(1000)]
    return {
        "to opacity 1": Function([(0, 0), (1, 1)], ramp),
        "ramp": Function([(0, 0), (1, 0.9)], ramp),
        "logarithmic": Function([(LOWEST, 0), (1, 0.6)], [(LOWEST, 0, 1, 0.5), (1, 1, 0, 0.5)],
                                logarithmic=True, change=0, widths=(1, 1e-2, 1e-4)),
        "step": Function([(0, 0), (0.5, 0), (0.5 + beside, 0.5), (1, 0.5)], ramp),
        "opaque": Function([(0, 0), (0.5, 0), (0.5 + beside, 1), (1, 1)], ramp),
        "opaque, its colour changes": Function(
            [(0, 0), (0.4, 0), (0.4 + beside, 1), (1, 1)],
            [(0, 0, 1, 0.5), (0.4, 0, 1, 0.5), (0.9, 1, 0, 0.5), (1, 1, 0, 0.5)]),
        "spike 1e-2": spikes(1, 1e-2, 5e-2),
        "spike 1e-4": spikes(1, 1e-4, 5e-4),
        "spike 1e-6": spikes(1, 1e-6, 5e-6),
        "thirty spikes": spikes(30, 1e-4, 1.5e-3),
        "noise": Function([(u, 0.5 * uniform()) for u in noise],
                          [(u, uniform(), uniform(), uniform()) for u in noise]),
        "faint": Function([(0, 0), (1, 0.01)], ramp),
    }


def run_of(function):
    """How far rays go along x."""
    return function.change / (1 - LOWEST)


# --- what is right ---


def interpolated(function, u, values, points):
    """Between points, constant beyond them; u and the points' values."""
    if function.logarithmic:
        u, values = numpy.log(u), numpy.log(values)
    return numpy.array([numpy.interp(u, values, column) for column in points])


def ray_colour(function, begin):
    """Red, green and blue of a ray that sees the values from `begin` on, over black."""
    opacity_values, opacities = zip(*function.opacities)
    colour_values, *colours = zip(*function.colours)
    length = numpy.hypot(DEPTH, run_of(function))
    bends = [u for u in {*opacity_values, *colour_values} if begin < u < begin + function.change]
    ends = numpy.array(sorted([begin, *bends, begin + function.change]))
    count = 16 + 8000 // len(ends)  # midpoints in each piece
    parts = (numpy.arange(count) + 0.5) / count
    u = (ends[:-1, None] + parts * numpy.diff(ends)[:, None]).ravel()
    share = numpy.diff(ends) / function.change if function.change else numpy.ones(1)
    steps = numpy.repeat(share * length / count, count)
    with numpy.errstate(divide="ignore"):
        depth = -numpy.log1p(-interpolated(function, u, opacity_values, [opacities])[0]) / function.unit * steps
    before = numpy.exp(-numpy.concatenate([[0], numpy.cumsum(depth)[:-1]]))
    light = before * -numpy.expm1(-depth)
    return interpolated(function, u, colour_values, colours) @ light


# --- what is drawn ---


def add_values(attributes, size):
    """The field of points or cells along x from 0 to 1."""
    from paraview.vtk.util.numpy_support import numpy_to_vtk

    values = numpy_to_vtk(numpy.tile(numpy.linspace(LOWEST, 1, size[0]), size[1] * size[2]), deep=1)
    values.SetName("value")
    attributes.SetScalars(values)


def make_image():
    from vtkmodules.vtkCommonDataModel import vtkImageData

    image = vtkImageData()
    h = 1 / CELLS
    size = (CELLS + 1, CELLS // 2 + 1, int(DEPTH * CELLS) + 1)
    image.SetDimensions(*size)
    image.SetSpacing(h, h, h)
    image.SetOrigin(0, -0.25, 0)
    add_values(image.GetPointData(), size)
    return image


def make_hyper_tree_grid():
    """Half a cell longer than the field is linear, at each end of x."""
    from paraview.vtk.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkHyperTreeGrid, vtkHyperTreeGridNonOrientedCursor

    grid = vtkHyperTreeGrid()
    h = 1 / CELLS
    size = (CELLS + 1, CELLS // 2, int(DEPTH * CELLS))
    grid.SetBranchFactor(2)
    grid.SetDimensions(*(n + 1 for n in size))
    for set_coordinates, n, origin in zip(
            (grid.SetXCoordinates, grid.SetYCoordinates, grid.SetZCoordinates), size, (-h / 2, -0.25, 0)):
        set_coordinates(numpy_to_vtk(origin + numpy.arange(n + 1) * h, deep=1))
    cursor = vtkHyperTreeGridNonOrientedCursor()
    for tree in range(grid.GetMaxNumberOfTrees()):
        grid.InitializeNonOrientedCursor(cursor, tree, True)
        cursor.SetGlobalIndexStart(tree)
    add_values(grid.GetCellData(), size)
    return grid


def look(view, function, width):
    """At the rays that enter from x = 0 to `width`."""
    slope = run_of(function) / DEPTH
    middle = [width / 2, 0, DEPTH]
    view.CameraParallelProjection = 1
    view.CameraFocalPoint = middle
    view.CameraPosition = [middle[0] - slope, 0, DEPTH + 1]
    view.CameraViewUp = [0, 1, 0]
    # Pixels are as wide as they are high, at a right angle to the rays.
    pixel = width / COLUMNS / numpy.hypot(1, slope)
    view.CameraParallelScale = pixel * ROWS / 2


def begins_of(function, width):
    """The values that a picture's rays begin at."""
    begins = LOWEST + (1 - LOWEST) * (numpy.arange(COLUMNS) + 0.5) / COLUMNS * width
    return begins[begins + function.change < 1]


def exact_row(function):
    """Of all pictures side by side, with 255 for 1."""
    return numpy.array(
        [255 * ray_colour(function, begin) for width in function.widths for begin in begins_of(function, width)])


def drawn_row(function, is_ours):
    from paraview import simple
    from paraview.vtk.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    view = simple.CreateView("RenderView", ViewSize=[COLUMNS, ROWS], OrientationAxesVisibility=0,
                             UseColorPaletteForBackground=0, Background=[0, 0, 0], UseFXAA=0)
    producer = simple.TrivialProducer()
    producer.GetClientSideObject().SetOutput(make_hyper_tree_grid() if is_ours else make_image())
    producer.UpdatePipeline()
    representation = simple.Show(producer, view)
    simple.ColorBy(representation, ("CELLS" if is_ours else "POINTS", "value"))
    representation.SetRepresentationType("Tree AMR Volume" if is_ours else "Volume")
    table = representation.LookupTable
    table.Discretize = 0
    table.ColorSpace = "RGB"
    table.RGBPoints = [x for point in function.colours for x in point]
    table.UseLogScale = int(function.logarithmic)
    opacity = representation.ScalarOpacityFunction
    opacity.UseLogScale = int(function.logarithmic)
    opacity.Points = [x for value, share in function.opacities for x in (value, share, 0.5, 0)]
    representation.ScalarOpacityUnitDistance = function.unit
    rows = []
    for width in function.widths:
        look(view, function, width)
        simple.Render(view)
        colours = vtkUnsignedCharArray()
        view.GetRenderWindow().GetPixelData(0, ROWS // 2, COLUMNS - 1, ROWS // 2, 0, colours, 0)
        rows.append(vtk_to_numpy(colours).reshape(COLUMNS, 3)[:len(begins_of(function, width))])
    simple.Delete(view)
    return numpy.concatenate(rows)


def compare(name, function):
    exact = exact_row(function)
    result = {"function": name, "exact": numpy.rint(exact).astype(int).tolist()}
    for key in ("treeamr", "volume"):
        drawn = drawn_row(function, key == "treeamr")
        difference = abs(drawn - exact)
        result.update({key: drawn.tolist(), f"{key}_error_rms": float(numpy.sqrt((difference ** 2).mean())),
                       f"{key}_error_max": float(difference.max())})
        print(f"{name:<28}{key:<9} of 255: rms {result[key + '_error_rms']:6.2f}, most {difference.max():6.2f}",
              flush=True)
    return result


def main():
    from paraview import simple

    simple._DisableFirstRenderCameraReset()
    path = pathlib.Path(sys.argv[1])
    others = json.loads(path.read_text()) if path.exists() else {}
    path.write_text(json.dumps({
        **others, "function_peers": [compare(*item) for item in functions().items()]}) + "\n")


if __name__ == "__main__":
    main()
