#!/usr/bin/python3
"""What a picture of wavelet coefficients costs: by footprints, and by rebuilding the volume and casting rays through it.

    gross.py SETTINGS truth DATASET -o FOLDER      coefficients and exact pictures, which take the longest
    gross.py SETTINGS cost DATASET -o FILE         times, which want a quiet machine; DATASET.truth beside the file"""

import json
import pathlib
import shutil
import statistics
import subprocess
import tempfile

import records
import rounds
import sweep


class Tools:
    def __init__(self, binaries, folder):
        self.binaries, self.folder = pathlib.Path(binaries).resolve(), pathlib.Path(folder)

    def run(self, command):
        """Stats record of a tool's run, in the folder."""
        words = command.split()
        subprocess.run([self.binaries / words[0], *words[1:], "--quiet", "--stats", "stats.json"], check=True, cwd=self.folder)
        return json.loads((self.folder / "stats.json").read_text())

    def compare(self, picture, truth):
        done = subprocess.run([self.binaries / "img-compare", picture, truth, "--json", "--channel", "R"], check=True, cwd=self.folder,
                              capture_output=True, text=True)
        return json.loads(done.stdout)["all"]

    def error(self, picture, truth, largest):
        """Root of the mean square and largest error of a pixel, shares of the truth's largest value."""
        found = self.compare(picture, truth)
        return {"rms": found["rmse"] / largest, "largest": found["max"] / largest}


def truth(asked, volume, tools):
    """What is not timed, in the tools' folder: coefficients of every wavelet and share kept and their exact pictures. A list of
    dicts."""
    camera = f"--view {asked['view']} --size {asked['size']}"
    voxels = 1
    for n in asked["dims"].split("x"):
        voxels *= int(n)
    tools.run(f"vol-raycast {volume} -o full.exr --model xray --quadrature reference {camera}")
    cases = []
    for wavelet in asked["wavelets"]:
        for keep in asked["keeps"]:
            name = f"{wavelet}-{keep}"
            tools.run(f"vol-dwt {volume} -o {name}.vdb --wavelet {wavelet} --levels {asked['levels']} --keep {round(keep * voxels)}")
            exact = tools.run(f"wavelet-raycast {name}.vdb -o {name}.exr {camera}")
            tools.run(f"wavelet-raycast {name}.vdb -o black.exr --budget 0 {camera}")
            cases.append({"wavelet": wavelet, "keep": keep, "name": name, "exact_s": exact["time_s"]["phases"]["render"][0],
                          "coefficients": exact["counts"]["coefficients"], "largest": tools.compare("black.exr", f"{name}.exr")["max"]})
            rounds.say(f"{wavelet}, {100 * keep:g} % kept: exact in {cases[-1]['exact_s']:.1f} s")
    return cases


def timed(asked, tools, case):
    """One row: every contender once a round; seconds of every round and errors."""
    camera = f"--view {asked['view']} --size {asked['size']}"
    wavelet, keep, name = case["wavelet"], case["keep"], case["name"]
    errors = ["closed form"] if wavelet == "haar" else [str(e) for e in asked["footprint_errors"]]
    row = {**case, "contenders": {}}
    repeat = f"--repeat {asked['repeat']}"

    def rebuild():
        inverse = tools.run(f"vol-dwt {name}.vdb -o rebuilt.nrrd --inverse {repeat}")
        rays = tools.run(f"vol-raycast rebuilt.nrrd -o rebuild.exr --model xray --step {asked['step']} {camera} {repeat}")
        return inverse["time_s"]["compute"] + rays["time_s"]["compute"]

    def footprints(error):
        allowed = "" if error == "closed form" else f"--footprint-error {error}"
        stats = tools.run(f"wavelet-raycast {name}.vdb -o footprints-{error.split()[0]}.exr --algorithm footprint {allowed} {camera} {repeat}")
        known = row["contenders"].setdefault(error, {})
        row["host"], row["commit"] = stats["host"], stats["commit"]
        known["tables_s"] = known.get("tables_s", []) + stats["time_s"]["phases"]["tables"]
        known["prepare_s"] = known.get("prepare_s", []) + stats["time_s"]["phases"]["prepare"]
        known["counts"] = stats["counts"]
        known["estimate"] = stats["error"]
        return statistics.median(stats["time_s"]["phases"]["render"])

    contenders = {"rebuild": rebuild, **{e: lambda e=e: footprints(e) for e in errors}}
    times = rounds.interleaved(contenders, asked["rounds"])
    for contender, seconds in times.items():
        known = row["contenders"].setdefault(contender, {})
        known["seconds"] = seconds
        picture = "rebuild.exr" if contender == "rebuild" else f"footprints-{contender.split()[0]}.exr"
        known["error"] = tools.error(picture, f"{name}.exr", case["largest"])
        known["error_full"] = tools.error(picture, "full.exr", case["largest"])
    said = ", ".join(f"{contender} {1e3 * statistics.median(seconds):.2f} ms" for contender, seconds in times.items())
    rounds.say(f"{wavelet}, {100 * keep:g} % kept: {said}")
    return row


def main():
    arguments = records.tool_arguments(__doc__, "settings", "what", "dataset")
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, output = settings["sweep"], pathlib.Path(arguments.output)
    if "dims" in asked["datasets"][arguments.dataset]:
        asked = {**asked, "dims": asked["datasets"][arguments.dataset]["dims"]}
    if arguments.what == "truth":
        volume = (sweep.ROOT / sweep.volume(arguments.dataset, settings["out"])).resolve()
        output.mkdir(parents=True, exist_ok=True)
        cases = truth(asked, volume, Tools(arguments.bin, output))
        (output / "cases.json").write_text(json.dumps(cases, indent=1))
        return
    with tempfile.TemporaryDirectory() as folder:
        found = pathlib.Path(folder) / "found"
        shutil.copytree(output.parent / f"{arguments.dataset}.truth", found)
        tools = Tools(arguments.bin, found)
        rows = [timed(asked, tools, case) for case in json.loads((found / "cases.json").read_text())]
    output.write_text(json.dumps({"dataset": arguments.dataset, "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
