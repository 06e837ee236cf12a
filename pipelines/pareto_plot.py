#!/usr/bin/python3
"""Error over time: one panel a data set and scene, one curve a method: the settings that nothing of the same method beats."""

import argparse
import math
import pathlib

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "precis"  # the same ids in every run
import matplotlib.pyplot as plt  # noqa: E402

import records  # noqa: E402

STYLES = {"uniform": ("0.35", "-", "o"), "blind": ("tab:brown", ":", "x"), "index": ("tab:blue", "-", "D"),
          "adaptive": ("tab:orange", "-", "^"), "split": ("tab:red", "-", "P"), "refined": ("tab:green", "-", "s"),
          "max-error": ("tab:purple", "--", "v")}
FLOOR = 1e-10  # what is drawn of an error of 0


def front(rows):
    """By growing time, the rows more accurate than all before."""
    best = []
    for time, error in sorted((1e3 * float(r["time_s"]), max(float(r["mse"]), FLOOR)) for r in rows):
        if not best or error < best[-1][1]:
            best.append((time, error))
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table")
    parser.add_argument("-o", "--output", required=True, help="folder")
    arguments = parser.parse_args()
    table = records.read_csv(arguments.table)
    groups = list(dict.fromkeys((row["dataset"], row["scene"], row["size"]) for row in table))
    columns = min(4, len(groups))
    lines = math.ceil(len(groups) / columns)
    figure, grid = plt.subplots(lines, columns, figsize=(4.2 * columns, 3.4 * lines), squeeze=False, constrained_layout=True)
    handles = {}
    for axes, group in zip(grid.flat, groups):
        rows = [row for row in table if (row["dataset"], row["scene"], row["size"]) == group]
        for method in dict.fromkeys(row["method"] for row in rows):
            colour, dash, mark = STYLES.get(method, ("k", "-", "."))
            handles[method], = axes.loglog(*zip(*front(r for r in rows if r["method"] == method)), color=colour,
                                           linestyle=dash, marker=mark, markersize=4, linewidth=1, label=method)
        axes.set_title(", ".join(group), fontsize=9)
        axes.tick_params(labelsize=7, which="both")
    for axes in grid.flat[len(groups):]:
        axes.axis("off")
    for axes in grid[:, 0]:
        axes.set_ylabel("MSE against the truth, byte scale", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("rendering time, ms", fontsize=8)
    figure.legend(handles.values(), handles.keys(), loc="upper center", ncol=7, fontsize=8, bbox_to_anchor=(0.5, 0.0), frameon=False)
    for kind in ("svg", "png"):
        metadata = {"Date": None} if kind == "svg" else {"Software": None}
        figure.savefig(pathlib.Path(arguments.output) / f"error-time.{kind}", dpi=110, bbox_inches="tight", metadata=metadata)


if __name__ == "__main__":
    main()
