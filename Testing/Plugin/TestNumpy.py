"""The functions for numpy against exact answers; their docstrings' examples; tables in ParaView.

usage: pvpython TestNumpy.py FOLDER
"""

import doctest
import inspect
import io
import pathlib
import sys
import unittest
import warnings

import numpy as np
from paraview.simple import *

import scene
import treeamr
from treeamr import grids, pictures, sampling

folder = pathlib.Path(sys.argv.pop())
OCTANTS = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)


def random_tree(seed, roots=(2, 1, 1), levels=5):
    """Level and index of the leaves, in any order."""
    random = np.random.default_rng(seed)
    found = []
    cells = np.stack(np.meshgrid(*map(np.arange, roots), indexing="ij"), axis=-1).reshape(-1, 3)
    for level in range(levels + 1):
        divided = random.random(len(cells)) < (0.7 if level < levels else 0)
        found.append(np.column_stack([np.full(np.count_nonzero(~divided), level), cells[~divided]]))
        cells = (2 * cells[divided][:, None] + OCTANTS).reshape(-1, 3)
    found = np.concatenate(found)
    random.shuffle(found)
    return found[:, 0], found[:, 1:]


def sphere(n=16):
    """Distances from the middle of a cube of the width 2, of n cells along each axis."""
    ijk = np.stack(np.meshgrid(*3 * [np.arange(n)], indexing="ij"), axis=-1).reshape(-1, 3)
    radius = np.linalg.norm((ijk + 0.5) / n * 2 - 1, axis=1)
    return treeamr.from_cells(int(np.log2(n)), ijk, {"radius": radius}, origin=(-1, -1, -1), spacing=2)


