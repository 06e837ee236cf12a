#!/usr/bin/python3
"""One data set and scene of a `pareto` sweep: first every setting, for its error and a rough time; then those near the
front again, some times each, to choose among them; the chosen a third time, interleaved, so that times can be compared."""

import argparse
import itertools
import json
import pathlib
import statistics

import raycaster
import rounds
import sweep


def families(asked):
    """(name, entry) of every family of settings that is asked for: a method is one or a list of them."""
    for name, entry in asked["methods"].items():
        for family in entry if isinstance(entry, list) else [entry]:
            if name in asked.get("of_methods", [name]) and family.get("only_size", asked.get("size")) == asked.get("size"):
                yield name, family


def curves(method):
    """(values of `with`, name and values of the ladder) for every curve of a method."""
    fixed = method.get("with", {})
    (rung, values), = method["ladder"].items()
    for chosen in itertools.product(*fixed.values()):
        yield dict(zip(fixed, map(str, chosen))), rung, [str(v) for v in values]


def setting_of(method, name, values):
    """What the tables call a setting: its options, short."""
    text = method["render"].format(**values)
    if "index" in method:
        text += f" --index {name}: {method['index'].format(**values)}"
    return " ".join(text.split())


def accuracy_pass(caster, settings, asked, dataset, log):
    """Every setting of every curve, once; a ladder ends where finer settings answer no question."""
    out = pathlib.Path(settings["out"])
    known = raycaster.known_options(caster.bin)
    runs = []
    for name, method in families(asked):
        if method.get("needs", "") not in known:
            continue
        for values, rung, ladder in curves(method):
            for value in ladder:
                values = values | {rung: value}
                options, index_s = method["render"].format(**values), None
                if "index" in method:
                    coefficients = out / "coefficients" / dataset / f"{values['wavelet']}.vdb"
                    path, index_s = caster.index(coefficients, method["index"].format(**values), f"{name}-{len(runs)}")
                    options += f" --index {path}"
                stats = caster.render(options, repeat=2)
                if stats is None:
                    continue
                mse, largest = caster.error()
                phases = stats["time_s"]["phases"]
                if index_s is None:
                    index_s = sum(statistics.median(phases[p]) for p in phases if "index" in p) or None
                runs.append({"method": name, "rung": value, "setting": setting_of(method, name, values),
                             "options": options, "samples": stats["counts"]["samples"], "mse": mse, "max_error": largest,
                             "seconds": min(phases["render"]), "index_s": index_s, "values": values,
                             "baseline": bool(method.get("baseline")), "estimate": stats.get("error")})
                if not method.get("whole") and (mse <= asked["targets"][-1] or runs[-1]["seconds"] > asked["limit_s"]):
                    break
        log(f"{name}: {sum(r['method'] == name for r in runs)} settings")
    return runs


def stand_in(runs, limit_s):
    """Uniform sampling's most accurate setting of those that took at most `limit_s` in the first pass (of those within a tenth
    of the least error, the fastest), or None: where uniform sampling misses a target, what met it would take longer."""
    uniform = [r for r in runs if r["baseline"]]
    able = [r for r in uniform if r["seconds"] <= limit_s] or uniform
    least = min((r["mse"] for r in able), default=0)
    found = min((r for r in able if r["mse"] <= 1.1 * least), key=lambda r: r["seconds"], default=None)
    return found and found["setting"]


NEAR = 2  # times what the fastest took in the first pass: what took longer there is not faster


def contenders(runs, targets, count, standing_in):
    """Settings to time: at each target the few fastest of uniform sampling and of the rest, by the times that `runs` hold, none
    far behind; for uniform sampling, where it misses the target, the one that stands in."""
    chosen = {}
    for target in targets:
        for baseline in (True, False):
            able = [r for r in runs if r["baseline"] == baseline and r["mse"] <= target]
            if baseline and not able:
                able = [r for r in runs if r["setting"] == standing_in]
            for run in sorted(able, key=lambda r: r["seconds"])[:count]:
                if run["seconds"] <= NEAR * min(r["seconds"] for r in able):
                    chosen[run["setting"]] = run
    return chosen


REPEATS = 4  # of every setting alike, the fastest counts: the first run also pays for memory that is touched for the first time, and a frame
# of a few milliseconds on all cores waits now and then for one that does something else


def screened(runs, asked, time):
    """The runs that may be the fastest at a target, with the shortest of several times in place of the first pass's: one
    time, of a picture drawn once, chooses badly. `time` gives the seconds of one run."""
    rough = list(contenders(runs, asked["targets"], asked["screened"], stand_in(runs, asked["limit_s"])).values())
    found = [[time(run) for run in rough] for _ in range(asked["screenings"])]
    return [run | {"seconds": min(times)} for run, times in zip(rough, zip(*found))]


def time_them(caster, asked, runs, log):
    """{threads: {setting: {"screened": seconds by which it was chosen, "rounds": those of each round}}}"""
    times = {}
    for threads in asked["threads"]:
        again = screened(runs, asked, lambda run: caster.seconds(run["options"], threads, REPEATS))  # noqa: B023
        chosen = contenders(again, asked["targets"], asked["contenders"], stand_in(runs, asked["limit_s"]))
        found = rounds.interleaved({name: lambda r=run: caster.seconds(r["options"], threads, REPEATS)
                                    for name, run in chosen.items()}, asked["rounds"])
        times[str(threads)] = {name: {"screened": run["seconds"], "rounds": found[name]} for name, run in chosen.items()}
        log(f"{threads} threads: {len(chosen)} settings of {len(again)} timed in {asked['rounds']} rounds")
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("group", help="DATASET/SCENE")
    parser.add_argument("--bin", required=True)
    parser.add_argument("--truth", required=True)
    parser.add_argument("--runs", help="results of the first pass: the second pass is asked for")
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    dataset, asked = arguments.group.split("/")[0], sweep.of_group(settings["sweep"], arguments.group)
    caster = raycaster.Raycaster(arguments.bin, raycaster.volume_at(settings, dataset), sweep.scene(arguments.group),
                                 asked["size"], arguments.truth,
                                 pathlib.Path(settings["out"]) / "pictures" / arguments.group)
    log = lambda text: rounds.say(f"{arguments.group}: {text}")  # noqa: E731
    if arguments.runs:
        found = time_them(caster, asked, json.loads(pathlib.Path(arguments.runs).read_text()), log)
    else:
        found = accuracy_pass(caster, settings, asked, dataset, log)
    pathlib.Path(arguments.output).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
