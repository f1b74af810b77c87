"""Moves the camera around a p4est forest the way the GUI does, then stops, and tells how long that takes.

Writes draft.png, a frame of the motion, and still.png beside the forest.

usage: pvpython motion.py FOREST.p8est [FRAMES]
"""

import pathlib
import sys
import time

import mandelbulb
from paraview import simple
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

forest = pathlib.Path(sys.argv[1])
frames = int(sys.argv[2]) if len(sys.argv) > 2 else 60


def seconds(render):
    """Wall and CPU until the picture is there."""
    wall, cpu = time.perf_counter(), time.process_time()
    render()
    window.WaitForCompletion()
    return time.perf_counter() - wall, time.process_time() - cpu


def save(name):
    """The picture in the window: a screenshot would be a still frame of its own."""
    picture = vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ShouldRerenderOff()
    picture.ReadFrontBufferOff()
    path = str(forest.with_name(name + ".png"))
    writer = vtkPNGWriter()
    writer.SetFileName(path)
    writer.SetInputConnection(picture.GetOutputPort())
    writer.Write()
    print("  " + path)


reader, view, volume = mandelbulb.show(forest)
simple.Render(view)
window = view.GetRenderWindow()
print("%d cells" % mandelbulb.statistics(view)["Cells"])

times, cpu_times, distances = [], [], []
for frame in range(frames):
    view.GetActiveCamera().Azimuth(2)
    wall, cpu = seconds(view.SMProxy.InteractiveRender)
    times.append(wall)
    cpu_times.append(cpu)
    distances.append(mandelbulb.statistics(view)["ImageSampleDistance"])
    if frame == frames // 2:
        save("draft")
print("%.1f frames/s: median %.3f s, slowest %.3f s, %.3f CPU-s a frame" % (
    frames / sum(times), sorted(times)[frames // 2], max(times), sum(cpu_times) / frames))
print("pixels between rays: " + " ".join("%.1f" % distance for distance in distances))
print("still image after %.2f s (%.2f CPU-s)" % seconds(view.SMProxy.StillRender))
save("still")
