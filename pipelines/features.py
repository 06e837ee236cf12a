#!/usr/bin/python3
"""Segmentation in wavelet space: agreement of labels with the truth on the phantom of textures; a sheet of slices, feature maps,
labels and rendered labels of every volume at hand; splats of several supports and thresholds."""

import argparse
import json
import pathlib
import shlex
import subprocess
import tempfile

import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.colors import ListedColormap  # noqa: E402

import isosurface  # noqa: E402
import rounds  # noqa: E402
import sweep  # noqa: E402

LOOKS = sweep.ROOT / "configs/transfer/labels.yaml"
COLOURS = ListedColormap(["#999999", "#e65933", "#408cd9", "#f2cc40", "#59bf66", "#b373cc", "#59cccc", "#f299b3"])  # of LOOKS


class Tools:
    def __init__(self, binaries, folder):
        self.binaries, self.folder = pathlib.Path(binaries).resolve(), pathlib.Path(folder)

    def run(self, command):
        """Stats record of a tool's run, in the folder."""
        words = shlex.split(command)
        subprocess.run([self.binaries / words[0], *words[1:], "--quiet", "--stats", "stats.json"], check=True, cwd=self.folder)
        return json.loads((self.folder / "stats.json").read_text())


def runs(asked):
    """The base, every wavelet with every share that is kept, then every other value by itself; none twice."""
    base = asked["base"]
    listed = [dict(base)]
    listed += [{**base, "wavelet": wavelet, "keep": keep} for keep in asked["wavelet_keeps"] for wavelet in asked["wavelets"]]
    listed += [{**base, key: value} for key, values in asked["sweep"].items() for value in values]
    return [run for n, run in enumerate(listed) if run not in listed[:n]]


def agreement(asked, tools):
    """One dict a run: adjusted Rand index and seconds of every seed."""
    edge = asked["edge"]
    for seed in asked["seeds"]:
        tools.run(f"vol-phantom texture --dims {edge} --seed {seed} -o {seed}.nrrd --labels-output {seed}.truth.nrrd")

    def measured(run):
        kept = "" if run["keep"] == 1 else f"--keep {int(run['keep'] * edge**3)}"
        found, seconds, topographic = [], [], []
        for seed in asked["seeds"]:
            tools.run(f"vol-dwt {seed}.nrrd -o c.vdb --wavelet {run['wavelet']} --levels {run['levels']} {kept}")
            stats = tools.run(f"vol-segment c.vdb -o labels.nrrd --classes 4 --truth {seed}.truth.nrrd {run['options']}")
            found.append(stats["result"]["adjusted_rand_index"])
            seconds.append(stats["time_s"]["compute"])
            topographic.append(stats["result"].get("topographic_error"))
        rounds.say(f"{run['wavelet']}, levels {run['levels']}, kept {run['keep']} {run['options']}: {min(found):.3f}")
        return {**run, "agreement": found, "seconds": seconds, "topographic_error": topographic}

    rows = [measured(run) for run in runs(asked)]
    return rows + [measured({"wavelet": "haar", "levels": 0, "keep": 1, "options": asked["intensities"]})]


def feature_maps(path, voxels):
    """{name: [z, y, x]} of the file of features, mapped and not read."""
    with open(path, "rb") as file:
        head = file.read(1 << 16)
    end = head.index(b"\n\n") + 2
    fields = dict(line.split(":=", 1) for line in head[:end].decode().splitlines() if ":=" in line)
    names = fields["precis.features.names"].split()
    values = numpy.memmap(path, dtype="<f4", mode="r", offset=end, shape=(*voxels.shape, len(names)))
    return {name: values[..., n] for n, name in enumerate(names)}


def bare(axes, title):
    axes.set_title(title, fontsize=7, pad=3)
    axes.set_xticks([])
    axes.set_yticks([])


def details(maps, level):
    """Amplitude of all of a level's subbands together."""
    return sum(numpy.square(m, dtype="f8") for name, m in maps.items() if name.startswith(f"level{level}.") and "H" in name) ** 0.5


