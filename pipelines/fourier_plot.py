#!/usr/bin/python3
"""Plots of `fourier`: error against a frame's time for the settings that were timed, and a frame's time against the size with
the fit of N^2 log N."""

import argparse
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy  # noqa: E402

import fourier_table  # noqa: E402

COLOURS = {"nearest": "0.5", "trilinear": "tab:blue", "catmull-rom": "tab:orange", "catmull-rom-fast": "tab:brown", "sinc:5": "tab:purple",
           "es:4": "tab:green", "es:6": "tab:red", "es:8": "k"}
MARKS = {"1": "o", "1.25": "v", "1.5": "s", "2": "D", "4": "*"}


def error_time(found, path):
    """The table of filters: error by padding, time of the same setting."""
    figure, axes = plt.subplots(figsize=(6.4, 4.6), constrained_layout=True)
    for row in found.times["filters"]:
        for compensated in ("no", "yes"):
            error = found.error(table="filters", dataset=found.dataset, filter=row["filter"], padding=row["padding"],
                                compensated=compensated, view="oblique")
            if error:
                axes.loglog(1e3 * row["drawn"], error["l2"], color=COLOURS[row["filter"]], marker=MARKS[row["padding"]], linestyle="",
                            fillstyle="full" if compensated == "yes" else "none")
    for name, colour in COLOURS.items():
        if name in found.config["filters"]:
            axes.plot([], [], color=colour, marker=".", linestyle="", label=name)
    for padding, mark in MARKS.items():
        axes.plot([], [], color="0.3", marker=mark, linestyle="", label=f"padding {padding}")
    axes.plot([], [], color="0.3", marker="o", fillstyle="none", linestyle="", label="not compensated")
    axes.set_xlabel(f"time of a frame, ms, {found.config['filter_size']}$^3$")
    axes.set_ylabel("relative L2 error, oblique view")
    axes.legend(fontsize=7, ncol=1, loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)
    axes.grid(alpha=0.3, which="both", linewidth=0.4)
    figure.savefig(path, dpi=110, metadata={"Software": None})


def growth(found, path):
    figure, axes = plt.subplots(figsize=(5.2, 3.8), constrained_layout=True)
    for name in found.config["growth_filters"]:
        rows = [r for r in found.times["growth"] if r["filter"] == name]
        n = numpy.array([r["size"] for r in rows], float)
        t = numpy.array([r["drawn"] for r in rows])
        model = n ** 2 * numpy.log2(n)
        c = numpy.exp(numpy.mean(numpy.log(t / model)))  # the factor that is right on average, in ratios
        axes.loglog(n, 1e3 * t, "o", color=COLOURS[name], label=name)
        axes.loglog(n, 1e3 * c * model, "-", color=COLOURS[name], linewidth=0.8, label=f"{1e9 * c:.2f} ns N$^2$ log$_2$ N")
    axes.set_xlabel("N")
    axes.set_ylabel("time of a frame, ms")
    axes.set_xticks(found.config["growth"], [str(s) for s in found.config["growth"]])
    axes.minorticks_off()
    axes.legend(fontsize=8, frameon=False)
    axes.grid(alpha=0.3, linewidth=0.4)
    figure.savefig(path, dpi=110, metadata={"Software": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("-o", "--output", required=True, help="folder")
    arguments = parser.parse_args()
    found = fourier_table.Found(json.loads(pathlib.Path(arguments.settings).read_text()))
    error_time(found, pathlib.Path(arguments.output) / "error-time.png")
    growth(found, pathlib.Path(arguments.output) / "growth.png")


if __name__ == "__main__":
    main()
