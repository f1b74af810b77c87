"""Pictures of grids in one call, without a window."""

from __future__ import annotations

import os
import pathlib
import sys
from collections.abc import Sequence

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - makes the window's class known
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkHyperTreeGrid, vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import (vtkActor, vtkColorTransferFunction, vtkRenderer, vtkRenderWindow, vtkVolume,
                                         vtkVolumeProperty, vtkWindowToImageFilter)

from .arrays import chosen_array, to_vtk
from .updates import Messages

VIRIDIS = ((0.267, 0.005, 0.329), (0.254, 0.265, 0.530), (0.164, 0.471, 0.558), (0.135, 0.659, 0.518),
           (0.478, 0.821, 0.318), (0.993, 0.906, 0.144))
"""Samples at equal distances of matplotlib's colour map of that name."""


class Picture(np.ndarray):
    """uint8 of shape (height, width, 3), the first row at the top; a notebook shows it."""

    def png(self) -> bytes:
        """As a PNG file. Raises ValueError for what arithmetic has made of it."""
        _check("the picture's type", self.dtype, self.dtype == np.uint8, "uint8")
        _check("the picture's shape", self.shape, self.ndim == 3 and self.shape[2] == 3, "(height, width, 3)")
        from vtkmodules.vtkIOImage import vtkPNGWriter
        image = vtkImageData()
        image.SetDimensions(self.shape[1], self.shape[0], 1)
        image.GetPointData().SetScalars(to_vtk("colors", np.flipud(np.asarray(self)).reshape(-1, 3)))
        writer = vtkPNGWriter()
        writer.SetInputData(image)
        writer.WriteToMemoryOn()
        writer.Write()
        result: vtkUnsignedCharArray = writer.GetResult()
        return vtk_to_numpy(result).tobytes()

    def save(self, path: str | os.PathLike) -> None:
        """Writes a PNG file. Raises ValueError for the name of another."""
        _check("path", path, pathlib.Path(path).suffix.lower() in ("", ".png"), "names that end in .png")
        with open(path, "wb") as file:
            file.write(self.png())

    def _repr_png_(self) -> bytes | None:
        return self.png() if self.ndim == 3 and self.shape[2] == 3 and self.dtype == np.uint8 else None


