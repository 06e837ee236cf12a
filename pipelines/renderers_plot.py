#!/usr/bin/python3
"""Plots of `renderers`: error over time and over memory, a panel a picture and data set; and the pictures side by side."""

import argparse
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

import records  # noqa: E402
import renderers  # noqa: E402
import renderers_table  # noqa: E402

COLOURS = {"rays": "0.35", "rays, index": "tab:blue", "rays, fewer": "tab:cyan", "rays, cubic": "tab:pink", "rays, split": "tab:red", "rays, max-error": "tab:purple",
           "wavelet rays": "tab:green", "wavelet footprints": "tab:olive", "Fourier": "tab:orange", "Fourier, device": "tab:brown",
           "Bezier solids": "tab:pink", "mesh": "tab:blue"}
MARKS = dict(zip(COLOURS, "oDspPvX^<>dh"))
FLOOR = 1e-4  # what is drawn of an error below


def front(points):
    """By growing cost, the points with a smaller error than all before."""
    best = []
    for cost, error in sorted(points):
        if not best or error < best[-1][1]:
            best.append((cost, error))
    return best


def panels(groups, label, cost, path, one_range=False):
    """Filled: against the common truth, faint what was timed beside other work; a line joins what nothing of the same method beats.
    Open: against the method's own."""
    pictures, datasets = (list(dict.fromkeys(key[n] for key in groups)) for n in (1, 0))
    figure, grid = plt.subplots(len(pictures), len(datasets), figsize=(3.4 * len(datasets), 3 * len(pictures)), squeeze=False,
                                constrained_layout=True, sharex=one_range)
    handles = {}
    for (dataset, picture), rows in groups.items():
        axes = grid[pictures.index(picture)][datasets.index(dataset)]
        for method in dict.fromkeys(row["method"] for row in rows):
            colour, mark = COLOURS.get(method, "k"), MARKS.get(method, ".")
            of = [row for row in rows if row["method"] == method]
            sure = [row for row in of if row.get("rounds") or not any(r.get("rounds") for r in rows)]
            axes.loglog(*zip(*((cost(r), max(r["rmse"], FLOOR)) for r in of)), mark, color=colour, markersize=2, alpha=0.3)
            if sure:
                axes.loglog(*zip(*((cost(r), max(r["rmse"], FLOOR)) for r in sure)), mark, color=colour, markersize=4)
                axes.loglog(*zip(*front((cost(r), max(r["rmse"], FLOOR)) for r in sure)), "-", color=colour, linewidth=0.9)
            own = [(cost(r), max(r["own"], FLOOR)) for r in of if r["own"] is not None]
            if own:
                axes.loglog(*zip(*own), mark, color=colour, markersize=4, fillstyle="none", markeredgewidth=0.5, alpha=0.6)
            handles.setdefault(method, axes.plot([], [], mark, color=colour, markersize=4, linestyle="-", linewidth=0.9)[0])
        axes.set_title(f"{dataset}, {picture}", fontsize=8)
        axes.tick_params(labelsize=6, which="both")
        axes.grid(True, which="major", linewidth=0.2)
    for axes in grid[:, 0]:
        axes.set_ylabel("RMSE, byte scale", fontsize=7)
    for axes in grid[-1]:
        axes.set_xlabel(label, fontsize=7)
    handles["against the method's own field"] = plt.Line2D([], [], marker="o", color="0.4", markersize=4, fillstyle="none", linestyle="", markeredgewidth=0.5)
    figure.legend(handles.values(), handles.keys(), loc="upper center", ncol=6, fontsize=7, bbox_to_anchor=(0.5, 0.0), frameon=False)
    figure.savefig(path, dpi=110, bbox_inches="tight", metadata={"Software": None})
    plt.close(figure)


def best_within(rows, method, limit_s):
    """The most accurate setting of a method that takes no longer than that, or its fastest."""
    of = [row for row in rows if row["method"] == method]
    able = [row for row in of if row["seconds"] <= limit_s]
    return min(able, key=lambda row: (row["rmse"], row["seconds"])) if able else min(of, key=lambda row: row["seconds"])


def sheet(settings, binaries, groups, path):
    """Of one data set: every picture's truth, and beside it what each method draws within the time that `shown` allows."""
    shown = settings["sweep"]["shown"]
    datasets = list(dict.fromkeys(name for name, _ in groups))
    dataset = shown["dataset"] if shown["dataset"] in datasets else datasets[0]
    kinds = [picture for name, picture in groups if name == dataset]
    methods = {picture: list(dict.fromkeys(row["method"] for row in groups[dataset, picture])) for picture in kinds}
    columns = 1 + max(map(len, methods.values()))
    figure, grid = plt.subplots(len(kinds), columns, figsize=(1.9 * columns, 2.25 * len(kinds)), squeeze=False)
    for axes in grid.flat:
        axes.axis("off")
    for line, picture in enumerate(kinds):
        gallery = renderers.Gallery(binaries, settings, dataset, picture)

        def show(column, file, title):
            grid[line][column].imshow(plt.imread(file), cmap="gray", interpolation="nearest")
            grid[line][column].set_title(title, fontsize=6)

        truth = gallery.folder / "truth.png"
        command = gallery.picture["truth"].format(**gallery.words)
        gallery.run(command, truth, gallery.camera())
        show(0, truth, f"{renderers_table.TITLES[picture]}\nexact, of the trilinear field")
        for column, method in enumerate(methods[picture], 1):
            row = best_within(groups[dataset, picture], method, shown["within_s"])
            gallery.draw(row["family"], row["values"], gallery.folder / "shown.png")
            gallery.forget()
            show(column, gallery.folder / "shown.png", f"{method}\n{1e3 * row['seconds']:.3g} ms, RMSE {row['rmse']:.2g}")
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.93, 0.04, 0.2)
    figure.savefig(path, dpi=130, bbox_inches="tight", metadata={"Software": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("--bin", required=True)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder")
    arguments = parser.parse_args()
    settings = records.load(arguments.settings)
    groups = renderers_table.merged(settings)
    timed = {key: rows for key, rows in groups.items() if any(row.get("rounds") for row in rows)}
    groups = timed or groups  # the short form has small pictures alone
    panels(groups, "time of a picture, ms", lambda r: 1e3 * r["seconds"], arguments.output / "error-time.png")
    panels(groups, "peak memory, MB", lambda r: r["bytes"] / 1e6, arguments.output / "error-memory.png", one_range=True)
    sheet(settings, arguments.bin, groups, arguments.output / "pictures.png")


if __name__ == "__main__":
    main()
