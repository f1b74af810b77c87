"""A grid that fits not those of the other ranks: all say so and go on.

TestBrokenRank.py <folder>                run by pvbatch on two ranks
"""

from paraview import simple

import scene

RIGHT = """
self.GetOutputDataObject(0).ShallowCopy(self.GetInputDataObject(0, 0))
"""
OTHER_LATTICE = RIGHT + """
from vtkmodules.vtkFiltersSources import vtkRandomHyperTreeGridSource
from vtkmodules.vtkParallelCore import vtkMultiProcessController
if vtkMultiProcessController.GetGlobalController().GetLocalProcessId() == 1:
    other = vtkRandomHyperTreeGridSource()
    other.SetDimensions(4, 4, 4)
    other.Update()
    self.GetOutputDataObject(0).ShallowCopy(other.GetOutputDataObject(0))
"""

view = scene.view()
source = simple.HyperTreeGridRandom(Dimensions=[5, 5, 5], OutputBounds=[-1, 1, -1, 1, -1, 1])
grid = simple.ProgrammableFilter(Input=source, OutputDataSetType="Same as Input", Script=RIGHT)
display = simple.Show(grid, view)
simple.ColorBy(display, ("CELLS", "Depth"))
for kind in ("Tree AMR Volume", "Tree AMR Isosurface"):
    display.SetRepresentationType(kind)
    scene.look(view)
    right = scene.picture(view, "broken-rank-before")
    assert scene.drawn(right).mean() > 0.1
    grid.Script = OTHER_LATTICE
    assert not scene.drawn(scene.picture(view, "broken-rank")).any()
    grid.Script = RIGHT
    assert scene.close((right, scene.picture(view, "broken-rank-after"))), kind

# The filter, too.
grid.Script = OTHER_LATTICE
spread = simple.TreeAMRRedistribute(Input=grid)
spread.UpdatePipeline()
assert spread.GetDataInformation().GetNumberOfCells() == 0
grid.Script = RIGHT
spread.UpdatePipeline()
assert spread.GetDataInformation().GetNumberOfCells() > 1000
