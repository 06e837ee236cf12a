#!/usr/bin/python3
"""Figure 3 of Gross et al. 1995: phi and psi of some wavelets in one dimension, as wavelet-raycast draws a single coefficient.

    gross_basis.py SETTINGS --bin FOLDER -o FILE.png"""

import pathlib
import subprocess
import tempfile

import matplotlib
import numpy

import records

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

SHOWN = 7  # samples of the function's level to each side


class Maker:
    """Functions along a line of samples, one of which is 1."""

    def __init__(self, tools, asked, folder):
        self.tools, self.asked, self.folder = tools, asked, pathlib.Path(folder)
        self.run("vol-phantom", "impulse", "--dims", f"{asked['samples']}x1x1", "--type", "f64", "-o", self.folder / "impulse.nrrd")

    def run(self, tool, *options):
        subprocess.run([f"{self.tools}/{tool}", *map(str, options)], check=True)

    def drawn(self, wavelet, levels, *options):
        """(x, f): one coefficient of the impulse's. Along an axis of one sample, one unit thick, the field is constant, and a ray's
        integral its value."""
        file, picture, plain = (self.folder / name for name in ("c.vdb", "picture.exr", "plain.exr"))
        samples, pixels = self.asked["samples"], self.asked["pixels"]
        self.run("vol-dwt", self.folder / "impulse.nrrd", "-o", file, "--wavelet", wavelet, "--levels", levels, "--quiet")
        self.run("wavelet-raycast", file, "-o", picture, "--size", f"{pixels}x1", "--width", samples, "--depth", self.asked["depth"],
                 "--budget", 1, "--quiet", *options)
        subprocess.run(["oiiotool", picture, "--ch", "R", "--compression", "none", "-d", "float", "-o", plain], check=True, stdout=subprocess.DEVNULL)
        f = numpy.frombuffer(plain.read_bytes()[-4 * pixels:], "<f4").astype(float)  # the only line of an uncompressed file
        return (samples - 1) / 2 + ((numpy.arange(pixels) + 0.5) / pixels - 0.5) * samples, f

    def functions(self, wavelet):
        """{name: (x, f)}, in samples of the level, from the first moment on (of psi: from the middle of its energy), of unit norm."""
        made = {"phi": (1, *self.drawn(wavelet, 0)), "psi": (2, *self.drawn(wavelet, 2, "--levels", "1:1"))}
        result = {}
        for name, (scale, x, f) in made.items():
            weight = f if name == "phi" else f * f
            u = (x - (x * weight).sum() / weight.sum()) / scale
            f = f / numpy.sqrt((f * f).sum() * (u[1] - u[0]))
            result[name] = u, f if f.max() >= -f.min() else -f
        return result


def main():
    arguments = records.tool_arguments(__doc__, "settings")
    asked = records.load(arguments.settings)["sweep"]["basis"]
    with tempfile.TemporaryDirectory() as folder:
        maker = Maker(arguments.bin, asked, folder)
        functions = {wavelet: maker.functions(wavelet) for wavelet in asked["wavelets"]}
    figure, grid = plt.subplots(2, len(functions), figsize=(2.5 * len(functions), 4), sharex=True, sharey="row", constrained_layout=True)
    for column, (wavelet, made) in zip(grid.T, functions.items()):
        for axes, (name, (u, f)) in zip(column, made.items()):
            near = abs(u) <= SHOWN
            axes.plot(u[near], f[near], linewidth=0.9, color="tab:blue" if name == "phi" else "tab:red")
            axes.set_title(f"{wavelet}: {name}", fontsize=8)
            axes.axhline(0, color="0.7", linewidth=0.4)
            axes.tick_params(labelsize=7)
        column[-1].set_xlabel("samples of its level", fontsize=7)
    figure.savefig(arguments.output, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
