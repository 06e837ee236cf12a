#!/usr/bin/python3
"""Where the saving comes from: from the paper's uniform sampling to the best setting in steps, all at the same error.

The error is that of the paper's uniform sampling (rectangle, half a voxel, nothing skipped) against the truth. Each step
of the way is the cheapest of a family of settings at that error: the family's cost-error front is interpolated between
the two settings that bracket the error, linearly in the logarithms, for samples and for time alike.
"""

import json
import math
import pathlib
import statistics
import subprocess

import records
import sweep

STEPS = ["the paper's uniform sampling", "skipping what is invisible", "second-order quadrature, steps of whole half voxels",
         "the best single step", "the index on top"]

EXPLANATION = """\
Each row is the cheapest setting of its kind at the error of the first row, against the truth; samples and milliseconds are
interpolated on the front of cost over error between the two settings that bracket that error, each on a front of its own: the
setting named last is the one with the fewest samples, and the fastest may be another. `x` is the factor to the row above, `in
all` to the first row. What is skipped is what the transfer function makes invisible (min-max macrocells), in every row
but the first. Uniform steps: {steps}. Index: of the classified field, rule `segment`, look-ahead; wavelet, standard
distance and epsilon as in the last column. Times are medians of {repeat} renderings by themselves: the index is
built beforehand, once a scene, the macrocells once a volume.
"""


class Scene:
    """Runs settings on one data set and scene, and remembers cost and error of each."""

    def __init__(self, settings, binaries, dataset, scene, folder):
        self.sweep, self.bin = settings["sweep"], binaries
        self.out = pathlib.Path(settings["out"])
        self.dataset, self.name = dataset, scene
        self.folder = folder / dataset / scene
        self.folder.mkdir(parents=True, exist_ok=True)
        self.scene_file = sweep.scene(f"{dataset}/{scene}")
        self.truth = self.out / "truth" / dataset / scene / "reference.exr"

    def run(self, *command):
        subprocess.run([f"{self.bin}/{command[0]}", *map(str, command[1:])], check=True)

    def render(self, label, *options):
        image, stats = self.folder / "picture.exr", self.folder / "picture.json"
        self.run("vol-raycast", sweep.volume(self.dataset, str(self.out)), "-o", image, "--scene", self.scene_file,
                 "--size", self.sweep["size"], "--repeat", self.sweep["decomposition"]["repeat"], "--stats", stats, "--quiet",
                 *options)
        record = json.loads(stats.read_text())
        compared = subprocess.run([f"{self.bin}/img-compare", image, self.truth, "--json", "--metric", "mse_byte"],
                                  check=True, capture_output=True, text=True)
        return {"label": label, "mse": json.loads(compared.stdout)["all"]["mse_byte"],
                "samples": record["counts"]["samples"], "ms": 1e3 * sweep.render_seconds(record)}

    def uniform(self, quadrature, step, *options):
        return self.render(f"{quadrature} {step}", "--quadrature", quadrature, "--step", step, *options)

    def indexed(self, wavelet, distance, epsilon, quadrature):
        index = self.folder / "index.nrrd"
        self.run("vol-index", self.out / "coefficients" / self.dataset / f"{wavelet}.vdb", "-o", index, "--epsilon", epsilon,
                 "--distance", distance, "--scene", self.scene_file, "--quiet")
        return self.render(f"{wavelet} d {distance} epsilon {epsilon} {quadrature}", "--quadrature", quadrature, "--step",
                           distance, "--index", index)


def front(runs, cost):
    """The runs that no other beats in both error and cost, by falling error."""
    best = []
    for run in sorted(runs, key=lambda r: (r[cost], r["mse"])):
        if not best or run["mse"] < best[-1]["mse"]:
            best.append(run)
    return best


def cost_at(runs, error, cost):
    """(cost, label) at an error: between the two runs of the front that bracket it, None where the front ends before."""
    best = front(runs, cost)
    for cheap, dear in zip(best, best[1:]):
        if dear["mse"] <= error <= cheap["mse"]:
            weight = math.log(cheap["mse"] / error) / math.log(cheap["mse"] / dear["mse"])
            nearest = dear if weight > 0.5 else cheap
            return cheap[cost] * (dear[cost] / cheap[cost]) ** weight, nearest["label"]
    if best and best[0]["mse"] <= error:
        return best[0][cost], best[0]["label"]
    return None, ""


