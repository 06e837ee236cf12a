#!/usr/bin/python3
"""One data set of the sweep of transfer curves: fits to every target for every number of control points, the pictures of fitted
curves by fvr-slice and by vol-raycast --model xray, and the time and memory of spectra for more and more control points."""

import json
import pathlib
import shlex
import statistics
import subprocess

import records
import rounds
import sweep


class Tools:
    def __init__(self, binaries, folder):
        self.binaries, self.folder = pathlib.Path(binaries), folder

    def run(self, command):
        """Stats record of a tool's run."""
        stats = self.folder / "stats.json"
        words = shlex.split(command)
        subprocess.run([self.binaries / words[0], *words[1:], "--quiet", "--stats", stats], check=True)
        return json.loads(stats.read_text())

    def compared(self, picture, truth, difference):
        done = subprocess.run([self.binaries / "img-compare", picture, truth, "--json", "--peak", "truth", "--quiet", "--metric", "rmse,max",
                               "--difference", difference], check=True, capture_output=True, text=True)
        return json.loads(done.stdout)


def fits(tools, asked, entry, volume):
    rows, span = [], f"--range {entry['range']}" if "range" in entry else ""
    for target, points in entry["targets"].items():
        profile = tools.folder / f"{target}.csv"
        profile.write_text("".join(f"{value},{weight}\n" for value, weight in points))
        for n in asked["points"]:
            stats = tools.run(f"tf-fit {profile} --volume {volume} {span} --weight {asked['weight']} --points {n} -o {tools.folder}/{target}-{n}.yaml")
            rows.append({"target": target, "points": n, "rms": stats["error"]["residual_rms"], "largest": stats["error"]["residual_largest"],
                         "condition": stats["result"]["condition"], "rank": stats["result"]["rank"], "method": stats["result"]["method"],
                         "iterations": stats["counts"]["iterations"], "range": stats["result"]["range"],
                         "control_points": stats["result"]["curves"][0]["points"]})
    return rows


def camera(entry):
    return f" --scene configs/scenes/{entry['scene']}.yaml" if "scene" in entry else f" --view {entry['view']}"


def pictures(tools, asked, entry, volume):
    """The two pictures of every target, with one exposure, and their difference."""
    n, found = asked["drawn"], {}
    view = f"{camera(entry)} --size {asked['size']}"
    spectrum = tools.folder / "spectrum.nrrd"
    for target in entry["targets"]:
        curve, base = tools.folder / f"{target}-{n}.yaml", tools.folder / target
        if not found:  # the same range for all targets
            tools.run(f"vol-fft {volume} --bezier {curve} --compensate {asked['filter']} -o {spectrum}")
        fvr, ray = f"fvr-slice {spectrum} --transfer {curve}{view}", f"vol-raycast {volume} --transfer {curve} --model xray{view} {asked['raycast']}"
        tools.run(f"{fvr} -o {base}-fvr.exr")
        cast = tools.run(f"{ray} -o {base}-ray.exr")
        exposure = tools.run(f"{fvr} -o {base}-fvr.png")["result"]["exposure"]
        tools.run(f"{ray} -o {base}-ray.png --exposure {exposure}")
        error = tools.compared(f"{base}-fvr.exr", f"{base}-ray.exr", f"{base}-difference.png")
        found[target] = {"rmse": error["all"]["rmse"], "largest": error["all"]["max"], "peak": error["peak"],
                         "ray_s": statistics.median(cast["time_s"]["phases"]["render"])}
    spectrum.unlink()
    return found


def costs(tools, asked, entry, volume):
    rows, span = [], f"--range {entry['range']}" if "range" in entry else ""
    spectrum = tools.folder / "spectrum.nrrd"
    for n in asked["cost"]:
        made = tools.run(f"vol-fft {volume} --bezier {n} {span} --compensate {asked['filter']} -o {spectrum}")
        drawn = tools.run(f"fvr-slice {spectrum} -o {tools.folder}/frame.exr{camera(entry)} --size {asked['size']} --repeat {asked['frames']}")
        rows.append({"points": n, "spectrum_mib": made["counts"]["spectrum_bytes"] / 2**20,
                     "transform_s": statistics.median(made["time_s"]["phases"]["transform"]),
                     "frame_s": statistics.median(drawn["time_s"]["phases"]["render"])})
    spectrum.unlink()
    return rows


def main():
    arguments = records.tool_arguments(__doc__, "settings", "dataset")
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, entry = settings["sweep"], settings["sweep"]["datasets"][arguments.dataset]
    folder = pathlib.Path(settings["out"]) / "curves" / arguments.dataset
    folder.mkdir(parents=True, exist_ok=True)
    tools, volume = Tools(arguments.bin, folder), sweep.volume(arguments.dataset, settings["out"])
    found = {"dataset": arguments.dataset, "fits": fits(tools, asked, entry, volume)}
    rounds.say(f"{arguments.dataset}: {len(found['fits'])} fits")
    found["pictures"] = pictures(tools, asked, entry, volume)
    found["costs"] = costs(tools, asked, entry, volume)
    rounds.say(f"{arguments.dataset}: pictures and costs")
    pathlib.Path(arguments.output).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
