#!/usr/bin/python3
"""Table and plot of a sweep of segmentations: agreement with the truth, which wavelet serves best, and what it costs."""

import csv
import json
import pathlib
import statistics

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "precis"  # the same ids in every run
import matplotlib.pyplot as plt  # noqa: E402

import records  # noqa: E402

COLUMNS = ["wavelet", "levels", "keep", "options", "agreement", "least", "first", "topographic_error", "seconds"]


def shown(run):
    known = [e for e in run["topographic_error"] if e is not None]
    return {**{k: run[k] for k in COLUMNS[:4]}, "agreement": f"{statistics.median(run['agreement']):.4f}", "least": f"{min(run['agreement']):.4f}",
            "first": f"{run['agreement'][0]:.4f}", "topographic_error": f"{statistics.median(known):.4f}" if known else "",
            "seconds": f"{statistics.median(run['seconds']):.3g}"}


def markdown(columns, rows):
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    return "\n".join(lines + ["| " + " | ".join(str(row[c]) for c in columns) + " |" for row in rows]) + "\n"


def wavelet_runs(found, asked, keep):
    base = asked["base"]
    return [r for w in asked["wavelets"] for r in found if (r["wavelet"], r["levels"], r["keep"], r["options"]) == (w, base["levels"], keep, "")]


def plot(found, asked, folder):
    keeps, wavelets = asked["wavelet_keeps"], asked["wavelets"]
    figure, axes = plt.subplots(figsize=(7, 3.2), constrained_layout=True)
    width = 0.8 / len(keeps)
    for n, keep in enumerate(keeps):
        rows = wavelet_runs(found, asked, keep)
        places = [i + (n + 0.5) * width - 0.4 for i in range(len(rows))]
        axes.bar(places, [statistics.median(r["agreement"]) for r in rows], width, label="all coefficients" if keep == 1 else f"{100 * keep:g} % kept")
        for x, r in zip(places, rows):
            axes.plot([x] * len(r["agreement"]), r["agreement"], "k.", markersize=3)
    axes.set_xticks(range(len(wavelets)), wavelets, fontsize=7)
    axes.set_ylim(0, 1)
    axes.set_ylabel("adjusted Rand index")
    axes.axhline(statistics.median(found[-1]["agreement"]), color="0.5", linewidth=1, linestyle=":", label="k-means of the values")
    axes.legend(fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 1), ncol=3, frameon=False)  # over the bars, not before them
    for kind in ("svg", "png"):
        figure.savefig(folder / f"agreement.{kind}", dpi=110, metadata={"Date": None} if kind == "svg" else {"Software": None})


def main():
    arguments = records.table_arguments(__doc__, "settings", "found", folder=True)
    asked = json.loads(pathlib.Path(arguments.settings).read_text())["sweep"]
    found, folder = json.loads(pathlib.Path(arguments.found).read_text()), arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    rows = [shown(run) for run in found]
    with open(folder / "table.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    said = []
    for keep in asked["wavelet_keeps"]:
        # By the worst seed: medians differ by less than the seeds of one wavelet do.
        best = sorted(wavelet_runs(found, asked, keep), key=lambda r: -min(r["agreement"]))[:3]
        what = "all coefficients" if keep == 1 else f"the {100 * keep:g} % most significant"
        said.append(f"With {what}, by the worst seed: " + ", ".join(f"{r['wavelet']} {min(r['agreement']):.3f}" for r in best) + ".")
    edge, seeds = asked["edge"], ", ".join(str(s) for s in asked["seeds"])
    (folder / "table.md").write_text(
        "# Segmentation in wavelet space\n\n"
        f"Four regions of {edge}^3 voxels that differ in texture alone (`vol-phantom texture`, seeds {seeds}), labelled by `vol-segment` with the\n"
        "options of each row. *Agreement*: adjusted Rand index against the truth, median of the seeds; 1 is the same partition, 0 is chance.\n"
        "*Least*: of the seeds; *first*: of the first. *Keep*: share of the coefficients that is kept, the most significant by energy; the others\n"
        "are zeros. *Topographic error* of the map, median. *Seconds* of `vol-segment`, median, without reading and writing. The last row is\n"
        f"k-means of the values themselves.\n\n{' '.join(said)}\n\n"
        + markdown(COLUMNS, rows) +
        "\n[labels.png](labels.png): slices, local amplitudes, labels and pictures of the labels. [splats.png](splats.png): voxels of the upper\n"
        "three of four classes of values of a molecule as splats. A support below the distance of two voxels leaves single balls; a wide one\n"
        "grows together, and the threshold then says how far the shape reaches beyond its voxels.\n")
    plot(found, asked, folder)


if __name__ == "__main__":
    main()
