"""Grids of sources that know nothing of ranks have the same picture on several ranks as on one.

TestParallel.py <folder>                  run by pvbatch: saves <kind>-<ranks>.png
TestParallel.py --compare <folder>        compares them
"""

import os
import sys

from paraview import servermanager, simple
from vtkmodules.vtkCommonCore import vtkCollection

import scene

# Of values along rays, whose results of all ranks are put together.
BLENDS = {
    "Maximum": "Maximum Intensity", "Minimum": "Minimum Intensity", "Average": "Average Intensity",
    "Additive": "Additive"}
# Of 255, however many ranks: pictures of volumes are rounded once.
BOUNDS = {
    **dict.fromkeys(BLENDS, 1),
    "Volume": 1, "Isosurface": 1, "Both": 1, "Uniform": 1, "Hexahedra": 1, "Copies": 1, "FirstRank": 1,
    "OtherArray": 1, "TwoArrays": 1, "TwoValues": 1, "TwoValuesOfArrays": 1, "Redistributed": 1}

# Of VTK's source, which since 9.3 draws other random numbers for each rank when it is asked by pieces.
RANDOM = """
from vtkmodules.vtkCommonExecutionModel import vtkExtentTranslator
from vtkmodules.vtkFiltersSources import vtkRandomHyperTreeGridSource
from vtkmodules.vtkParallelCore import vtkMultiProcessController
controller = vtkMultiProcessController.GetGlobalController()
process, processes = controller.GetLocalProcessId(), controller.GetNumberOfProcesses()
source = vtkRandomHyperTreeGridSource()
source.SetOutputBounds(-1, 1, -1, 1, -1, 1)
"""
ITS_PART = RANDOM + """
source.SetDimensions(5, 5, 5)
part = vtkExtentTranslator()
part.SetWholeExtent(0, 4, 0, 4, 0, 4)
part.SetPiece(process)
part.SetNumberOfPieces(processes)
part.PieceToExtent()
source.UpdateExtent(part.GetExtent())
self.GetOutputDataObject(0).ShallowCopy(source.GetOutputDataObject(0))
"""
OTHER_GRID = RANDOM + """
source.SetDimensions(4, 4, 4)
source.SetSeed(3)
source.Update()
self.GetOutputDataObject(0).ShallowCopy(source.GetOutputDataObject(0))
"""
OF_FIRST_RANK = OTHER_GRID + """
if process > 0:
    self.GetOutputDataObject(0).Initialize()
"""


def grids(script, source=None):
    """What a script makes of the grids of a source, or by itself."""
    return simple.ProgrammableFilter(
        Input=source or simple.HyperTreeGridRandom(), OutputDataSetType="Same as Input", Script=script)


def closed(contour):
    contour.UpdatePipeline()
    points, boundary, inside = scene.open_edges(contour, -1, 1)
    print("points", points, "open edges on the boundary and inside", boundary, inside)
    assert points > 1000 and boundary > 0 and inside == 0


def check_selection(source, view):
    """Selected cells are those of the source, on the rank that it has them on."""
    ranks = servermanager.vtkProcessModule.GetProcessModule().GetNumberOfLocalPartitions()
    selected = set()
    for y in range(5, 180, 9):
        for x in range(5, 240, 9):
            representations, selections = vtkCollection(), vtkCollection()
            view.SelectSurfaceCells([x, y, x, y], representations, selections, 0)
            if selections.GetNumberOfItems() == 0:
                continue
            process, cell = servermanager._getPyProxy(selections.GetItemAsObject(0)).IDs
            selected.add((process, cell))
    assert len(selected) > 30
    print("ranks of selected cells", {process for process, _ in selected})
    assert {process for process, _ in selected} == set(range(ranks))
    # Leaves, of which the first rank has its own.
    ids = [number for pair in selected for number in pair]
    marked = simple.ExtractSelection(
        Input=source, PreserveTopology=1, Selection=simple.IDSelectionSource(IDs=ids, FieldType="CELL"))
    marked.UpdatePipeline()
    found = scene.extracted(marked.GetClientSideObject().GetOutputDataObject(0))
    assert found == {cell for process, cell in selected if process == 0}, found
    return selected


