"""Writes the report: FOLDER/index.html, a page that needs no other file, and FOLDER/report.json.

Of the folder it takes what has been measured: measured.json (treeamr-report), peers.json (peers.py and
function_peers.py), tests/*.json
(GoogleTest's output of the stiff and extreme cases, whose properties "measured" and "allowed" are the rows),
soak.json and instructions.json. What is missing is left out of the page and named on it.

--check is for continuous integration: fails when a list is missing or empty, a case failed, or a figure that is the
same on every machine is out of its bounds.

usage: python3 report.py FOLDER [--check]
"""

import argparse
import datetime
import html
import json
import math
import pathlib
import platform
import subprocess
import sys

import figures

PACKAGES = ["paraview", "libembree[34]-*", "libtbb12", "libhwy1*", "g++"]  # as dpkg-query takes them
LISTS = ["volume", "functions", "field", "field_orders", "isosurface", "isosurface_orders", "estimate", "digits"]
# Suites whose cases tell numbers; of the others a fault is survived or not.
RECORDING = ("StiffCases", "ExtremeCases", "ExtremeWindows")

# OSPRay 3.2 (with Open VKL 2.0.1) on unstructured cells: CPU-seconds a frame of 1000 x 1000 pixels on two cores of
# another machine, error against its own 10 samples per cell. Both are middles of ranges.
OSPRAY = [{"dataset": "mandelbulb-2.6M", "name": "OSPRay 3.2, 1 sample per cell (quoted)", "cpu_s": 5.7, "psnr_db": 35},
          {"dataset": "mandelbulb-2.6M", "name": "OSPRay 3.2, 5 samples per cell (quoted)", "cpu_s": 23, "psnr_db": 48}]


# --- what was measured ---


def read_json(path):
    return json.loads(path.read_text()) if path.exists() else {}


def read_cases(folder):
    """Of GoogleTest's files: one row for each case."""
    cases = []
    for path in sorted(folder.glob("*.json")):
        for suite in read_json(path).get("testsuites", []):
            for case in suite["testsuite"]:
                cases.append({
                    "name": f"{suite['name']}.{case['name']}",
                    "passed": case["result"] == "COMPLETED" and "failures" not in case,
                    "measured": case.get("measured", ""), "allowed": case.get("allowed", "")})
    for log in sorted(folder.glob("*.log")):
        if not log.with_suffix(".json").exists():
            cases.append({"name": log.stem, "passed": False, "measured": "ended before its last case", "allowed": ""})
    return cases


def versions():
    found = {}
    for package in PACKAGES:
        query = subprocess.run(["dpkg-query", "-W", "-f", "${Package} ${Version}\n", package], capture_output=True, text=True)
        for line in query.stdout.splitlines():
            name, version = line.split(" ")
            if version:  # else it is only known of
                found[name] = version
    source = pathlib.Path(__file__).parent
    commit = subprocess.run(["git", "-C", source, "describe", "--always", "--dirty"], capture_output=True, text=True)
    return {"TreeAMR": commit.stdout.strip() or "unknown", **found, "system": platform.platform()}


def gather(folder):
    measured = read_json(folder / "measured.json")
    report = {"machine": measured.get("machine", "unknown"),
              "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
              "versions": versions()}
    for name in LISTS:
        report[name] = measured.get(name, [])
    peers = read_json(folder / "peers.json")
    report["peers"] = peers.get("peers", [])
    report["isosurface_peers"] = peers.get("isosurface_peers", [])
    report["function_peers"] = peers.get("function_peers", [])
    report["stability"] = read_cases(folder / "tests")
    for name in ("soak", "instructions"):
        report[name] = read_json(folder / f"{name}.json")
    return report


# --- what continuous integration asks ---


def rows(report, name, **labels):
    return [row for row in report[name] if all(row.get(key) == value for key, value in labels.items())]


