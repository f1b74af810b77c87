"""A volume, lit by the gradients of its field: sheet.png.

usage: pvpython sheet.py FOLDER
"""

import pathlib
import sys

from paraview.simple import *

grid = TreeAMRExample()
view = CreateView("RenderView", ViewSize=[900, 620], OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
                  Background=[0.05, 0.06, 0.08])

volume = Show(grid, view)
ColorBy(volume, ("CELLS", "sheet"))
volume.SetRepresentationType("Tree AMR Volume")
volume.LookupTable.ApplyPreset("Inferno" if GetParaViewVersion() >= (6, 1) else "Inferno (matplotlib)", True)
volume.LookupTable.RescaleTransferFunction(0.0, 0.9)
volume.ScalarOpacityFunction.Points = [
    0.0, 0.0, 0.5, 0.0, 0.08, 0.0, 0.5, 0.0, 0.3, 0.25, 0.5, 0.0, 0.6, 0.95, 0.5, 0.0, 1.0, 1.0, 0.5, 0.0]
volume.ScalarOpacityUnitDistance = 0.05
volume.Shade = 1
volume.Ambient, volume.Diffuse, volume.Specular, volume.SpecularPower = 0.35, 0.75, 0.3, 20

view.CameraPosition = [1.3, 1.35, 2.1]
view.CameraFocalPoint = [0.5, 0.5, 0.5]
view.CameraViewUp = [0, 1, 0]
SaveScreenshot(str(pathlib.Path(sys.argv[1]) / "sheet.png"), view)
