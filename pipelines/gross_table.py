#!/usr/bin/python3
"""Table and plot of what gross.py measured: footprints beside rebuilding the volume."""

import csv
import json
import pathlib
import statistics

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "precis"  # the same ids in every run
import matplotlib.pyplot as plt  # noqa: E402

import records  # noqa: E402
import rounds  # noqa: E402

COLUMNS = ["dataset", "wavelet", "kept", "coefficients", "asked", "ms", "rebuild_ms", "faster", "largest_error", "rebuild_largest_error",
           "error_to_volume", "rebuild_error_to_volume", "tables_ms", "tables_MB", "prepare_ms"]


def rows_of(found):
    for run in found["rows"]:
        rebuild = run["contenders"]["rebuild"]
        for asked, known in run["contenders"].items():
            if asked == "rebuild":
                continue
            milliseconds = [1e3 * s for s in known["seconds"]]
            yield {
                "dataset": found["dataset"], "wavelet": run["wavelet"], "kept": f"{100 * run['keep']:g} %", "coefficients": run["coefficients"],
                "asked": asked, "ms": f"{statistics.median(milliseconds):.2f}",
                "rebuild_ms": f"{1e3 * statistics.median(rebuild['seconds']):.2f}",
                "faster": rounds.shown(rounds.ratio(rebuild["seconds"], known["seconds"])),
                "largest_error": f"{known['error']['largest']:.1e}", "rebuild_largest_error": f"{rebuild['error']['largest']:.1e}",
                "error_to_volume": f"{known['error_full']['rms']:.1e}", "rebuild_error_to_volume": f"{rebuild['error_full']['rms']:.1e}",
                "tables_ms": f"{1e3 * statistics.median(known['tables_s']):.0f}", "tables_MB": f"{known['counts']['table_bytes'] / 1e6:.1f}",
                "prepare_ms": f"{1e3 * statistics.median(known['prepare_s']):.1f}"}


def plot(found, folder):
    figure, grid = plt.subplots(1, len(found), figsize=(4.6 * len(found), 3.6), squeeze=False, constrained_layout=True)
    for axes, data in zip(grid[0], found):
        lines = {}
        for run in data["rows"]:
            for asked, known in run["contenders"].items():
                label = f"{run['wavelet']}, " + (asked if asked in ("rebuild", "closed form") else f"error {asked}")
                lines.setdefault(label, []).append((run["coefficients"], 1e3 * statistics.median(known["seconds"])))
        wavelets = list(dict.fromkeys(run["wavelet"] for run in data["rows"]))
        styles = {"rebuild": ":", "closed form": "-", "error 0.01": "-", "error 0.001": "--", "error 0.0001": "-."}
        for label, points in lines.items():
            wavelet, what = label.split(", ")
            axes.plot(*zip(*sorted(points)), styles.get(what, "-"), color=f"C{wavelets.index(wavelet)}", marker="o", markersize=3, linewidth=1,
                      label=label)
        axes.set_title(data["dataset"], fontsize=9)
        axes.set_xlabel("coefficients kept", fontsize=8)
        axes.set_ylabel("a picture, ms", fontsize=8)
        axes.set_ylim(bottom=0)
        axes.set_xlim(left=0)
        axes.tick_params(labelsize=7)
        axes.grid(True, linewidth=0.2)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncol=3, fontsize=7, bbox_to_anchor=(0.5, 0.0), frameon=False)
    for kind in ("svg", "png"):
        figure.savefig(folder / f"cost.{kind}", dpi=110, bbox_inches="tight", metadata={"Date": None} if kind == "svg" else {"Software": None})


def main():
    arguments = records.table_arguments(__doc__, "settings", "found...", folder=True)
    asked = json.loads(pathlib.Path(arguments.settings).read_text())["sweep"]
    found, folder = [json.loads(pathlib.Path(path).read_text()) for path in arguments.found], arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    rows = [row for data in found for row in rows_of(data)]
    with open(folder / "cost.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    first = found[0]["rows"][0]
    lines = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    lines += ["| " + " | ".join(str(row[c]) for c in COLUMNS) + " |" for row in rows]
    (folder / "cost.md").write_text(
        "# X-ray pictures of wavelet coefficients: footprints beside rebuilding the volume\n\n"
        f"{asked['size']} pixels, {asked['levels']} levels, view {asked['view']}, {first['host']['cpu']}, {first['host']['threads']} threads,\n"
        f"{first['host']['simd']}, commit {first['commit']}. Medians of {asked['rounds']} interleaved runs of {asked['repeat']} pictures each.\n"
        "*ms*: a picture by `wavelet-raycast --algorithm footprint --footprint-error` *asked*, tables made once before. *rebuild*: inverse\n"
        f"transform (`vol-dwt --inverse`) and rays through its voxels (`vol-raycast --model xray --step {asked['step']}`), without reading and writing.\n"
        "*faster*: rebuild over footprints, run by run, with the 95 % interval of the median. Errors are shares of the largest value of the exact picture:\n"
        "*largest error* of a pixel against the exact integral of the coefficients kept; *error to volume*, root of the mean square, against\n"
        "the picture of all voxels (trilinear, `--quadrature reference`). *tables*: made once a view and its coefficients. *prepare*: sorting the\n"
        "coefficients, once a file. The contract of footprints is the error asked for, a share of the range, by estimate; without it\n"
        "wavelet-raycast takes 1e-4. 0.01 is the error of the ray caster they are compared with. Plot: [cost.png](cost.png), time over the coefficients kept.\n\n"
        + "\n".join(lines) + "\n")
    plot(found, folder)


if __name__ == "__main__":
    main()