class TestNumpy(unittest.TestCase):
    def setUp(self):
        self.catcher = warnings.catch_warnings(record=True)
        self.warned = self.catcher.__enter__()
        warnings.simplefilter("always")

    def tearDown(self):
        self.catcher.__exit__(None, None, None)

    def test_docstrings(self):
        output, sys.stdout = sys.stdout, io.StringIO()  # pvpython's own stream has no encoding, as doctest wants
        try:
            results = [doctest.testmod(module) for module in (grids, sampling, pictures)]
            text = sys.stdout.getvalue()
        finally:
            sys.stdout = output
        self.assertEqual([result.failed for result in results], [0, 0, 0], text)
        self.assertTrue(all(result.attempted > 2 for result in results))

    def test_everything_has_types_and_a_docstring(self):
        for name in treeamr.__all__:
            self.assertTrue(getattr(treeamr, name).__doc__, name)
            if inspect.isfunction(getattr(treeamr, name)):
                signature = inspect.signature(getattr(treeamr, name))
                self.assertNotIn(inspect.Signature.empty, [p.annotation for p in signature.parameters.values()], name)
                self.assertIsNot(signature.return_annotation, inspect.Signature.empty, name)

    def test_cells_are_where_they_are_said_to_be(self):
        for seed, type in enumerate((np.float32, np.float64, np.int16, np.uint64, bool, ">f8", np.float16)):
            level, ijk = random_tree(seed)
            values = np.arange(len(level)).astype(type)
            grid = treeamr.from_cells(level.astype(np.uint8), ijk, values, (-1, 0, 5), (0.5, 1, 2), roots=(2, 1, 1))
            self.assertEqual(grid.GetNumberOfLeaves(), len(level))
            centres = (-1, 0, 5) + np.array([0.5, 1, 2]) * (ijk + 0.5) / 2.0**level[:, None]
            np.testing.assert_array_equal(treeamr.probe(grid, centres, method="nearest"), values.astype(np.float64))
        self.assertEqual(self.warned, [])

    def test_probe_has_the_shape_of_the_points(self):
        n = 4
        ijk = np.stack(np.meshgrid(*3 * [np.arange(n)], indexing="ij"), axis=-1).reshape(-1, 3)
        centres = (ijk + 0.5) / n
        matrix = np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 5.0]])
        grid = treeamr.from_cells(2, ijk, {"a": centres @ matrix.T, "b": centres @ matrix[0]})
        points = np.random.default_rng(1).uniform(0.2, 0.8, (5, 7, 3))
        values, gradients = treeamr.probe(grid, points, gradients=True)
        np.testing.assert_allclose(values, points @ matrix.T, atol=1e-6)
        np.testing.assert_allclose(gradients, np.broadcast_to(matrix, (5, 7, 2, 3)), atol=1e-5)
        values, gradients = treeamr.probe(grid, points, "b", gradients=True)
        np.testing.assert_allclose(values, points @ matrix[0], atol=1e-6)
        self.assertEqual(gradients.shape, (5, 7, 3))
        self.assertAlmostEqual(treeamr.probe(grid, points[0, 0], "b"), points[0, 0] @ matrix[0], 6)
        self.assertTrue(np.isnan(treeamr.probe(grid, [[2.0, 0, 0], [0.5, 0.5, 0.5]], "b")[0]))
        self.assertEqual(treeamr.probe(grid, np.empty((0, 3)), "b").shape, (0,))

    def test_isosurface_is_closed_and_where_the_value_is(self):
        surface = treeamr.isosurface(sphere(), [0.5, 0.7])
        radius = np.linalg.norm(surface.vertices, axis=1)
        self.assertLess(np.abs(radius[:, None] - [0.5, 0.7]).min(axis=1).max(), 0.01)
        edges = np.sort(surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        self.assertEqual(set(np.unique(edges, axis=0, return_counts=True)[1]), {2})
        np.testing.assert_allclose(-surface.vertices / radius[:, None], surface.normals, atol=0.05)
        corners = surface.vertices[surface.triangles]
        turned = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.assertTrue((np.einsum("ij,ij->i", turned, surface.normals[surface.triangles[:, 0]]) > 0).all())
        self.assertEqual([part.shape for part in treeamr.isosurface(sphere(), 99)], 3 * [(0, 3)])

    def test_a_volume_has_the_colour_that_it_should(self):
        grid = treeamr.from_cells(1, OCTANTS, np.full(8, 1.0))
        diagonal = np.sqrt(3)
        picture = treeamr.render(grid, range=(0, 2), colors=[(1, 0, 0), (0, 0, 1)], opacity=0.1, size=(101, 101),
                                 direction=(0, 1, 0), zoom=3)
        self.assertEqual((picture.shape, picture.dtype), ((101, 101, 3), np.uint8))
        through = 0.9 ** (50 / diagonal)  # of the way of 1, per fiftieth of the diagonal
        expected = 255 * (through * np.ones(3) + (1 - through) * np.array([0.5, 0, 0.5]))
        self.assertLess(np.abs(picture[50, 50] - expected).max(), 1)

    def test_pictures_do_not_depend_on_the_unit_of_length(self):
        ijk = np.stack(np.meshgrid(*3 * [np.arange(8)], indexing="ij"), axis=-1).reshape(-1, 3)
        for width, origin in ((1e-30, 0), (1e-30, 3e-30), (1e-18, 1e-17), (1e18, 0), (1e30, 2e30)):
            pictures = []
            for unit in (1., width):
                grid = treeamr.from_cells(0, ijk, ijk.sum(axis=1) * 1.0, origin=3 * [origin / width * unit],
                                          spacing=3 * [unit / 8])
                pictures.append(treeamr.render(grid, isovalues=10.3, volume=True, opacity=(0, 0.3), size=(61, 61)))
            self.assertGreater(np.ptp(pictures[0]), 100)
            difference = np.abs(pictures[1].astype(int) - pictures[0]).max(axis=2)
            self.assertLess((difference > 2).sum(), 10, f"{width} wide at {origin}")  # outlines

    def test_surfaces_have_their_colours_and_pictures_are_upright(self):
        level = np.ones(8, int)
        grid = treeamr.from_cells(level, OCTANTS, OCTANTS[:, 2] * 1.0)
        picture = treeamr.render(grid, direction=(0, 1, 0), opacity=(0, 1), colors=[(0, 0, 1), (1, 0, 0)], size=(61, 61))
        upper, lower = picture[25, 30].astype(int), picture[35, 30].astype(int)
        self.assertGreater(upper[0] - upper[2], lower[0] - lower[2])  # the larger values are red, and up
        file = folder / "picture.png"
        picture.save(file)
        self.assertEqual(file.read_bytes(), picture._repr_png_())
        self.assertIsNone(picture[0]._repr_png_())

    def test_files(self):
        from vtkmodules.vtkIOXML import vtkXMLHyperTreeGridWriter
        writer = vtkXMLHyperTreeGridWriter()
        writer.SetInputData(sphere())
        writer.SetFileName(str(folder / "sphere.htg"))
        writer.Write()
        grid = treeamr.read(folder / "sphere.htg")
        point = [0.3, 0.2, 0.1]
        self.assertEqual(treeamr.probe(grid, point), treeamr.probe(sphere(), point))
        with self.assertRaisesRegex(FileNotFoundError, "nothing.p8est: no such file"):
            treeamr.read(folder / "nothing.p8est")
        (folder / "no.p8est").write_text("hello")
        with self.assertRaisesRegex(treeamr.Error, "no.p8est: "):
            treeamr.read(folder / "no.p8est")
        (folder / "no.vtu").write_text("<VTKFile type='ImageData' version='1.0'/>")
        with self.assertRaisesRegex(treeamr.Error, "no.vtu: "):
            treeamr.read(folder / "no.vtu")
        forest = pathlib.Path(__file__).parent.parent / "Data" / "Fuzz" / "ForestFuzz" / "brick"
        self.assertGreater(treeamr.read(forest).GetNumberOfLeaves(), 0)
        with self.assertRaisesRegex(treeamr.Error, 'payload "double é"'):
            treeamr.read(forest, "double é")
        with self.assertRaisesRegex(ValueError, "payload and arrays are of forests"):
            treeamr.read(folder / "sphere.htg", payload="double x")

    def test_what_does_not_fit_is_an_exception(self):
        ijk = [[0, 0, 0], [1, 0, 0]]
        picture = treeamr.render(sphere(4), size=(8, 6))
        for error, text, call in (
                (treeamr.Error, r"cells overlap: row 0, level 0 .*, and row 1, level 1",
                 lambda: treeamr.from_cells([0, 1], [[0, 0, 0], [1, 1, 1]], [1, 2])),
                (treeamr.Error, r"row 1, level 0 at \(1, 0, 0\); allowed",
                 lambda: treeamr.from_cells(0, ijk, [1, 2], roots=(1, 1, 1))),
                (treeamr.Error, "Spacing", lambda: treeamr.from_cells(0, ijk, [1, 2], spacing=-1)),
                (ValueError, r"ijk has the shape \(2,\)", lambda: treeamr.from_cells(0, [1, 2], [1, 2])),
                (ValueError, "'values' has 3 entries, allowed are 2", lambda: treeamr.from_cells(0, ijk, [1, 2, 3])),
                (ValueError, r"origin has the shape \(2,\)", lambda: treeamr.from_cells(0, ijk, [1, 2], origin=(1, 2))),
                (TypeError, "'values' has the type complex128", lambda: treeamr.from_cells(0, ijk, [1j, 2])),
                (KeyError, "no cell array is called 'x'; there are 'radius'", lambda: treeamr.probe(sphere(4), [0, 0, 0], "x")),
                (ValueError, "method is 'cubic'", lambda: treeamr.probe(sphere(4), [0, 0, 0], method="cubic")),
                (TypeError, "grid is a list", lambda: treeamr.isosurface([], 1)),
                (TypeError, "data is a vtkHyperTreeGrid", lambda: treeamr.from_unstructured(sphere(4))),
                (ValueError, r"colors has the shape \(3,\)", lambda: treeamr.render(sphere(4), colors=(1, 0, 0))),
                (ValueError, "colors is .*255.*, allowed are numbers from 0 to 1",
                 lambda: treeamr.render(sphere(4), colors=[(255, 0, 0), (0, 0, 0)])),
                (ValueError, "opacity is .nan., allowed", lambda: treeamr.render(sphere(4), opacity=np.nan)),
                (ValueError, "range is", lambda: treeamr.render(sphere(4), range=(np.nan, 1))),
                (ValueError, "size is", lambda: treeamr.render(sphere(4), size=(0, 1))),
                (ValueError, "size is 80", lambda: treeamr.render(sphere(4), size=80)),
                (ValueError, "zoom is 0", lambda: treeamr.render(sphere(4), zoom=0)),
                (ValueError, "direction is", lambda: treeamr.render(sphere(4), direction=(0, 0, 0))),
                (ValueError, "volume is off", lambda: treeamr.render(sphere(4), volume=False)),
                (ValueError, "masked array", lambda: treeamr.from_cells(0, ijk, np.ma.array([1, 2], mask=[1, 0]))),
                (ValueError, "'ijk' is a masked array",
                 lambda: treeamr.from_cells(0, np.ma.masked_greater(ijk, 0), [1, 2])),
                (ValueError, "'points' is a masked array",
                 lambda: treeamr.probe(sphere(4), np.ma.masked_less([1., 1., 0.], 0.5))),
                (ValueError, "isovalues is", lambda: treeamr.render(sphere(4), isovalues=[[1.]])),
                (ValueError, "shade is no, allowed are True and False", lambda: treeamr.render(sphere(4), shade="no")),
                (ValueError, "occlusion is -1", lambda: treeamr.render(sphere(4), isovalues=1, occlusion=-1)),
                (ValueError, "samples_per_cell is 0", lambda: treeamr.render(sphere(4), samples_per_cell=0)),
                (ValueError, "path is a.jpg, allowed are names that end in .png", lambda: picture.save("a.jpg")),
                (ValueError, "the picture's type is float64", lambda: (1.5 * picture).png()),
                (ValueError, "roots is", lambda: treeamr.from_cells(0, ijk, [1, 2], roots=(2.5, 1, 1))),
                (KeyError, "the grid has no cell arrays",
                 lambda: treeamr.probe(treeamr.from_cells(0, np.empty((0, 3)), np.empty(0)), [0, 0, 0])),
                (treeamr.Error, "^((?!vtkInformation).)*$", lambda: treeamr.isosurface(sphere(4), np.nan))):
            with self.assertRaisesRegex(error, text):
                call()

    def test_unstructured(self):
        from vtkmodules.vtkFiltersHyperTree import vtkHyperTreeGridToUnstructuredGrid
        level, ijk = random_tree(9)
        grid = treeamr.from_cells(level, ijk, {"n": np.arange(len(level)) * 1.0})
        hexahedra = vtkHyperTreeGridToUnstructuredGrid()
        hexahedra.SetInputData(grid)
        hexahedra.Update()
        again = treeamr.from_unstructured(hexahedra.GetOutput())
        centres = (ijk + 0.5) / 2.0**level[:, None]
        np.testing.assert_array_equal(treeamr.probe(again, centres, "n", "nearest"), np.arange(len(level)))

    def test_tables_in_paraview(self):
        level, ijk = random_tree(5)
        file = folder / "cells.csv"
        np.savetxt(file, np.column_stack([level, ijk, np.arange(len(level))]), "%d", ",", header="level,i,j,k,n", comments="")
        table = CSVReader(FileName=[str(file)])
        grid = TreeAMRFromTable(Input=table, Spacing=[2, 2, 2])
        grid.UpdatePipeline()
        self.assertEqual(grid.GetDataInformation().GetNumberOfCells(), len(level))
        self.assertEqual(grid.GetDataInformation().GetBounds(), (0, 4, 0, 2, 0, 2))
        self.assertEqual(grid.CellData["n"].GetRange(), (0, len(level) - 1))
        view = CreateRenderView()
        display = Show(grid, view)
        ColorBy(display, ("CELLS", "n"))
        display.SetRepresentationType("Tree AMR Volume")
        Render(view)


if __name__ == "__main__":
    scene.main()