def render(grid: vtkHyperTreeGrid, array: str | None = None, isovalues: float | Sequence[float] | None = None, *,
           volume: bool | None = None, range: Sequence[float] | None = None,
           colors: Sequence[Sequence[float]] | vtkColorTransferFunction = VIRIDIS,
           opacity: float | Sequence[float] | vtkPiecewiseFunction = (0., 0.8), shade: bool = False,
           occlusion: int = 0, direction: Sequence[float] = (-1., -1.6, -0.9), up: Sequence[float] = (0., 0., 1.),
           zoom: float = 1., size: Sequence[int] = (800, 600), background: Sequence[float] = (1., 1., 1.),
           samples_per_cell: float = 2.) -> Picture:
    """A picture of a volume, of isosurfaces, or of both.

    array: name of a cell array; the active scalars, or else the first, by default. Of vectors: the magnitude.
    isovalues: of surfaces to draw.
    volume: whether to draw the volume; by default when there are no isovalues.
    range: the values that the first and the last of the colours and opacities are at; those of the data by default.
    colors: (red, green, blue), each 0 to 1, at equal distances over the range; or any function of VTK.
    opacity: of the volume, likewise, per fiftieth of the grid's diagonal; or any function of VTK. A number: of all values.
    shade: whether the lamp at the camera lights the volume; it always lights surfaces.
    occlusion: rays a pixel that darken what is near other parts of the surfaces; 16 show no grain.
    direction, up: which way the camera looks, and what is up in the picture. It sees all of the grid at zoom 1.
    size: (width, height) in pixels.
    samples_per_cell: more of them are more accurate and take more time.

    Raises KeyError for an array that there is not, ValueError for what is none of these, treeamr.Error for what cannot be
    drawn, RuntimeError where VTK needs a display and there is none (xvfb-run makes one).

    >>> import numpy, treeamr
    >>> centres = numpy.stack(numpy.meshgrid(*3 * [numpy.arange(8)], indexing="ij"), axis=-1).reshape(-1, 3)
    >>> grid = treeamr.from_cells(3, centres, numpy.linalg.norm(centres - 3.5, axis=1))
    >>> picture = treeamr.render(grid, isovalues=2.5, size=(160, 120))
    >>> picture.shape, picture.png()[:4]
    ((120, 160, 3), b'\\x89PNG')
    """
    name = chosen_array(grid, array)
    _check("isovalues", isovalues, isovalues is None or np.ndim(isovalues) <= 1, "a number, or a list of some")
    values = [] if isovalues is None else np.atleast_1d(np.asarray(isovalues, dtype=np.float64)).tolist()
    with_volume = not values if volume is None else volume
    if not with_volume and not values:
        raise ValueError("volume is off and isovalues has none, needed is one of the two")
    low, high = grid.GetCellData().GetArray(name).GetFiniteRange(-1) if range is None else range
    if range is not None and not (np.isfinite([low, high]).all() and low <= high):
        raise ValueError(f"range is {range}, allowed are two finite numbers, the smaller first")
    for what, vector in (("direction", direction), ("up", up)):
        _check(what, vector, np.shape(vector) == (3,) and np.isfinite(vector).all() and np.any(vector),
               "three finite numbers, not all 0")
    for what, switch in (("volume", volume), ("shade", shade)):
        _check(what, switch, switch is None or isinstance(switch, (bool, np.bool_, int)), "True and False")
    _check("occlusion", occlusion, np.ndim(occlusion) == 0 and occlusion == int(occlusion) and 0 <= occlusion <= 65535,
           "whole numbers from 0 to 65535")
    _check("samples_per_cell", samples_per_cell, 0.01 <= samples_per_cell <= 1024, "numbers from 0.01 to 1024")
    _check("zoom", zoom, np.isfinite(zoom) and zoom > 0, "finite numbers above 0")
    _check("size", size, np.shape(size) == (2,) and all(n == int(n) and 1 <= n <= 16384 for n in size),
           "(width, height), whole numbers from 1 to 16384")
    _check("background", background, np.shape(background) == (3,) and _are_parts(background), "three numbers from 0 to 1")
    bounds = _bounds(grid)
    diagonal = float(np.linalg.norm(bounds[:, 1] - bounds[:, 0]))
    if not 1e-15 < diagonal < 1e15:
        # VTK's cameras are never nearer than 1e-20, and square lengths.
        grid = _resized(grid, bounds.mean(axis=1), 1. / (bounds[:, 1] - bounds[:, 0]).max())
        bounds = _bounds(grid)
        diagonal = float(np.linalg.norm(bounds[:, 1] - bounds[:, 0]))
    function = _color_function(colors, low, high)

    renderer = vtkRenderer()
    renderer.SetBackground(background)
    window = _window()
    window.SetSize(int(size[0]), int(size[1]))
    window.AddRenderer(renderer)
    mappers = []
    if with_volume:
        prop, mapper = _volume(grid, name, function, _opacity_function(opacity, low, high), diagonal / 50., shade)
        mapper.SetSamplesPerCell(samples_per_cell)
        renderer.AddVolume(prop)
        mappers.append(mapper)
    if values:
        actor, mapper = _surfaces(grid, name, values, function)
        mapper.SetAmbientOcclusionSamples(occlusion)
        renderer.AddActor(actor)
        mappers.append(mapper)
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(bounds.mean(axis=1))
    camera.SetPosition(bounds.mean(axis=1) - np.asarray(direction, dtype=np.float64))
    camera.SetViewUp(up)
    renderer.ResetCamera(bounds.ravel())
    camera.Zoom(zoom)
    with Messages(*mappers):
        window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    image.Update()
    pixels = vtk_to_numpy(image.GetOutput().GetPointData().GetScalars())
    window.Finalize()
    return np.flipud(pixels.reshape(int(size[1]), int(size[0]), 3)).copy().view(Picture)


def _check(name: str, value, holds: bool, allowed: str) -> None:
    if not holds:
        raise ValueError(f"{name} is {value}, allowed are {allowed}")


def _are_parts(values) -> bool:
    """Whether all are from 0 to 1."""
    array = np.asarray(values, dtype=np.float64)
    return bool(((array >= 0) & (array <= 1)).all())


