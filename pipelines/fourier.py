#!/usr/bin/python3
"""Runs of Fourier volume rendering for fourier.yaml: `errors` of one data set, or `times` of everything that is timed."""

import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy

import fourier_truth
import isosurface
import rounds
import sweep

NO_DEVICE = 3  # exit status of fvr-slice-gpu



class Tools:
    """The programs, and one folder for their files; a spectrum's is written over by the next one's."""

    def __init__(self, binaries, folder):
        self.bin, self.folder = pathlib.Path(binaries), pathlib.Path(folder)

    def run(self, tool, *arguments, status=0):
        stats = self.folder / "stats.json"
        done = subprocess.run([self.bin / tool, *map(str, arguments), "--quiet", "--stats", stats], capture_output=True, text=True)
        if done.returncode != status:
            if done.returncode == NO_DEVICE:
                return None
            raise SystemExit(f"{tool} {' '.join(map(str, arguments))}: {done.stderr}")
        return json.loads(stats.read_text())

    def resampled(self, volume, size):
        """`volume` at size^3, or at NXxNYxNZ, as unit voxels; (path, voxels)."""
        dims = size if isinstance(size, str) else f"{size}x{size}x{size}"
        path = self.folder / f"{pathlib.Path(volume).stem}-{dims}.nrrd"
        if not path.exists():
            other = self.folder / "resampled.nrrd"
            self.run("vol-convert", volume, "-o", other, "--resample", dims)
            isosurface.write_nrrd(path, isosurface.read_nrrd(other))
        return path, isosurface.read_nrrd(path)

    def spectrum(self, volume, padding=1, compensate="none", *options):
        path = self.folder / "spectrum.nrrd"
        return path, self.run("vol-fft", volume, "-o", path, "--pad", padding, "--compensate", compensate, *options)

    def pictures(self, spectrum, views, width, *options, tool="fvr-slice"):
        """[view, row, column], and the record; (None, None) where a device is missing."""
        path = self.folder / "views.nrrd"
        asked = [word for view in views for word in ("--view", view)]
        stats = self.run(tool, spectrum, "-o", path, *asked, "--size", f"{width}x{width}", "--width", width, "--wrap", *options)
        return (isosurface.read_nrrd(path), stats) if stats else (None, None)


def pixels(config, size):
    return 2 * round(config["window"] * size / 2)


# (table, filter, padding, compensated, options of vol-fft) of the paper's tables, and what else they are held against.
PAPER = [("4.1", "nearest", 1, False, ()), ("4.2", "trilinear", 1, False, ()), ("4.2", "trilinear", 1, True, ()),
         ("4.3", "catmull-rom-fast", 1, True, ()), ("4.3", "catmull-rom", 1, False, ()), ("4.3", "catmull-rom", 1, True, ()),
         ("4.4", "trilinear", 2, False, ()), ("4.4", "trilinear", 2, True, ()),
         ("beside", "es:4", 2, True, ()), ("beside", "es:6", 2, True, ())]


def settings_of_filters(config):
    for name in config["filters"]:
        for padding in config["paddings"]:
            if not name.startswith("es") and name != "catmull-rom-fast":
                yield name, padding, False
            if name != "nearest":
                yield name, padding, True


class Errors:
    """Of one data set: a row a setting, size and view."""

    def __init__(self, tools, config, dataset, volume):
        self.tools, self.config, self.dataset, self.volume = tools, config, dataset, volume
        self.rows = []

    def truths(self, path, voxels):
        """Pictures of es:12 in f64; what check() adds to the table says how far these are from the direct sum."""
        width, oblique = pixels(self.config, len(voxels)), self.config["oblique"]
        spectrum, _ = self.tools.spectrum(path, 2, "es:12", "--type", "f64")
        truth = self.tools.pictures(spectrum, [oblique], width)[0][0].astype(float)
        n = len(voxels)  # pixels that are the voxels' columns: the slice's points are points of the spectrum
        return {"oblique": (oblique, width, truth), "axis": ("0,0", n, fourier_truth.voxel_sum(voxels, n))}

    def check(self):
        path, voxels = self.tools.resampled(self.volume, self.config["truth_size"])
        view, width, picture = self.truths(path, voxels)["oblique"]
        truth = fourier_truth.direct_sum(voxels, view, width)
        self.rows.append({"table": "truth", "dataset": self.dataset, "dims": f"{len(voxels)}^3", "filter": "es:12", "padding": "2",
                          "compensated": "yes", "view": "oblique"}
                         | fourier_truth.figures(picture, truth, fourier_truth.silhouette(voxels, view, width)))

    def add(self, table, name, padding, compensated, path, voxels, truths, masks):
        compensate = name if compensated else "none"
        spectrum, made = self.tools.spectrum(path, padding, compensate)
        for which, (view, width, truth) in truths.items():
            picture = self.tools.pictures(spectrum, [view], width, "--filter", name)[0][0]
            row = {"table": table, "dataset": self.dataset, "dims": f"{len(voxels)}^3", "filter": name, "padding": f"{padding:g}",
                   "compensated": "yes" if compensated else "no", "view": which}
            self.rows.append(row | fourier_truth.figures(picture, truth, masks[which]))

    def run(self):
        self.check()
        sizes = sorted({self.config["filter_size"], *self.config["sizes"]})
        for size in sizes:
            path, voxels = self.tools.resampled(self.volume, size)
            truths = self.truths(path, voxels)
            masks = {which: fourier_truth.silhouette(voxels, view, width) for which, (view, width, _) in truths.items()}
            if size == self.config["filter_size"]:
                for name, padding, compensated in settings_of_filters(self.config):
                    self.add("filters", name, padding, compensated, path, voxels, truths, masks)
            if size in self.config["sizes"]:
                for table, name, padding, compensated, _ in PAPER:
                    self.add(table, name, padding, compensated, path, voxels, truths, masks)
            rounds.say(f"{self.dataset} at {size}^3: errors")
        return self.rows


