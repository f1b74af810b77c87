"""Groups of grids are drawn as one where they lie on one lattice, else refused with an error."""

import unittest

import numpy
from paraview import servermanager, simple

import scene


class TestGroup(scene.TestCase):
    def test_halves_are_the_whole(self):
        """A grid and its mirror image beside it, as a group and through the filter."""
        source = simple.TreeAMRExample(Dataset="Synthetic")
        mirror = simple.HyperTreeGridAxisReflection(Input=source, PlaneNormal="X Axis", PlanePosition=4)
        group = simple.GroupDatasets(Input=[source, mirror])
        merged = simple.TreeAMRMergeGrids(Input=group)
        merged.UpdatePipeline()
        self.assertEqual(2 * 288, servermanager.Fetch(merged).GetNumberOfLeaves())
        view = scene.view()
        for kind in ("Tree AMR Volume", "Tree AMR Isosurface"):
            pictures = []
            for proxy in (group, merged):
                representation = simple.Show(proxy, view)
                simple.ColorBy(representation, ("CELLS", "xyz"))
                representation.SetRepresentationType(kind)
                # ParaView 5.13 knows no bounds of the mirror image that this would start from.
                representation.ScalarOpacityUnitDistance = 0.8
                scene.look(view)
                view.CameraFocalPoint = [4, 2, 2]
                simple.ResetCamera(view)
                pictures.append(scene.picture(view, f"{kind} {len(pictures)}"))
                simple.Hide(proxy, view)
            self.assertGreater(scene.drawn(pictures[0]).mean(), 0.02)
            self.assertEqual(0, numpy.abs(pictures[0] - pictures[1]).max())

    def compare_blocks(self, group, alone, first, assembly=None):
        """Pictures of all blocks, of the one that a selector names, of all again, of none, and of that one's source."""
        view = scene.view()
        for kind in ("Tree AMR Volume", "Tree AMR Isosurface"):
            pictures = {}
            for name, shown, selectors in (("both", group, ["/"]), ("first", group, [first]), ("again", group, ["/Root"]),
                                           ("none", group, []), ("alone", alone, ["/"])):
                representation = simple.Show(shown, view)
                simple.ColorBy(representation, ("CELLS", "xyz"))
                representation.SetRepresentationType(kind)
                representation.ScalarOpacityUnitDistance = 0.8
                representation.BlockSelectors = selectors
                if assembly:
                    representation.Assembly = assembly
                if not pictures:
                    scene.look(view)
                    simple.ResetCamera(view)
                pictures[name] = scene.picture(view, f"{kind} {name}")
                simple.Hide(shown, view)
            self.assertTrue(scene.close((pictures["first"], pictures["alone"])))
            self.assertTrue(scene.close((pictures["both"], pictures["again"])))
            self.assertFalse(scene.close((pictures["both"], pictures["first"])))
            self.assertFalse(scene.drawn(pictures["none"]).any())

    def test_hidden_blocks(self):
        """What the inspector of blocks hides is not drawn, and is drawn again."""
        source = simple.TreeAMRExample(Dataset="Synthetic")
        mirror = simple.HyperTreeGridAxisReflection(Input=source, PlaneNormal="X Axis", PlanePosition=4)
        for kind in ("vtkMultiBlockDataSet", "vtkPartitionedDataSetCollection"):
            group = simple.GroupDatasets(Input=[source, mirror], OutputType=kind)
            group.UpdatePipeline()
            hierarchy = group.GetDataInformation().GetHierarchy()
            self.compare_blocks(group, source, hierarchy.GetNodePath(hierarchy.GetChild(0, 0)))

    @unittest.skipIf(scene.PARAVIEW < (5, 13), "displays have no Assembly")
    def test_hidden_blocks_of_an_assembly(self):
        """By names of the collection's own; the second block is first in it."""
        source = simple.TreeAMRExample(Dataset="Synthetic")
        mirror = simple.HyperTreeGridAxisReflection(Input=source, PlaneNormal="X Axis", PlanePosition=4)
        group = simple.GroupDatasets(Input=[source, mirror], OutputType="vtkPartitionedDataSetCollection")
        named = simple.ProgrammableFilter(Input=group, OutputDataSetType="Same as Input", Script="""
from vtkmodules.vtkCommonDataModel import vtkDataAssembly
collection = self.GetOutputDataObject(0)
collection.ShallowCopy(self.GetInputDataObject(0, 0))
assembly = vtkDataAssembly()
assembly.SetRootNodeName("Root")
for index, name in (1, "mirror"), (0, "original"):
    assembly.AddDataSetIndex(assembly.AddNode(name), index)
collection.SetDataAssembly(assembly)
""")
        named.UpdatePipeline()
        self.compare_blocks(named, source, "/Root/original", "Assembly")

    @unittest.skipIf(scene.PARAVIEW < (6, 0), "there is no such filter for hyper tree grids")
    def test_axis_aligned_reflection(self):
        """Both halves are drawn, and one by its name in the assembly, which displays take by default."""
        source = simple.TreeAMRExample(Dataset="Synthetic")
        both = simple.AxisAlignedReflect(Input=source, PlaneMode="X Max")
        both.UpdatePipeline()
        self.compare_blocks(both, source, "/Root/Input")

    def test_two_grids(self):
        group = simple.GroupDatasets(
            Input=[simple.TreeAMRExample(Dataset="Synthetic"), simple.TreeAMRExample(MaximumLevel=4)])
        group.UpdatePipeline()
        view = scene.view()
        representation = simple.Show(group, view)
        for kind in ("Tree AMR Volume", "Tree AMR Isosurface"):
            representation.SetRepresentationType(kind)
            scene.look(view)
            self.assertFalse(scene.drawn(scene.picture(view, "group")).any())


if __name__ == "__main__":
    scene.main()
