"""Three translucent isosurfaces, sorted pixel by pixel with an opaque tube through them: layers.png.

usage: pvpython layers.py FOLDER
"""

import pathlib
import sys

from paraview.simple import *

grid = TreeAMRExample()
view = CreateView("RenderView", ViewSize=[900, 620], OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
                  Background=[1, 1, 1])

surfaces = Show(grid, view)
ColorBy(surfaces, ("CELLS", "sheet"))
surfaces.SetRepresentationType("Tree AMR Isosurface")
surfaces.Isovalues = [0.2, 0.45, 0.7]
surfaces.LookupTable.ApplyPreset("Turbo", True)
surfaces.LookupTable.RescaleTransferFunction(0.1, 0.8)
surfaces.Opacity = 0.35
surfaces.Specular = 0.3

tube = Show(Tube(Input=Line(Point1=[0.0, 0.3, 0.8], Point2=[1.0, 0.75, 0.3]), Radius=0.015, NumberofSides=48), view)
tube.AmbientColor = tube.DiffuseColor = [0.8, 0.8, 0.75]
tube.Specular = 0.5

view.CameraPosition = [1.25, 1.25, 2.1]
view.CameraFocalPoint = [0.5, 0.5, 0.5]
view.CameraViewUp = [0, 1, 0]
SaveScreenshot(str(pathlib.Path(sys.argv[1]) / "layers.png"), view)
