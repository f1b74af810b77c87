"""Grids from ParaView's own Axis Reflection, whose coordinates decrease: pictures, values and cells are the mirrored ones."""

import numpy
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy

import scene

EYE = numpy.array([3.0, 2.0, 5.0])
UP = numpy.array([0.1, 1.0, 0.2])
AXES = ("X", "Y", "Z", "XY", "XZ", "YZ", "XYZ")
SEEN = ("XZ", "XYZ")  # in pictures


def signs(axes):
    return numpy.array([-1.0 if axis in axes else 1.0 for axis in "XYZ"])


def reflected(source, axes):
    """Mirrored about 0 along some axes."""
    for axis in axes:
        source = simple.HyperTreeGridAxisReflection(
            Input=source, PlaneNormal=axis + " Axis", PlanePosition=0.0)
    return source


class TestMirrored(scene.TestCase):
    def setUp(self):
        super().setUp()
        self.source = simple.TreeAMRExample(Dataset="Synthetic")
        self.view = scene.view(160, 120)
        # ParaView's light kit would turn over, too.
        self.view.UseLight = 0
        light = simple.AddLight(view=self.view)
        light.Coords = "Camera"
        light.Position, light.FocalPoint = (0, 0, 1), (0, 0, 0)

    def look(self, axes):
        camera = self.view.GetActiveCamera()
        camera.SetFocalPoint(*(signs(axes) * 2.0))
        camera.SetPosition(*(signs(axes) * (2.0 + 1.7 * EYE)))
        camera.SetViewUp(*(signs(axes) * UP))
        self.view.GetRenderer().ResetCameraClippingRange()

    def picture(self, source, axes, representation):
        """Through a mirrored camera, and turned over where that is another hand's: the same for all axes."""
        display = simple.Show(source, self.view)
        display.SetRepresentationType(representation)
        simple.ColorBy(display, ("CELLS", "xyz") if representation == "Tree AMR Volume" else None)
        if representation == "Tree AMR Isosurface":
            display.Isovalues = [6.5]
        self.look(axes)
        result = scene.picture(self.view, "mirrored-" + representation.split()[-1] + axes)
        return result[:, ::-1] if len(axes) % 2 else result

    def selected(self, source):
        simple.SelectSurfaceCells(Rectangle=[0, 0, 159, 119], View=self.view)
        selection = source.GetSelectionInput(0).GetProperty("Input").GetProxy(0)
        return set(servermanager._getPyProxy(selection).IDs[1::2])

    def test_pictures_and_selected_cells(self):
        expected = {}
        for axes in ("",) + SEEN:
            source = reflected(self.source, axes)
            for representation in ("Tree AMR Volume", "Tree AMR Isosurface"):
                found = self.picture(source, axes, representation)
                if axes == "":
                    self.assertGreater(scene.drawn(found).mean(), 0.1)
                    expected[representation] = found
                difference = numpy.abs(found - expected[representation]).max(axis=2)
                # Rays through a pixel's middle meet an edge of the domain on the one side or the other.
                self.assertLess((difference > 2).mean(), 0.005, (axes, representation))
            ids = self.selected(source)
            simple.Hide(source, self.view)
            self.assertGreater(len(ids), 20)
            # Cells keep their places in the arrays.
            self.assertLess(len(ids ^ expected.setdefault("ids", ids)), 3, axes)

    def test_contour(self):
        def contour(source):
            return simple.TreeAMRContour(Input=source, ContourBy=["CELLS", "xyz"], Isosurfaces=[6.5])

        mesh = servermanager.Fetch(contour(self.source))
        points = vtk_to_numpy(mesh.GetPoints().GetData())
        normals = vtk_to_numpy(mesh.GetPointData().GetNormals())
        for axes in AXES:
            mirrored = servermanager.Fetch(contour(reflected(self.source, axes)))
            found = vtk_to_numpy(mirrored.GetPoints().GetData()) * signs(axes)
            # Sorted, as blocks come in another order.
            order, expected_order = numpy.lexsort(found.round(9).T), numpy.lexsort(points.round(9).T)
            self.assertEqual(len(points), len(found))
            self.assertLess(numpy.abs(found[order] - points[expected_order]).max(), 1e-6)
            found_normals = vtk_to_numpy(mirrored.GetPointData().GetNormals()) * signs(axes)
            self.assertLess(numpy.abs(found_normals[order] - normals[expected_order]).max(), 1e-4)
            triangles = vtk_to_numpy(mirrored.GetPolys().GetConnectivityArray()).reshape(-1, 3)
            corners = vtk_to_numpy(mirrored.GetPoints().GetData())[triangles]
            facing = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            of_corners = vtk_to_numpy(mirrored.GetPointData().GetNormals())[triangles].sum(axis=1)
            self.assertTrue(((facing * of_corners).sum(axis=1) > 0).all(), axes)

    def test_probe(self):
        for axes in ("",) + AXES:
            ends = signs(axes) * ((0.313, 0.717, 0.231), (3.891, 3.143, 2.837))
            line = simple.Line(Point1=ends[0], Point2=ends[1], Resolution=200)
            values = {}
            for method in ("Nearest", "GTI"):
                probe = simple.TreeAMRProbe(
                    Input=line, Source=reflected(self.source, axes), InterpolationMethod=method)
                result = servermanager.Fetch(probe).GetPointData()
                self.assertTrue(vtk_to_numpy(result.GetArray("vtkValidPointMask")).all())
                values[method] = vtk_to_numpy(result.GetArray("xyz"))
            if axes == "":
                expected = values
            for method, found in values.items():
                self.assertLess(numpy.abs(found - expected[method]).max(), 1e-5, (axes, method))

    def test_beside_the_original(self):
        """Both halves are drawn, each by its own representation, and the view knows the bounds of both."""
        mirrored = reflected(self.source, "X")
        for source in (self.source, mirrored):
            display = simple.Show(source, self.view)
            simple.ColorBy(display, ("CELLS", "xyz"))
            display.SetRepresentationType("Tree AMR Volume")
        scene.look(self.view, (0, 0, 1))
        image = scene.picture(self.view, "mirrored-both")
        self.assertLessEqual(numpy.abs(image - image[:, ::-1]).max(), 2)
        columns = numpy.nonzero(scene.drawn(image).any(axis=0))[0]
        self.assertGreater(columns[-1] - columns[0], 90)


if __name__ == "__main__":
    scene.main()
