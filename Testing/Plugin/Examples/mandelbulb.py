"""An isosurface with ambient occlusion and shadows: mandelbulb.png.

usage: pvpython mandelbulb.py FOLDER
"""

import pathlib
import sys

from paraview.simple import *

grid = TreeAMRExample(Dataset="Mandelbulb", MaximumLevel=8, RefinementThreshold=0.5)
view = CreateView("RenderView", ViewSize=[900, 620], OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
                  Background=[1, 1, 1])

surface = Show(grid, view)
ColorBy(surface, None)
surface.SetRepresentationType("Tree AMR Isosurface")
surface.Isovalues = [0.6]
surface.AmbientColor = surface.DiffuseColor = [0.98, 0.86, 0.66]
surface.AmbientOcclusionSamples = 32
surface.AmbientOcclusionRadius = 0.15
surface.Shadows = 1
surface.Ambient, surface.Diffuse = 0.45, 0.95

view.CameraPosition = [1.3, 1.2, 2.1]
view.CameraFocalPoint = [0.5, 0.5, 0.5]
view.CameraViewUp = [0, 1, 0]
SaveScreenshot(str(pathlib.Path(sys.argv[1]) / "mandelbulb.png"), view)
