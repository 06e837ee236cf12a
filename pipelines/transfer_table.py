#!/usr/bin/python3
"""Tables and plots of a sweep of transfer curves: residual over the number of control points, fitted curves over their targets
and histograms, the pictures side by side, and what the control points cost."""

import csv
import json
import pathlib

import matplotlib
import numpy

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "precis"  # the same ids in every run
import matplotlib.pyplot as plt  # noqa: E402

import isosurface  # noqa: E402
import pairs  # noqa: E402
import records  # noqa: E402
import sweep  # noqa: E402

COLUMNS = ["dataset", "target", "points", "rms", "largest", "condition", "rank", "method", "iterations"]
COST = ["dataset", "points", "spectrum_mib", "transform_s", "frame_s", "rms"]


def de_casteljau(points, v):
    b = [numpy.full_like(v, p) for p in points]
    while len(b) > 1:
        b = [(1 - v) * p + v * q for p, q in zip(b, b[1:])]
    return b[0]


def shown(value, digits=3):
    return value if isinstance(value, str) else "" if value is None else f"{value:.{digits}g}"


def save(figure, folder, name, kinds=("svg", "png")):
    for kind in kinds:
        metadata = {"Date": None} if kind == "svg" else {"Software": None}
        figure.savefig(folder / f"{name}.{kind}", dpi=110, bbox_inches="tight", metadata=metadata)
    plt.close(figure)


def panels(count, width, height, most=3):
    columns = min(most, count)
    lines = -(-count // columns)
    figure, grid = plt.subplots(lines, columns, figsize=(width * columns, height * lines), squeeze=False, constrained_layout=True)
    for axes in grid.flat[count:]:
        axes.axis("off")
    return figure, grid


def plot_curves(found, asked, out, folder):
    chosen = [n for n in (2, asked["drawn"], max(asked["points"])) if n in asked["points"]]
    targets = [(f, target) for f in found for target in asked["datasets"][f["dataset"]]["targets"]]
    figure, grid = panels(len(targets), 4.2, 3.0)
    for axes, (f, target) in zip(grid.flat, targets):
        voxels = isosurface.read_nrrd(sweep.volume(f["dataset"], out))
        rows = {r["points"]: r for r in f["fits"] if r["target"] == target}
        lo, hi = rows[chosen[0]]["range"]
        counts, edges = numpy.histogram(voxels, bins=min(256, int(hi - lo) + 1), range=(lo, hi))
        other = axes.twinx()
        other.fill_between(edges[:-1], numpy.log1p(counts), step="post", color="0.85")
        other.set_yticks([])
        other.set_ylim(0)
        axes.set_zorder(other.get_zorder() + 1)
        axes.patch.set_visible(False)
        v = numpy.linspace(0, 1, 1001)
        points = numpy.array(asked["datasets"][f["dataset"]]["targets"][target], dtype=float)
        axes.plot(lo + v * (hi - lo), numpy.interp(lo + v * (hi - lo), points[:, 0], points[:, 1]), color="k", linewidth=1.2, label="target")
        for n, colour in zip(chosen, ("tab:green", "tab:red", "tab:blue")):
            axes.plot(lo + v * (hi - lo), de_casteljau(rows[n]["control_points"], v), color=colour, linewidth=1, label=f"N = {n}")
        axes.set_title(f"{f['dataset']}, {target}", fontsize=9)
        axes.tick_params(labelsize=7)
        axes.set_ylim(-0.05, 1.6)
    for axes in grid[:, 0]:
        axes.set_ylabel("weight B (histogram: log)", fontsize=8)
    handles, names = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="upper center", ncol=4, fontsize=8, bbox_to_anchor=(0.5, 0.0), frameon=False)
    save(figure, folder, "curves")


def plot_residuals(found, folder):
    figure, axes = plt.subplots(figsize=(6, 4), constrained_layout=True)
    for f, mark in zip(found, "osD^v"):
        for target in dict.fromkeys(r["target"] for r in f["fits"]):
            rows = [r for r in f["fits"] if r["target"] == target]
            axes.semilogy([r["points"] for r in rows], [max(r["rms"], 1e-12) for r in rows], marker=mark, markersize=3, linewidth=1,
                          label=f"{f['dataset']}, {target}")
    axes.set_xlabel("control points N")
    axes.set_ylabel("RMS residual of the weight")
    axes.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)  # beside the curves, not over them
    axes.grid(True, which="both", linewidth=0.2)
    save(figure, folder, "residual")


def plot_pictures(found, asked, out, folder):
    targets = [(f, target) for f in found for target in f["pictures"]]
    figure, grid = plt.subplots(len(targets), 3, figsize=(6.6, 2.3 * len(targets)), squeeze=False)
    for line, (f, target) in zip(grid, targets):
        base, error = f"{out}/curves/{f['dataset']}/{target}", f["pictures"][target]
        for axes, kind, title in zip(line, ("fvr", "ray", "difference"),
                                     (f"{f['dataset']}, {target}: fvr-slice", "vol-raycast --model xray",
                                      f"difference: RMSE {100 * error['rmse'] / error['peak']:.2g} %, largest {100 * error['largest'] / error['peak']:.2g} %")):
            axes.imshow(plt.imread(f"{base}-{kind}.png"))
            axes.set_title(title, fontsize=6, pad=2)
            axes.set_xticks([])
            axes.set_yticks([])
    figure.tight_layout(pad=0.3)
    save(figure, folder, "pictures", ["png"])


