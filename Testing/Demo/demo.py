"""Reads the demo's p4est forest in ParaView and saves pictures of it beside the file:

volume.png, isosurface.png, occlusion.png (with ambient occlusion), both.png (with an opaque sphere through them),
translucent.png (the same sphere translucent) and layers.png (two translucent isosurfaces and an opaque tube). Prints cells, bytes per cell, build and frame seconds.

usage: pvpython demo.py FOREST.p8est
"""

import pathlib
import sys
import time

import mandelbulb
from paraview.simple import *

forest = pathlib.Path(sys.argv[1])


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
reader, view, volume = mandelbulb.show(forest)
print("read %s in %.2f s" % (forest, time.perf_counter() - start))
Render(view)
statistics = mandelbulb.statistics(view)
print("%d cells, %.2f bytes a cell, octree built in %.2f s" % (
    statistics["Cells"], statistics["OctreeBytes"] / statistics["Cells"], statistics["FieldSeconds"]))
print("volume frame: " + timed_frame(view))
save(view, "volume")

# The isosurface is a second representation of the same grid: it shares the volume's octree.
Hide(reader, view)
same = PassThrough(Input=reader)
surface = Show(same, view)
ColorBy(surface, None)
surface.SetRepresentationType("Tree AMR Isosurface")
surface.Isovalues = [0.9]
surface.DiffuseColor = surface.AmbientColor = [0.85, 0.8, 0.7]
Render(view)
print("isosurface frame: " + timed_frame(view))
save(view, "isosurface")
surface.AmbientOcclusionSamples = 16
Render(view)
print("with ambient occlusion: " + timed_frame(view))
save(view, "occlusion")
surface.AmbientOcclusionSamples = 0

# Both, with a sphere through them; the surface lies inside the volume, so that is drawn fainter.
Show(reader, view)
volume.ScalarOpacityFunction.Points = [
    0.0, 0.0, 0.5, 0.0, 0.3, 0.0, 0.5, 0.0, 0.6, 0.15, 0.5, 0.0, 1.0, 0.3, 0.5, 0.0]
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

# Two translucent surfaces in the colours of their values, an opaque tube through them and a faint volume.
Hide(sphere, view)
volume.ScalarOpacityFunction.Points = [
    0.0, 0.0, 0.5, 0.0, 0.3, 0.0, 0.5, 0.0, 0.6, 0.01, 0.5, 0.0, 1.0, 0.05, 0.5, 0.0]
surface.Isovalues = [0.35, 0.8]
ColorBy(surface, ("CELLS", "mandelbulb"))
surface.Opacity = 0.4
line = Line(Point1=[0.05, 0.35, 0.9], Point2=[0.95, 0.6, 0.4])
tube = Show(Tube(Input=line, Radius=0.03, NumberofSides=48), view)
tube.DiffuseColor = tube.AmbientColor = [0.2, 0.55, 0.85]
tube.Specular = 0.4
Render(view)
print("translucent isosurfaces: " + timed_frame(view))
save(view, "layers")
