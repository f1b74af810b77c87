"""What many processes hold, how long they take, and how far their pictures are from that of one.

Runs ParaView's pvbatch on 1, 2, 3, 4 and 8 ranks for each data set, each run with a time limit, and writes FOLDER/ranks.json:
a list of {"dataset", "ranks", "volume_max_diff", "volume_mean_diff", "default_max_diff", "surface_max_diff",
"translucent_max_diff" ... (of 255, from one rank's, without antialiasing; null for one rank), "peak_mb_per_rank",
"base_mb_per_rank" (before there is a view), "view_mb_per_rank" (with an empty one), "cells_per_rank", "ghosts_per_rank" (the
largest of all ranks), "read_s" (until the first picture), "wall_s_frame", "cpu_s_frame" (of all ranks)}. Pictures, and 40 times
their differences, are FOLDER/ranks/*.png.

Volumes are compared at 8 samples a cell and at the default of 2 ("default"), of which times are.

The ranks share this machine's cores: wall times say what that costs, not what more machines would give.

usage: python3 ranks.py FOLDER [--datasets NAME...] [--ranks N...] [--timeout SECONDS]
"""

import argparse
import json
import pathlib
import subprocess
import sys

PIXELS = 500
FORESTS = ["mandelbulb-2.6M", "mandelbulb-20M"]
PICTURES = ["volume", "default", "surface", "translucent"]


# ---- On each rank, by pvbatch --symmetric.


def place(tree, size):
    return tree % size[0], tree // size[0] % size[1], tree // (size[0] * size[1])


def scatter(tree, seed):
    """A number from 0 to 1 that looks random."""
    value = (tree * 2654435761 + seed * 40503) % 2**32
    value = (value ^ value >> 15) * 2246822519 % 2**32
    return (value ^ value >> 13) / 2**32


def make_grid(size, owner, rank, refines, values):
    """A grid of unit trees of which the process has those that owner(tree) gives it. refines(level, low, seed): whether a cell
    has children; values(centre): its value."""
    import numpy
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkHyperTreeGrid, vtkHyperTreeGridNonOrientedGeometryCursor

    grid = vtkHyperTreeGrid()
    grid.Initialize()
    grid.SetDimensions([n + 1 for n in size])
    grid.SetBranchFactor(2)
    for axis, set_coordinates in enumerate(
            (grid.SetXCoordinates, grid.SetYCoordinates, grid.SetZCoordinates)):
        set_coordinates(numpy_to_vtk(numpy.arange(size[axis] + 1, dtype=float), deep=1))
    data = []

    def fill(cursor, seed):
        bounds = [0.] * 6
        cursor.GetBounds(bounds)
        index = cursor.GetGlobalNodeIndex()
        data.extend([0.] * (index + 1 - len(data)))
        data[index] = values([(bounds[2 * a] + bounds[2 * a + 1]) / 2 for a in range(3)])
        if refines(cursor.GetLevel(), bounds, seed):
            cursor.SubdivideLeaf()
            for child in range(8):
                cursor.ToChild(child)
                fill(cursor, seed * 8 + child + 1)
                cursor.ToParent()

    start = 0
    for tree in range(size[0] * size[1] * size[2]):
        if owner(tree) != rank:
            continue
        cursor = vtkHyperTreeGridNonOrientedGeometryCursor()
        grid.InitializeNonOrientedGeometryCursor(cursor, tree, True)
        cursor.SetGlobalIndexStart(start)
        fill(cursor, tree)
        start += cursor.GetTree().GetNumberOfVertices()
    array = numpy_to_vtk(numpy.array(data, dtype=float), deep=1)
    array.SetName("value")
    grid.GetCellData().SetScalars(array)
    return grid


def smooth_brick(rank, ranks):
    """3 x 2 x 1 trees, one after the other on the ranks in turn, finer near a sphere."""
    def distance(point):
        return sum((p - c) ** 2 for p, c in zip(point, (1.4, 0.9, 0.5))) ** 0.5

    def refines(level, bounds, _seed):
        centre = [(bounds[2 * a] + bounds[2 * a + 1]) / 2 for a in range(3)]
        return level < 3 or (level < 5 and abs(distance(centre) - 0.7) < 2 * (bounds[1] - bounds[0]))

    return make_grid((3, 2, 1), lambda tree: tree % ranks, rank, refines, lambda p: max(0., 1. - distance(p) / 1.5))


