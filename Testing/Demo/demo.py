"""Reads the demo's p4est forest in ParaView and saves pictures of it beside the file:

volume.png, isosurface.png, both.png (with an opaque sphere through them) and translucent.png (the same sphere
translucent). Prints cells, bytes per cell, build and frame seconds.

usage: pvpython demo.py FOREST.p8est
"""

import pathlib
import sys
import time

from paraview.simple import *
from treeamr.vtkTreeAMRRendering import vtkTreeAMRVolumeMapper  # makes the mapper's own methods visible

forest = pathlib.Path(sys.argv[1])
paraview.simple._DisableFirstRenderCameraReset()


def save(view, name):
    path = forest.with_name(name + ".png")
    SaveScreenshot(str(path), view, ImageResolution=view.ViewSize[:])
    print("  " + str(path))


def timed_frame(view):
    """Seconds of wall and CPU of one frame from a camera that has just moved."""
    view.CameraPosition = [x + 1e-6 for x in view.CameraPosition]
    wall, cpu = time.perf_counter(), time.process_time()
    Render(view)
    return "%.2f s (%.2f CPU-s)" % (time.perf_counter() - wall, time.process_time() - cpu)


start = time.perf_counter()
reader = TreeAMRP4estReader(FileName=str(forest), Payload="double mandelbulb")
reader.UpdatePipeline()
print("read %s in %.2f s" % (forest, time.perf_counter() - start))

view = CreateView("RenderView")
view.ViewSize = [1000, 1000]
view.OrientationAxesVisibility = 0
view.UseColorPaletteForBackground = 0
view.Background = [0.08, 0.09, 0.12]
view.CameraPosition = [1.332, 1.176, 1.688]
view.CameraFocalPoint = [0.5, 0.5, 0.5]
view.CameraViewUp = [0, 1, 0]
view.CameraViewAngle = 40

colors = GetColorTransferFunction("mandelbulb")
colors.RGBPoints = [0.3, 0.23, 0.11, 0.33, 0.45, 0.55, 0.16, 0.39, 0.6, 0.93, 0.41, 0.22,
                    0.75, 0.98, 0.76, 0.25, 1.0, 1.0, 1.0, 0.85]
colors.ColorSpace = "RGB"
opacities = GetOpacityTransferFunction("mandelbulb")
opacities.Points = [0.0, 0.0, 0.5, 0.0, 0.3, 0.0, 0.5, 0.0, 0.45, 0.2, 0.5, 0.0, 0.6, 0.6, 0.5, 0.0,
                    1.0, 0.9, 0.5, 0.0]

volume = Show(reader, view)
ColorBy(volume, ("CELLS", "mandelbulb"))
volume.SetRepresentationType("Tree AMR Volume")
volume.ScalarOpacityUnitDistance = 0.02
Render(view)
mapper = view.GetRenderer().GetVolumes().GetItemAsObject(0).GetMapper()
print("%d cells, %.2f bytes a cell, octree built in %.2f s" % (mapper.GetNumberOfCells(),
      mapper.GetOctreeBytes() / mapper.GetNumberOfCells(), mapper.GetBuildSeconds()))
print("volume frame: " + timed_frame(view))
save(view, "volume")

# The isosurface is a second representation of the same grid: it shares the volume's octree.
Hide(reader, view)
same = PassThrough(Input=reader)
surface = Show(same, view)
ColorBy(surface, None)
surface.SetRepresentationType("Tree AMR Isosurface")
surface.Isovalue = 0.9
surface.DiffuseColor = surface.AmbientColor = [0.85, 0.8, 0.7]
Render(view)
print("isosurface frame: " + timed_frame(view))
save(view, "isosurface")

# Both, with a sphere through them; the surface lies inside the volume, so that is drawn fainter.
Show(reader, view)
opacities.Points = [0.0, 0.0, 0.5, 0.0, 0.3, 0.0, 0.5, 0.0, 0.6, 0.15, 0.5, 0.0, 1.0, 0.3, 0.5, 0.0]
sphere = Sphere(Center=[0.74, 0.52, 0.68], Radius=0.2, ThetaResolution=96, PhiResolution=96)
ball = Show(sphere, view)
ball.DiffuseColor = ball.AmbientColor = [0.2, 0.55, 0.85]
ball.Specular = 0.4
Render(view)
print("volume, isosurface and sphere: " + timed_frame(view))
save(view, "both")
ball.Opacity = 0.45
Render(view)
save(view, "translucent")
