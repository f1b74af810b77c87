"""Compares ParaView's own ways to a volume rendering and to isosurfaces of octree data with TreeAMR's: time,
memory, error.

Each route reads the same forest, in a process of its own with a time limit. Prints tables, adds the figures
to FOLDER/bench.json, or another FILE, as "peers" and "isosurface_peers", saves FOLDER/peers/*.png.

Volumes are the pictures of treeamr-benchmark: its data sets, camera and transfer functions (see Scene.cpp).
PSNR is that of the window's 8-bit colours against the benchmark's converged picture of the generalized
trilinear interpolation, where that is in FOLDER.

Isosurfaces are seen from the same place. Open edges are those of one polygon alone, away from the domain's
end. On the data set sphere-0.3M, whose values are distances from the cube's centre, errors are the distances
from the sphere of radius 0.3 of the points that the pixels show and of the mesh's own points, in edge lengths
of the domain; and the angles, in degrees, between the sphere's normals and those that the pixels are shaded
with, which their 8-bit colours tell to 0.2 degrees, and those of the mesh (of its polygons, where its points
have none).

usage: python3 peers.py FOLDER [--part volume|isosurface] [--datasets NAME...] [--routes ROUTE...]
       [--timeout SECONDS] [--json FILE]
"""

import argparse
import dataclasses
import json
import math
import os
import pathlib
import resource
import signal
import subprocess
import sys
import time

PIXELS = 1000
MARK = "peers.py: "  # before a route's figures, among what else ParaView prints

ROUTES = {
    "treeamr": "Tree AMR Volume",
    "projected-tetra": "hexes, projected tetrahedra",
    "bunyk": "hexes, Bunyk ray cast",
    "zsweep": "hexes, Z sweep",
    "resample-128": "Resample To Image, 128^3",
    "resample-256": "Resample To Image, 256^3",
    "resample-512": "Resample To Image, 512^3",
}
# Without two that take minutes even for 0.3 million cells; Bunyk also shows what has no opacity (8 dB).
DEFAULT_ROUTES = [route for route in ROUTES if route not in ("bunyk", "zsweep")]

SURFACE_ROUTES = {
    "isosurface-treeamr": "Tree AMR Isosurface",
    "isosurface-contour": "Tree AMR Contour",
    "isosurface-grid": "Contour of the grid",
    "isosurface-hexes": "hexes, Contour",
}
# By the start of the data set's name.
ISOVALUES = {"sphere": 0.3, "mandelbulb": 0.9, "sheet": 0.5}
# Of eight trees: ParaView 5.11's Contour finds nothing in a grid of one.
SURFACE_DATASETS = ["sphere-0.3M", "mandelbulb-2.6M-8"]


@dataclasses.dataclass
class Part:
    key: str  # in bench.json
    routes: dict
    default_routes: list
    default_datasets: list
    columns: list  # beside those of all: heading, key, format


PARTS = {
    "volume": Part("peers", ROUTES, DEFAULT_ROUTES, ["mandelbulb-0.3M", "mandelbulb-2.6M"],
                   [("dB", "psnr_db", ".1f")]),
    "isosurface": Part("isosurface_peers", SURFACE_ROUTES, list(SURFACE_ROUTES), SURFACE_DATASETS, [
        ("polygons", "polygons", "d"), ("open", "open_edges", "d"),
        ("seen max", "seen_distance_max", ".1e"), ("mean", "seen_distance_mean", ".1e"),
        ("mesh max", "mesh_distance_max", ".1e"), ("mean", "mesh_distance_mean", ".1e"),
        ("seen deg", "seen_angle_max", ".2f"), ("mean", "seen_angle_mean", ".3f"),
        ("mesh deg", "mesh_angle_max", ".2f"), ("mean", "mesh_angle_mean", ".3f")]),
}


def transfer_function(dataset):
    """Of Scene.cpp: the end of the values, (value, r, g, b) linear in between, extinction per edge length."""
    if dataset.startswith("mandelbulb"):
        return (1, [(0, 0, 1, 0.5), (1, 1, 0, 0.5)],
                lambda u: 60 * min(1, (max(0, u - 0.3) / 0.6) ** 2))
    return (2, [(0, 0, 0.9, 1), (1, 1, 0.5, 0), (2, 1, 0.1, 0)],
            lambda u: 30 * min(1, max(0, 1.2 * (u - 0.15))))


# --- in pvpython: one route ---


def hexes_with_point_values(reader):
    """Values at points that neighbours share make the better pictures and cost little beside the rest."""
    from paraview import simple

    hexes = simple.HyperTreeGridToUnstructuredGrid(Input=reader)
    return simple.CellDatatoPointData(Input=simple.CleantoGrid(Input=hexes))