def random_trees(rank, ranks):
    """4 x 4 x 3 random trees, level jumps included, most of them on few ranks, none on two (of three or more)."""
    used = ranks - 2 if ranks > 2 else ranks

    def refines(level, _bounds, seed):
        return level < 4 and scatter(seed, level) < (0.9 if level == 0 else 0.45)

    def value(point):
        return 0.5 + 0.5 * scatter(int(sum(p * f for p, f in zip(point, (64, 4096 * 7, 262144 * 5)))), 1) * point[0] / 4

    return make_grid((4, 4, 3), lambda tree: int(used * scatter(tree, 3) ** 2), rank, refines, value)


MADE = {"smooth-brick": smooth_brick, "random-trees": random_trees}


def peak_mb():
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmHWM"))


def held(grid):
    """Cells that the process counts, and those that others do."""
    import numpy
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    if grid is None or grid.GetNumberOfNonEmptyTrees() == 0:
        return 0, 0
    masked = 0
    if grid.HasMask():
        mask = vtkUnsignedCharArray()
        mask.DeepCopy(grid.GetMask())
        masked = int(numpy.count_nonzero(vtk_to_numpy(mask)))
    marks = grid.GetGhostCells()
    ghosts = int(numpy.count_nonzero(vtk_to_numpy(marks))) if marks else 0
    return grid.GetNumberOfLeaves() - masked - ghosts, ghosts


def empty_view():
    from paraview import simple

    view = simple.CreateView(
        "RenderView", ViewSize=[PIXELS, PIXELS], OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
        Background=[0.08, 0.09, 0.12], UseFXAA=0)
    simple.Render(view)
    return view


def show(view, folder, dataset, rank, ranks):
    """The representation, coloured over the same range whatever the rank."""
    from paraview import simple

    if dataset in MADE:
        simple._DisableFirstRenderCameraReset()
        source = simple.PVTrivialProducer()
        source.GetClientSideObject().SetOutput(MADE[dataset](rank, ranks))
        array, low, high = "value", 0., 1.
    else:
        simple._DisableFirstRenderCameraReset()
        source = simple.TreeAMRP4estReader(
            FileName=str(folder / f"{dataset}.p8est"), Payload="double mandelbulb")
        array, low, high = "mandelbulb", 0., 1.
    shown = simple.Show(source, view)
    simple.ColorBy(shown, ("CELLS", array))
    shown.SetRepresentationType("Tree AMR Volume")
    size = {"smooth-brick": (3, 2, 1), "random-trees": (4, 4, 3)}.get(dataset, (1, 1, 1))
    width = max(size)
    view.CameraFocalPoint = [s / 2 for s in size]
    view.CameraPosition = [s / 2 + width * d for s, d in zip(size, (0.83, 0.68, 1.19))]
    view.CameraViewUp = [0, 1, 0]
    view.CameraViewAngle = 40
    shown.ScalarOpacityUnitDistance = 0.02 * width
    shown.LookupTable.RGBPoints = [low, 0.23, 0.3, 0.75, (low + high) / 2, 0.87, 0.87, 0.87, high, 0.7, 0.02, 0.15]
    shown.ScalarOpacityFunction.Points = [
        low, 0., 0.5, 0., low + 0.3 * (high - low), 0., 0.5, 0., high, 0.6, 0.5, 0.]
    return shown


def measure(folder, dataset):
    """Writes what this rank has seen to FOLDER/ranks/DATASET-RANKS.RANK.json, and the pictures."""
    import time

    from paraview import servermanager, simple

    module = servermanager.vtkProcessModule.GetProcessModule()
    ranks, rank = module.GetNumberOfLocalPartitions(), module.GetPartitionId()
    out = folder / "ranks"
    figures = {"base_mb": peak_mb()}
    view = empty_view()
    figures["view_mb"] = peak_mb()
    start = time.time()
    shown = show(view, folder, dataset, rank, ranks)
    simple.Render(view)
    figures["read_s"] = time.time() - start

    def save(name):
        simple.SaveScreenshot(str(out / f"{dataset}-{name}-{ranks}.png"), view, ImageResolution=[PIXELS, PIXELS])

    save("default")
    frames = 3
    start, cpu = time.time(), time.process_time()
    for _ in range(frames):
        view.CameraPosition = [x * (1 + 1e-6) for x in view.CameraPosition]
        simple.Render(view)
    figures["wall_s_frame"] = (time.time() - start) / frames
    figures["cpu_s_frame"] = (time.process_time() - cpu) / frames
    volume = view.GetRenderer().GetVolumes().GetItemAsObject(0)
    figures["cells"], figures["ghosts"] = held(volume.GetMapper().GetInputDataObject(0, 0) if volume else None)
    shown.SamplesPerCell = 8
    save("volume")
    shown.SetRepresentationType("Tree AMR Isosurface")
    simple.ColorBy(shown, None)
    shown.Isovalues = [0.6]
    save("surface")
    shown.Isovalues = [0.45, 0.8]
    shown.Opacity = 0.4
    save("translucent")
    figures["peak_mb"] = peak_mb()
    (out / f"{dataset}-{ranks}.{rank}.json").write_text(json.dumps(figures), encoding="ascii")


