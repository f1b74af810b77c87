"""A reader that fails on one rank, after its grid was shown: errors, and the session goes on with what is right.

TestBrokenInput.py <forest> <folder>           in this process, and all others that MPI started with it
TestBrokenInput.py <forest> <folder> <port>    a client of serve.py
"""

import sys

from paraview import simple

import scene

FOREST = sys.argv[1]
if len(sys.argv) > 3:
    simple.Connect("localhost", int(sys.argv.pop()))

view = scene.view()
reader = simple.TreeAMRP4estReader(FileName=FOREST, Payload="double rho")
display = simple.Show(reader, view)
simple.ColorBy(display, ("CELLS", "rho"))
for kind in ("Tree AMR Volume", "Tree AMR Isosurface"):
    display.SetRepresentationType(kind)
    scene.look(view)
    right = scene.picture(view, "broken-input-before")
    assert scene.drawn(right).mean() > 0.1
    for name, value, wrong in (("Payload", "double rho", "duble rho"), ("FileName", FOREST, FOREST + ".missing")):
        setattr(reader, name, wrong)
        scene.picture(view, "broken-input")
        setattr(reader, name, value)
        assert scene.close((right, scene.picture(view, "broken-input-after"))), (kind, name)
    # What is mended to something else shows that, not what was there before.
    for payload, name, same in (("float low; float high", "high", False), ("double rho", "rho", True)):
        reader.Payload = payload
        reader.UpdatePipeline()
        simple.ColorBy(display, ("CELLS", name))
        display.IsosurfaceArray = ["CELLS", name]
        image = scene.picture(view, "broken-input-" + name)
        assert scene.drawn(image).mean() > 0.1
        assert same == scene.close((right, image)), (kind, name)
