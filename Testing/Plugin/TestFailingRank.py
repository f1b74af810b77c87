"""A rank without memory for its part of a frame: it says so, the other goes on, and the next frame is whole.

TestFailingRank.py <folder>               run by pvbatch --symmetric on two ranks
"""

import os
import resource
import sys

import numpy
from paraview import servermanager, simple
from vtkmodules.vtkFiltersSources import vtkRandomHyperTreeGridSource

import scene

rank = servermanager.vtkProcessModule.GetProcessModule().GetPartitionId()
made = vtkRandomHyperTreeGridSource()
made.SetDimensions(5, 5, 5)
made.SetOutputBounds(-1, 1, -1, 1, -1, 1)
made.Update()
source = simple.PVTrivialProducer()
source.GetClientSideObject().SetOutput(made.GetOutputDataObject(0))
view = scene.view(1600, 1200)
display = simple.Show(source, view)
simple.ColorBy(display, ("CELLS", "Depth"))
display.SetRepresentationType("Tree AMR Volume")
scene.look(view)


def picture(name):
    """Of the first rank, which has that of both; nothing on the other one."""
    path = os.path.join(sys.argv[-1], f"failing-rank-{name}.png")
    simple.SaveScreenshot(path, view, ImageResolution=[1600, 1200])
    return scene.load(path) if rank == 0 else numpy.zeros((2, 2, 3))


def limit(_mapper, _event):
    with open("/proc/self/statm", encoding="ascii") as pages:
        size = int(pages.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size, resource.RLIM_INFINITY))


def lift(_mapper, _event):
    resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))


before = picture("before")
mapper = view.GetRenderer().GetVolumes().GetItemAsObject(0).GetMapper()
if rank == 1:
    observers = [
        mapper.AddObserver("VolumeMapperRenderStartEvent", limit),
        mapper.AddObserver("VolumeMapperRenderEndEvent", lift)]
missing = picture("missing")
if rank == 1:
    for observer in observers:
        mapper.RemoveObserver(observer)
after = picture("after")
if rank == 0:
    print("drawn before, without a rank and after:", *(scene.drawn(one).mean() for one in (before, missing, after)))
    assert scene.drawn(missing).any() and abs(before - missing).max() > 50
    assert scene.close((before, after))
