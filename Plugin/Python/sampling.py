"""The field of a grid at points and on isosurfaces, as numpy's arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkHyperTreeGrid, vtkPolyData

from .arrays import chosen_array, to_vtk, unmasked
from .updates import output
from .vtkTreeAMRReader import vtkTreeAMRContourFilter, vtkTreeAMRProbeFilter

METHODS = ("nearest", "current", "finest", "octant", "gti")


class Isosurface(NamedTuple):
    """A closed mesh, but where the surface leaves the grid."""

    vertices: np.ndarray
    """float64 of shape (n, 3), in the units of the data"""
    triangles: np.ndarray
    """int64 of shape (m, 3): vertices, counterclockwise seen from where values are lower"""
    normals: np.ndarray
    """float32 of shape (n, 3), of length 1, towards lower values; smooth across cells of all levels"""


def probe(grid: vtkHyperTreeGrid, points: ArrayLike, array: str | None = None, method: str = "gti",
          gradients: bool = False) -> np.ndarray | tuple[np.ndarray, np.ndarray]:
    """The field at points.

    points: of shape (..., 3), in the units of the data.
    array: name of a cell array; the active scalars, or else the first, by default.
    method: how values between the cells' centres are reconstructed: "gti" (continuous), "octant", "finest", "current" or
        "nearest" (the cell's own).
    gradients: also return them, per unit of length.

    Returns the values, of shape (...) or, of an array of several components, (..., components), as floats; NaN where a point
    is outside of all cells. With gradients a pair: of scalars they have the shape (..., 3), of others (..., components, 3).

    Raises KeyError for an array that there is not, ValueError for a shape or method that is none of these.

    >>> import numpy, treeamr
    >>> centres = numpy.stack(numpy.meshgrid(*3 * [numpy.arange(4)], indexing="ij"), axis=-1).reshape(-1, 3)
    >>> grid = treeamr.from_cells(2, centres, centres @ [1., 10., 100.])
    >>> treeamr.probe(grid, [[0.5, 0.5, 0.5], [0.5, 0.5, 1.5]])
    array([166.5,   nan])
    """
    places = np.asarray(unmasked("points", points), dtype=np.float64)
    if places.ndim == 0 or places.shape[-1] != 3:
        raise ValueError(f"points has the shape {places.shape}, allowed is (..., 3)")
    if method not in METHODS:
        raise ValueError(f"method is {method!r}, allowed are {', '.join(map(repr, METHODS))}")
    name = chosen_array(grid, array)
    at = vtkPoints()
    at.SetData(to_vtk("points", places.reshape(-1, 3)))
    data = vtkPolyData()
    data.SetPoints(at)
    algorithm = vtkTreeAMRProbeFilter()
    algorithm.SetInputData(data)
    algorithm.SetSourceData(grid)
    algorithm.SetInterpolationMethod(METHODS.index(method))
    algorithm.SetComputeGradients(gradients)
    algorithm.GetCellDataArraySelection().EnableArray(name)
    found = output(algorithm).GetPointData()
    outside = vtk_to_numpy(found.GetArray(algorithm.GetValidPointMaskArrayName())) == 0

    def taken(result: str, shape: tuple[int, ...]) -> np.ndarray:
        values = vtk_to_numpy(found.GetArray(result))
        values = values.astype(values.dtype if values.dtype.kind == "f" else np.float64)
        values[outside] = np.nan
        return values.reshape(places.shape[:-1] + shape)[()]

    components = found.GetArray(name).GetNumberOfComponents()
    shape = () if components == 1 else (components,)
    values = taken(name, shape)
    return (values, taken(name + "_gradient", shape + (3,))) if gradients else values


def isosurface(grid: vtkHyperTreeGrid, value: float | Sequence[float], array: str | None = None,
               component: int = 0) -> Isosurface:
    """The surface on which the continuous field has a value, as triangles without cracks across levels.

    value: the isovalue, or several, whose surfaces come one after the other.
    array: name of a cell array; the active scalars, or else the first, by default.
    component: of it; -1 for the magnitude.

    Raises KeyError for an array that there is not.

    >>> import numpy, treeamr
    >>> centres = numpy.stack(numpy.meshgrid(*3 * [numpy.arange(8)], indexing="ij"), axis=-1).reshape(-1, 3)
    >>> grid = treeamr.from_cells(3, centres, numpy.linalg.norm(centres - 3.5, axis=1), spacing=8.)
    >>> vertices, triangles, normals = treeamr.isosurface(grid, 2.5)
    >>> bool(abs(numpy.linalg.norm(vertices - 4., axis=1) - 2.5).max() < 0.1)
    True
    """
    values = np.atleast_1d(np.asarray(value, dtype=np.float64))
    name = chosen_array(grid, array)
    algorithm = vtkTreeAMRContourFilter()
    algorithm.SetInputData(grid)
    algorithm.SetInputArrayToProcess(0, 0, 0, "vtkDataObject::FIELD_ASSOCIATION_CELLS", name)
    algorithm.SetComponent(component)
    algorithm.SetNumberOfContours(len(values))
    for i, isovalue in enumerate(values):
        algorithm.SetValue(i, isovalue)
    algorithm.SetComputeScalars(False)
    algorithm.SetSelectionIsFinal(True)  # no other array
    mesh = output(algorithm)
    if mesh.GetNumberOfPoints() == 0:
        return Isosurface(np.empty((0, 3)), np.empty((0, 3), np.int64), np.empty((0, 3), np.float32))
    return Isosurface(vtk_to_numpy(mesh.GetPoints().GetData()).copy(),
                      vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64),
                      vtk_to_numpy(mesh.GetPointData().GetNormals()).copy())
