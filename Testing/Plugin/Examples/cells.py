"""Cells of one's own as numpy arrays: a grid, its field at points, an isosurface and pictures, without files or windows.

usage: pvpython cells.py FOLDER
"""

import pathlib
import sys

import numpy as np
import treeamr

folder = pathlib.Path(sys.argv[1])

# The cells of a sphere's octree: those that its surface meets are divided, down to level 6.
levels, indices = [], []
cells = np.array([[0, 0, 0]])
octants = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
for level in range(7):
    width = 1 / 2**level
    distance = np.linalg.norm((cells + 0.5) * width - 0.5, axis=1) - 0.3
    divided = (np.abs(distance) < width) & (level < 6)
    levels.append(np.full(np.count_nonzero(~divided), level))
    indices.append(cells[~divided])
    cells = (2 * cells[divided][:, None] + octants).reshape(-1, 3)
level, ijk = np.concatenate(levels), np.concatenate(indices)
centres = (ijk + 0.5) / 2.0**level[:, None]
radius = np.linalg.norm(centres - 0.5, axis=1)

grid = treeamr.from_cells(level, ijk, {"radius": radius})
print(grid.GetNumberOfLeaves(), "cells")

line = np.linspace([0.5, 0.5, 0.5], [0.9, 0.5, 0.5], 5)
print("radius along a line:", treeamr.probe(grid, line).round(2))

vertices, triangles, normals = treeamr.isosurface(grid, 0.3)
print(len(triangles), "triangles; distance from the sphere:",
      np.abs(np.linalg.norm(vertices - 0.5, axis=1) - 0.3).max().round(4))

# In a notebook, `treeamr.render(grid)` at the end of a cell shows the picture.
treeamr.render(grid).save(folder / "volume.png")
treeamr.render(grid, isovalues=0.3, occlusion=16).save(folder / "isosurface.png")
