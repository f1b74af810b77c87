"""What treeamr-in-situ shows of its dye each step: a volume and an isosurface, volume_<step>.png and isosurface_<step>.png.

A script for Catalyst 2, such as ParaView's "Save Catalyst State" writes.
"""

from paraview import catalyst, simple

SIZE = [400, 400]

dye = simple.TrivialProducer(registrationName="dye")


def show(representation):
    view = simple.CreateView(
        "RenderView", ViewSize=SIZE, OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
        Background=[0, 0, 0], UseFXAA=0,
        CameraPosition=[1.2, 0.9, 1.2], CameraFocalPoint=[0.38, 0.36, 0.36], CameraViewUp=[0, 1, 0])
    display = simple.Show(dye, view)
    simple.ColorBy(display, ("CELLS", "dye"))
    display.SetRepresentationType(representation)
    return view, display


volume, display = show("Tree AMR Volume")
display.ScalarOpacityUnitDistance = 0.03
display.SamplesPerCell = 8  # so that rays of ranks behind others take as many as of one
isosurface, display = show("Tree AMR Isosurface")
display.Isovalues = [0.3]

# After all that shows the dye: each rank runs this script, and until then has the range of its own cells.
colours = simple.GetColorTransferFunction("dye")
colours.RescaleTransferFunction(0, 1)
opacities = simple.GetOpacityTransferFunction("dye")
opacities.Points = [0, 0, 0.5, 0, 0.05, 0, 0.5, 0, 1, 0.5, 0.5, 0]

for view, name in ((volume, "volume"), (isosurface, "isosurface")):
    extractor = simple.CreateExtractor("PNG", view, registrationName=name)
    extractor.Writer.FileName = name + "_{timestep:04d}.png"
    extractor.Writer.ImageResolution = SIZE

options = catalyst.Options()
options.ExtractsOutputDirectory = "."
options.GlobalTrigger = "TimeStep"
