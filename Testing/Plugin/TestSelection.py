"""Cells selected on `Tree AMR Isosurface`."""

import numpy
from paraview import servermanager, simple
from vtkmodules.vtkCommonCore import vtkCollection

import scene

ISOVALUE = 6.5


class TestSelection(scene.TestCase):
    def setUp(self):
        super().setUp()
        self.source = simple.TreeAMRExample(Dataset="Synthetic")
        self.view = scene.view()
        self.representation = simple.Show(self.source, self.view)
        simple.ColorBy(self.representation, None)
        self.representation.SetRepresentationType("Tree AMR Isosurface")
        self.representation.Isovalues = [ISOVALUE]
        scene.look(self.view, (-4, -3, -6))
        simple.Render(self.view)
        self.boxes = scene.leaf_boxes(servermanager.Fetch(self.source))

    def selected(self):
        """The ids of the source's selection."""
        selection = self.source.GetSelectionInput(0).GetProperty("Input").GetProxy(0)
        self.assertEqual("IDSelectionSource", selection.GetXMLName())
        ids = servermanager._getPyProxy(selection).IDs
        self.assertEqual({0}, set(ids[::2]))
        return set(ids[1::2])

    def points_along(self, x, y):
        """Points on the ray of a pixel, near each other against the cells."""
        ends = []
        for depth in (0, 1):
            self.view.GetRenderer().SetDisplayPoint(x + 0.5, y + 0.5, depth)
            self.view.GetRenderer().DisplayToWorld()
            point = numpy.array(self.view.GetRenderer().GetWorldPoint())
            ends.append(point[:3] / point[3])
        return numpy.linspace(*ends, 20001)

    def test_pixels(self):
        """What hovering asks for. Half a cell from the edge the product of the coordinates is reconstructed exactly."""
        compared = set()
        for y in range(5, 180, 15):
            for x in range(5, 240, 15):
                points = self.points_along(x, y)
                inside = ((points >= 0) & (points <= 4)).all(axis=1)
                crossed = numpy.nonzero((points.prod(axis=1) >= ISOVALUE) & inside)[0]
                if crossed.size == 0:
                    continue
                on_surface = points[crossed[0]]
                if not ((on_surface > 0.5) & (on_surface < 3.5)).all():
                    continue
                representations, selections = vtkCollection(), vtkCollection()
                self.view.SelectSurfaceCells([x, y, x, y], representations, selections, 0)
                self.assertEqual(1, selections.GetNumberOfItems())
                process, cell = servermanager._getPyProxy(selections.GetItemAsObject(0)).IDs
                self.assertEqual(0, process)
                low, high = self.boxes[cell]
                self.assertTrue(((on_surface > low - 1e-3) & (on_surface < high + 1e-3)).all(), (x, y))
                compared.add(cell)
        self.assertGreater(len(compared), 10)

    def test_rectangle(self):
        simple.SelectSurfaceCells(Rectangle=[100, 70, 140, 110], View=self.view)
        ids = self.selected()
        self.assertGreater(len(ids), 5)
        for cell in ids:
            low, high = self.boxes[cell]
            self.assertLessEqual(low.prod(), ISOVALUE)
            self.assertGreaterEqual(high.prod(), ISOVALUE)

    def test_polygon(self):
        simple.SelectSurfaceCells(Rectangle=[100, 70, 140, 110], View=self.view)
        rectangle = self.selected()
        simple.SelectSurfaceCells(Polygon=[100, 70, 140, 70, 140, 110], View=self.view)
        polygon = self.selected()
        self.assertTrue(polygon)
        self.assertTrue(polygon < rectangle)

    def test_extraction(self):
        """What is selected is seen."""
        simple.SelectSurfaceCells(Rectangle=[0, 0, 239, 179], View=self.view)
        marked = simple.ExtractSelection(
            Input=self.source, Selection=servermanager._getPyProxy(self.source.GetSelectionInput(0)),
            PreserveTopology=1)
        self.assertEqual(self.selected(), scene.extracted(servermanager.Fetch(marked)))
        simple.ClearSelection(self.source)
        surface = scene.drawn(scene.picture(self.view, "selection-surface"))
        self.assertTrue(surface.any())
        simple.Hide(self.source, self.view)
        simple.Show(scene.extracted_alone(marked), self.view).SetRepresentationType("Surface")
        cells = scene.drawn(scene.picture(self.view, "selection-cells"))
        self.assertTrue(cells[surface].all())
        self.assertFalse(cells.all())

    def test_block(self):
        """Of a composite data set, where a selection names the block too."""
        blocks = simple.ProgrammableFilter(
            Input=self.source, OutputDataSetType="vtkMultiblockDataSet", Script="""
self.GetOutputDataObject(0).SetBlock(2, self.GetInputDataObject(0, 0))
""")
        simple.Hide(self.source, self.view)
        shown = simple.Show(blocks, self.view)
        shown.SetRepresentationType("Tree AMR Isosurface")
        shown.Isovalues = [ISOVALUE]
        simple.SelectSurfaceCells(Rectangle=[0, 0, 239, 179], View=self.view)
        selection = servermanager._getPyProxy(blocks.GetSelectionInput(0))
        self.assertEqual("CompositeDataIDSelectionSource", selection.Input[0].GetXMLName())
        ids = selection.Input[0].IDs
        self.assertEqual({3}, set(ids[::3]))
        marked = simple.ExtractSelection(Input=blocks, Selection=selection, PreserveTopology=1)
        self.assertEqual(set(ids[2::3]), scene.extracted(servermanager.Fetch(marked).GetBlock(2)))

    def test_no_points(self):
        representations, selections = vtkCollection(), vtkCollection()
        self.view.SelectSurfacePoints([0, 0, 239, 179], representations, selections, 0)
        self.assertEqual(0, selections.GetNumberOfItems())


if __name__ == "__main__":
    scene.main()