def show_volume(route, reader, view):
    """The representation of the route's volume."""
    from paraview import simple

    source, kind, array = reader, "Tree AMR Volume", ("CELLS", "value")
    if route != "treeamr":
        source = hexes_with_point_values(reader)
        kind, array = "Volume", ("POINTS", "value")
    if route.startswith("resample"):
        source = simple.ResampleToImage(Input=source, SamplingDimensions=[int(route.split("-")[1])] * 3)
    representation = simple.Show(source, view)
    simple.ColorBy(representation, array)
    representation.SetRepresentationType(kind)
    mappers = {"projected-tetra": "Projected tetra", "bunyk": "Bunyk ray cast", "zsweep": "Z sweep"}
    if route in mappers:
        representation.SelectMapper = mappers[route]
    return representation


def set_transfer_function(representation, dataset):
    end, colours, extinction = transfer_function(dataset)
    table = representation.LookupTable
    table.ColorSpace = "RGB"
    table.RGBPoints = [x for point in colours for x in point]
    unit = 0.01
    count = 1024
    values = [end * i / (count - 1) for i in range(count)]
    representation.ScalarOpacityFunction.Points = [
        x for u in values for x in (u, 1 - math.exp(-extinction(u) * unit), 0.5, 0)]
    representation.ScalarOpacityUnitDistance = unit


def show_surface(route, reader, view, isovalue):
    """The source of the route's mesh; None where there is none."""
    from paraview import simple

    source, kind = reader, "Tree AMR Isosurface"
    if route != "isosurface-treeamr":
        if route == "isosurface-hexes":
            source = hexes_with_point_values(reader)
        array = ["POINTS" if route == "isosurface-hexes" else "CELLS", "value"]
        contour = simple.TreeAMRContour if route == "isosurface-contour" else simple.Contour
        source = contour(Input=source, ContourBy=array, Isosurfaces=[isovalue])
        kind = "Surface"
    representation = simple.Show(source, view)
    representation.ColorArrayName = [None, ""]
    representation.SetRepresentationType(kind)
    representation.DiffuseColor = representation.AmbientColor = [0.85, 0.8, 0.7]
    if source is not reader:
        return source
    representation.Isovalues = [isovalue]
    return None


def open_edges(mesh):
    """How many edges of a vtkPolyData belong to one polygon alone. A dual grid ends half a cell before the
    domain does, at most a 32nd of it: edges there are no gaps."""
    from paraview.vtk.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkFeatureEdges

    merged = vtkCleanPolyData()
    merged.SetInputData(mesh)
    merged.ToleranceIsAbsoluteOn()
    merged.SetAbsoluteTolerance(1e-7)
    edges = vtkFeatureEdges()
    edges.FeatureEdgesOff()
    edges.NonManifoldEdgesOff()
    edges.SetInputConnection(merged.GetOutputPort())
    edges.Update()
    found = edges.GetOutput()
    if found.GetNumberOfLines() == 0:
        return 0
    ends = vtk_to_numpy(found.GetLines().GetConnectivityArray()).reshape(-1, 2)
    middles = vtk_to_numpy(found.GetPoints().GetData())[ends].mean(axis=1)
    return int(((middles > 0.04) & (middles < 0.96)).all(axis=1).sum())


def seen(view):
    """Which pixels' rays meet the surface, and where: pixels as a mask, lower row first."""
    import numpy
    from paraview.vtk.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkFloatArray

    depths = vtkFloatArray()
    view.GetRenderWindow().GetZbufferData(0, 0, PIXELS - 1, PIXELS - 1, depths)
    depth = vtk_to_numpy(depths).astype(float).reshape(PIXELS, PIXELS)
    y, x = numpy.nonzero(depth < 1)
    in_window = [
        (2 * x + 1) / PIXELS - 1, (2 * y + 1) / PIXELS - 1, 2 * depth[y, x] - 1, numpy.ones(len(x))]
    matrix = view.GetActiveCamera().GetCompositeProjectionTransformMatrix(1, -1, 1)
    projection = numpy.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    points = numpy.linalg.solve(projection, numpy.array(in_window))
    return depth < 1, (points[:3] / points[3]).T


def shaded_normals(view):
    """Of all pixels, lower row first, turned to the eye: a white surface in red, green and blue light along
    the axes, from ahead and from behind, has the normal's components as its colours."""
    from paraview import simple
    from paraview.vtk.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    view.UseLight = 0
    for representation in view.Representations:
        representation.DiffuseColor = [1, 1, 1]
    lights = [simple.AddLight(view=view) for _ in range(3)]
    pictures = []
    for side in (1, -1):
        for axis, light in enumerate(lights):
            unit = [float(a == axis) for a in range(3)]
            light.Type, light.DiffuseColor = "Directional", unit
            light.Position, light.FocalPoint = [side * x for x in unit], [0, 0, 0]
        simple.Render(view)
        colours = vtkUnsignedCharArray()
        view.GetRenderWindow().GetPixelData(0, 0, PIXELS - 1, PIXELS - 1, 0, colours, 0)
        pictures.append(vtk_to_numpy(colours).astype(float).reshape(PIXELS, PIXELS, 3))
    return pictures[0] - pictures[1]


