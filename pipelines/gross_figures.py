#!/usr/bin/python3
"""Surfaces of fields that wavelet coefficients stand for, after figures 5 to 13 of Gross et al. 1995: one picture with
its figures, the table of all, or the sheets.

    gross_figures.py SETTINGS volume DATASET | truth NAME | picture NAME | table all | sheets all --bin FOLDER -o FILE"""

import csv
import dataclasses
import json
import pathlib
import subprocess
import tempfile

import numpy

import isosurface
import records

WHAT = """\
Of every picture: the wavelet, the levels and the number of coefficients kept; the error of the volume that they stand for,
as vol-dwt foretold it (the norm of what was dropped over that of all, Gross et al. (25); of the CT head, whose 93 slices are
extended to 96, a bound) and as measured on the volume rebuilt;
the RMSE of the picture, colours 0 to 1, against the truth: the same surface of all coefficients, in the same way. *coefficients*:
rays in wavelet space, guaranteed by Bernstein bounds, of the continuous expansion; evaluations are of f and its
derivative, a ray. *marching cubes*: the volume rebuilt, its mesh drawn; seconds are of all three steps. *hull*: the
volume rebuilt, its surface with the translucent medium around it. The expansion is of the samples as they are
(c0 = voxels), so that coefficients and marching cubes are two fields, alike where the data are smooth. The paper's bust (Johann Strauss
by a laser scanner) is not public: here it is the phantom's of the same size, made binary as theirs was; of how many levels figure 6 is, the
paper does not say: here 3. Figure 12 has all detail in the upper half, and below the 300 most significant; an untruncated
battle-lemarie filter reaches everywhere, so it is cut to 29 taps there, as the paper's is.
"""
HULL = [[0, 0], [0.05, 0], [0.5, 0.08], [0.51, 0]]  # below the isovalue of figure 6, a bluish medium
FIELDS = ["figure", "dataset", "wavelet", "levels", "kept", "isovalue", "method", "coefficients", "predicted", "volume_error",
          "picture_rmse", "evaluations_a_ray", "seconds"]


@dataclasses.dataclass(frozen=True)
class Picture:
    figure: str
    dataset: str
    wavelet: str
    levels: int
    kept: str
    isovalue: str
    method: str
    region: str = ""

    @property
    def truth(self):
        """The same surface of all coefficients: that of the samples, in whatever levels they are written."""
        return dataclasses.replace(self, levels=0, kept="all", region="")

    @property
    def name(self):
        parts = [self.dataset, self.wavelet, self.levels, self.kept, self.isovalue, self.method.replace(" ", "-"),
                 "region" if self.region else ""]
        return "_".join(str(part) for part in parts if part != "")


def dataset_of(name):
    return name.split("_")[0]


def file_name(figure):
    return "figure-" + figure.replace(",", "").replace(" ", "-").lower()


def figures(swept, datasets):
    chosen = swept.get("only_figures", list(swept["figures"]))
    return [name for name in chosen if swept["figures"][name]["dataset"] in datasets]


def pictures(swept, figure):
    """Those of a figure, line by line of its sheet."""
    entry = swept["figures"][figure]
    found = []
    for wavelet in entry["wavelets"]:
        if wavelet not in swept.get("only_wavelets", [wavelet]):
            continue
        filters = entry["filters_of"][wavelet] if "filters_of" in entry else entry["filters"]
        for method in entry["methods"]:
            for levels, kept in filters:
                if kept not in swept.get("only_kept", [kept]):
                    continue
                for isovalue in entry["isovalues"]:
                    found.append(Picture(figure, entry["dataset"], wavelet, levels, str(kept), str(isovalue), method, entry.get("region", "")))
    return found


def voxelised(swept, name, tool):
    """Binary volumes, [z, y, x]."""
    if name == "blocks":
        voxels = numpy.zeros((16, 16, 16), dtype="f4")
        voxels[3:13, 3:6, 3:13] = 1
        voxels[4:9, 6:12, 5:10] = 1
        voxels[9:11, 6:9, 10:12] = 1
        return voxels
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "bust.nrrd"
        command = swept["bust"]["make"].split()
        subprocess.run([f"{tool}/{command[0]}", *command[1:], "-o", path, "--quiet"], check=True)
        return (isosurface.read_nrrd(path) >= swept["bust"]["inside"]).astype("f4")


