"""Compares ParaView's own ways to a volume rendering of octree data with TreeAMR's: time, memory, error.

Each route reads the same forest, in a process of its own with a time limit, and draws the pictures of
treeamr-benchmark: its data sets, camera and transfer functions (see Scene.cpp). PSNR is that of the window's
8-bit colours against the benchmark's converged picture of the generalized trilinear interpolation, where that
is in FOLDER. Prints a table, adds the figures to FOLDER/bench.json as "peers", saves FOLDER/peers/*.png.

usage: python3 peers.py FOLDER [--datasets NAME...] [--routes ROUTE...] [--timeout SECONDS]
"""

import argparse
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


def transfer_function(dataset):
    """Of Scene.cpp: the end of the values, (value, r, g, b) linear in between, extinction per edge length."""
    if dataset.startswith("mandelbulb"):
        return (1, [(0, 0, 1, 0.5), (1, 1, 0, 0.5)],
                lambda u: 60 * min(1, (max(0, u - 0.3) / 0.6) ** 2))
    return (2, [(0, 0, 0.9, 1), (1, 1, 0.5, 0), (2, 1, 0.1, 0)],
            lambda u: 30 * min(1, max(0, 1.2 * (u - 0.15))))


# --- in pvpython: one route ---


def show(route, reader, view):
    """The representation of the route's volume."""
    from paraview import simple

    source, kind, array = reader, "Tree AMR Volume", ("CELLS", "value")
    if route != "treeamr":
        # Values at points that neighbours share make the better pictures and cost little beside the rest.
        hexes = simple.HyperTreeGridToUnstructuredGrid(Input=reader)
        source = simple.CellDatatoPointData(Input=simple.CleantoGrid(Input=hexes))
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

    def first_picture():
        path = folder / (dataset + ".p8est")
        reader = simple.TreeAMRP4estReader(FileName=str(path), Payload="double value")
        set_transfer_function(show(route, reader, view), dataset)
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
    if reference.exists():
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


def table_row(result):
    route = ROUTES[result["route"]]
    start = f"{result['dataset']:<16} {route:<28}"
    if "failed" in result:
        return f"{start} failed: {result['failed']}"
    gigabytes = result["peak_rss_bytes"] / 1e9
    if "timed_out_s" in result:
        return f"{start} no picture within {result['timed_out_s']:g} s, {gigabytes:.2f} GB"
    quality = f"{result['psnr_db']:7.1f}" if "psnr_db" in result else ""
    return (f"{start} {result['first_picture_s']:9.1f} {result['first_picture_cpu_s']:9.1f} "
            f"{result['s_frame']:9.2f} {result['cpu_s_frame']:9.2f} {gigabytes:8.2f} {quality}")


def add_result(path, result):
    """In the place of an older one of the same data set and route."""
    benchmark = json.loads(path.read_text()) if path.exists() else {}
    others = [peer for peer in benchmark.get("peers", [])
              if (peer["dataset"], peer["route"]) != (result["dataset"], result["route"])]
    path.write_text(json.dumps({**benchmark, "peers": others + [result]}, indent=1) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--datasets", nargs="+", default=["mandelbulb-0.3M", "mandelbulb-2.6M"],
                        metavar="NAME")
    parser.add_argument("--routes", nargs="+", default=DEFAULT_ROUTES, choices=ROUTES, metavar="ROUTE",
                        help=", ".join(ROUTES))
    parser.add_argument("--timeout", type=float, default=600, metavar="SECONDS", help="of each route (600)")
    parser.add_argument("--measure", nargs=2, metavar=("NAME", "ROUTE"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        print(MARK + json.dumps(measure(arguments.folder, *arguments.measure)))
        return
    for dataset in arguments.datasets:
        if not (arguments.folder / (dataset + ".p8est")).exists():
            sys.exit(f"peers.py: no {dataset}.p8est in {arguments.folder}")
    (arguments.folder / "peers").mkdir(exist_ok=True)
    print(f"{'':<45} {'first s':>9} {'CPU-s':>9} {'frame s':>9} {'CPU-s':>9} {'peak GB':>8} {'dB':>7}")
    for dataset in arguments.datasets:
        for route in arguments.routes:
            result = {"dataset": dataset, "route": route,
                      **run(arguments.folder, dataset, route, arguments.timeout)}
            print(table_row(result), flush=True)
            add_result(arguments.folder / "bench.json", result)


if __name__ == "__main__":
    main()
