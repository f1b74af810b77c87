"""Figures of the report as SVG text: work-precision diagrams, convergence, time over memory."""

import io
import itertools
import math

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot, ticker  # after the choice of a backend without windows

# Okabe and Ito (2008): told apart by colour-blind readers, too.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]
# TreeAMR's own are the first colour everywhere.
COLOUR_OF = {"GTI": COLOURS[0], "current": COLOURS[1], "finest": COLOURS[2], "octant": COLOURS[3],
             "nearest": COLOURS[4], "implicit": COLOURS[0], "contour-vertices": COLOURS[1],
             "contour-flat": COLOURS[2], "contour-smooth": COLOURS[3]}

pyplot.rcParams.update({
    "svg.fonttype": "none", "svg.hashsalt": "report", "font.family": "sans-serif", "font.size": 9,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6, "axes.axisbelow": True, "lines.linewidth": 1.4, "lines.markersize": 4.5,
    "legend.frameon": False, "figure.constrained_layout.use": True})


def svg(figure):
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            if axis.get_scale() == "log":
                label_short_range(axis)
    out = io.StringIO()
    figure.savefig(out, metadata={"Date": None})
    pyplot.close(figure)
    text = out.getvalue()
    return text[text.index("<svg"):]


def grouped(rows, key):
    """{key's value: rows}, in the order of their first."""
    groups = {}
    for row in rows:
        groups.setdefault(row[key], []).append(row)
    return groups


def pareto_front(points):
    """Those of (cost, error, ...) that no other beats in both, by rising cost."""
    front = []
    for point in sorted(points, key=lambda p: (p[0], p[1])):
        if not front or point[1] < front[-1][1]:
            front.append(point)
    return front


def axes_grid(names, columns, size):
    rows = math.ceil(len(names) / columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(size[0] * columns, size[1] * rows), squeeze=False)
    for spare in axes.flat[len(names):]:
        spare.set_visible(False)
    return figure, dict(zip(names, axes.flat))


def shared_legend(figure, axes):
    entries = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    columns = max(2, round(figure.get_figwidth() / 2.6))
    lines = math.ceil(len(entries) / columns)
    top = 1 - (0.2 * lines + 0.1) / figure.get_figheight()  # in inches
    figure.get_layout_engine().set(rect=(0, 0, 1, top))
    figure.legend(entries.values(), entries.keys(), loc="upper center", ncol=columns)


def label_short_range(axis):
    """Less than two decades need more ticks than their powers of ten."""
    low, high = axis.get_view_interval()
    if high < 100 * low:
        axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
        axis.set_minor_locator(ticker.NullLocator())
        axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))


def loglog(ax, title, x, y):
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_title(title, loc="left", fontweight="bold", fontsize=10)
    ax.set_xlabel(x)
    ax.set_ylabel(y)


VOLUME_SERIES = {
    "samples per cell": ("o-", 0), "without pre-integration": ("s--", 1), "level of detail": ("^:", 2),
    "image sample distance": ("v:", 3)}


def volume_work_precision(rows, error, label, peers=(), quoted=()):
    """error: rows' key, or a function of a row. peers and quoted: {dataset, name, cpu_s, error}."""
    of = error if callable(error) else lambda row: row[error]
    rows = [row for row in rows if row["series"] in VOLUME_SERIES]
    data = grouped(rows, "dataset")
    apart = grouped(quoted, "name")
    markers = dict(zip({**grouped(peers, "name"), **apart}, itertools.cycle("XP*Ddhp<>")))
    figure, axes = axes_grid(list(data), min(2, len(data)), (5.2, 3.9))
    for dataset, ax in axes.items():
        loglog(ax, dataset, "CPU-seconds a frame", label)
        for series, own in grouped(data[dataset], "series").items():
            style, colour = VOLUME_SERIES[series]
            shown = [(row["cpu_s"], of(row), row["setting"]) for row in own if of(row) > 0]
            ax.plot([p[0] for p in shown], [p[1] for p in shown], style, color=COLOURS[colour], label=series)
            if series == "samples per cell":
                for x, y, setting in shown:
                    ax.annotate(setting, (x, y), xytext=(4, 3), textcoords="offset points", fontsize=7.5,
                                color=COLOURS[colour])
        front = pareto_front([(row["cpu_s"], of(row)) for row in data[dataset] if of(row) > 0])
        ax.plot([p[0] for p in front], [p[1] for p in front], "o", markersize=9, markerfacecolor="none",
                markeredgecolor="#888888", label="Pareto front of these")
        for name, marker in markers.items():
            at = [(p["cpu_s"], p["error"]) for p in (*peers, *quoted) if (p["dataset"], p["name"]) == (dataset, name)]
            if at:
                ax.plot(*zip(*at), marker, color=COLOURS[6], markersize=7, label=name,
                        markerfacecolor="none" if name in apart else COLOURS[6])
        ax.margins(x=0.12)
    shared_legend(figure, axes.values())
    return svg(figure)


