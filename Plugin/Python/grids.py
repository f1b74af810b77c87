"""Grids from numpy's arrays, from data sets of VTK and from files."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkHyperTreeGrid, vtkTable

from .arrays import to_vtk, unmasked
from .updates import Error, Messages, output
from .vtkTreeAMRReader import vtkTreeAMRFromTable, vtkTreeAMRFromUnstructured, vtkTreeAMRP4estReader


def from_cells(level: ArrayLike, ijk: ArrayLike, values: ArrayLike | Mapping[str, ArrayLike],
               origin: Sequence[float] = (0., 0., 0.), spacing: float | Sequence[float] = 1.,
               roots: Sequence[int] | None = None) -> vtkHyperTreeGrid:
    """A grid of the leaves of an octree, or of a forest of octrees.

    level: whole numbers of shape (n,), 0 to 31; or one for all cells. A cell is spacing / 2**level wide.
    ijk: whole numbers of shape (n, 3), from 0 on: indices among the cells of that level, which begin at
        origin + ijk * spacing / 2**level.
    values: of the cells, of shape (n,) or (n, components); several arrays as a dictionary by name. The only one is
        called "values". The first is the active scalars.
    origin: where the first root begins, in the units of the data, as all lengths.
    spacing: the width of a root, along each axis or of all.
    roots: their numbers along the axes; as many as the cells need by default.

    Cells may come in any order; of several at one place the first counts. Where there is none the grid is empty.

    Raises treeamr.Error for numbers that are none of a cell on this lattice and for cells that overlap, ValueError and
    TypeError for shapes and types that do not fit.

    >>> import treeamr
    >>> grid = treeamr.from_cells([1] * 7 + [2] * 8,
    ...     [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1],
    ...      [2, 2, 2], [3, 2, 2], [2, 3, 2], [3, 3, 2], [2, 2, 3], [3, 2, 3], [2, 3, 3], [3, 3, 3]],
    ...     {"density": [1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15.]}, spacing=10.)
    >>> grid.GetNumberOfLeaves(), grid.GetBounds()
    (15, (0.0, 10.0, 0.0, 10.0, 0.0, 10.0))
    """
    indices = np.asarray(unmasked("ijk", ijk))
    if indices.ndim != 2 or indices.shape[1] != 3:
        raise ValueError(f"ijk has the shape {indices.shape}, allowed is (n, 3)")
    count = len(indices)
    levels = np.asarray(unmasked("level", level))
    if levels.ndim == 0:
        levels = np.full(count, levels)
    named = dict(values) if isinstance(values, Mapping) else {"values": values}
    place = [f"treeamr cell {name}" for name in ("level", "i", "j", "k")]
    if taken := set(place) & set(named):
        raise ValueError(f"values has the name {taken.pop()!r}, allowed is any other")
    table = vtkTable()
    columns = [to_vtk(name, column) for name, column in
               zip(place, (levels, indices[:, 0], indices[:, 1], indices[:, 2]))]
    columns += [to_vtk(name, array) for name, array in named.items()]
    for column in columns:
        if column.GetNumberOfTuples() != count:
            raise ValueError(f"'{column.GetName()}' has {column.GetNumberOfTuples()} entries, allowed are {count}, "
                             "one for each row of ijk")
        table.AddColumn(column)
    algorithm = vtkTreeAMRFromTable()
    algorithm.SetInputData(table)
    algorithm.SetLevelColumn(place[0])
    algorithm.SetIColumn(place[1])
    algorithm.SetJColumn(place[2])
    algorithm.SetKColumn(place[3])
    algorithm.SetOrigin(*_three("origin", origin))
    algorithm.SetSpacing(*_three("spacing", spacing))
    numbers = _three("roots", (0, 0, 0) if roots is None else roots)
    if any(number != int(number) for number in numbers):
        raise ValueError(f"roots is {roots}, allowed are whole numbers")
    algorithm.SetRoots(*map(int, numbers))
    return output(algorithm)


def _three(name: str, values) -> list[float]:
    array = np.asarray(values)
    if array.shape not in ((), (3,)):
        raise ValueError(f"{name} has the shape {array.shape}, allowed are one number and three")
    return np.broadcast_to(array, 3).tolist()


def from_unstructured(data: vtkDataObject) -> vtkHyperTreeGrid:
    """A grid of the octree that a simulation wrote as hexahedra or voxels.

    data: a vtkUnstructuredGrid, or a composite data set of them, which become one grid.

    Cell arrays stay as they are; scalars of points in floating point become values at the cells' corners, which are
    interpolated exactly. vtkTreeAMRFromUnstructured has all of the rules.

    Raises treeamr.Error for cells that are no boxes along the axes or fit no octree, naming the first.
    """
    if not isinstance(data, vtkDataObject) or not (data.IsA("vtkUnstructuredGrid") or data.IsA("vtkCompositeDataSet")):
        raise TypeError(f"data is a {type(data).__name__}, allowed are a vtkUnstructuredGrid and a vtkCompositeDataSet")
    algorithm = vtkTreeAMRFromUnstructured()
    algorithm.SetInputDataObject(data)
    return output(algorithm)


def read(path: str | os.PathLike, payload: str = "", arrays: str | Sequence[str] | None = None) -> vtkHyperTreeGrid:
    """A file's grid: a forest of p4est (.p8est, .p4est or any other name), a checkpoint of deal.II (NAME.info), a .htg, or an
    octree written as hexahedra (.vtu, .pvtu).

    payload: what the bytes of a forest's quadrants are, for example "double rho; float velocity[3]"; see
        vtkTreeAMRP4estReader. Of other files: none.
    arrays: the names of those to read of a forest; all by default.

    Raises FileNotFoundError, and treeamr.Error for a file that cannot be read, naming it.
    """
    file = pathlib.Path(path)
    if not file.exists():
        raise FileNotFoundError(f"{file}: no such file")
    suffix = file.suffix.lower()
    if suffix in (".htg", ".vtu", ".pvtu"):
        if payload or arrays is not None:
            raise ValueError(f"{file}: payload and arrays are of forests, allowed are none")
        from vtkmodules import vtkIOXML  # only where it is used
        reader = {".htg": vtkIOXML.vtkXMLHyperTreeGridReader, ".vtu": vtkIOXML.vtkXMLUnstructuredGridReader,
                  ".pvtu": vtkIOXML.vtkXMLPUnstructuredGridReader}[suffix]()
        reader.SetFileName(str(file))
        try:
            data = output(reader)
        except Error as error:  # VTK's do not name the file
            raise Error(f"{file}: {error}") from None
        return data if suffix == ".htg" else from_unstructured(data)
    reader = vtkTreeAMRP4estReader()
    reader.SetFileName(str(file))
    reader.SetPayload(payload)
    if arrays is not None:
        with Messages(reader, reader.GetExecutive()):
            reader.UpdateInformation()
        arrays = [arrays] if isinstance(arrays, str) else arrays
        known = [reader.GetCellArrayName(i) for i in range(reader.GetNumberOfCellArrays())]
        if unknown := set(arrays) - set(known):
            raise Error(f"{file}: no arrays are called {', '.join(sorted(map(repr, unknown)))}; "
                        f"there are {', '.join(map(repr, known)) or 'none'}")
        for name in known:
            reader.SetCellArrayStatus(name, int(name in arrays))
    return output(reader)
