#!/usr/bin/python3
"""Tables of `fourier`: errors as CSV, and in Markdown Cheng's Tables 4.1 to 4.6 with what was measured beside."""

import csv
import json
import pathlib

import records

COLUMNS = ["table", "dataset", "dims", "filter", "padding", "compensated", "view", "l2", "l2_centre", "largest", "ghosts"]
FIGURES = COLUMNS[-4:]

# Cheng 2007, platform B (Pentium 4 3.0 GHz, Radeon X850 Pro): pre-processing in seconds, frames a second.
PUBLISHED = {
    ("4.1", "64^3"): (0.25, 100), ("4.1", "128^3"): (3.359, 66.67), ("4.1", "256^3"): (33.297, 32.25),
    ("4.2", "64^3"): (0.25, 66.67), ("4.2", "128^3"): (2.578, 62.5), ("4.2", "256^3"): (35.688, 21.27),
    ("4.3", "64^3"): (0.25, 2.78), ("4.3", "128^3"): (3.641, 2.66), ("4.3", "256^3"): (37.984, 2.54),
    ("4.4", "64^3"): (3.708, 66.67), ("4.4", "128^3"): (35.031, 31.25),
    ("4.6", "64^3"): (1.172, 9.174), ("4.6", "128^3"): (26.375, 8), ("4.6", "256^3"): (37.984, 0.57)}
PUBLISHED_FFTS = {"128^3": (62.5, 21.132), "256^3": (21.276, 21.132), "512x512x256": (8, 16.129)}

TITLES = {"4.1": "Table 4.1, no filter", "4.2": "Table 4.2, trilinear", "4.3": "Table 4.3, cubic", "4.4": "Table 4.4, trilinear, padded",
          "4.6": "Table 4.6, Bezier transfer function of 6 control points, trilinear", "beside": "Beside them: es, padded"}

EXPLANATION = """\
# Fourier volume rendering: Cheng's tables, filters and costs

Published figures are of 2007 (platform B); ours are medians of {rounds} runs of {views} pictures and more on {cpu}, {threads} threads,
{simd}. What can be compared is the ratio between methods, and what the paper has no figure for: the error.

What differs. The paper slices on the GPU with 16-bit textures and reads back for FFTW; here everything is 32-bit floats on
the CPU, but for the rows of `fvr-slice-gpu`, which ran on {device}. Its set-up is a textbook FFT on the CPU, here FFTW's: so pre-processing (reading the volume
included) is a hundred times shorter, and frames grow with the slice's area as its own do. Its cubic filter takes four linearly interpolated samples
(`catmull-rom-fast`), because its GPU could not fetch 64, and drops from 21 to 2.5 frames a second; the 64 samples are not that
dear here. Its sets of 64^3 to 256^3 are not at hand: ours are brought to those sizes by trilinear resampling and drawn as
cubes of unit voxels.

*l2*: relative L2 error over the whole picture, {window} volumes wide; *centre*: over the middle half of its width and height; *largest*: as a
share of the largest pixel; *ghosts*: the error's energy outside the object (more than two pixels from where any voxel above a
twentieth of the largest falls), as a share of the picture's. All against the picture of the volume's own transform, of {oblique}; the truth is
`es:12` in f64 at padding 2, which rows `truth` of the CSV hold against the direct sum at {truth_size}^3: largest l2 {truth:.1e}, the rounding of a
float picture. *Axis*: view 0,0, a pixel a column of voxels, against their plain sums: filters that interpolate are right there without compensation,
and compensation makes them wrong.
"""


def text(value, digits=3):
    if value is None or value == "":
        return "–"
    return value if isinstance(value, str) else f"{value:.{digits}g}"


def table(header, rows):
    lines = [header, ["---"] * len(header)] + rows
    return "".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines) + "\n"


class Found:
    def __init__(self, settings):
        out = pathlib.Path(settings["out"])
        self.config = settings["sweep"]
        self.rows = [row for d in settings["datasets"] for row in json.loads((out / "errors" / f"{d}.json").read_text())]
        self.times = json.loads((out / "times.json").read_text())
        self.dataset = self.times["dataset"]

    def error(self, **wanted):
        for row in self.rows:
            if all(row[key] == value for key, value in wanted.items()):
                return row
        return {}


def paper_tables(found):
    parts = []
    for number, title in TITLES.items():
        rows = []
        for row in (r for r in found.times["paper"] if r["table"] == number):
            compensated = "yes" if row["compensated"] else "no"
            published = PUBLISHED.get((number, row["dims"]), (None, None))
            key = dict(table=number, dataset=found.dataset, dims=row["dims"], filter=row["filter"], compensated=compensated)
            oblique, axis = found.error(**key, view="oblique"), found.error(**key, view="axis")
            rows.append([row["dims"], f"`{row['filter']}`", row["padding"], compensated, text(published[0]), text(row["pre_s"]),
                         text(published[1]), text(1 / row["drawn"]), text(1 / row["with_writing"]), f"{row['peak_rss_bytes'] / 2**20:.0f}",
                         *(text(oblique.get(f)) for f in FIGURES), text(axis.get("l2"))])
        parts.append(f"## {title}\n\n" + table(
            ["size", "filter", "padding", "compensated", "published s", "our s", "published frames/s", "our frames/s", "with writing",
             "MiB", "l2", "centre", "largest", "ghosts", "axis l2"], rows))
    return "".join(parts)