class Maker:
    """Makes pictures in a folder of its own."""

    def __init__(self, settings, tools, folder):
        self.swept, self.out = settings["sweep"], pathlib.Path(settings["out"])
        self.tools, self.folder = tools, pathlib.Path(folder)

    def run(self, tool, *options):
        stats = self.folder / "stats.json"
        subprocess.run([f"{self.tools}/{tool}", *map(str, options), "--stats", stats, "--quiet"], check=True)
        return records.load(stats)

    def coefficients(self, picture, levels, kept):
        """The file, and the stats of making it."""
        path = self.folder / "coefficients.vdb"
        options = ["--wavelet", picture.wavelet, "--levels", levels]
        if kept != "all":
            options += ["--keep", kept]
            if picture.region:
                options += ["--region", picture.region]
        return path, self.run("vol-dwt", self.out / "volumes" / f"{picture.dataset}.nrrd", "-o", path, *options)

    def scene(self, picture, opacity):
        """What every renderer is told of a picture: options, and a scene with a transfer function of that opacity."""
        view, path = self.swept["views"][picture.dataset], self.folder / "scene.yaml"
        path.write_text(json.dumps({"camera": view["camera"], "shading": True, "reference_length": 1,
                                    "transfer": {"colours": [[0, 0.25, 0.5, 1]], "opacity": opacity}}))
        return ["--scene", path, "--size", view["size"]]

    def draw(self, picture, file, image):
        """Draws the surface of a file of coefficients: (seconds, evaluations a ray or None, the volume rebuilt or None)."""
        scene = self.scene(picture, HULL if picture.method == "hull" else [[0, 0]])
        if picture.method == "coefficients":
            stats = self.run("isosurf-ray", file, "-o", image, "--isovalue", picture.isovalue, *scene)
            return sum(stats["time_s"]["phases"]["render"]), stats["counts"]["evaluations"] / max(1, stats["counts"]["rays"]), None
        volume, mesh = self.folder / "volume.nrrd", self.folder / "mesh.ply"
        seconds = self.run("vol-dwt", file, "--inverse", "-o", volume)["time_s"]["compute"]
        if picture.method == "hull":
            stats = self.run("vol-raycast", volume, "--isovalue", picture.isovalue, "-o", image, *scene)
        else:
            seconds += self.run("isosurf-mc", volume, "--isovalue", picture.isovalue, "-o", mesh)["time_s"]["compute"]
            stats = self.run("vol-raycast", volume, "--mesh", mesh, "-o", image, *scene)
        return seconds + stats["time_s"]["compute"], None, volume

    def make_truth(self, picture, image):
        self.draw(picture, self.coefficients(picture, 0, "all")[0], image)

    def make(self, picture, png):
        """Draws the picture; its line of the table."""
        row = {key: getattr(picture, key) for key in ("dataset", "wavelet", "levels", "kept", "isovalue", "method")}
        image, truth = self.folder / "image.exr", self.out / "truth" / f"{picture.truth.name}.exr"
        file, stats = self.coefficients(picture, picture.levels, picture.kept)
        row["coefficients"] = stats["counts"]["coefficients_kept"]
        row["predicted"] = stats["error"].get("l2", stats["error"].get("l2_bound", 0)) / stats["result"]["l2_norm"]
        row["seconds"], row["evaluations_a_ray"], volume = self.draw(picture, file, image)
        if volume is None:
            volume = self.folder / "volume.nrrd"
            self.run("vol-dwt", file, "--inverse", "-o", volume)
        row["volume_error"] = self.compare("vol-compare", volume, self.out / "volumes" / f"{picture.dataset}.nrrd")["relative_l2"]
        row["picture_rmse"] = self.compare("img-compare", image, truth)["all"]["rmse"]
        self.show(image, png)
        return row

    def compare(self, tool, one, other):
        done = subprocess.run([f"{self.tools}/{tool}", one, other, "--json"], capture_output=True, text=True, check=True)
        return json.loads(done.stdout)

    def show(self, image, png):
        subprocess.run(["oiiotool", image, "--ch", "R,G,B", "--clamp:min=0:max=1", "--powc", "0.4545", "-d", "uint8", "-o", png],
                       check=True, stdout=subprocess.DEVNULL)


