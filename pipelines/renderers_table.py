#!/usr/bin/python3
"""Tables of `renderers`: every setting as CSV; in Markdown the fastest of every method at equal error."""

import csv
import pathlib
import statistics

import records
import rounds

COLUMNS = ["dataset", "size", "picture", "method", "setting", "rmse", "largest", "own", "time_s", "once_s", "bytes", "once_bytes"]
TITLES = {"xray": "X-ray", "composite": "Emission and absorption", "isosurface": "Isosurface"}

EXPLANATION = """\
# One truth, all renderers

Pictures of {size} pixels by every renderer that can draw them, against one truth; errors are RMSE on the byte scale (of X-rays:
255 is the truth's brightest pixel). **The truth** of `blobs` and `blobs-fine`, Gaussians of standard deviation 1 voxel and more that end
inside the box, is what the samples were taken of: X-rays in closed form, all else from samples three times as dense joined by cubic
B-splines. Nobody knows what a scanner's voxels were taken of; there it is the exact picture of the trilinear field, a convention, and the one
of ray casters. **Own** is the error against the exact picture of what a method itself means: of rays the trilinear field, of Fourier slices the
plain sum over all voxels, band-limited (also of those on the box's faces, which count half in a trilinear field that ends there), of haar
all its coefficients. Where the own error is small and the other is not, a method computes well
what is not the convention; no setting of it comes nearer. [Error over time](error-time.png), [over memory](error-memory.png).

Times are of a picture alone, on all cores, the faster of {repeats} runs in one process; what is made once a volume (transform, spectrum, index,
mesh, and planning) stands beside, memory is the whole process's peak. Settings below are the fastest of their method at an error; their times are
medians of {rounds} interleaved rounds, or of a single run where a method is more than {near} times slower than the fastest; those of all
other settings, in table.csv alone, are of one pass beside other work. *Ahead*: how many times as fast the fastest method is as the next one, median and 95 %
interval. {host}.
"""


def found(settings, kind):
    """{(dataset, picture): what was found}, as far as there is any."""
    out = pathlib.Path(settings["out"])
    paths = {(d, p): out / kind / d / f"{p}.json" for d in settings["datasets"] for p in settings["sweep"]["pictures"]}
    return {key: records.load(path) for key, path in paths.items() if path.exists()}


def merged(settings):
    """{(dataset, picture): rows}, of those that were timed in rounds with these as `rounds` and their median as `seconds`."""
    timed = found(settings, "times")
    rows = found(settings, "accuracy")
    for key, several in timed.items():
        by_setting = {(t["method"], t["setting"]): t for t in several}
        for row in rows[key]:
            if taken := by_setting.get((row["method"], row["setting"])):
                row |= {"rounds": taken["seconds"], "seconds": statistics.median(taken["seconds"]), "once": taken["once"]}
    return rows


def at_target(rows, target):
    """{method: the fastest of the rows timed in rounds that keeps the error}"""
    able = [row for row in rows if row.get("rounds") and row["rmse"] <= target]
    return {m: min((r for r in able if r["method"] == m), key=lambda r: r["seconds"]) for m in dict.fromkeys(r["method"] for r in able)}


def markdown(lines):
    head, *rest = lines
    return "\n".join("| " + " | ".join(line) + " |" for line in [head, ["---"] * len(head), *rest]) + "\n"


def milliseconds(seconds):
    return f"{1e3 * seconds:.3g}"


def lead(fastest, second):
    """How many times as fast: round by round, or of the medians where one of them ran once, in no round."""
    if len(fastest) == len(second):
        return rounds.shown(rounds.ratio(second, fastest))
    return f"{statistics.median(second) / statistics.median(fastest):.2f}"


def winners(swept, picture, groups):
    """A line a data set and error: every method's time, the fastest in bold, and how far it is ahead."""
    methods = list(swept["pictures"][picture]["methods"])
    lines = [["data set", "RMSE at most", *(f"{m}, ms" for m in methods), "ahead"]]
    for (dataset, kind), rows in groups.items():
        for target in swept["pictures"][picture].get("targets", swept["targets"]) if kind == picture else []:
            best = at_target(rows, target)
            order = sorted(best, key=lambda m: best[m]["seconds"])
            ahead = lead(*(best[m]["rounds"] for m in order[:2])) if len(order) > 1 else ""
            times = [milliseconds(best[m]["seconds"]) if m in best else "-" for m in methods]
            lines.append([dataset, f"{target:g}", *(f"**{t}**" if order and m == order[0] else t for m, t in zip(methods, times)), ahead])
    return markdown(lines)


def chosen(picture, groups):
    lines = [["data set", "method", "setting", "RMSE", "largest", "own", "ms", "once, ms", "MB", "once, MB"]]
    for (dataset, kind), rows in groups.items():
        for row in rows if kind == picture else []:
            if row.get("rounds") or not any(r.get("rounds") for r in rows):
                lines.append([dataset, row["method"], row["setting"], *(records.number(row[c], 3) for c in ("rmse", "largest", "own")),
                              milliseconds(row["seconds"]), milliseconds(row["once"]), f"{row['bytes'] / 1e6:.0f}",
                              f"{row['once_bytes'] / 1e6:.0f}" if row["once_bytes"] else ""])
    return markdown(lines)


def main():
    arguments = records.table_arguments(__doc__, "settings")
    settings = records.load(arguments.settings)
    swept, groups = settings["sweep"], merged(settings)
    with open(arguments.csv, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for (dataset, picture), rows in groups.items():
            for row in rows:
                figures = [records.number(row[c], 6) for c in ("rmse", "largest", "own")]
                writer.writerow([dataset, row["size"], picture, row["method"], row["setting"], *figures, f"{row['seconds']:.4g}", f"{row['once']:.4g}",
                                 row["bytes"], row["once_bytes"] or ""])
    host = next(iter(groups.values()))[0]["host"]
    about = f"{host['cpu']}, {host['threads']} threads, {host['simd']}"
    text = EXPLANATION.format(size=swept["size"], repeats=swept["repeats"], rounds=swept["rounds"], near=swept["near"], host=about)
    for picture in swept["pictures"]:
        text += f"\n## {TITLES[picture]}\n\n"
        timed = {key: rows for key, rows in groups.items() if any(row.get("rounds") for row in rows)}
        text += winners(swept, picture, timed) + "\n" + chosen(picture, timed) if timed else chosen(picture, groups)
    pathlib.Path(arguments.markdown).write_text(text)


if __name__ == "__main__":
    main()