def render():
    ranks = servermanager.vtkProcessModule.GetProcessModule().GetNumberOfLocalPartitions()
    source = grids(ITS_PART)
    source.UpdatePipeline()
    view = scene.view()
    representation = simple.Show(source, view)
    simple.ColorBy(representation, ("CELLS", "Depth"))
    scene.look(view)
    for kind in ("Volume", "Isosurface"):
        representation.SetRepresentationType("Tree AMR " + kind)
        scene.picture(view, f"{kind}-{ranks}")
    check_selection(source, view)

    spread = simple.TreeAMRRedistribute(Input=source)
    contouring = {"ContourBy": ["CELLS", "Depth"], "Isosurfaces": list(representation.Isovalues)}
    closed(simple.TreeAMRContour(Input=spread, **contouring))
    points, triangles = scene.contoured(spread, **contouring)
    exported = scene.exported(os.path.join(sys.argv[-1], f"Isosurface-{ranks}.gltf"), view)
    print("points, colours, triangles exported:", exported)
    assert exported == (points, points, triangles)
    representation.SetRepresentationType("Tree AMR Volume")
    representation.ShowIsosurfaces = 1
    representation.IsosurfaceValues = [1.5, 2.5]
    samples, representation.SamplesPerCell = representation.SamplesPerCell, 8  # beside surfaces boxes cut cells
    scene.picture(view, f"Both-{ranks}")
    representation.SamplesPerCell = samples
    representation.ShowIsosurfaces = 0
    for name, blend in BLENDS.items():
        representation.BlendMode = blend
        scene.picture(view, f"{name}-{ranks}")
    representation.BlendMode = "Composite"
    simple.Hide(source, view)

    # The first rank makes one grid of the pieces of all.
    path = os.path.join(sys.argv[-1], f"hexahedra-{ranks}.pvtu")
    simple.SaveData(path, simple.HyperTreeGridToUnstructuredGrid(Input=source))
    hexahedra = simple.XMLPartitionedUnstructuredGridReader(FileName=[path])
    whole = simple.TreeAMRFromUnstructured(Input=hexahedra)
    shown = simple.Show(whole, view)
    simple.ColorBy(shown, ("CELLS", "Depth"))
    shown.SetRepresentationType("Tree AMR Volume")
    scene.picture(view, f"Hexahedra-{ranks}")
    simple.Hide(whole, view)
    shown = simple.Show(simple.TreeAMRRedistribute(Input=whole), view)
    simple.ColorBy(shown, None)
    shown.SetRepresentationType("Tree AMR Isosurface")
    shown.Isovalues = [2.5]
    scene.picture(view, f"Redistributed-{ranks}")
    simple.HideAll(view)

    # A source that gives each rank the same, and one that gives all to the first.
    for name, script in ("Copies", OTHER_GRID), ("FirstRank", OF_FIRST_RANK):
        made = grids(script)
        shown = simple.Show(made, view)
        simple.ColorBy(shown, ("CELLS", "Depth"))
        shown.SetRepresentationType("Tree AMR Volume")
        scene.picture(view, f"{name}-{ranks}")
        simple.Hide(made, view)

    # Arrays that are shown later on are sent then.
    more = grids("""
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
grid = self.GetOutputDataObject(0)
grid.ShallowCopy(self.GetInputDataObject(0, 0))
height = numpy_to_vtk(5 - vtk_to_numpy(grid.GetCellData().GetArray('Depth')), deep=1)
height.SetName('Height')
grid.GetCellData().AddArray(height)
""", source)
    shown = simple.Show(more, view)
    simple.ColorBy(shown, ("CELLS", "Depth"))
    shown.SetRepresentationType("Tree AMR Volume")
    simple.Render(view)
    simple.ColorBy(shown, ("CELLS", "Height"))
    scene.picture(view, f"OtherArray-{ranks}")
    shown.UseSeparateOpacityArray = 1
    shown.OpacityArrayName = ["CELLS", "Depth"]
    scene.picture(view, f"TwoArrays-{ranks}")
    shown.UseSeparateOpacityArray = 0
    function = shown.TransferFunction2D
    function.Range = [0, 5, 0, 1]
    function.OutputDimensions = [64, 64]
    function.Boxes = [-2, -0.5, 6, 2, 1, 0.5, 0, 0.9]
    shown.UseTransfer2D = 1
    scene.picture(view, f"TwoValues-{ranks}")
    shown.UseGradientForTransfer2D = 0
    shown.ColorArray2Name = ["CELLS", "Depth"]
    scene.picture(view, f"TwoValuesOfArrays-{ranks}")
    simple.Hide(more, view)

    # All cells alike: what is seen is how ranks are composited.
    simple.Show(source, view)
    scene.set_colour(representation.LookupTable, 0, 5, (1, 1, 1))
    scene.set_opacity(representation.ScalarOpacityFunction, 0, 5, 0.1)
    scene.picture(view, f"Uniform-{ranks}")


def load(kind, ranks):
    return scene.load(os.path.join(sys.argv[-1], f"{kind}-{ranks}.png"))


def compare():
    wrong = []
    for kind, bound in BOUNDS.items():
        one = load(kind, 1)
        assert scene.drawn(one).mean() > 0.1, kind
        for ranks in (2, 3):
            difference = abs(one - load(kind, ranks))
            print(kind, ranks, "largest difference:", difference.max(), "mean", difference.mean())
            if difference.max() > bound:
                wrong.append((kind, ranks))
    assert not wrong, wrong


compare() if sys.argv[1] == "--compare" else render()