def list_pairs(found, asked, out, folder):
    """The first target of every data set: slices beside rays."""
    entries, pictures = [], {}
    for f in found:
        target, error = next(iter(f["pictures"].items()))
        names = [f"{f['dataset']}-{kind}.png" for kind in ("ray", "fvr", "difference")]
        pictures |= {name: f"{out}/curves/{f['dataset']}/{target}-{name.removeprefix(f['dataset'] + '-')}" for name in names}
        figures = f"RMSE {100 * error['rmse'] / error['peak']:.2g} %, largest {100 * error['largest'] / error['peak']:.2g} % of the largest pixel"
        entries.append(pairs.entry(f"{f['dataset']}, {target}, {asked['drawn']} control points: rays and Fourier slices", "vol-raycast --model xray",
                                   names[0], [pairs.other("fvr-slice", *names[1:], figures)]))
    pairs.write(folder, entries, pictures)


def mean_rms(f, n):
    """Root of the mean square over the targets."""
    squares = [r["rms"] ** 2 for r in f["fits"] if r["points"] == n]
    return (sum(squares) / len(squares)) ** 0.5 if squares else None


def plot_costs(found, folder):
    figure, grid = plt.subplots(1, 2, figsize=(9, 3.6), constrained_layout=True)
    for f, mark in zip(found, "osD^v"):
        rows = [r for r in f["costs"] if mean_rms(f, r["points"])]
        rms = [mean_rms(f, r["points"]) for r in rows]
        for axes, key in zip(grid, ("frame_s", "spectrum_mib")):
            axes.loglog([r[key] * (1e3 if key == "frame_s" else 1) for r in rows], rms, marker=mark, markersize=4, linewidth=1, label=f["dataset"])
            for r, y in zip(rows, rms):
                axes.annotate(str(r["points"]), (r[key] * (1e3 if key == "frame_s" else 1), y), fontsize=6, xytext=(3, 3), textcoords="offset points")
    grid[0].set_xlabel("time of a frame, ms")
    grid[1].set_xlabel("spectra, MiB")
    grid[0].set_ylabel("RMS residual, mean square of the targets")
    grid[0].legend(fontsize=7)
    save(figure, folder, "cost")


def write_csv(path, columns, rows):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def markdown(columns, rows):
    lines = [columns, ["---"] * len(columns)] + [[str(row[c]) for c in columns] for row in rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def main():
    arguments = records.table_arguments(__doc__, "settings", "found...", folder=True)
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, out = settings["sweep"], settings["out"]
    found = [json.loads(pathlib.Path(path).read_text()) for path in arguments.found]
    folder = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    fits = [{**r, "dataset": f["dataset"], "rms": shown(r["rms"], 8), "largest": shown(r["largest"], 8), "condition": shown(r["condition"])}
            for f in found for r in f["fits"]]
    costs = [{**{k: shown(v, 4) if isinstance(v, float) else v for k, v in r.items()}, "dataset": f["dataset"], "rms": shown(mean_rms(f, r["points"]))}
             for f in found for r in f["costs"]]
    pictures = [{"dataset": f["dataset"], "target": t, "rmse %": shown(100 * p["rmse"] / p["peak"]), "largest %": shown(100 * p["largest"] / p["peak"]),
                 "ray casting, s": shown(p["ray_s"])} for f in found for t, p in f["pictures"].items()]
    write_csv(folder / "table.csv", COLUMNS, fits)
    write_csv(folder / "cost.csv", COST, costs)
    most = max(asked["points"])
    few = [r for r in fits if r["points"] in (2, asked["drawn"], most)]
    (folder / "table.md").write_text(
        "# Fitted transfer curves\n\n"
        f"Residual of the weight B(v) against its target, values weighted by the volume's {asked['weight']}; control points within 0 to 2. All N"
        " are in\n[table.csv](table.csv); [curves.png](curves.png) has curves and histograms, [residual.png](residual.png) the residual over N.\n\n"
        + markdown(COLUMNS, few) +
        f"\n## Fourier volume rendering against ray casting\n\nPictures of {asked['drawn']} control points, {asked['size']} pixels,"
        f" `--compensate {asked['filter']}`, against `vol-raycast --model xray {asked['raycast']}` of\nthe weighted voxels; in percent of the"
        " largest pixel. The sum has n samples where the integral has n - 1 cells: what reaches\nthe volume's border differs by that"
        " ([pictures.png](pictures.png)).\n\n"
        + markdown(list(pictures[0]), pictures) +
        "\n## What control points cost\n\nEach is a spectrum more, in memory, in the transforms and in every frame. *rms*: the residual that they"
        " leave, over the\ntargets ([cost.png](cost.png)).\n\n" + markdown(COST, costs))
    plot_curves(found, asked, out, folder)
    plot_residuals(found, folder)
    plot_pictures(found, asked, out, folder)
    list_pairs(found, asked, out, folder)
    plot_costs(found, folder)


if __name__ == "__main__":
    main()
