"""An isosurface in the colours of the cells' levels, each cell in its own, smooth across all of them: levels.png.

usage: pvpython levels.py FOLDER
"""

import pathlib
import sys

import numpy as np
import treeamr
from paraview.simple import *


def gyroid(points):
    x, y, z = 4 * np.pi * points.T
    return np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)


# Cells that the surface may meet are divided, more often near three places.
places = np.array([[0.9, 0.7, 0.9], [0.2, 0.9, 0.8], [0.5, 0.2, 1.0]])
levels, indices = [], []
cells = np.array([[0, 0, 0]])
octants = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
for level in range(8):
    centres = (cells + 0.5) / 2**level
    distance = np.linalg.norm(centres[:, None] - places, axis=2).min(axis=1)
    divided = (level < 7.5 - 9 * distance) & (level < 7) & (np.abs(gyroid(centres)) < 30 / 2**level) | (level < 3)
    levels.append(np.full(np.count_nonzero(~divided), level))
    indices.append(cells[~divided])
    cells = (2 * cells[divided][:, None] + octants).reshape(-1, 3)
level, ijk = np.concatenate(levels), np.concatenate(indices)
field = gyroid((ijk + 0.5) / 2.0**level[:, None])
grid = TrivialProducer()
grid.GetClientSideObject().SetOutput(treeamr.from_cells(level, ijk, {"gyroid": field, "level": level}))

view = CreateView("RenderView", ViewSize=[800, 620], OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
                  Background=[1, 1, 1])
surface = Show(grid, view)
ColorBy(surface, ("CELLS", "level"))
surface.SetRepresentationType("Tree AMR Isosurface")
surface.IsosurfaceArray = ["CELLS", "gyroid"]
surface.Isovalues = [0]
surface.LookupTable.InterpretValuesAsCategories = 1
surface.LookupTable.Annotations = ["3", "3", "4", "4", "5", "5", "6", "6", "7", "7"]
surface.LookupTable.IndexedColors = [
    0.13, 0.19, 0.38, 0.16, 0.45, 0.56, 0.55, 0.72, 0.45, 0.95, 0.75, 0.35, 0.85, 0.35, 0.22]
surface.AmbientOcclusionSamples = 32
surface.AmbientOcclusionRadius = 0.1

view.CameraPosition = [1.4, 1.3, 2.3]
view.CameraFocalPoint = [0.5, 0.48, 0.5]
view.CameraViewUp = [0, 1, 0]
SaveScreenshot(str(pathlib.Path(sys.argv[1]) / "levels.png"), view)
