#!/usr/bin/python3
"""One curvilinear grid by every setting of the sweep: times interleaved, counts, the error against the same options at
the finest throttle."""

import argparse
import json
import pathlib
import shlex
import statistics
import subprocess

import yaml

import rounds
import sweep


class Drawer:
    def __init__(self, binaries, words, folder):
        self.bin, self.words, self.folder = binaries, words, folder
        folder.mkdir(parents=True, exist_ok=True)

    def draw(self, options, name, form="exr"):
        """The stats record of a picture, NAME.FORM."""
        stats = self.folder / "picture.json"
        subprocess.run([f"{self.bin}/curv-tricubic", *self.words, "-o", str(self.folder / f"{name}.{form}"), "--stats", str(stats),
                        "--quiet", *shlex.split(options)], check=True)
        return json.loads(stats.read_text())

    def error(self, name, truth):
        """(RMSE, largest difference), linear colours 0 to 1."""
        done = subprocess.run([f"{self.bin}/img-compare", self.folder / f"{name}.exr", self.folder / f"{truth}.exr", "--json",
                               "--metric", "mse_byte,max"], capture_output=True, text=True)
        figures = json.loads(done.stdout)["all"]
        return figures["mse_byte"] ** 0.5 / 255, figures["max"]


def words_of(grid, name, binaries, folder):
    """The command's words that name the grid, made where it is a phantom."""
    if "source" in grid:
        entry = yaml.safe_load((sweep.ROOT / "configs/data.yaml").read_text())["grids"][grid["source"]]
        solution = sweep.locate({"file": entry["solution"]})
        words = [sweep.locate(entry), "--plot3d", "auto", "--solution", solution]
    else:
        path = folder / "grid.vts"
        subprocess.run([f"{binaries}/vol-phantom", *shlex.split(grid["make"]), "-o", path], check=True)
        words = [str(path)]
    return [*words, *shlex.split(grid.get("options", "")), "--view", grid["view"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("grid")
    parser.add_argument("--bin", required=True)
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, folder = settings["sweep"], pathlib.Path(settings["out"]) / "pictures" / arguments.grid
    folder.mkdir(parents=True, exist_ok=True)
    grid = asked["grids"][arguments.grid]
    drawer = Drawer(arguments.bin, [*words_of(grid, arguments.grid, arguments.bin, folder), "--size", asked["size"]], folder)
    found, truths = {}, {}
    for name, setting in asked["settings"].items():
        options, throttle = setting.get("options", ""), setting.get("throttle", 1)
        if options not in truths:
            truths[options] = f"finest-{len(truths)}"
            drawer.draw(f"{options} --throttle {asked['finest']}", truths[options])
        stats = drawer.draw(f"{options} --throttle {throttle}", name)
        rmse, largest = drawer.error(name, truths[options])
        found[name] = {"counts": stats["counts"], "rmse": rmse, "max": largest, "finest": truths[options]}
        if name in asked["pictures"]:
            drawer.draw(f"{options} --throttle {throttle}", name, "png")
    contenders = {name: lambda s=s, n=name: drawer.draw(f"{s.get('options', '')} --throttle {s.get('throttle', 1)}", n)["time_s"]["compute"]
                  for name, s in asked["settings"].items()}
    times = rounds.interleaved(contenders, asked["rounds"])
    for name in found:
        found[name]["seconds"] = statistics.median(times[name])
    ratio = rounds.ratio(times["tricubic"], times["trilinear"])
    rounds.say(f"{arguments.grid}: {len(found)} pictures")
    pathlib.Path(arguments.output).write_text(json.dumps({"grid": arguments.grid, "folder": str(folder), "drawn": found, "ratio": ratio}, indent=1))


if __name__ == "__main__":
    main()
