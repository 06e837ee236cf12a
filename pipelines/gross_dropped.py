#!/usr/bin/python3
"""What dropping coefficients costs an X-ray picture of a Gaussian: against the picture of all of them, beside its bound, and against
the closed form.

    gross_dropped.py SETTINGS --bin FOLDER -o FILE.md"""

import json
import math
import pathlib
import subprocess
import tempfile

import numpy

import convergence
import fourier_truth
import records

TEXT = """\
# Coefficients dropped from an X-ray picture

The phantom `gaussian` of {dims}^3 voxels, {size} x {size} pixels. *Error*: L2 norm of the difference from the picture of all coefficients, in value
times world length over the picture's area, at most the *bound*, sqrt(longest chord) times the L2 norm of what was dropped (Cauchy and Schwarz; wavelets
are orthonormal), for every number of coefficients kept. *From the closed form*: what is left with all of them is the sampling floor, the samples
standing for the coefficients of phi; basis functions are splines at multiples of 2^-{depth}. *Largest*: of a pixel, over the largest of the picture.

| wavelet | kept | dropped / norm | error | bound | error / bound | from the closed form | largest |
| --- | --- | --- | --- | --- | --- | --- | --- |
"""


def closed_form(asked):
    """Line integrals of exp(-r^2 / (2 s^2)), s = 0.3 half edges, along the chords of the box; the pixels' centres row by row."""
    size, width, half = asked["size"], asked["width"], (asked["dims"] - 1) / 2
    sigma = 0.3 * half
    right, down = fourier_truth.axes(asked["view"])
    into = numpy.cross(down, right)
    at = ((numpy.arange(size) + 0.5) / size - 0.5) * width
    origin = at[None, :, None] * right + at[:, None, None] * down  # from the box's centre, on the plane through it
    entry, leave = numpy.full((size, size), -numpy.inf), numpy.full((size, size), numpy.inf)
    for axis in range(3):
        ends = numpy.stack([(side * half - origin[..., axis]) / into[axis] for side in (-1, 1)])
        entry, leave = numpy.maximum(entry, ends.min(0)), numpy.minimum(leave, ends.max(0))
    erf = numpy.vectorize(math.erf)
    length = sigma * math.sqrt(math.pi / 2) * (erf(leave / (sigma * math.sqrt(2))) - erf(entry / (sigma * math.sqrt(2))))
    return numpy.where(leave > entry, numpy.exp(-(origin ** 2).sum(-1) / (2 * sigma ** 2)) * length, 0)


def main():
    arguments = records.tool_arguments(__doc__, "settings")
    asked = records.load(arguments.settings)["sweep"]["dropped"]
    text = TEXT.format(**asked)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def run(tool, *options):
            subprocess.run([f"{arguments.bin}/{tool}", *map(str, options), "--quiet", "--stats", folder / "stats.json"], check=True)
            return records.load(folder / "stats.json")

        def compared(one, other):
            """(L2 norm of the difference over the picture's area, largest difference)"""
            done = subprocess.run([f"{arguments.bin}/img-compare", one, other, "--json"], check=True, capture_output=True, text=True)
            figures = json.loads(done.stdout)["all"]
            return figures["rmse"] * asked["width"], figures["max"]

        truth, volume = closed_form(asked), folder / "gaussian.nrrd"
        convergence.write_exr(folder / "truth.exr", dict.fromkeys("RGB", truth))
        run("vol-phantom", "gaussian", "--dims", asked["dims"], "--type", "f64", "-o", volume)
        chord = math.sqrt(3) * (asked["dims"] - 1)
        for wavelet in asked["wavelets"]:
            for kept in ["all", *asked["keeps"]]:
                picture, file = folder / f"{kept}.exr", folder / "coefficients.vdb"
                stats = run("vol-dwt", volume, "-o", file, "--wavelet", wavelet, 
                            "--levels", asked["levels"], *(["--keep", kept] if kept != "all" else []))
                run("wavelet-raycast", file, "-o", picture, "--depth", asked["depth"], "--view", asked["view"], "--width", asked["width"], "--size", f"{asked['size']}x{asked['size']}")
                floor, largest = compared(picture, folder / "truth.exr")
                line = [wavelet, stats["counts"]["coefficients_kept"]]
                if kept == "all":
                    line += [0, "", "", ""]
                else:
                    dropped, error = stats["error"]["l2"], compared(picture, folder / "all.exr")[0]
                    bound = math.sqrt(chord) * dropped
                    if error > bound:
                        raise SystemExit(f"{wavelet}, {kept} coefficients: an error of {error} is over the bound of {bound}")
                    line += [f"{dropped / stats['result']['l2_norm']:.3g}", f"{error:.3g}", f"{bound:.3g}", f"{error / bound:.2f}"]
                text += "| " + " | ".join(map(str, [*line, f"{floor:.3g}", f"{largest / truth.max():.2g}"])) + " |\n"
    pathlib.Path(arguments.output).write_text(text)


if __name__ == "__main__":
    main()
