#!/usr/bin/python3
"""Error against cost: one panel a data set and scene, uniform sampling as lines, index-guided runs as marks."""

import argparse
import math
import pathlib

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "precis"  # the same ids in every run
import matplotlib.pyplot as plt  # noqa: E402

import records  # noqa: E402

COST = {"samples": ("samples", "samples"), "time": ("time_s", "rendering time, s")}
LINES = {"rectangle": ("0.55", "-"), "trapezoid": ("0.35", "--"), "preintegrated": ("0.1", ":")}
COLOURS = {"haar": "tab:blue", "daubechies-4": "tab:orange", "battle-lemarie": "tab:green"}
MARKS = {"blind": "x", "look-ahead": "o", "classified": "D"}


def curve(axes, rows, cost, **style):
    """Joined in the order of the rows: of growing accuracy or growing error bound."""
    points = [(float(row[cost]), float(row["mse_truth"])) for row in rows]
    points = [(x, y) for x, y in points if x > 0 and y > 0]
    if points:
        axes.loglog(*zip(*points), **style)


def panel(axes, rows, cost):
    for quadrature, (colour, dash) in LINES.items():
        curve(axes, [r for r in rows if r["method"] == "uniform" and r["quadrature"] == quadrature], cost,
              color=colour, linestyle=dash, label=f"uniform, {quadrature}")
    curve(axes, [r for r in rows if r["method"] == "standard"], cost, color="k", marker="*", linestyle="",
          label="paper's uniform sampling")
    curve(axes, [r for r in rows if r["method"] == "split"], cost, color="tab:red", marker="P", linestyle="",
          label="split, three Gauss nodes")
    for method in dict.fromkeys(r["method"] for r in rows if r["wavelet"]):
        for wavelet in dict.fromkeys(r["wavelet"] for r in rows if r["wavelet"]):
            chosen = [r for r in rows if r["method"] == method and r["wavelet"] == wavelet]
            curve(axes, chosen, cost, color=COLOURS.get(wavelet), marker=MARKS.get(method, "s"), markersize=4,
                  linewidth=0.6, fillstyle="none", label=f"{method}, {wavelet}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table")
    parser.add_argument("-o", "--output", required=True, help="folder")
    arguments = parser.parse_args()
    table = records.read_csv(arguments.table)
    groups = list(dict.fromkeys((row["dataset"], row["scene"]) for row in table))
    columns = min(3, len(groups))
    lines = math.ceil(len(groups) / columns)
    for what, (cost, label) in COST.items():
        figure, grid = plt.subplots(lines, columns, figsize=(4.4 * columns, 3.4 * lines), squeeze=False,
                                    constrained_layout=True)
        for axes, group in zip(grid.flat, groups):
            panel(axes, [row for row in table if (row["dataset"], row["scene"]) == group], cost)
            axes.set_title(", ".join(group), fontsize=9)
            axes.tick_params(labelsize=7, which="both")
        for axes in grid.flat[len(groups):]:
            axes.axis("off")
        for axes in grid[:, 0]:
            axes.set_ylabel("MSE against the truth, byte scale", fontsize=8)
        for axes in grid[-1]:
            axes.set_xlabel(label, fontsize=8)
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="upper center",
                      ncol=5, fontsize=7, bbox_to_anchor=(0.5, 0.0), frameon=False)
        for kind in ("svg", "png"):
            metadata = {"Date": None} if kind == "svg" else {"Software": None}
            figure.savefig(pathlib.Path(arguments.output) / f"error-{what}.{kind}", dpi=110, bbox_inches="tight",
                           metadata=metadata)
        plt.close(figure)


if __name__ == "__main__":
    main()