def by_field_and_function(report):
    """{(field, function): rows by rising samples per cell}"""
    groups = {}
    for row in sorted(report["functions"], key=lambda row: row["samples_per_cell"]):
        groups.setdefault((row["dataset"], row["function"]), []).append(row)
    return groups


def each(report, name, column, low, high, **labels):
    for row in rows(report, name, **labels):
        yield f"{name}, {column}, " + " ".join(
            str(row[key]) for key in row if isinstance(row[key], str) or key == "refinement"), row[column], low, high


def bounds(report):
    """(what, figure, lowest, highest) of figures that do not depend on the machine, but for rounding; of the brief
    form."""
    any_rounding = 3e-7
    yield from each(report, "field", "max_error", 0, any_rounding, field="trilinear", method="GTI")
    for method in ("current", "finest", "octant"):
        yield from each(report, "field", "max_error", 0, any_rounding, field="trilinear", method=method, region="away")
        yield from each(report, "field", "max_error", 3e-3, 1, field="trilinear", method=method, region="near")
        yield from each(report, "field_orders", "order_max", 0.8, 1.3, field="trilinear", method=method, region="near")
    yield from each(report, "field_orders", "order_max", 1.9, 2.1, field="quadratic", method="GTI", region="inside")
    yield from each(report, "field_orders", "order_mean", 1.9, 2.1, field="quadratic", method="GTI", region="inside")
    yield from each(report, "field_orders", "order_max", 1.7, 2.2, field="smooth", method="GTI", region="inside")
    yield from each(report, "field_orders", "order_mean", 1.9, 2.1, field="smooth", method="GTI", region="inside")
    for column in ("order_distance_max", "order_distance_mean"):
        yield from each(report, "isosurface_orders", column, 1.9, 2.1, method="implicit")
        yield from each(report, "isosurface_orders", column, 1.8, 2.1, method="contour-flat")
    yield from each(report, "isosurface_orders", "order_angle_max", 0.7, 2.2, method="implicit")
    yield from each(report, "isosurface_orders", "order_gradient_max", 1, 2.2, method="contour-vertices")
    for method in ("implicit", "contour-smooth"):
        yield from each(report, "isosurface_orders", "order_angle_mean", 1.7, 2.2, method=method)
        yield from each(report, "isosurface", "angle_mean_degrees", 0, 0.09, method=method, dataset="one-level-2")
        yield from each(report, "isosurface", "angle_mean_degrees", 0, 0.45, method=method, dataset="four-levels-2")
        yield from each(report, "isosurface", "angle_max_degrees", 0, 14, method=method, dataset="four-levels-2")
    for tree in ("one-level", "four-levels"):
        yield from each(report, "isosurface", "jump_degrees", 0, 0.05, method="implicit", tree=tree)
        yield from each(report, "isosurface", "jump_of_pieces_degrees", 0.5, 180, method="implicit", tree=tree)
    yield from each(report, "isosurface", "distance_max", 0, 1.2e-3, dataset="one-level-2")
    yield from each(report, "isosurface", "distance_max", 0, 4.5e-3, dataset="four-levels-2")
    for method in ("contour-vertices", "contour-flat", "contour-smooth"):
        yield from each(report, "isosurface", "open_edges", 0, 0, method=method)
    for column in ("probe_error", "contour_error", "isosurface_error", "volume_error"):
        # Colours are floats, too, composited one after the other.
        yield from each(report, "digits", column, 0, 2**-18 if column == "volume_error" else 2**-20, stored="offset")
        yield from each(report, "digits", column, 0.05, 1e6, stored="floats")
    samples = sorted(rows(report, "volume", series="samples per cell"), key=lambda row: float(row["setting"]))
    for coarse, fine in zip(samples, samples[1:]):
        yield ("volume, error with more samples over that with fewer", fine["rmse"] / coarse["rmse"], 0, 0.7)
        yield ("volume, samples with more a cell over those with fewer", fine["samples"] / coarse["samples"], 1.01, 8)
    yield from each(report, "functions", "rmse", 0, 4e-3, samples_per_cell=2)
    yield from each(report, "functions", "rmse", 0, 1e-3, samples_per_cell=64)
    of_ends = 0.25 / 1024  # rays end where less light is left
    for what, own in by_field_and_function(report).items():
        for coarse, fine in zip(own, own[1:]):
            yield (f"functions, {', '.join(what)}, error at {fine['samples_per_cell']:g} samples over that at "
                   f"{coarse['samples_per_cell']:g}", fine["rmse"], 0, 1.1 * coarse["rmse"] + of_ends)
    yield from each(report, "estimate", "share_within_factor_2", 0.95, 1, target=None)


