#!/usr/bin/python3
"""One curvilinear grid by every setting of the sweep: counts and errors at every size; or, the first word being `times`, times
interleaved at the first."""

import json
import pathlib
import re
import shlex
import subprocess

import yaml

import records
import rounds
import sweep


class Drawer:
    """curv-tricubic on one grid at one size."""

    def __init__(self, binaries, words, size, folder):
        self.bin, self.words, self.size, self.folder = binaries, words, size, folder
        self.truths = {}  # options: name of the picture
        folder.mkdir(parents=True, exist_ok=True)

    def draw(self, options, name, form="exr", repeat=1):
        """The stats record of a picture, NAME.FORM."""
        stats = self.folder / "picture.json"
        words = [f"{self.bin}/curv-tricubic", *self.words, "--size", self.size, "-o", self.folder / f"{name}.{form}", "--stats", stats,
                 "--repeat", repeat, "--quiet", *shlex.split(options)]
        subprocess.run([str(word) for word in words], check=True)
        return json.loads(stats.read_text())

    def seconds(self, options, repeat=2):
        """The fastest of some runs in one process: the first also pays for memory that is touched for the first time."""
        return min(self.draw(options, "timed", repeat=repeat)["time_s"]["phases"]["render"])

    def compare(self, picture, truth):
        """(RMSE, largest difference), linear colours 0 to 1."""
        done = subprocess.run([f"{self.bin}/img-compare", picture, truth, "--json", "--metric", "mse_byte,max"], check=True,
                              capture_output=True, text=True)
        figures = json.loads(done.stdout)["all"]
        return figures["mse_byte"] ** 0.5 / 255, figures["max"]

    def error(self, name, options, asked):
        """Against rays where the thickness is physical, else against the finest throttle."""
        truth = rays(options, asked) if "physical" in options else f"{options} --throttle {asked['finest']}"
        if truth not in self.truths:
            self.truths[truth] = f"truth-{len(self.truths)}"
            self.draw(truth, self.truths[truth])
        return self.compare(self.folder / f"{name}.exr", self.folder / f"{self.truths[truth]}.exr")


def rays(options, asked):
    """The same picture by rays, which have no order."""
    kept = re.sub(r"--order depth|--max-error \S+", "", options).strip()
    return f"{kept} --method rays --tolerance {asked['tolerance']}"


def spelled(setting):
    options = setting.get("options", "")
    return options if "--max-error" in options else f"{options} --throttle {setting.get('throttle', 1)}"


def words_of(grid, binaries, folder):
    """The command's words that name the grid, made where it is a phantom."""
    if "source" in grid:
        entry = yaml.safe_load((sweep.ROOT / "configs/data.yaml").read_text())["grids"][grid["source"]]
        words = [sweep.locate(entry), "--plot3d", "auto", "--solution", sweep.locate({"file": entry["solution"]})]
    else:
        path = folder / "grid.vts"
        subprocess.run([f"{binaries}/vol-phantom", *shlex.split(grid["make"]), "-o", path], check=True)
        words = [str(path)]
    return [*words, *shlex.split(grid.get("options", "")), "--view", grid["view"]]


def pictures(asked, grid, words, binaries, folder):
    found = {"grid": grid, "folder": str(folder / asked["sizes"][0]), "drawn": []}
    for size in asked["sizes"]:
        drawer = Drawer(binaries, words, size, folder / size)
        for name, setting in asked["settings"].items():
            stats = drawer.draw(spelled(setting), name)
            rmse, largest = drawer.error(name, setting.get("options", ""), asked)
            found["drawn"].append({"size": size, "setting": name, "counts": stats["counts"], "rmse": rmse, "max": largest})
    drawer = Drawer(binaries, words, asked["sizes"][0], folder / asked["sizes"][0])
    for name in asked["pictures"]:
        drawer.draw(rays("", asked) if name == "rays" else spelled(asked["settings"][name]), name, "png")
    rounds.say(f"{grid}: {len(found['drawn'])} pictures")
    return found


def times(asked, grid, words, binaries, folder):
    drawer = Drawer(binaries, words, asked["sizes"][0], folder / "times")
    contenders = {name: lambda s=spelled(s): drawer.seconds(s) for name, s in asked["settings"].items()}
    found = {"grid": grid, "seconds": rounds.interleaved(contenders, asked["rounds"])}
    for name, options in {"rays": "", "rays trilinear": "--cells trilinear"}.items():
        found["seconds"][name] = [drawer.seconds(rays(options, asked), 1)]
    rounds.say(f"{grid}: times")
    return found


def main():
    arguments = records.tool_arguments(__doc__, "what", "settings", "grid")
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, folder = settings["sweep"], pathlib.Path(settings["out"]) / "pictures" / arguments.grid
    folder.mkdir(parents=True, exist_ok=True)
    words = words_of(asked["grids"][arguments.grid], arguments.bin, folder)
    find = times if arguments.what == "times" else pictures
    pathlib.Path(arguments.output).write_text(json.dumps(find(asked, arguments.grid, words, arguments.bin, folder), indent=1))


if __name__ == "__main__":
    main()
