#!/usr/bin/python3
"""Tables of a `pareto` sweep: every setting as CSV; in Markdown the fastest at equal error, slopes, and --max-error."""

import csv
import json
import math
import pathlib
import statistics

import pareto
import records
import rounds
import sweep

COLUMNS = ["dataset", "scene", "size", "method", "setting", "samples", "mse", "max_error", "time_s", "index_s"]

EXPLANATION = """\
Pictures of {truths}; truth: the adaptive reference integral, to the tolerance given. MSE on the byte scale, largest error on the colour scale 0..1.
The first pass renders every setting once, for its error, on all cores. Of it the fastest at each error, of uniform sampling
and of the rest (up to twice the least time, {screened} at most), are timed again at each number of threads, and the fastest of each kind once more, in {rounds} interleaved rounds:
no setting is chosen for the luck that it is measured with. A time is the least of {repeats} frames in one process. *Ratio*: time of the best uniform setting over that of the best other setting,
median with its 95 % interval (order statistics); above 1 the other is faster. Uniform sampling may take any step and quadrature,
with the same skipping of empty space and the same early terminations. Where none of its settings keeps the error, its most accurate one
of at most {limit_s} s stands in: finer steps take longer, so the ratio is *over* what is given; in medians it counts as that. Scenes in which the
others miss it are in none. Times are of rendering
alone; what an index takes to build for a scene, on all cores, stands beside them, and the ratio of a first picture, which waits for it.
{host}.
"""


def load(path):
    return json.loads(pathlib.Path(path).read_text())


def markdown(header, lines):
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in [header, ["---"] * len(header), *lines]) + "\n"


def shown_ms(ms):
    return "" if math.isnan(ms) else f"{ms:.1f}"


def best(times, runs, baseline, target):
    """The timed setting that was chosen for a target, or None: of those that keep the error, the fastest when they were screened."""
    able = [s for s in times if runs[s]["baseline"] == baseline and runs[s]["mse"] <= target]
    return min(able, key=lambda s: times[s]["screened"], default=None)


def equal_error(swept, groups):
    """One dict a scene, target and thread count: the best settings, their times and ratio; of an index its building, and the ratio
    of a first picture."""
    for group, (runs, timed) in groups.items():
        by_setting = {r["setting"]: r for r in runs}
        for threads, times in timed.items():
            for target in sweep.of_group(swept, group)["targets"]:
                uniform, other = (best(times, by_setting, b, target) for b in (True, False))
                reached = uniform is not None
                if not reached and other:
                    uniform = pareto.stand_in(runs, swept["limit_s"])
                measured = [times[s]["rounds"] if s else [math.nan] for s in (uniform, other)]
                ratio = rounds.ratio(*measured) if uniform and other else None
                seconds = [statistics.median(m) for m in measured]
                build = by_setting[other]["index_s"] if other else None
                yield dict(group=group, target=target, threads=threads, uniform=uniform, reached=reached, other=other, ratio=ratio,
                           mse=by_setting[uniform]["mse"] if uniform else None,
                           method=by_setting[other]["method"] if other else "", ms=[1e3 * s for s in seconds],
                           build_ms=1e3 * build if build else None,
                           first=seconds[0] / (seconds[1] + build) if uniform and build else None)


def equal_error_table(rows):
    def uniform(r):
        if not r["uniform"]:
            return "none reaches it"
        return r["uniform"] if r["reached"] else f"none reaches it; MSE {r['mse']:.1g}: {r['uniform']}"
    def over(r):
        return "" if r["reached"] else "over "
    def ratio(r):
        return over(r) + rounds.shown(r["ratio"]) if r["ratio"] else "-"
    lines = [[r["group"], f"{r['target']:g}", r["threads"], uniform(r), shown_ms(r["ms"][0]),
              r["other"] or "none reaches it", shown_ms(r["ms"][1]), ratio(r),
              shown_ms(r["build_ms"]) if r["build_ms"] else "", over(r) + f"{r['first']:.2f}" if r["first"] else ""] for r in rows]
    return markdown(["scene", "MSE at most", "threads", "uniform", "ms", "other", "ms", "ratio", "index, ms", "ratio with it"], lines)


def summary(rows):
    """Over all scenes, without shading and with it, for each target and thread count: median ratio, and how many are slower and
    1.5 times as fast. Where uniform sampling misses the error its ratio is a bound from below, and so is a median that has one
    at its place or before it."""
    lines = []
    for threads, target in dict.fromkeys((r["threads"], r["target"]) for r in rows):
        for shaded in (False, True):
            asked = [r for r in rows if (r["threads"], r["target"]) == (threads, target)
                     and r["group"].partition("@")[0].endswith("-shaded") == shaded]
            found = [r for r in asked if r["ratio"]]
            if found:
                ratios = [r["ratio"][0] for r in found]
                over = "over " if any(not r["reached"] and r["ratio"][0] <= statistics.median_high(ratios) for r in found) else ""
                lines.append([f"{target:g}", threads, "on" if shaded else "off", len(found), sum(not r["reached"] for r in found),
                              len(asked) - len(found), f"{over}{statistics.median(ratios):.2f}",
                              sum(r["reached"] and r["ratio"][2] < 1 for r in found), sum(ratio >= 1.5 for ratio in ratios)])
    return markdown(["MSE at most", "threads", "shading", "scenes", "uniform misses it", "others miss it", "median ratio", "slower",
                     "1.5 times as fast"], lines)


