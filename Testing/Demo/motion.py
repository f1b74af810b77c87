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
    """Until the picture is there."""
    start = time.perf_counter()
    render()
    window.WaitForCompletion()
    return time.perf_counter() - start


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

times, distances = [], []
for frame in range(frames):
    view.GetActiveCamera().Azimuth(2)
    times.append(seconds(view.SMProxy.InteractiveRender))
    distances.append(mandelbulb.statistics(view)["ImageSampleDistance"])
    if frame == frames // 2:
        save("draft")
times.sort()
print("%.1f frames/s: median %.3f s, slowest %.3f s" % (frames / sum(times), times[frames // 2], times[-1]))
print("pixels between rays: " + " ".join("%.1f" % distance for distance in distances))
print("still image after %.2f s" % seconds(view.SMProxy.StillRender))
save("still")
