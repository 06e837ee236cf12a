#!/usr/bin/python3
"""One data set and one kind of picture of `renderers`: every setting once, for its error and a rough time."""

import itertools
import json
import pathlib
import shlex
import statistics
import subprocess

import blobs
import convergence
import fourier_truth
import pareto
import records
import rounds
import sweep

NO_DEVICE = 3  # exit status


def settings_of(family):
    """Every setting of a family, one list a ladder, from coarse to fine: the values of its words."""
    fixed = family.get("with", {})
    (rung, values), = family["ladder"].items()
    for chosen in itertools.product(*fixed.values()):
        yield [dict(zip(fixed, map(str, chosen))) | {rung: str(value)} for value in values]


def shown(family, values):
    """What the tables call a setting: the options of its command that do not name files, and what was prepared for it."""
    words, given = shlex.split(family["draw"])[1:], []
    for number, word in enumerate(words):
        file = number + 1 < len(words) and is_file(words[number + 1], values)
        if not file and not is_file(word, values):
            given.append(word.format(**values))
    return " ".join(given + [f"({name} {value})" for name, value in values.items() if f"{{{name}}}" not in family["draw"]])


def is_file(word, values):
    return word.startswith("{") and word[1:-1] not in values


class Gallery:
    """One data set and one kind of picture: files, truths, and pictures by any setting."""

    def __init__(self, binaries, settings, dataset, picture):
        self.bin, self.asked, self.dataset = binaries, settings["sweep"], settings["sweep"]["datasets"][dataset]
        self.picture, self.name = self.asked["pictures"][picture], dataset
        self.volumes = pathlib.Path(settings["out"]) / "volumes"
        self.folder = pathlib.Path(settings["out"]) / "pictures" / dataset / picture
        self.folder.mkdir(parents=True, exist_ok=True)
        self.is_xray = picture == "xray"
        self.size = self.dataset.get("size", self.asked["size"])
        self.targets = self.picture.get("targets", self.asked["targets"])
        invisible = self.folder / "invisible.yaml"
        invisible.write_text("colours: [[0, 0, 0, 0], [1, 0, 0, 0]]\nopacity: [[0, 0], [1, 0]]\n")
        self.words = {"volume": self.volumes / f"{dataset}.nrrd", "grid": self.volumes / f"{dataset}.vts", "invisible": invisible,
                      **{name: self.dataset[name] for name in ("scene", "shaded", "isovalue")}}
        self.made = {}
        self.owns = {}

    def run(self, command, output, options=()):
        """The stats record of a tool's command, or None where there is no device, or no tool for it was built."""
        stats = self.folder / "stats.json"
        words = [*shlex.split(command), "-o", str(output), "--stats", str(stats), "--quiet", *map(str, options)]
        if words[0].endswith("-gpu") and not pathlib.Path(self.bin, words[0]).exists():
            return None
        done = subprocess.run([f"{self.bin}/{words[0]}", *words[1:]], capture_output=True, text=True)
        if done.returncode == NO_DEVICE:
            return None
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.stderr}")
        return json.loads(stats.read_text())

    def draw(self, family, values, output, repeat=1):
        """(record of the picture or None where there is no device, records of what was prepared for it)."""
        words = self.words | values
        prepared = []
        words["volume"] = self.reduced(int(values.get("reduce", 1)))
        for name, step in family.get("prepare", {}).items():
            words[name], record = self.prepare(step["by"].format(**words), step["makes"])
            prepared.append(record)
        return self.run(family["draw"].format(**words), output, [*self.camera(), "--repeat", repeat]), prepared

    def camera(self):
        return [*shlex.split(self.dataset["camera"]), "--size", self.size]

    def reduced(self, share):
        """The volume with so many times fewer samples along every axis, over the same box."""
        if share == 1:
            return self.words["volume"]
        path = self.folder / f"reduced-{share}.nrrd"
        if not path.exists():
            dims = json.loads(subprocess.run([f"{self.bin}/vol-info", self.words["volume"], "--json"], check=True, capture_output=True,
                                             text=True).stdout)["dims"]
            coarse = "x".join(str(-(-n // share)) for n in dims)
            self.run(f"vol-convert {self.words['volume']} --resample {coarse}", path)
        return path

    def prepare(self, command, ending):
        """(file, record) of what is made once a volume. It stays until forget(): spectra of large volumes are large."""
        path = self.folder / f"made-{len(self.made)}.{ending}"
        if command not in self.made:
            self.made[command] = (path, self.run(command, path))
        return self.made[command]

    def forget(self):
        for path, _ in self.made.values():
            path.unlink(missing_ok=True)
        self.made.clear()

    def truth(self):
        path = self.folder / "truth.exr"
        command = self.picture["truth"].format(**self.words)
        if "edge" in self.dataset and self.is_xray:
            self.closed_form(path)
        elif "edge" in self.dataset:  # from denser samples
            dense = command.replace(f"{self.name}.nrrd", f"{self.name}-dense.nrrd")
            self.run(f"{dense} --reconstruction b-spline", path, self.camera())
        else:
            self.run(command, path, self.camera())
        return path

    def closed_form(self, path):
        scene = sweep.yaml.safe_load((sweep.ROOT / self.dataset["scene"]).read_text())["camera"]
        view, width = f"{scene['azimuth']},{scene['elevation']}", float(self.dataset["camera"].split()[-1])
        right, down = fourier_truth.axes(view)
        size = int(self.size.split("x")[0])
        picture = blobs.xray(self.dataset["edge"], right, down, width, size)
        convergence.write_exr(path, dict.fromkeys("RGB", picture))

    def own(self, family):
        """The exact picture of what a family means; None where that is not said, or is the truth."""
        if "own" not in family or ("edge" not in self.dataset and family["own"]["draw"] == self.picture["truth"]):
            return None
        key = json.dumps(family["own"])
        if key not in self.owns:
            self.owns[key] = self.folder / f"own-{len(self.owns)}.exr"
            self.draw(family["own"], {}, self.owns[key])
            self.forget()
        return self.owns[key]

    def error(self, picture, truth):
        """(RMSE, largest) on the byte scale; of X-rays relative to the truth's brightest pixel."""
        done = subprocess.run([f"{self.bin}/img-compare", picture, truth, "--json", "--metric", "rmse_byte,max,mse", "--background", "0",
                               *(["--peak", "truth"] if self.is_xray else [])], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"img-compare {picture} {truth}: {done.stderr}")
        figures = json.loads(done.stdout)["all"]
        rmse = figures["mse"] ** 0.5
        return figures["rmse_byte"], figures["max"] * (figures["rmse_byte"] / rmse if rmse else 255)


def seconds(record):
    """The fastest of a setting's runs in one process, and what went before the first picture."""
    times = record["time_s"]
    drawn = times["phases"]["render"]
    return min(drawn), times["compute"] - statistics.median(drawn) + drawn[0] - min(drawn)


def costs(drawn, prepared):
    """once: seconds of what is made once a volume, and its memory."""
    render, set_up = seconds(drawn)
    return {"seconds": render, "bytes": drawn["peak_rss_bytes"], "once": set_up + sum(record["time_s"]["compute"] for record in prepared),
            "once_bytes": max((record["peak_rss_bytes"] for record in prepared), default=None)}


def accuracy(gallery, log):
    """Every setting once; a ladder ends where finer settings answer no question."""
    asked, truth, rows = gallery.asked, gallery.truth(), []
    whole = gallery.dataset.get("check")  # which settings there are must not depend on the machine
    for name, family in pareto.families(gallery.picture):
        if gallery.name not in family.get("only", [gallery.name]):
            continue
        own = gallery.own(family)
        for ladder in settings_of(family):
            for values in ladder:
                picture = gallery.folder / "picture.exr"
                drawn, prepared = gallery.draw(family, values, picture, 1 if whole else asked["repeats"])
                if drawn is None:
                    break
                rmse, largest = gallery.error(picture, truth)
                rows.append({"method": name, "setting": shown(family, values), "size": gallery.size, "rmse": rmse, "largest": largest, "family": family, "values": values,
                             "own": gallery.error(picture, own)[0] if own else None, **costs(drawn, prepared), "host": drawn["host"]})
                if not whole and (rmse <= gallery.targets[-1] or rows[-1]["seconds"] > asked["limit_s"]):
                    break
            gallery.forget()
        log(f"{name}: {sum(r['method'] == name for r in rows)} settings")
    return rows


def main():
    arguments = records.tool_arguments(__doc__, "settings", "dataset", "picture")
    gallery = Gallery(arguments.bin, records.load(arguments.settings), arguments.dataset, arguments.picture)
    found = accuracy(gallery, lambda text: rounds.say(f"{arguments.dataset}, {arguments.picture}: {text}"))
    pathlib.Path(arguments.output).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
