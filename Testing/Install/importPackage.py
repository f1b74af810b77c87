"""Run with an environment that knows the installed package: the wrapped classes import and work."""

import treeamr
from treeamr.vtkTreeAMRReader import vtkTreeAMRExampleSource
from treeamr.vtkTreeAMRRendering import vtkTreeAMRIsosurfaceMapper, vtkTreeAMRVolumeMapper

source = vtkTreeAMRExampleSource()
source.SetDatasetToSynthetic()
source.Update()
for mapper in (vtkTreeAMRVolumeMapper(), vtkTreeAMRIsosurfaceMapper()):
    mapper.SetInputConnection(source.GetOutputPort())
print(treeamr.__version__, treeamr.__file__)
