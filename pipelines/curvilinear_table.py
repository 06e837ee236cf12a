#!/usr/bin/python3
"""Tables and contact sheet of a `curvilinear` sweep."""

import argparse
import csv
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

import rounds  # noqa: E402

COLUMNS = ["grid", "setting", "cells", "circles", "sheets", "points", "samples", "redundant", "holes", "rmse", "max", "ms"]


def rows_of(grid):
    for name, drawn in grid["drawn"].items():
        yield {"grid": grid["grid"], "setting": name, **{c: drawn["counts"][c] for c in COLUMNS[2:9]},
               "rmse": f"{drawn['rmse']:.3g}", "max": f"{drawn['max']:.3g}", "ms": f"{1e3 * drawn['seconds']:.1f}"}


def sheet(path, grids, asked):
    """A row a grid, a column a setting."""
    chosen = [name for name in asked["pictures"] if name in asked["settings"]]
    figure, axes = plt.subplots(len(grids), len(chosen), figsize=(2.2 * len(chosen), 2.3 * len(grids)), squeeze=False)
    for row, grid in zip(axes, grids):
        for place, name in zip(row, chosen):
            place.imshow(plt.imread(pathlib.Path(grid["folder"]) / f"{name}.png"))
            place.set_title(f"{grid['grid']}: {name}", fontsize=6, pad=2)
            place.set_xticks([])
            place.set_yticks([])
    figure.tight_layout(pad=0.3)
    figure.savefig(path, dpi=130, metadata={"Software": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("found", nargs="+")
    arguments = parser.parse_args()
    asked = json.loads(pathlib.Path(arguments.settings).read_text())["sweep"]
    grids = [json.loads(pathlib.Path(path).read_text()) for path in arguments.found]
    folder = pathlib.Path(arguments.output)
    rows = [row for grid in grids for row in rows_of(grid)]
    with open(folder / "table.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    text = (f"# Curvilinear grids by sheets\n\n{asked['size']} pixels. *rmse*, *max*: against the same options at a throttle of"
            f" {asked['finest']}, linear colours 0 to 1. *holes*: pixels without a sample between two with;\n*redundant*: points that"
            " fall on a pixel their sheet has already. Times are medians of interleaved runs, all threads.\n\n## Tricubic over trilinear\n\n"
            "The paper's times are seconds on a Sun 4/690MP; its trilinear ones compute the tricubic control points too.\n\n"
            "| grid | time, tricubic / trilinear | published |\n|---|---|---|\n")
    for grid in grids:
        paper = asked["grids"][grid["grid"]].get("published")
        said = f"{paper['tricubic']} / {paper['trilinear']} = {paper['tricubic'] / paper['trilinear']:.2f}" if paper else ""
        text += f"| {grid['grid']} | {rounds.shown(grid['ratio'])} | {said} |\n"
    lines = [COLUMNS, ["---"] * len(COLUMNS)] + [[r[c] for c in COLUMNS] for r in rows]
    text += "\n## All settings\n\n" + "".join("| " + " | ".join(map(str, c)) + " |\n" for c in lines)
    (folder / "table.md").write_text(text)
    sheet(folder / "pictures.png", grids, asked)


if __name__ == "__main__":
    main()