def functions(rows):
    """Error over time by function, one panel for each field."""
    data = grouped(rows, "dataset")
    figure, axes = axes_grid(list(data), 2, (5.2, 3.6))
    # Colours twice, the second time dashed.
    styles = [(colour, line) for line in ("-", "--") for colour in COLOURS]
    style_of = dict(zip(grouped(rows, "function"), styles))
    for dataset, ax in axes.items():
        loglog(ax, dataset, "CPU-seconds a frame", "RMSE, peak 1")
        for name, own in grouped(data[dataset], "function").items():
            colour, line = style_of[name]
            own = sorted(own, key=lambda row: row["samples_per_cell"])
            error = [max(row["rmse"], 1e-7) for row in own]
            ax.plot([row["cpu_s"] for row in own], error, line, marker=".", color=colour, label=name)
            at = [i for i, row in enumerate(own) if row["samples_per_cell"] == 2]
            ax.plot([own[i]["cpu_s"] for i in at], [error[i] for i in at], "o", markersize=7,
                    markerfacecolor="none", color=colour)
        ax.axhline(1 / 1024, color="#999999", linestyle=":", linewidth=1)
    shared_legend(figure, axes.values())
    return svg(figure)


def function_strips(rows):
    """Rows of pixels, one panel for each function: what is right and what is drawn."""
    figure, axes = axes_grid([row["function"] for row in rows], 2, (5.2, 0.95))
    names = {"exact": "exact", "treeamr": "TreeAMR", "volume": "Volume"}
    for row, ax in zip(rows, axes.values()):
        ax.imshow([row[key] for key in names], aspect="auto", interpolation="nearest")
        ax.set_title(row["function"], fontsize=9)
        ax.set_yticks(range(len(names)), names.values())
        ax.set_xticks([])
        ax.grid(False)
        ax.spines[:].set_visible(False)
    return svg(figure)


def kept_values(rows):
    figure, ax = pyplot.subplots(figsize=(6, 3.6))
    budgets = set()
    for (dataset, own), colour in zip(grouped([r for r in rows if r["series"] == "kept values"],
                                              "dataset").items(), COLOURS):
        own = sorted(own, key=lambda row: float(row["setting"]))
        x = [float(row["setting"]) for row in own]
        budgets.update(x)
        ax.plot(x, [row["cpu_s"] for row in own], "o-", color=colour, label=dataset)
        ax.plot(x, [row["cpu_s_cold"] for row in own], "o:", color=colour, markerfacecolor="white")
    ax.set_xscale("symlog", linthresh=32)
    ax.set_xticks(sorted(budgets), [f"{budget:g}" for budget in sorted(budgets)])
    ax.minorticks_off()
    ax.set_ylim(bottom=0)
    ax.set_xlabel("budget of kept values in MiB")
    ax.set_ylabel("CPU-seconds a frame")
    ax.plot([], [], "o:", color="#666666", markerfacecolor="white", label="first frame")
    ax.legend(fontsize=8)
    return svg(figure)


def interpolation(rows):
    data = grouped([r for r in rows if r["series"] == "interpolation"], "dataset")
    figure, axes = axes_grid(list(data), 2, (4.6, 3.3))
    for dataset, ax in axes.items():
        loglog(ax, dataset, "CPU-seconds a frame of a plain ray marcher", "RMSE of the colours, peak 1")
        for row in data[dataset]:
            colour = COLOUR_OF[row["setting"]]
            ax.plot(row["cpu_s"], row["rmse"], "o", color=colour)
            ax.annotate(row["setting"], (row["cpu_s"], row["rmse"]), xytext=(5, 3),
                        textcoords="offset points", color=colour)
        ax.margins(0.25)
    return svg(figure)


def convergence(rows, panels, x, x_label, y_label, slopes=()):
    """One panel for each (title, rows' filter, y key), one line for each method."""
    figure, axes = axes_grid(list(range(len(panels))), 2, (5.2, 3.6))
    for (title, wanted, y), ax in zip(panels, axes.values()):
        loglog(ax, title, x_label, y_label)
        drawn = []
        for name, own in grouped([row for row in rows if wanted(row)], "method").items():
            points = sorted((row[x], row[y]) for row in own if row[x] and row[y])
            drawn += points
            ax.plot([p[0] for p in points], [p[1] for p in points], "o-", color=COLOUR_OF[name], label=name,
                    linewidth=2.4 if COLOUR_OF[name] == COLOURS[0] else 1.4)
        if drawn and slopes:
            ends = [min(p[0] for p in drawn), max(p[0] for p in drawn)]
            top = max(p[1] for p in drawn)
            for slope, style in zip(slopes, itertools.cycle([":", "--"])):
                ax.plot(ends, [top * (e / ends[1]) ** slope for e in ends], style, color="#999999",
                        label=f"order {slope}", linewidth=1)
    shared_legend(figure, axes.values())
    return svg(figure)


def isosurface_routes(rows):
    figure, axes = axes_grid(["seen_distance_mean", "seen_angle_mean"], 2, (4.8, 3.2))
    for (key, ax), title, label in zip(
            axes.items(), ("Distance", "Normals"),
            ("mean distance (domain 1 wide)", "mean angle in degrees")):
        loglog(ax, title, "CPU-seconds to the first picture", label)
        for row, colour in zip(rows, COLOURS):
            if key in row:
                ax.plot(row["first_picture_cpu_s"], row[key], "o", color=colour,
                        label=row["route"].removeprefix("isosurface-"))
        ax.margins(0.3)
    shared_legend(figure, axes.values())
    return svg(figure)