def ratios(found):
    """Frames a second of each table over those of 4.1, ours beside the paper's."""
    rows = []
    for dims in dict.fromkeys(r["dims"] for r in found.times["paper"]):
        plain = next(r for r in found.times["paper"] if r["table"] == "4.1" and r["dims"] == dims)
        for row in (r for r in found.times["paper"] if r["dims"] == dims and r["table"] != "4.1" and (r["table"], dims) in PUBLISHED):
            if row["compensated"] and row["filter"] != "catmull-rom-fast":
                continue
            rows.append([row["table"], dims, f"`{row['filter']}`", text(PUBLISHED["4.1", dims][1] / PUBLISHED[row["table"], dims][1]),
                         text(row["drawn"] / plain["drawn"])])
    return "## Time of a frame, in those of Table 4.1\n\n" + table(["table", "size", "filter", "published", "ours"], rows)


def ffts(found):
    rows = []
    for row in found.times["ffts"]:
        published = PUBLISHED_FFTS.get(row["dims"], (None, None))
        shown = published[1] if row["by"].endswith("gpu --ifft gpu") else published[0] if "--ifft" in row["by"] else None
        rows.append([row["dims"], f"`{row['by']}`", text(shown), text(1 / row["drawn"] if "drawn" in row else "no device"),
                     *(text(row[k] * 1e3 if row.get(k) is not None else None) for k in ("slice", "inverse", "read_back"))])
    return "## Table 4.5, the inverse transform by FFTW or on the device\n\n" + table(
        ["size", "by", "published frames/s", "our frames/s", "slice ms", "inverse ms", "read-back ms"], rows)


def filters(found):
    parts = []
    for dataset in dict.fromkeys(r["dataset"] for r in found.rows):
        rows = []
        chosen = [r for r in found.rows if r["table"] == "filters" and r["dataset"] == dataset]
        for row in (r for r in chosen if r["view"] == "oblique"):
            axis = next(r for r in chosen if r["view"] == "axis" and all(r[k] == row[k] for k in ("filter", "padding", "compensated")))
            rows.append([f"`{row['filter']}`", row["padding"], row["compensated"], *(text(row[f]) for f in FIGURES), text(axis["l2"])])
        parts.append(f"## Every filter and padding: {dataset}, {chosen[0]['dims']}\n\n" +
                     table(["filter", "padding", "compensated", "l2", "centre", "largest", "ghosts", "axis l2"], rows))
    return "".join(parts)


def growth(found):
    rows = [[row["size"], f"`{row['filter']}`", text(row["fft_s"]), text(row["slice"] * 1e3), text(row["inverse"] * 1e3),
             text(row["drawn"] * 1e3), f"{row['peak_rss_bytes'] / 2**20:.0f}"] for row in found.times["growth"]]
    return "## Growth with the size, padding 1 (growth.png)\n\n" + table(
        ["size", "filter", "transform s", "slice ms", "inverse ms", "frame ms", "MiB"], rows)


def rays(found):
    rows = []
    slices = [r for r in found.times["rays"] if r["by"] == "fvr-slice"]
    for row in found.times["rays"]:
        best, after = "", ""
        if row["by"] == "vol-raycast":
            able = [s for s in slices if s["rmse"] <= row["rmse"] and s["seconds"] < row["seconds"]]
            if able:
                one = min(able, key=lambda s: s["seconds"])
                best, after = f"`{one['setting']}`", f"{one['fft_s'] / (row['seconds'] - one['seconds']):.1f}"
            else:
                best = "none"
        rows.append([f"`{row['by']}`", row["setting"], text(row["seconds"] * 1e3), text(row["fft_s"]), text(row["rmse"]), text(row["largest"]),
                     best, after])
    return ("## Where it beats casting rays\n\n"
            f"{found.dataset}, {found.config['rays']['size']}^3, the oblique view. Errors as shares of the largest pixel, each against its own converged\n"
            "picture: rays against the reference integral of the trilinear field, slices against that of the volume's transform. *After*: views\n"
            "until the transform, reading and writing the spectrum included, is paid for.\n\n"
            + table(["by", "setting", "ms a view", "transform s", "rmse", "largest", "fastest slice as good", "after views"], rows))


def device(found):
    if not found.times["device"]:
        return "## The device beside the CPU\n\nNo EGL device here.\n"
    rows = [[f"`{row['filter']}`", text(row["difference"])] for row in found.times["device"]]
    return "## The device beside the CPU\n\nLargest difference of two views' pixels, as a share of the largest pixel.\n\n" + table(
        ["filter", "difference"], rows)


def main():
    arguments = records.table_arguments(__doc__, "settings")
    found = Found(json.loads(pathlib.Path(arguments.settings).read_text()))
    with open(arguments.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(row | {f: f"{row[f]:.4g}" for f in FIGURES} for row in found.rows)
    host = found.times["host"]
    head = EXPLANATION.format(**{k: found.config[k] for k in ("rounds", "views", "window", "oblique", "truth_size")}, cpu=host["cpu"],
                              threads=host["threads"], simd=host["simd"], device=found.times["device_name"] or "no device",
                              truth=max(r["l2"] for r in found.rows if r["table"] == "truth"))
    pathlib.Path(arguments.markdown).write_text(
        head + "\n" + paper_tables(found) + ratios(found) + ffts(found) + growth(found) + rays(found) + device(found) + "\n" + filters(found))


if __name__ == "__main__":
    main()