def mesh_normals(mesh):
    """Points with normals: the mesh's own, else the polygons' middles and normals."""
    from paraview.vtk.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkCellCenters, vtkPolyDataNormals

    normals = mesh.GetPointData().GetNormals()
    if not normals:
        flat = vtkPolyDataNormals()
        flat.SetInputData(mesh)
        flat.ComputePointNormalsOff()
        flat.ComputeCellNormalsOn()
        flat.SplittingOff()
        flat.ConsistencyOff()
        middles = vtkCellCenters()
        middles.SetInputConnection(flat.GetOutputPort())
        middles.Update()
        mesh = middles.GetOutput()
        normals = mesh.GetPointData().GetNormals()
    return vtk_to_numpy(mesh.GetPoints().GetData()), vtk_to_numpy(normals)


def largest_and_mean(name, errors):
    return {f"{name}_max": float(errors.max()), f"{name}_mean": float(errors.mean())}


def sphere_distances(points):
    """From the isosurface of sphere-0.3M."""
    import numpy

    return abs(numpy.linalg.norm(points - 0.5, axis=1) - ISOVALUES["sphere"])


def sphere_angles(points, normals):
    """Degrees between the sphere's normals and others, of either side."""
    import numpy

    sine = numpy.linalg.norm(numpy.cross(points - 0.5, normals), axis=1)
    cosine = abs(((points - 0.5) * normals).sum(axis=1))
    return numpy.degrees(numpy.arctan2(sine, cosine))


def surface_figures(view, dataset, source):
    from paraview.vtk.util.numpy_support import vtk_to_numpy

    mesh = source.GetClientSideObject().GetOutputDataObject(0) if source else None
    figures = {"polygons": mesh.GetNumberOfPolys(), "open_edges": open_edges(mesh)} if mesh else {}
    if dataset == "sphere-0.3M":
        pixels, points = seen(view)
        figures.update(largest_and_mean("seen_distance", sphere_distances(points)))
        figures.update(largest_and_mean("seen_angle", sphere_angles(points, shaded_normals(view)[pixels])))
        if mesh and mesh.GetNumberOfPoints() > 0:
            mesh_points = vtk_to_numpy(mesh.GetPoints().GetData())
            figures.update(largest_and_mean("mesh_distance", sphere_distances(mesh_points)))
            figures.update(largest_and_mean("mesh_angle", sphere_angles(*mesh_normals(mesh))))
    return figures


def psnr(picture, reference):
    """Of a PNG file against the floats that treeamr-benchmark keeps (ReferenceImage.h)."""
    import numpy
    from paraview.vtk.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkPNGReader

    reader = vtkPNGReader()
    reader.SetFileName(str(picture))
    reader.Update()
    shown = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())[:, :3] / 255
    converged = numpy.fromfile(reference, dtype=numpy.float32, offset=24).reshape(-1, 4)[:, :3]
    return float(-10 * numpy.log10(numpy.mean((shown - numpy.clip(converged, 0, 1)) ** 2)))


