"""A volume and an isosurface in it with ambient occlusion, cut in half, before the cells of a slice: everything.png.

usage: pvpython everything.py FOLDER
"""

import pathlib
import sys

from paraview.simple import *

grid = TreeAMRExample()
view = CreateView("RenderView", ViewSize=[760, 530], OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
                  Background=[1, 1, 1])

volume = Show(grid, view)
ColorBy(volume, ("CELLS", "sheet"))
volume.SetRepresentationType("Tree AMR Volume")
volume.LookupTable.ColorSpace = "Lab"
volume.LookupTable.RGBPoints = [
    0.0, 0.95, 0.96, 0.97, 0.12, 0.62, 0.77, 0.88, 0.35, 0.16, 0.38, 0.62, 0.47, 0.25, 0.25, 0.45, 0.53, 0.93, 0.55, 0.2,
    0.8, 0.98, 0.78, 0.35, 1.2, 1.0, 0.95, 0.7]
volume.ScalarOpacityFunction.Points = [
    0.0, 0.0, 0.5, 0.0, 0.04, 0.0, 0.5, 0.0, 0.3, 0.25, 0.5, 0.0, 0.5, 0.4, 0.5, 0.0, 1.0, 0.5, 0.5, 0.0]
volume.ShowIsosurfaces = 1
volume.IsosurfaceValues = [0.55]
volume.IsosurfaceOpacityScale = 10
volume.AmbientOcclusionSamples = 32
volume.AmbientOcclusionRadius = 0.1
volume.UseCropping = 1
volume.CroppingScale = [1, 1, 0.5]
volume.CroppingOrigin = [0, 0, 0.5]

# ParaView's own slice, whose polygons are the cells that it meets.
cut = Slice(Input=grid, Triangulatetheslice=0)
cut.HyperTreeGridSlicer.Origin = [0.5, 0.5, 0.4999]
cut.HyperTreeGridSlicer.Normal = [0, 0, 1]
cells = Show(cut, view)
cells.SetRepresentationType("Surface With Edges")
ColorBy(cells, ("CELLS", "sheet"))
cells.EdgeColor = [0.55, 0.6, 0.65]
cells.Ambient, cells.Diffuse = 1, 0

view.CameraPosition = [1.27, 0.95, 2.38]
view.CameraFocalPoint = [0.46, 0.48, 0.5]
view.CameraViewUp = [0, 1, 0]
SaveScreenshot(str(pathlib.Path(sys.argv[1]) / "everything.png"), view)