def labels(settings, tools, path):
    asked, out, datasets = settings["sweep"], settings["out"], settings["datasets"]
    base = asked["base"]
    figure, grid = plt.subplots(len(datasets), 6, figsize=(12, 2.2 * len(datasets)), squeeze=False)
    for line, dataset in zip(grid, datasets):
        entry = asked["datasets"][dataset]
        volume = (sweep.ROOT / sweep.volume(dataset, out)).resolve()
        tools.run(f"vol-dwt {volume} -o c.vdb --wavelet {base['wavelet']} --levels {base['levels']}")
        tools.run(f"vol-segment c.vdb -o labels.nrrd --features-output features.nrrd --classes {entry['labels']} {base['options']}")
        draw = entry["draw"].replace("configs/", f"{sweep.ROOT}/configs/")
        tools.run(f"vol-raycast {volume} --labels labels.nrrd -o picture.png --size {asked['picture']} {draw}")
        voxels, found = isosurface.read_nrrd(volume), isosurface.read_nrrd(tools.folder / "labels.nrrd")
        middle = len(voxels) // 2
        maps = {name: m[middle] for name, m in feature_maps(tools.folder / "features.nrrd", voxels).items()}
        shown = [(f"{dataset}: slice of the values", voxels[middle], "gray")]
        shown += [(f"local amplitude, level {level}", details(maps, level), "magma") for level in (1, 2, 3)]
        for axes, (title, picture, colour) in zip(line, shown):
            axes.imshow(picture, cmap=colour, origin="lower")
            bare(axes, title)
        line[4].imshow(found[middle], cmap=COLOURS, vmin=-0.5, vmax=7.5, interpolation="nearest", origin="lower")
        bare(line[4], f"{entry['labels']} labels")
        line[5].imshow(plt.imread(tools.folder / "picture.png"))
        bare(line[5], "vol-raycast --labels")
        rounds.say(f"{dataset}: labels and picture")
    figure.tight_layout(pad=0.3)
    figure.savefig(path, dpi=110, metadata={"Software": None})


def splats(asked, tools, path):
    wanted = asked["splats"]
    tools.run(wanted["make"].format(out="volume.nrrd"))
    tools.run("vol-dwt volume.nrrd -o c.vdb --levels 0")
    tools.run(f"vol-segment c.vdb -o labels.nrrd {wanted['segment']}")
    supports, thresholds = wanted["supports"], wanted["thresholds"]
    figure, grid = plt.subplots(len(supports), len(thresholds), figsize=(2.1 * len(thresholds), 2.3 * len(supports)), squeeze=False)
    (tools.folder / "clear.yaml").write_text(
        "space: srgb\nlabels:\n" + "".join(line for line in LOOKS.read_text().splitlines(True) if line.startswith("  - [") and "[0," not in line))
    for line, support in zip(grid, supports):
        for axes, threshold in zip(line, thresholds):
            tools.run(f"vol-raycast volume.nrrd --labels labels.nrrd --label-transfer clear.yaml --splat {wanted['labels']} --splat-support {support}"
                              f" --splat-threshold {threshold} -o picture.png --size {wanted['size']} --view 30,20")
            axes.imshow(plt.imread(tools.folder / "picture.png"))
            bare(axes, f"support {support}, threshold {threshold}")
        rounds.say(f"splats of support {support}")
    figure.tight_layout(pad=0.3)
    figure.savefig(path, dpi=110, metadata={"Software": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("part", choices=["agreement", "labels", "splats"])
    parser.add_argument("--bin", required=True)
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    with tempfile.TemporaryDirectory() as folder:
        tools = Tools(arguments.bin, folder)
        if arguments.part == "agreement":
            pathlib.Path(arguments.output).write_text(json.dumps(agreement(settings["sweep"], tools), indent=1))
        elif arguments.part == "labels":
            labels(settings, tools, arguments.output)
        else:
            splats(settings["sweep"], tools, arguments.output)


if __name__ == "__main__":
    main()