# ---- Once, by pvpython.


def compare(folder, dataset, ranks):
    """Prints the largest and mean differences of the pictures of so many ranks from those of one."""
    import numpy
    from paraview.vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkIOImage import vtkPNGReader, vtkPNGWriter

    result = {}
    for name in PICTURES:
        images = []
        for number in (1, ranks):
            reader = vtkPNGReader()
            reader.SetFileName(str(folder / "ranks" / f"{dataset}-{name}-{number}.png"))
            reader.Update()
            scalars = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())
            images.append(scalars.reshape(PIXELS, PIXELS, -1)[..., :3].astype(int))
        difference = abs(images[0] - images[1])
        result[name + "_max_diff"] = int(difference.max())
        result[name + "_mean_diff"] = round(float(difference.mean()), 4)
        amplified = vtkImageData()
        amplified.SetDimensions(PIXELS, PIXELS, 1)
        amplified.GetPointData().SetScalars(
            numpy_to_vtk((40 * difference).clip(0, 255).astype(numpy.uint8).reshape(-1, 3), deep=1))
        writer = vtkPNGWriter()
        writer.SetFileName(str(folder / "ranks" / f"{dataset}-{name}-{ranks}-difference.png"))
        writer.SetInputData(amplified)
        writer.Write()
    print(json.dumps(result))


# ---- What `make bench-ranks` runs.


def run(folder, dataset, ranks, timeout):
    """The row of a data set on so many ranks, without the pictures' differences."""
    script = pathlib.Path(__file__).resolve()
    pattern = f"{dataset}-{ranks}.*.json"
    for old in (folder / "ranks").glob(pattern):
        old.unlink()
    subprocess.run(
        ["mpiexec", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-np", str(ranks), "pvbatch",
         "--symmetric", "--force-offscreen-rendering", str(script), "--measure", str(folder), dataset],
        check=True, timeout=timeout, stdout=subprocess.DEVNULL)
    of_ranks = [json.loads(file.read_text()) for file in (folder / "ranks").glob(pattern)]
    assert len(of_ranks) == ranks, f"{dataset}: {len(of_ranks)} of {ranks} ranks have finished"

    def largest(key):
        return max(figures[key] for figures in of_ranks)

    return {
        "dataset": dataset, "ranks": ranks, "peak_mb_per_rank": round(largest("peak_mb"), 1),
        "base_mb_per_rank": round(largest("base_mb"), 1), "view_mb_per_rank": round(largest("view_mb"), 1),
        "cells_per_rank": largest("cells"), "ghosts_per_rank": largest("ghosts"), "read_s": round(largest("read_s"), 2),
        "wall_s_frame": round(largest("wall_s_frame"), 3),
        "cpu_s_frame": round(sum(figures["cpu_s_frame"] for figures in of_ranks), 3)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--datasets", nargs="+", default=FORESTS + list(MADE))
    parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2, 3, 4, 8])
    parser.add_argument("--timeout", type=float, default=600)
    options = parser.parse_args()
    (options.folder / "ranks").mkdir(parents=True, exist_ok=True)
    rows = []
    for dataset in options.datasets:
        for ranks in options.ranks:
            row = run(options.folder, dataset, ranks, options.timeout)
            differences = dict.fromkeys(
                (f"{name}_{kind}_diff" for name in PICTURES for kind in ("max", "mean")), None)
            if ranks > 1:
                differences = json.loads(subprocess.run(
                    ["pvpython", __file__, "--compare", str(options.folder), dataset, str(ranks)],
                    check=True, capture_output=True, text=True).stdout)
            rows.append({**row, **differences})
            print(", ".join(f"{key} {value}" for key, value in rows[-1].items()), flush=True)
            (options.folder / "ranks.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="ascii")


if "--measure" in sys.argv:
    measure(pathlib.Path(sys.argv[-2]), sys.argv[-1])
elif "--compare" in sys.argv:
    compare(pathlib.Path(sys.argv[-3]), sys.argv[-2], int(sys.argv[-1]))
else:
    main()