def complaints(report):
    found = [f"{name}: nothing was measured" for name in [*LISTS, "stability", "instructions"] if not report[name]]
    found += [f"{case['name']} failed: {case['measured']}" for case in report["stability"] if not case["passed"]]
    found += [f"{case['name']} tells nothing of what was measured" for case in report["stability"]
              if case["name"].startswith(RECORDING) and not (case["measured"] and case["allowed"])]
    found += [f"{what}: {figure:g}, allowed are {low:g} to {high:g}"
              for what, figure, low, high in bounds(report) if figure is None or not low <= figure <= high]
    return found


# --- the page ---


STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1b1f24; max-width: 1080px; margin: 2em auto; padding: 0 1.2em; }
h1 { margin-bottom: .1em; } h2 { margin-top: 2.2em; border-bottom: 1px solid #d8dee4; padding-bottom: .2em; }
figure { margin: 1.2em 0; } figure svg { max-width: 100%; height: auto; }
figcaption, .conditions { color: #57606a; font-size: 13.5px; }
table { border-collapse: collapse; font-size: 13.5px; margin: .8em 0; display: block; overflow-x: auto; }
th, td { padding: .22em .5em; border-bottom: 1px solid #e6eaef; text-align: right; vertical-align: top; }
th { color: #57606a; font-weight: 600; } td { white-space: nowrap; }
td.text, th.text { text-align: left; } .cases td { white-space: normal; }
.bad { color: #b3261e; font-weight: 600; } .good { color: #1a7f37; }
"""


def cell(value, form=None):
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "&ndash;"
    return format(value, form) if form else html.escape(str(value))


def table(columns, body):
    """columns: (heading, rows' key or function of a row, format; None for text)."""
    def entry(row, key, form):
        value = key(row) if callable(key) else row.get(key)
        return f'<td{"" if form else " class=text"}>{cell(value, form)}</td>'

    head = "".join(f'<th{"" if form else " class=text"}>{html.escape(name)}</th>' for name, _, form in columns)
    lines = "".join("<tr>" + "".join(entry(row, key, form) for _, key, form in columns) + "</tr>" for row in body)
    return f"<table><tr>{head}</tr>{lines}</table>"


def figure(picture, caption):
    return f"<figure>{picture}<figcaption>{caption}</figcaption></figure>"


def rmse(psnr):
    return 10 ** (-psnr / 20)


def summary(report):
    """Sentences with the numbers of this run."""
    lines = []
    for dataset, own in figures.grouped(rows(report, "volume", series="samples per cell"), "dataset").items():
        good = [row for row in own if row["rmse"] <= 1e-3]
        if good:
            least = min(good, key=lambda row: row["cpu_s"])
            lines.append(f"{dataset}: an error of {least['rmse']:.1e} of the colours' range ({least['psnr_db']:.0f} dB) "
                         f"takes {least['cpu_s']:.3g} CPU-s a frame of {least['pixels']:.0f} x {least['pixels']:.0f} "
                         f"pixels, at {least['setting']} samples per cell.")
    for row in rows(report, "field_orders", field="smooth", method="GTI", region="inside"):
        lines.append(f"GTI on a smooth field, tree {row['tree']}: order {row['order_mean']:.2f} in the mean, "
                     f"{row['order_max']:.2f} in the maximum.")
    finest = rows(report, "functions", samples_per_cell=2)
    if finest:
        worst = max(finest, key=lambda row: row["rmse"])
        lines.append(f"Of {len(finest)} pairs of a field and a transfer function the worst at the default of 2 samples per "
                     f"cell, {worst['dataset']} with {worst['function']}, errs by {worst['rmse']:.1e}.")
    cases = report["stability"]
    if cases:
        lines.append(f"{sum(case['passed'] for case in cases)} of {len(cases)} stiff and extreme cases pass.")
    return lines


COMPARED = [("first_picture_cpu_s", "CPU-s to the first picture", -1), ("cpu_s_frame", "CPU-s a frame", -1),
            ("peak_rss_bytes", "bytes of memory", -1), ("psnr_db", "dB", 1),
            ("seen_distance_max", "largest distance of the surface that is seen", -1),
            ("seen_distance_mean", "mean distance of the surface that is seen", -1),
            ("seen_angle_mean", "mean angle of the normals that are seen", -1)]


def losses(report):
    """Every figure in which one of ParaView's routes was better in this run."""
    lines = []
    for peers in (report["peers"], report["isosurface_peers"]):
        for dataset, own in figures.grouped(peers, "dataset").items():
            ours = [row for row in own if "treeamr" in row["route"] and "first_picture_s" in row]
            others = [row for row in own if row not in ours and row["route"] != "isosurface-contour"]
            for row in others:
                for key, what, sign in COMPARED:
                    if ours and key in row and key in ours[0] and sign * row[key] > sign * ours[0][key]:
                        lines.append(f"{dataset}, {row['route']}: {row[key]:.3g} {what}, TreeAMR {ours[0][key]:.3g}.")
    return lines


def volume_section(report):
    if not report["volume"]:
        return ""
    peers = [{"dataset": row["dataset"], "name": f"ParaView: {row['route']}", "cpu_s": row["cpu_s_frame"],
              "error": rmse(row["psnr_db"])} for row in report["peers"]
             if "psnr_db" in row and row["route"] != "treeamr"]
    quoted = [{**row, "error": rmse(row["psnr_db"])} for row in OSPRAY]
    kept = [row for row in report["volume"] if row["series"] == "kept values"]
    methods = [row for row in report["volume"] if row["series"] == "interpolation"]
    estimate = report["estimate"]
    text = "<h2>Volume rendering: error over run time</h2>" + figure(
        figures.volume_work_precision(report["volume"], "rmse", "RMSE of the colours, peak 1", peers, quoted),
        "Down and left is better. Each point is a setting; numbers are samples per cell. Errors are against the "
        "converged picture of the same field (64 samples per cell by the scalar reference), so that they are of the "
        "rendering alone; below 2e-4 (75 dB) it is the same end of rays, with a 1024th of their light left, that both "
        "have in common. Vertex values are kept from the frame before. The routes' errors include 8-bit colours "
        "(about 1e-3) and their own reconstruction. OSPRay's points are quoted: another day and machine, against its "
        "own finest picture.")
    text += figure(
        figures.volume_work_precision(report["volume"], lambda row: 1 - row["ssim"], "1 - SSIM of the luminance"),
        "The same by structural similarity (Wang et al. 2004), which weighs what the eye sees: 0.01 is hardly visible, "
        "1e-4 not at all.")
    if kept:
        text += figure(figures.kept_values(report["volume"]),
                       "Memory against time, the picture being the same bit for bit: a frame that finds its vertex "
                       "values kept, and one that has to compute them.")
    if methods:
        text += figure(figures.interpolation(report["volume"]),
                       "What the interpolation alone changes in the picture, by a plain ray marcher on "
                       f"{methods[0]['pixels']:.0f} x {methods[0]['pixels']:.0f} pixels, against GTI's converged "
                       "picture.")
    if estimate:
        text += "<h3>The error that the mapper reports</h3>" + table([
            ("data set", "dataset", None), ("target RMSE", "target", ".1e"),
            ("samples per cell", "samples_per_cell", ".3g"), ("cameras", "cameras", ".0f"),
            ("true RMSE", "true_rmse", ".2e"), ("estimated", "estimated_rmse", ".2e"),
            ("worst ratio", "worst_ratio", ".2f"), ("within factor 2", "share_within_factor_2", ".0%"),
            ("target met", "share_met", ".0%"), ("cost, of the frame", "cost_share", ".1%"),
            ("CPU-s a frame", "cpu_s_frame", ".3g")], estimate)
    return text


def functions_section(report):
    own = report["functions"]
    if not own:
        return ""
    samples = sorted({row["samples_per_cell"] for row in own})
    body = [{"field": field, "function": function,
             **{f"rmse {row['samples_per_cell']:g}": row["rmse"] for row in few},
             **{f"cpu {row['samples_per_cell']:g}": 1e3 * row["cpu_s"] for row in few}}
            for (field, function), few in by_field_and_function(report).items()]
    body.sort(key=lambda row: list(figures.grouped(own, "dataset")).index(row["field"]))
    text = "<h2>Transfer functions of every kind: error over samples and run time</h2>" + figure(
        figures.functions(own),
        f"Along a line from left to right {samples[0]:g} to {samples[-1]:g} samples per cell, the ring is the default of "
        f"2. Errors are of red, green, blue and opacity of {own[0]['pixels']:.0f} pixels a row, against a converged "
        "picture that is integrated in double precision, cut wherever the field bends or the function does. Rays end "
        "where less than a 1024th of their light is left (the dotted line), whatever the samples. The shock jumps from 0 to 1000, of "
        "which the functions see 0 to 1; spikes are as wide, to each side, as their names tell. Errors below 1e-7 are "
        "drawn there.")
    text += "<h3>RMSE by samples per cell</h3>" + table([
        ("field", "field", None), ("function", "function", None),
        *((f"{count:g}", f"rmse {count:g}", ".1e") for count in samples),
        ("CPU-ms at 2", "cpu 2", ".1f"), (f"at {samples[-1]:g}", f"cpu {samples[-1]:g}", ".1f")], body)
    return text


def function_peers_section(report):
    if not report["function_peers"]:
        return ""
    return ("<h3>Transfer functions</h3>") + figure(
        figures.function_strips(report["function_peers"]),
        "A linear field, as points of a uniform grid for ParaView's Volume and as cells of a hyper tree grid for TreeAMR, "
        "both at their defaults, beside the integral along each ray, in a row of pixels. From left to right rays begin at "
        "values from a millionth to 1; for the logarithmic function, of six decades, also up to a hundredth and to a "
        "ten thousandth, beside it. Errors include the rounding to 8 bits.") + table([
            ("function", "function", None), ("TreeAMR: largest error, of 255", "treeamr_error_max", ".2f"),
            ("RMSE", "treeamr_error_rms", ".2f"), ("ParaView's Volume: largest", "volume_error_max", ".2f"),
            ("RMSE", "volume_error_rms", ".2f")], report["function_peers"])


def field_section(report):
    if not report["field"]:
        return ""
    trees = list(figures.grouped(report["field"], "tree"))
    jumps = trees[-1]

    def wanted(field, tree):
        return lambda row: (row["field"], row["tree"], row["region"]) == (field, tree, "inside")

    inside = rows(report, "field", region="inside")
    panels = [(f"{field}, {tree}: {name}", wanted(field, tree), key)
              for field, tree, name, key in [("smooth", jumps, "maximum", "max_error"),
                                             ("smooth", jumps, "mean", "mean_error"),
                                             ("trilinear", jumps, "maximum", "max_error"),
                                             ("smooth", jumps, "gradient, mean", "gradient_mean_error")]]
    text = "<h2>Reconstruction: error over refinement and time</h2>" + figure(
        figures.convergence(inside, panels, "h", "width of the finest cell (domain 1 wide)", "error (gradient: part of the steepest)",
                            (1, 2)),
        "Random points inside the domain; the tree's level boundaries stay while every leaf is refined. A method that "
        "is not exact where levels meet falls with order 1 in the maximum. GTI on the trilinear field is at the "
        "rounding of single precision from the start.")
    text += figure(
        figures.convergence(inside, [(f"smooth, {tree}", wanted("smooth", tree), "mean_error") for tree in trees],
                            "ns_per_query", "CPU-nanoseconds a query of single points", "mean error"),
        "Error over time: left and down is better; along a line the tree is refined.")
    orders = rows(report, "field_orders", region="inside")
    methods = list(figures.grouped(orders, "method"))

    def by_method(heading, key, form):
        body = []
        for field, own in figures.grouped(orders, "field").items():
            for tree, few in figures.grouped(own, "tree").items():
                body.append({"field": field, "tree": tree, **{row["method"]: row[key] for row in few}})
        return f"<h3>{heading}</h3>" + table(
            [("field", "field", None), ("tree", "tree", None), *((name, name, form) for name in methods)], body)

    text += by_method("Fitted orders of the largest error, inside the domain", "order_max", ".2f")
    text += ("<p class=conditions>No order (&ndash;): the error is rounding from the start. The front, 0.03 wide, is not "
             "resolved by the coarsest cells yet.</p>")
    text += by_method("Fitted orders of the mean error", "order_mean", ".2f")
    text += by_method("Largest error on the finest tree", "finest_max_error", ".1e")
    return text


def isosurface_section(report):
    own = report["isosurface"]
    if not own:
        return ""
    surfaces = list(figures.grouped(own, "surface"))
    trees = list(figures.grouped(own, "tree"))

    def wanted(surface, tree):
        return lambda row: (row["surface"], row["tree"]) == (surface, tree)

    pairs = [(surface, tree) for surface in surfaces for tree in trees[:2]]
    text = "<h2>Isosurfaces: error over run time</h2>"
    for key, label in (("distance_mean", "mean distance from the surface (domain 1 wide)"),
                       ("angle_mean_degrees", "mean angle of normals in degrees")):
        text += figure(
            figures.convergence(own, [(f"{surface}, {tree}", wanted(surface, tree), key) for surface, tree in pairs],
                                "cpu_s_build", "CPU-seconds from the field to the surface", label),
            "Implicit: the ray tracer's extraction and hierarchy, points and normals as pixels see them. Contour: "
            "triangles, at their vertices, over their flat faces, and over the faces with interpolated normals. "
            "Along a line the tree is refined.")
    last = {row["tree"]: max(r["refinement"] for r in own if r["tree"] == row["tree"]) for row in own}
    finest = [row for row in own if row["refinement"] == last[row["tree"]]]
    angles = {(row["surface"], row["tree"], row["method"]): row["angle_mean_degrees"] for row in finest}
    ratios = [angles[surface, tree, "implicit"] / angles[surface, tree, "contour-smooth"]
              for surface in surfaces for tree in trees]
    jumps = [row for row in own if row.get("jump_degrees") is not None]
    text += (f"<p>Normals are interpolated between vertex gradients, for rays and for the contour's points alike: of second "
             f"order in the mean, and in the largest angle of first order where cells of different size meet. On the finest "
             f"trees the ray tracer's are {min(ratios):.2f} to {max(ratios):.2f} times as far from the truth in the mean as "
             f"the contour's interpolated ones. Over random crossings of faces where levels meet, up to four levels apart, "
             f"they turn by {max(row['jump_degrees'] for row in jumps):.1e} degrees at most beyond twice the change of the "
             f"step itself; the gradients of the trilinear pieces turn by up to "
             f"{max(row['jump_of_pieces_degrees'] for row in jumps):.0f}.</p>")
    text += "<h3>Fitted orders</h3>" + table([
        ("surface", "surface", None), ("tree", "tree", None), ("method", "method", None),
        ("largest distance", "order_distance_max", ".2f"), ("mean distance", "order_distance_mean", ".2f"),
        ("largest angle", "order_angle_max", ".2f"), ("mean angle", "order_angle_mean", ".2f"),
        ("largest error of gradients", "order_gradient_max", ".2f"), ("mean", "order_gradient_mean", ".2f")],
        report["isosurface_orders"])
    text += ("<p class=conditions>Of gradients at the contour's points, the error as a vector beside the unit length of the "
             "exact one. Where it is largest on the sphere, gradients are too long by up to a tenth on coarse trees, which "
             "turns them the less: their angles come to first order from below.</p>")
    text += "<h3>Finest trees</h3>" + table([
        ("surface", "surface", None), ("tree", "tree", None), ("method", "method", None), ("cells", "cells", ",.0f"),
        ("CPU-s build", "cpu_s_build", ".4f"), ("CPU-s a frame", "cpu_s_frame", ".3f"),
        ("largest distance", "distance_max", ".1e"), ("in cells", "distance_max_h", ".3f"),
        ("mean", "distance_mean", ".1e"), ("largest angle in degrees", "angle_max_degrees", ".2f"),
        ("mean", "angle_mean_degrees", ".3f"), ("largest jump of normals", "jump_degrees", ".1e"),
        ("of the pieces' gradients", "jump_of_pieces_degrees", ".1f"), ("triangles", "triangles", ",.0f"),
        ("open edges", "open_edges", ".0f")], finest)
    return text


def digits_section(report):
    if not report["digits"]:
        return ""
    return ("<h2>Digits: values that lie close together beside their size</h2><p class=conditions>Largest errors in parts "
            "of the range, of linear fields: of values at points, of the field on contours and isosurfaces less the "
            "isovalue, of a volume's colours; as floats, and less an offset in double, which such fields have. "
            f"2<sup>-20</sup> is {2**-20:.1e}. Without a surface: 1.</p>") + table([
                ("values", "values", None), ("stored as", "stored", None), ("probe", "probe_error", ".1e"),
                ("contour", "contour_error", ".1e"), ("isosurface", "isosurface_error", ".1e"),
                ("volume", "volume_error", ".1e")], report["digits"])


def peers_section(report):
    if not (report["peers"] or report["isosurface_peers"] or report["function_peers"]):
        return ""
    common = [("data set", "dataset", None), ("route", lambda row: row["route"].removeprefix("isosurface-"), None),
              ("first picture, CPU-s", "first_picture_cpu_s", ".2f"), ("s", "first_picture_s", ".2f"),
              ("frame, CPU-s", "cpu_s_frame", ".3f"), ("s", "s_frame", ".3f"),
              ("peak memory, GB", lambda row: row.get("peak_rss_bytes", math.nan) / 1e9, ".2f")]
    state = ("", lambda row: row.get("failed") or (
        f"not finished within {row['timed_out_s']:g} s" if "timed_out_s" in row else ""), None)
    text = ("<h2>ParaView's own routes, same data, same run</h2><p class=conditions>Each in a process of its own, "
            "1000 x 1000 pixels, memory of the whole process with ParaView. OSPRay is not among them: distributions "
            "ship it without volumes.</p>")
    if report["peers"]:
        text += "<h3>Volumes</h3>" + table([*common, ("PSNR, dB", "psnr_db", ".1f"), state], report["peers"])
    if report["isosurface_peers"]:
        text += "<h3>Isosurfaces</h3>"
        known = [row for row in report["isosurface_peers"] if "seen_distance_mean" in row]
        if known:
            text += figure(figures.isosurface_routes(known),
                           f"{known[0]['dataset']}: what the pixels show, against the sphere. Left and down is better.")
        text += table([
            *common, ("polygons", "polygons", ",.0f"), ("open edges", "open_edges", ",.0f"),
            ("seen: largest distance", "seen_distance_max", ".1e"), ("mean", "seen_distance_mean", ".1e"),
            ("largest angle, degrees", "seen_angle_max", ".2f"), ("mean", "seen_angle_mean", ".3f"),
            ("mesh: largest distance", "mesh_distance_max", ".1e"), state], report["isosurface_peers"])
    text += function_peers_section(report)
    worse = losses(report)
    if worse:
        text += "<h3>Where TreeAMR loses</h3><ul>" + "".join(f"<li>{html.escape(line)}</li>" for line in worse) + "</ul>"
    return text


def stability_section(report):
    if not report["stability"]:
        return ""
    text = "<h2>Stiff and extreme cases, faults</h2><table class=cases><tr>" + "".join(
        f"<th class=text>{name}</th>" for name in ("case", "", "measured", "allowed")) + "</tr>"
    for case in report["stability"]:
        verdict = "<span class=good>passed</span>" if case["passed"] else "<span class=bad>failed</span>"
        text += "<tr>" + "".join(f"<td class=text>{entry}</td>" for entry in (
            html.escape(case["name"]), verdict, html.escape(case["measured"]), html.escape(case["allowed"]))) + "</tr>"
    return text + "</table>"


def rest_section(report):
    text = ""
    if report["soak"]:
        soak = report["soak"]
        text += (f"<h2>Soak</h2><p>{soak['changes']} random changes of properties in one ParaView process: "
                 f"{soak['resident_mib_start']:.0f} MiB resident after the first ones, "
                 f"{soak['resident_mib_end']:.0f} MiB at the end.</p>")
    if report["instructions"]:
        text += "<h2>Instructions</h2><p class=conditions>By valgrind's callgrind; to compare commits.</p>" + table(
            [("what", "what", None), ("instructions", "instructions", ",.0f")],
            [{"what": what, "instructions": count} for what, count in report["instructions"].items()])
    return text


def page(report):
    missing = [name for name in [*LISTS, "peers", "isosurface_peers", "function_peers", "stability", "soak", "instructions"]
               if not report[name]]
    conditions = (f"{html.escape(report['machine'])}; {report['date']}; " + ", ".join(
        f"{html.escape(name)} {html.escape(version)}" for name, version in report["versions"].items()))
    parts = ["<!DOCTYPE html><html lang=en><meta charset=utf-8><title>TreeAMR: error against run time</title>",
             f"<style>{STYLE}</style><h1>Error against run time</h1><p class=conditions>{conditions}. CPU-seconds are "
             "those of all threads.</p>",
             "<ul>" + "".join(f"<li>{html.escape(line)}</li>" for line in summary(report)) + "</ul>",
             f"<p class=conditions>Not measured: {', '.join(missing)}.</p>" if missing else "",
             volume_section(report), functions_section(report), field_section(report), isosurface_section(report), digits_section(report),
             peers_section(report),
             stability_section(report), rest_section(report), "</html>\n"]
    return "".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--check", action="store_true", help="fail when something is missing or out of its bounds")
    arguments = parser.parse_args()
    report = gather(arguments.folder)
    (arguments.folder / "report.json").write_text(json.dumps(report, indent=1) + "\n")
    (arguments.folder / "index.html").write_text(page(report))
    print(f"{arguments.folder / 'index.html'}: {len(report['stability'])} cases, "
          f"{sum(len(report[name]) for name in LISTS)} measurements")
    if arguments.check and (found := complaints(report)):
        sys.exit("\n".join(["report.py:", *found]))


if __name__ == "__main__":
    main()