def _window() -> vtkRenderWindow:
    window = vtkRenderWindow()
    if window.IsA("vtkXOpenGLRenderWindow") and sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        raise RuntimeError("this VTK draws with an X display and there is none: set DISPLAY, or run under xvfb-run")
    window.SetOffScreenRendering(True)
    return window


def _bounds(grid: vtkHyperTreeGrid) -> np.ndarray:
    """The lowest and the highest coordinate along each axis, of shape (3, 2). VTK 9.3's own do not follow the grid's
    coordinates."""
    from .vtkTreeAMRRendering import vtkTreeAMRIsosurfaceMapper

    mapper = vtkTreeAMRIsosurfaceMapper()
    mapper.SetInputData(grid)
    return np.reshape(mapper.GetBounds(), (3, 2))


def _resized(grid: vtkHyperTreeGrid, centre, factor: float) -> vtkHyperTreeGrid:
    """Scaled about a centre, which becomes the origin."""
    result = vtkHyperTreeGrid()
    result.ShallowCopy(grid)
    for axis, of in zip("XYZ", centre):
        planes = vtk_to_numpy(getattr(grid, f"Get{axis}Coordinates")()).astype(np.float64)
        getattr(result, f"Set{axis}Coordinates")(to_vtk(axis, factor * (planes - of)))
    return result


def _color_function(colors, low: float, high: float) -> vtkColorTransferFunction:
    if isinstance(colors, vtkColorTransferFunction):
        return colors
    samples = np.asarray(colors, dtype=np.float64)
    if samples.ndim != 2 or samples.shape[1] != 3 or len(samples) == 0:
        raise ValueError(f"colors has the shape {samples.shape}, allowed is (n, 3)")
    _check("colors", samples.tolist(), _are_parts(samples), "numbers from 0 to 1")
    function = vtkColorTransferFunction()
    for value, color in zip(np.linspace(low, high, len(samples)), samples):
        function.AddRGBPoint(value, *color)
    return function


def _opacity_function(opacity, low: float, high: float) -> vtkPiecewiseFunction:
    if isinstance(opacity, vtkPiecewiseFunction):
        return opacity
    samples = np.atleast_1d(np.asarray(opacity, dtype=np.float64))
    if samples.ndim != 1 or len(samples) == 0:
        raise ValueError(f"opacity has the shape {samples.shape}, allowed are one number and (n,)")
    _check("opacity", samples.tolist(), _are_parts(samples), "numbers from 0 to 1")
    function = vtkPiecewiseFunction()
    for value, alpha in zip(np.linspace(low, high, len(samples)), samples):
        function.AddPoint(value, alpha)
    return function


def _volume(grid, name: str, colors, opacity, unit: float, shade: bool):
    from .vtkTreeAMRRendering import vtkTreeAMRVolumeMapper
    mapper = vtkTreeAMRVolumeMapper()
    mapper.SetInputData(grid)
    mapper.SetScalarModeToUseCellFieldData()
    mapper.SelectScalarArray(name)
    mapper.AutoAdjustSampleDistancesOff()
    properties = vtkVolumeProperty()
    properties.SetInterpolationTypeToLinear()
    properties.SetColor(colors)
    properties.SetScalarOpacity(opacity)
    properties.SetScalarOpacityUnitDistance(unit)
    properties.SetShade(shade)
    prop = vtkVolume()
    prop.SetMapper(mapper)
    prop.SetProperty(properties)
    return prop, mapper


def _surfaces(grid, name: str, values: list[float], colors):
    from .vtkTreeAMRRendering import vtkTreeAMRIsosurfaceMapper
    mapper = vtkTreeAMRIsosurfaceMapper()
    mapper.SetInputData(grid)
    mapper.SetInputArrayToProcess(0, 0, 0, "vtkDataObject::FIELD_ASSOCIATION_CELLS", name)
    mapper.SetNumberOfContours(len(values))
    for i, value in enumerate(values):
        mapper.SetValue(i, value)
    mapper.SetScalarModeToUseCellFieldData()
    mapper.SelectColorArray(name)
    mapper.SetLookupTable(colors)
    mapper.UseLookupTableScalarRangeOn()
    mapper.AutoAdjustSampleDistancesOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    return actor, mapper