def measure(folder, dataset, route):
    from paraview import simple

    simple._DisableFirstRenderCameraReset()
    elevation, azimuth = math.radians(25), math.radians(35)
    view = simple.CreateView(
        "RenderView", ViewSize=[PIXELS, PIXELS], OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
        Background=[0, 0, 0], UseFXAA=0, CameraFocalPoint=[0.5] * 3, CameraViewUp=[0, 1, 0],
        CameraViewAngle=40, CameraPosition=[
            0.5 + 1.6 * math.cos(elevation) * math.sin(azimuth), 0.5 + 1.6 * math.sin(elevation),
            0.5 + 1.6 * math.cos(elevation) * math.cos(azimuth)])
    simple.Render(view)  # the window and its context are nobody's cost

    def timed(work):
        wall, cpu = time.perf_counter(), time.process_time()
        work()
        return time.perf_counter() - wall, time.process_time() - cpu

    mesh_source = None

    def first_picture():
        nonlocal mesh_source
        path = folder / (dataset + ".p8est")
        reader = simple.TreeAMRP4estReader(FileName=str(path), Payload="double value")
        if route in SURFACE_ROUTES:
            mesh_source = show_surface(route, reader, view, ISOVALUES[dataset.split("-")[0]])
        else:
            set_transfer_function(show_volume(route, reader, view), dataset)
        simple.Render(view)

    def next_picture():
        view.CameraPosition = [x + 1e-7 for x in view.CameraPosition]
        simple.Render(view)

    first = timed(first_picture)
    more = [timed(next_picture)]
    while len(more) < 3 and sum(wall for wall, _ in more) < 60:
        more.append(timed(next_picture))
    result = {
        "first_picture_s": first[0], "first_picture_cpu_s": first[1],
        "s_frame": min(wall for wall, _ in more), "cpu_s_frame": min(cpu for _, cpu in more),
        "peak_rss_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}
    picture = folder / "peers" / f"{dataset}-{route}.png"
    simple.SaveScreenshot(str(picture), view, ImageResolution=[PIXELS, PIXELS])
    reference = folder / (dataset + ".reference")
    if route in SURFACE_ROUTES:
        result.update(surface_figures(view, dataset, mesh_source))
    elif reference.exists():
        result["psnr_db"] = psnr(picture, reference)
    return result


# --- all routes, each in a process ---


def run(folder, dataset, route, timeout):
    """The figures of one route, or what became of it."""
    process = subprocess.Popen(
        ["pvpython", "--force-offscreen-rendering", __file__, str(folder), "--measure", dataset, route],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
    try:
        output, _ = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        peak = next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM"))
        return {"timed_out_s": timeout, "peak_rss_bytes": peak * 1024}
    figures = [line for line in output.splitlines() if line.startswith(MARK)]
    if process.returncode != 0 or not figures:
        last_line = (output.strip().splitlines() or ["no output"])[-1]
        return {"failed": f"exit code {process.returncode}: {last_line}"}
    return json.loads(figures[0][len(MARK):])


def table_head(part):
    return (f"{'':<45} {'first s':>9} {'CPU-s':>9} {'frame s':>9} {'CPU-s':>9} {'peak GB':>8}" +
            "".join(f" {heading:>9}" for heading, _, _ in part.columns))


def table_row(part, result):
    start = f"{result['dataset']:<17} {part.routes[result['route']]:<27}"
    if "failed" in result:
        return f"{start} failed: {result['failed']}"
    gigabytes = result["peak_rss_bytes"] / 1e9
    if "timed_out_s" in result:
        return f"{start} no picture within {result['timed_out_s']:g} s, {gigabytes:.2f} GB"
    more = [format(result[key], form) if key in result else "" for _, key, form in part.columns]
    return (f"{start} {result['first_picture_s']:9.1f} {result['first_picture_cpu_s']:9.1f} "
            f"{result['s_frame']:9.2f} {result['cpu_s_frame']:9.2f} {gigabytes:8.2f}" +
            "".join(f" {figure:>9}" for figure in more))


def add_result(path, key, result):
    """In the place of an older one of the same data set and route."""
    benchmark = json.loads(path.read_text()) if path.exists() else {}
    others = [peer for peer in benchmark.get(key, [])
              if (peer["dataset"], peer["route"]) != (result["dataset"], result["route"])]
    path.write_text(json.dumps({**benchmark, key: others + [result]}, indent=1) + "\n")


def run_part(part, arguments):
    routes = [route for route in arguments.routes or part.default_routes if route in part.routes]
    datasets = arguments.datasets or part.default_datasets
    for dataset in datasets:
        if routes and not (arguments.folder / (dataset + ".p8est")).exists():
            sys.exit(f"peers.py: no {dataset}.p8est in {arguments.folder}")
    if routes:
        print(table_head(part))
    for dataset in datasets:
        for route in routes:
            result = {"dataset": dataset, "route": route,
                      **run(arguments.folder, dataset, route, arguments.timeout)}
            print(table_row(part, result), flush=True)
            add_result(arguments.json or arguments.folder / "bench.json", part.key, result)


def main():
    routes = [*ROUTES, *SURFACE_ROUTES]
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--part", choices=PARTS, help="both")
    parser.add_argument("--datasets", nargs="+", metavar="NAME", help="; ".join(
        f"{name}: {' '.join(part.default_datasets)}" for name, part in PARTS.items()))
    parser.add_argument("--routes", nargs="+", choices=routes, metavar="ROUTE", help=", ".join(routes))
    parser.add_argument("--timeout", type=float, default=600, metavar="SECONDS", help="of each route (600)")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="FOLDER/bench.json")
    parser.add_argument("--measure", nargs=2, metavar=("NAME", "ROUTE"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        print(MARK + json.dumps(measure(arguments.folder, *arguments.measure)))
        return
    (arguments.folder / "peers").mkdir(exist_ok=True)
    for name, part in PARTS.items():
        if arguments.part in (None, name):
            run_part(part, arguments)


if __name__ == "__main__":
    main()
