"""Run by pvpython with an environment that knows the installed plugin: it has been loaded by itself."""

from paraview import simple

source = simple.TreeAMRExample(Dataset="Synthetic")
source.UpdatePipeline()
names = simple.GetRepresentation(source, simple.CreateRenderView()).GetProperty("Representation").Available
assert {"Tree AMR Volume", "Tree AMR Isosurface"} <= set(names), names
print(source.CellData.keys())