def decompose(scene, asked):
    """Families of runs, in the order of STEPS."""
    paper = scene.uniform("rectangle", "0.5v", "--no-skip")
    skipping = scene.uniform("rectangle", "0.5v")
    uniform = {(q, s): scene.uniform(q, s) for q in asked["quadratures"] for s in asked["steps"]}
    halves = [run for (_, step), run in uniform.items() if float(step[:-1]) * 2 == int(float(step[:-1]) * 2)]
    single = list(uniform.values())
    indexed = [scene.indexed(wavelet, distance, epsilon, quadrature)
               for wavelet, distances in asked["index"].items() for distance in distances for epsilon in asked["epsilons"]
               for quadrature in asked["index_quadratures"]]
    return paper["mse"], [[paper], [skipping], halves, single, indexed]


def rows_of(error, families):
    rows = []
    for name, family in zip(STEPS, families):
        samples, label = cost_at(family, error * 1.0000001, "samples")
        ms, _ = cost_at(family, error * 1.0000001, "ms")
        rows.append({"step": name, "samples": samples, "ms": ms, "label": label})
    return rows


def factor(rows, n, before, cost):
    return None if rows[n][cost] is None or rows[before][cost] is None else rows[before][cost] / rows[n][cost]


def text(value, digits=3):
    return "-" if value is None else f"{value:.{digits}g}"


def table_of(dataset, scene, error, rows):
    lines = [f"## {dataset}, scene `{scene}`, at MSE {error:.3g} (byte scale)\n",
             "| | samples | x | in all | ms | x | in all | setting |", "|---|---:|---:|---:|---:|---:|---:|---|"]
    for n, row in enumerate(rows):
        line = [row["step"]]
        for cost in ("samples", "ms"):
            value = row[cost]
            shown = "-" if value is None else f"{value:.0f}" if cost == "samples" else f"{value:.3g}"
            line += [shown] + ([text(factor(rows, n, n - 1, cost)), text(factor(rows, n, 0, cost))] if n else ["", ""])
        lines.append("| " + " | ".join(line + [row["label"]]) + " |")
    return "\n".join(lines) + "\n"


def summary(found):
    """Medians over the scenes, per data set and in all."""
    lines = ["## Medians over the scenes\n", "| data | samples in all | samples, index | time in all | time, index |",
             "|---|---:|---:|---:|---:|"]
    for dataset in list(dict.fromkeys(d for d, _, _ in found)) + (["all"] if len({d for d, _, _ in found}) > 1 else []):
        line = [dataset]
        for cost in ("samples", "ms"):
            for before in (0, -2):
                values = [factor(rows, -1, before, cost) for d, _, rows in found if dataset in (d, "all")]
                values = [v for v in values if v is not None]
                line.append(f"{statistics.median(values):.3g} ({min(values):.3g} to {max(values):.3g})" if values else "-")
        lines.append("| " + " | ".join(line) + " |")
    return "\n".join(lines) + "\n"


def main():
    arguments = records.tool_arguments(__doc__, "settings")
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked = settings["sweep"]["decomposition"]
    folder = pathlib.Path(settings["out"]) / "decomposition"
    wanted = [d for d in asked["datasets"] if d in settings["datasets"]] or [d for d in asked["else"] if d in settings["datasets"]]
    found, tables, measured = [], [], []
    for dataset in wanted:
        for name in settings["sweep"]["datasets"][dataset]["scenes"]:
            scene = Scene(settings, arguments.bin, dataset, name, folder)
            error, families = decompose(scene, asked)
            rows = rows_of(error, families)
            found.append((dataset, name, rows))
            tables.append(table_of(dataset, name, error, rows))
            measured.append({"dataset": dataset, "scene": name, "mse": error, "rows": rows, "runs": families})
    (folder / "runs.json").write_text(json.dumps(measured, indent=1))
    explanation = EXPLANATION.format(steps=", ".join(asked["steps"]), repeat=asked["repeat"])
    output = pathlib.Path(arguments.output)
    output.write_text("# Where the saving comes from\n\n" + explanation + "\n" + summary(found) + "\n" + "\n".join(tables))


if __name__ == "__main__":
    main()