def all_rows(settings):
    for figure in figures(settings["sweep"], settings["datasets"]):
        for picture in pictures(settings["sweep"], figure):
            row = records.load(pathlib.Path(settings["out"]) / "pictures" / f"{picture.name}.json")
            yield picture, {"figure": figure, **row}


def shown(row, key):
    value = row[key]
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.3g}"
    return str(value)


def write_table(settings, path):
    rows = [row for _, row in all_rows(settings)]
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: f"{row[key]:.6g}" if isinstance(row[key], float) else row[key] for key in FIELDS} for row in rows)
    text = "# Surfaces from wavelet coefficients\n\n" + WHAT
    for figure in dict.fromkeys(row["figure"] for row in rows):
        keys = FIELDS[1:]
        text += f"\n## Figure{'s' if ' ' in figure else ''} {figure}\n\n| {' | '.join(key.replace('_', ' ') for key in keys)} |\n|{' --- |' * len(keys)}\n"
        for row in rows:
            if row["figure"] == figure:
                text += "| " + " | ".join(shown(row, key) for key in keys) + " |\n"
    path.with_suffix(".md").write_text(text)


def levels(picture):
    return "not transformed" if picture.levels == 0 else f"{picture.levels} level{'s'[:picture.levels > 1]}"


def write_sheets(settings, folder):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    sheets = {}
    for picture, row in all_rows(settings):
        sheets.setdefault(picture.figure, {}).setdefault((picture.wavelet, picture.method), []).append((picture, row))
    for figure, lines in sheets.items():
        if len(lines) > 1 and all(len(line) == 1 for line in lines.values()):  # one line of single pictures
            lines = {"": [one for line in lines.values() for one in line]}
        across = max(len(line) for line in lines.values())
        drawn, grid = plt.subplots(len(lines), across, figsize=(2.2 * across, 2.6 * len(lines)), squeeze=False,
                                   constrained_layout=True)
        for axes in grid.flat:
            axes.axis("off")
        for j, line in enumerate(lines.values()):
            for i, (picture, row) in enumerate(line):
                grid[j, i].imshow(plt.imread(pathlib.Path(settings["out"]) / "pictures" / f"{picture.name}.png"))
                grid[j, i].set_title(f"{picture.wavelet}, {picture.method}\n{row['coefficients']} coefficients, {levels(picture)}\n"
                                     f"isovalue {picture.isovalue}, RMSE {row['picture_rmse']:.2g}", fontsize=5.5, pad=2)
        drawn.savefig(folder / f"{file_name(figure)}.png", dpi=130, bbox_inches="tight", metadata={"Software": None})
        plt.close(drawn)


def main():
    arguments = records.tool_arguments(__doc__, "settings", "what", "name")
    settings, output = records.load(arguments.settings), pathlib.Path(arguments.output)
    if arguments.what == "volume":
        isosurface.write_nrrd(output, voxelised(settings["sweep"], arguments.name, arguments.bin))
    elif arguments.what == "picture":
        picture = next(p for f in settings["sweep"]["figures"] for p in pictures(settings["sweep"], f) if p.name == arguments.name)
        with tempfile.TemporaryDirectory() as folder:
            row = Maker(settings, arguments.bin, folder).make(picture, output.with_suffix(".png"))
        output.write_text(json.dumps(row, indent=1) + "\n")
    elif arguments.what == "truth":
        picture = next(p.truth for f in settings["sweep"]["figures"] for p in pictures(settings["sweep"], f) if p.truth.name == arguments.name)
        with tempfile.TemporaryDirectory() as folder:
            Maker(settings, arguments.bin, folder).make_truth(picture, output)
    elif arguments.what == "table":
        write_table(settings, output)
    else:
        write_sheets(settings, output.parent)


if __name__ == "__main__":
    main()
