"""Run with an environment that knows the installed package: the wrapped classes import and work."""

import treeamr
from treeamr.vtkTreeAMRReader import vtkTreeAMRExampleSource
from treeamr.vtkTreeAMRRendering import vtkTreeAMRIsosurfaceMapper, vtkTreeAMRVolumeMapper

source = vtkTreeAMRExampleSource()
source.SetDatasetToSynthetic()
source.Update()
for mapper in (vtkTreeAMRVolumeMapper(), vtkTreeAMRIsosurfaceMapper()):
    mapper.SetInputConnection(source.GetOutputPort())
grid = treeamr.from_cells(1, [[0, 0, 0], [1, 1, 1]], [1.0, 2.0])
assert treeamr.probe(grid, [0.75, 0.75, 0.75], method="nearest") == 2
print(treeamr.__version__, treeamr.__file__)
