"""What the scripts of this folder share: a Mandelbulb forest as a volume in a view, in the demo's colours."""

from paraview import simple
import treeamr.vtkTreeAMRRendering  # makes the mapper's own methods visible


def show(forest):
    """The reader, the view of 1000 x 1000 pixels and the representation."""
    simple._DisableFirstRenderCameraReset()
    reader = simple.TreeAMRP4estReader(FileName=str(forest), Payload="double mandelbulb")
    view = simple.CreateView("RenderView")
    view.ViewSize = [1000, 1000]
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.Background = [0.08, 0.09, 0.12]
    view.CameraPosition = [1.332, 1.176, 1.688]
    view.CameraFocalPoint = [0.5, 0.5, 0.5]
    view.CameraViewUp = [0, 1, 0]
    view.CameraViewAngle = 40

    volume = simple.Show(reader, view)
    simple.ColorBy(volume, ("CELLS", "mandelbulb"))
    volume.SetRepresentationType("Tree AMR Volume")
    volume.ScalarOpacityUnitDistance = 0.02
    volume.LookupTable.RGBPoints = [
        0.3, 0.23, 0.11, 0.33, 0.45, 0.55, 0.16, 0.39, 0.6, 0.93, 0.41, 0.22, 0.75, 0.98, 0.76, 0.25,
        1.0, 1.0, 1.0, 0.85]
    volume.LookupTable.ColorSpace = "RGB"
    volume.ScalarOpacityFunction.Points = [
        0.0, 0.0, 0.5, 0.0, 0.3, 0.0, 0.5, 0.0, 0.45, 0.2, 0.5, 0.0, 0.6, 0.6, 0.5, 0.0, 1.0, 0.9, 0.5, 0.0]
    return reader, view, volume


def statistics(view):
    """What the volume's mapper says of its last frame, by name."""
    table = view.GetRenderer().GetVolumes().GetItemAsObject(0).GetMapper().GetStatistics()
    return {table.GetColumnName(i): table.GetValue(0, i).ToDouble() for i in range(table.GetNumberOfColumns())}
