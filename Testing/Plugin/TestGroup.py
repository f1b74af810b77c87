"""A group of two grids is refused with an error, and does no other harm."""

from paraview import simple

import scene


class TestGroup(scene.TestCase):
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
