"""Between numpy's arrays and VTK's."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkDataArray
from vtkmodules.vtkCommonDataModel import vtkHyperTreeGrid


def unmasked(name: str, values: ArrayLike) -> ArrayLike:
    """The values themselves. Raises ValueError where some of them do not count."""
    if np.ma.is_masked(values):
        raise ValueError(f"'{name}' is a masked array, allowed are arrays whose entries all count (NaN leaves a cell out)")
    return values


def to_vtk(name: str, values: ArrayLike) -> vtkDataArray:
    """An array of VTK that shares the memory of contiguous values, of shape (n,) or (n, components)."""
    unmasked(name, values)
    if not isinstance(name, str):
        raise TypeError(f"the name of an array is {name!r}, allowed is a str")
    array = np.asarray(values)
    if array.dtype == bool:
        array = array.astype(np.uint8)
    elif array.dtype == np.float16:
        array = array.astype(np.float32)
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
        raise TypeError(f"'{name}' has the type {array.dtype}, allowed are integers, booleans and floats of up to 8 bytes")
    if array.ndim not in (1, 2):
        raise ValueError(f"'{name}' has the shape {array.shape}, allowed are (n,) and (n, components)")
    result = numpy_to_vtk(np.ascontiguousarray(array.astype(array.dtype.newbyteorder("="), copy=False)))
    result.SetName(name)
    return result


def checked_grid(grid) -> vtkHyperTreeGrid:
    """The grid itself. Raises TypeError for anything else."""
    if not isinstance(grid, vtkHyperTreeGrid):
        raise TypeError(f"grid is a {type(grid).__name__}, allowed is a vtkHyperTreeGrid: "
                        "see treeamr.read, treeamr.from_cells and treeamr.from_unstructured")
    return grid


def chosen_array(grid: vtkHyperTreeGrid, array: str | None) -> str:
    """The array's name: the active scalars' or the first one's where none is given. Raises KeyError."""
    cells = checked_grid(grid).GetCellData()
    names = [cells.GetArrayName(i) for i in range(cells.GetNumberOfArrays())]
    if not names:
        raise KeyError("the grid has no cell arrays")
    if array is None:
        array = cells.GetScalars().GetName() if cells.GetScalars() else names[0]
    if array not in names:
        raise KeyError(f"no cell array is called {array!r}; there are {', '.join(map(repr, names))}")
    return array
