"""Drafts, still frames, selections and exported surfaces that a server renders, on one rank or more, for a client.

TestServer.py <port>                      a client of serve.py
"""

import os
import sys
import tempfile

import numpy
from paraview import servermanager, simple

import scene

simple.Connect("localhost", int(sys.argv[1]))
view = scene.view()
# ParaView's own ways to make interactive frames cheap.
view.ImageReductionFactor = 1
view.CompressorConfig = "NULL"
source = simple.HyperTreeGridRandom(Dimensions=[5, 5, 5], OutputBounds=[-1, 1, -1, 1, -1, 1])
representation = simple.Show(source, view)
simple.ColorBy(representation, ("CELLS", "Depth"))
representation.SetRepresentationType("Tree AMR Volume")
representation.InteractiveRenderTime = 1e-9
scene.look(view)
simple.Render(view)
still = scene.shown(view.GetRenderWindow())
assert scene.drawn(still).mean() > 0.1

view.SMProxy.InteractiveRender()
draft = scene.shown(view.GetRenderWindow())
print("mean difference of the draft:", numpy.abs(draft - still).mean())
assert numpy.abs(draft - still).mean() > 1
simple.Render(view)
assert (scene.shown(view.GetRenderWindow()) == still).all()

representation.AutoAdjustSampleDistances = 0
view.SMProxy.InteractiveRender()
assert (scene.shown(view.GetRenderWindow()) == still).all()

# Estimated by the server, whether one or two processes draw the picture: a few dozen groups of pixels tell the error to
# a fifth of it.
assert representation.EstimatedError == -1
representation.SamplesPerCell = 64
simple.Render(view)
converged = scene.shown(view.GetRenderWindow()).astype(float)
representation.EstimateError = 1
representation.SamplesPerCell = 0.25
simple.Render(view)
difference = (scene.shown(view.GetRenderWindow()) - converged) / 255
error = numpy.sqrt((difference ** 2).mean())
print("estimated error:", representation.EstimatedError, "of", error, "in", representation.FrameSeconds, "s")
assert error > 0.005  # the random cells are others in ParaView 6.1; rounding to 256 levels is 0.0016 of it
assert error / 1.5 < representation.EstimatedError < error * 1.5
representation.SMProxy.UpdatePropertyInformation()
assert representation.SMProxy.GetProperty("EstimatedError").GetElement(0) == representation.EstimatedError
assert representation.FrameSeconds > 0

representation.SetRepresentationType("Tree AMR Isosurface")
simple.Render(view)
surface = scene.drawn(scene.shown(view.GetRenderWindow()))
assert surface.mean() > 0.1

spread = simple.TreeAMRRedistribute(Input=source)  # as the representation does by itself

# Exporters run on the client, which has no grid, and write the contour of all ranks.
with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, "isosurface.gltf")
    for isovalues, threshold in (([2.5], 0), ([1.5, 2.5], 1e6)):
        representation.Isovalues = isovalues
        view.RemoteRenderThreshold = threshold
        points, triangles = scene.contoured(spread, ContourBy=["CELLS", "Depth"], Isosurfaces=isovalues)
        print(points, "points on", isovalues)
        assert triangles > 1000
        assert scene.exported(path, view) == (points, points, triangles)
    simple.ColorBy(representation, None)
    assert scene.exported(path, view) == (points, 0, triangles)
    representation.Isovalues = [9.0]
    assert scene.exported(path, view) == (0, 0, 0)
    representation.Isovalues = [2.5]
    representation.Visibility = 0
    assert scene.exported(path, view) == (0, 0, 0)
    representation.Visibility = 1

simple.SelectSurfaceCells(Rectangle=[0, 0, 239, 179], View=view)
selection = servermanager._getPyProxy(source.GetSelectionInput(0))
selected = selection.Input[0].IDs
processes, cells = selected[::2], selected[1::2]
print("cells selected:", len(cells), "of processes", set(processes))
assert set(processes) == set(range(servermanager.ActiveConnection.GetNumberOfDataPartitions()))
assert len(set(zip(processes, cells))) == len(cells) > 1000
# They are where the surface is seen.
marked = simple.ExtractSelection(Input=source, Selection=selection, PreserveTopology=1)
simple.Hide(source, view)
simple.Show(scene.extracted_alone(marked), view).SetRepresentationType("Surface")
simple.Render(view)
assert scene.drawn(scene.shown(view.GetRenderWindow()))[surface].all()