def sizes(swept):
    return [swept["size"], *swept.get("at_sizes", {})]


def truths(swept):
    """The sizes and what their truths' tolerances are."""
    return " and ".join(f"{size} pixels ({swept.get('at_sizes', {}).get(size, swept)['tolerance']})" for size in sizes(swept))


def slope(coarse, fine, x):
    return math.log(coarse["mse"] / fine["mse"]) / 2 / math.log(x)


def slopes(groups):
    """d log RMSE / d log step between neighbouring steps 1v .. 0.25v; for split, in the number of nodes."""
    lines = []
    for group, (runs, _) in groups.items():
        line = [group]
        for quadrature in ("rectangle", "trapezoid", "preintegrated"):
            at = {float(r["rung"][:-1]): r for r in runs if r["method"] == "uniform" and r["mse"] > 1e-9
                  and r["values"]["quadrature"] == quadrature and r["values"].get("termination") == "0"}
            pairs = [(h, h / 2) for h in at if h / 2 in at and h <= 1]
            line.append(f"{statistics.median(slope(at[a], at[b], 2) for a, b in pairs):.2f}" if pairs else "-")
        nodes = {int(r["rung"]): r for r in runs if r["method"] == "split" and r["values"].get("termination") == "0"}
        for n in (1, 2, 3):
            line.append(f"{math.sqrt(nodes[n]['mse']):.2g}" if n in nodes else "-")
        for a, b in ((1, 2), (2, 3)):
            line.append(f"{slope(nodes[a], nodes[b], b / a):.1f}" if b in nodes and nodes[b]["mse"] > 0 else "-")
        lines.append(line)
    return markdown(["scene", "rectangle", "trapezoid", "preintegrated", "split 1: RMSE", "2", "3", "slope 1 to 2", "2 to 3"], lines)


def bounds(swept, groups):
    """What --max-error promised and kept; a bound that it could not keep it refuses, and says so."""
    lines = []
    for group, (runs, _) in groups.items():
        found = {r["rung"]: r for r in runs if r["method"] == "max-error"}
        for bound in map(str, swept["methods"]["max-error"]["ladder"]["bound"] if found else []):
            if r := found.get(bound):
                kept = "yes" if r["max_error"] <= float(bound) else "**no**"
                lines.append([group, bound, f"{r['max_error']:.2g}", kept, f"{1e3 * r['seconds']:.1f}"])
            else:
                lines.append([group, bound, "", "refused", ""])
    return markdown(["scene", "bound", "largest error", "kept", "ms"], lines) if lines else ""


def write_csv(path, swept, groups):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for group, (runs, _) in groups.items():
            for r in runs:
                dataset, scene = group.partition("@")[0].split("/")
                writer.writerow([dataset, scene, sweep.of_group(swept, group)["size"], r["method"], r["setting"], r["samples"], f"{r['mse']:.6g}",
                                 f"{r['max_error']:.6g}", f"{r['seconds']:.4g}", records.number(r["index_s"], 4)])


def main():
    arguments = records.table_arguments(__doc__, "settings")
    settings = load(arguments.settings)
    if not settings["groups"]:
        raise SystemExit("pareto: none of the data sets is at hand")
    swept, out = settings["sweep"], pathlib.Path(settings["out"])
    def timed(group):
        return swept["rounds"] and swept["datasets"][group.split("/")[0]].get("timed", True)
    groups = {g: (load(out / "accuracy" / f"{g}.json"), load(out / "times" / f"{g}.json") if timed(g) else {})
              for g in settings["groups"]}
    write_csv(arguments.csv, swept, groups)
    stats = load(out / "truth" / settings["groups"][0] / "reference.json")
    host = f"{stats['host']['cpu']}, {stats['host']['threads']} threads, {stats['host']['simd']}, commit {stats['commit']}"
    text = "# Error against time\n\n" + EXPLANATION.format(host=host, truths=truths(swept), repeats=pareto.REPEATS, **swept)
    for size in sizes(swept):
        at = {g: found for g, found in groups.items() if sweep.of_group(swept, g)["size"] == size}
        if rows := list(equal_error(swept, at)):
            text += (f"\n## {size}: all scenes\n\n" + summary(rows) + f"\n## {size}: fastest at equal error\n\n" + equal_error_table(rows))
    main_size = {g: found for g, found in groups.items() if "@" not in g}
    text += ("\n## Order of convergence\n\nSlope of log RMSE over log step (median between steps of 1 voxel and below), and of the split"
             " quadrature its RMSE\n(byte scale) at 1, 2 and 3 Gauss nodes with the slope in the number of nodes. Shading jumps at"
             " the faces of cells,\nwhere the gradient does: steps that do not know the faces are of order 1 there.\n\n" + slopes(main_size))
    if guaranteed := bounds(swept, main_size):
        text += "\n## --max-error\n\nTimes of the first pass, one run each.\n\n" + guaranteed
    pathlib.Path(arguments.markdown).write_text(text)


if __name__ == "__main__":
    main()