def seconds(stats, frames):
    """A frame's: slice, inverse, and writing of the pictures too."""
    result, times = stats["result"], stats["time_s"]
    drawn = sum(times["phases"]["render"]) if "phases" in times else times["compute"]
    return {"slice": result["slice_s_per_frame"], "inverse": result["inverse_s_per_frame"],
            "read_back": result.get("read_back_s_per_frame"), "drawn": 1 / result["frames_per_second"],
            "with_writing": (drawn + times["write"]) / frames, "peak_rss_bytes": stats["peak_rss_bytes"]}


class Times:
    def __init__(self, tools, config, volume):
        self.tools, self.config, self.volume = tools, config, volume
        self.device_name = None

    def timed(self, spectrum, size, *options, tool="fvr-slice", views=None, rounds_=None):
        """Median of the rounds of every part of a frame, all views of a turn; of small pictures more, so that a run is no shorter."""
        found, count = [], views or self.config["views"] * max(1, round((256 / size) ** 2))
        for _ in range(rounds_ or self.config["rounds"]):
            stats = self.tools.run(tool, spectrum, "-o", self.tools.folder / "views.nrrd", "--view", self.config["oblique"],
                                   "--turntable", count, "--size", f"{size}x{size}", "--width", size, "--wrap", *options)
            if stats is None:
                return None
            found.append(seconds(stats, count))
        return {key: float(numpy.median([f[key] for f in found])) if found[0][key] is not None else None for key in found[0]} | \
               {"rounds": len(found)}

    def made(self, path, padding, compensate, *options):
        spectrum, stats = self.tools.spectrum(path, padding, compensate, *options)
        return spectrum, {"pre_s": stats["time_s"]["total"], "fft_s": stats["time_s"]["phases"]["transform"][0],
                          "fft_peak_rss_bytes": stats["peak_rss_bytes"]}

    def paper(self):
        rows = []
        for size in self.config["sizes"]:
            path, _ = self.tools.resampled(self.volume, size)
            for table, name, padding, compensated, options in [*PAPER, ("4.6", "trilinear", 1, False, ("--bezier", 6))]:
                spectrum, made = self.made(path, padding, name if compensated else "none", *options)
                rows.append({"table": table, "dims": f"{size}^3", "filter": name, "padding": padding, "compensated": compensated}
                            | made | self.timed(spectrum, size, "--filter", name))
            rounds.say(f"tables at {size}^3: times")
        return rows

    def filters(self):
        """Every filter and padding, for the plot of error against time: in turn, so that what disturbs the machine disturbs all alike.
        Compensation changes no frame's time: filters that can do without share a spectrum."""
        path, _ = self.tools.resampled(self.volume, self.config["filter_size"])
        size, spectra, contenders = pixels(self.config, self.config["filter_size"]), {}, {}
        for padding in self.config["paddings"]:
            for name in self.config["filters"]:
                compensate = name if name.startswith("es") or name == "catmull-rom-fast" else "none"
                if (padding, compensate) not in spectra:
                    made, _ = self.made(path, padding, compensate)
                    spectra[padding, compensate] = made.rename(made.with_name(f"spectrum-{len(spectra)}.nrrd"))
                spectrum = spectra[padding, compensate]
                contenders[name, f"{padding:g}"] = lambda spectrum=spectrum, name=name: self.timed(spectrum, size, "--filter", name, rounds_=1)["drawn"]
        times = rounds.interleaved(contenders, self.config["rounds"])
        for spectrum in spectra.values():
            spectrum.unlink()
        rounds.say("filters: times")
        return [{"filter": name, "padding": padding, "drawn": float(numpy.median(seconds))} for (name, padding), seconds in times.items()]

    def ffts(self):
        """Table 4.5: trilinear slices, the inverse by FFTW or on the device, and without the device."""
        rows = []
        for dims in [f"{s}^3" for s in self.config["sizes"][1:] or self.config["sizes"]] + [self.config["large"]]:
            size = int(dims.split("^")[0].split("x")[0])
            path, _ = self.tools.resampled(self.volume, size if "^" in dims else dims)
            spectrum, _ = self.made(path, 1, "none")
            for tool, options in [("fvr-slice", ()), ("fvr-slice-gpu", ("--ifft", "fftw")), ("fvr-slice-gpu", ("--ifft", "gpu"))]:
                on_device = tool != "fvr-slice"
                found = self.timed(spectrum, size, "--filter", "trilinear", *options, tool=tool, views=4 if on_device else None,
                                   rounds_=min(3, self.config["rounds"]))
                rows.append({"dims": dims, "by": " ".join([tool, *options])} | (found or {}))
            rounds.say(f"Table 4.5 at {dims}")
        return rows

    def growth(self):
        rows = []
        for size in self.config["growth"]:
            path = self.tools.folder / "growth.nrrd"
            self.tools.run("vol-phantom", "marschner-lobb", "-o", path, "--dims", f"{size}x{size}x{size}")
            for name in self.config["growth_filters"]:
                spectrum, made = self.made(path, 1, name if name.startswith("es") else "none")
                rows.append({"size": size, "filter": name} | made | self.timed(spectrum, size, "--filter", name))
            path.unlink()
        rounds.say("growth")
        return rows

    def rays(self):
        """Rays of several steps against their own converged integral, slices against the direct sum or es:12 in f64."""
        asked, size = self.config["rays"], self.config["rays"]["size"]
        path, voxels = self.tools.resampled(self.volume, size)
        width = pixels(self.config, size)
        oblique = self.config["oblique"]
        scene = ["--model", "xray", "--view", oblique, "--size", f"{width}x{width}", "--width", width]
        cast = self.tools.folder / "rays.exr"

        def picture(*options):
            stats = self.tools.run("vol-raycast", path, "-o", cast, *scene, *options)
            return stats

        truth = self.tools.folder / "truth.exr"
        picture("--quadrature", "reference", "--tolerance", "1e-7")
        cast.rename(truth)
        rows = []
        for step in asked["steps"]:
            stats = picture("--quadrature", "trapezoid", "--step", step, "--repeat", 5)
            figures = subprocess.run([self.tools.bin / "img-compare", cast, truth, "--peak", "truth", "--json"],
                                     capture_output=True, text=True, check=False)
            figures = json.loads(figures.stdout)
            rows.append({"by": "vol-raycast", "setting": f"--step {step}", "seconds": sweep.render_seconds(stats), "fft_s": 0,
                         "rmse": figures["all"]["rmse"], "largest": figures["all"]["max"]})
        spectrum, _ = self.tools.spectrum(path, 2, "es:12", "--type", "f64")
        exact = self.tools.pictures(spectrum, [oblique], width)[0][0].astype(float)
        for name in asked["filters"]:
            spectrum, made = self.made(path, 2, name)
            found = self.tools.pictures(spectrum, [oblique], width, "--filter", name)[0][0]
            error = found - exact
            rows.append({"by": "fvr-slice", "setting": f"{name}, padding 2", "fft_s": made["pre_s"],
                         "seconds": self.timed(spectrum, width, "--filter", name)["drawn"],
                         "rmse": float(numpy.sqrt((error ** 2).mean())), "largest": float(abs(error).max())})
        peak = float(abs(exact).max())
        for row in rows:
            row |= {"rmse": row["rmse"] / peak, "largest": row["largest"] / peak}
        rounds.say("rays")
        return rows

    def device(self):
        """Largest difference of the two programs' pictures, as a share of the range."""
        size = self.config["device_size"]
        path, _ = self.tools.resampled(self.volume, size)
        rows = []
        for name in self.config["filters"]:
            spectrum, _ = self.tools.spectrum(path, 2, name if name != "nearest" else "none")
            views = [self.config["oblique"], "0,0"]
            ours, _ = self.tools.pictures(spectrum, views, size, "--filter", name)
            theirs, stats = self.tools.pictures(spectrum, views, size, "--filter", name, tool="fvr-slice-gpu")
            if theirs is not None:
                self.device_name = stats["host"]["device"]
                rows.append({"filter": name, "difference": float(abs(ours - theirs).max() / abs(ours).max())})
        rounds.say("device")
        return rows

    def run(self):
        found = {"paper": self.paper(), "filters": self.filters(), "ffts": self.ffts(), "growth": self.growth(), "rays": self.rays(), "device": self.device(),
                "host": self.tools.run("vol-phantom", "ramp", "--dims", "4", "-o", self.tools.folder / "x.nrrd")["host"]}
        return found | {"device_name": self.device_name}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("what", choices=["errors", "times"])
    parser.add_argument("--dataset")
    parser.add_argument("--bin", required=True)
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    config = settings["sweep"]
    with tempfile.TemporaryDirectory(dir=settings["out"]) as folder:
        tools = Tools(arguments.bin, folder)
        if arguments.what == "errors":
            found = Errors(tools, config, arguments.dataset, sweep.volume(arguments.dataset, settings["out"])).run()
        else:
            dataset = "head" if "head" in settings["datasets"] else settings["datasets"][0]
            found = Times(tools, config, sweep.volume(dataset, settings["out"])).run() | {"dataset": dataset}
    pathlib.Path(arguments.output).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
