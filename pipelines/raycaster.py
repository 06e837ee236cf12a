"""Runs vol-raycast and img-compare on one data set and scene: a picture's time, its samples and its error."""

import json
import shlex
import subprocess

import sweep


def known_options(binaries):
    return subprocess.run([f"{binaries}/vol-raycast", "--help"], check=True, capture_output=True, text=True).stdout


class Raycaster:
    def __init__(self, binaries, volume, scene, size, truth, folder):
        self.bin, self.volume, self.scene, self.size, self.truth, self.folder = binaries, volume, scene, size, truth, folder
        self.folder.mkdir(parents=True, exist_ok=True)

    def index(self, coefficients, options, name):
        """Builds an index; \\returns its path and the seconds that took."""
        path, stats = self.folder / f"{name}.nrrd", self.folder / "index.json"
        subprocess.run([f"{self.bin}/vol-index", coefficients, "-o", path, "--stats", stats, "--quiet", *shlex.split(options)],
                       check=True)
        return path, json.loads(stats.read_text())["time_s"]["compute"]

    def render(self, options, threads=0, repeat=1):
        """The stats record of a picture, or None where the tool said that it cannot (status 2)."""
        stats = self.folder / "picture.json"
        command = [f"{self.bin}/vol-raycast", self.volume, "-o", self.folder / "picture.exr", "--scene", self.scene, "--size",
                   self.size, "--threads", threads, "--repeat", repeat, "--stats", stats, "--quiet", *shlex.split(options)]
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode != 2 or "--max-error:" not in done.stderr:
            done.check_returncode()
        if done.returncode:  # the one answer that is no fault: this bound cannot be kept
            print(f"{options}: {done.stderr.strip()}", flush=True)
            return None
        return json.loads(stats.read_text())

    def error(self, picture=None):
        """(MSE on the byte scale, largest absolute difference 0..1) of the last picture, or of another file."""
        done = subprocess.run([f"{self.bin}/img-compare", picture or self.folder / "picture.exr", self.truth, "--json", "--metric",
                               "mse_byte,max"], check=True, capture_output=True, text=True)
        figures = json.loads(done.stdout)["all"]
        return figures["mse_byte"], figures["max"]

    def seconds(self, options, threads, repeat):
        """The fastest of a few runs in one process: the first also pays for memory that is touched for the first time."""
        return min(self.render(options, threads, repeat)["time_s"]["phases"]["render"])


def volume_at(settings, dataset):
    return sweep.volume(dataset, settings["out"])
