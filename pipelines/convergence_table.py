#!/usr/bin/python3
"""Slopes of the errors that convergence.py found, beside those of theory: table and plot."""

import csv
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "precis"  # the same ids in every run
import matplotlib.pyplot as plt  # noqa: E402

import orders  # noqa: E402
import records  # noqa: E402

COLUMNS = ["kind", "method", "over", "errors", "slope", "theory", "verdict", "reason"]
TEXT = f"""\
# Observed orders

How the error falls as each renderer is refined: the slope of log error, by least squares over the finest values, beside the
order that theory gives (kind `width`: decades a tap). Truth is a closed form of the phantom, the direct sum of all voxels
(Fourier), or `--quadrature reference` on the same volume (steps, split), all coefficients (levels), or the exact integral of the
same functions (linearised). *kept*: at most
{orders.ALLOWED:g} below theory. [orders.png](orders.png) shows the errors, dashed the slopes of theory.

"""


def shown(row):
    return {"kind": row["kind"], "method": row["method"], "over": " ".join(f"{v:g}" for v in row["over"]),
            "errors": " ".join(f"{e:.3g}" for e in row["errors"]), "slope": f"{orders.slope(row):.2f}",
            "theory": f"{row['order']:g}", "verdict": orders.verdict(row), "reason": row.get("reason", "")}


def panel(axes, kind, rows):
    title, label, _, smaller = orders.KINDS[kind]
    for number, row in enumerate(rows):
        h = orders.lengths(row)
        axes.plot(row["over"], row["errors"], "o-", color=f"C{number}", markersize=3, linewidth=1,
                  label=f"{row['method']}: {orders.slope(row):.2f} ({row['order']:g})")
        theory = [row["errors"][-1] * (v / h[-1]) ** row["order"] for v in h]
        axes.plot(row["over"], theory, "--", color=f"C{number}", linewidth=0.7)
    axes.set_yscale("log")
    if kind not in ("width", "wavelet-levels", "linearised"):
        axes.set_xscale("log", base=2)
        axes.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    if smaller:
        axes.invert_xaxis()  # finer to the right
    axes.set_title(title, fontsize=8)
    axes.set_xlabel(label, fontsize=7)
    axes.tick_params(labelsize=6, which="both")
    axes.grid(True, which="major", linewidth=0.2)
    axes.legend(fontsize=6)


def plot(found, folder):
    kinds = list(dict.fromkeys(row["kind"] for row in found))
    lines = -(-len(kinds) // 4)
    figure, grid = plt.subplots(lines, 4, figsize=(13.6, 2.8 * lines), squeeze=False, constrained_layout=True)
    for axes, kind in zip(grid.flat, kinds):
        panel(axes, kind, [row for row in found if row["kind"] == kind])
    for axes in grid.flat[len(kinds):]:
        axes.axis("off")
    for axes in grid[:, 0]:
        axes.set_ylabel("error", fontsize=7)
    for end, metadata in (("svg", {"Date": None}), ("png", {"Software": None})):
        figure.savefig(folder / f"orders.{end}", dpi=110, bbox_inches="tight", metadata=metadata)
    plt.close(figure)


def main():
    arguments = records.table_arguments(__doc__, "found", folder=True)
    found = json.loads(pathlib.Path(arguments.found).read_text())
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = [shown(row) for row in found]
    with open(arguments.output / "table.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    lines = [COLUMNS, ["---"] * len(COLUMNS), *([str(row[c]) for c in COLUMNS] for row in rows)]
    (arguments.output / "table.md").write_text(TEXT + "".join("| " + " | ".join(line) + " |\n" for line in lines))
    plot(found, arguments.output)


if __name__ == "__main__":
    main()
