#!/usr/bin/python3
"""Runs the refinements of convergence.yaml through the tools: one error a value, and its truth from closed forms."""

import json
import math
import pathlib
import struct
import subprocess
import tempfile

import numpy

import fourier_truth
import isosurface
import records

SIGMA = 0.3  # of vol-phantom's gaussian, on [-1, 1]^3
ISOVALUE = 0.4
RADIUS = SIGMA * math.sqrt(-2 * math.log(ISOVALUE))


def write_exr(path, channels):
    """{name: picture} as an uncompressed OpenEXR file of floats."""
    names = sorted(channels)
    height, width = channels[names[0]].shape

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(value)) + value

    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<2I", 20000630, 2) + b"".join([
        attribute("channels", "chlist", b"".join(n.encode() + b"\0" + struct.pack("<4I", 2, 0, 1, 1) for n in names) + b"\0"),
        attribute("compression", "compression", b"\0"), attribute("dataWindow", "box2i", window),
        attribute("displayWindow", "box2i", window), attribute("lineOrder", "lineOrder", b"\0"),
        attribute("pixelAspectRatio", "float", struct.pack("<f", 1)), attribute("screenWindowCenter", "v2f", bytes(8)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1))]) + b"\0"
    lines = [b"".join(channels[n][y].astype("<f4").tobytes() for n in names) for y in range(height)]
    line = 8 + len(lines[0])
    first = len(header) + 8 * height
    offsets = struct.pack(f"<{height}Q", *(first + line * y for y in range(height)))
    pathlib.Path(path).write_bytes(header + offsets + b"".join(struct.pack("<iI", y, len(data)) + data for y, data in enumerate(lines)))


class Rays:
    """Origins and direction of an orthographic picture's rays, about the origin: lib/camera."""

    def __init__(self, view, width, size):
        right, down = fourier_truth.axes(view)
        azimuth, elevation = (math.radians(float(angle)) for angle in view.split(","))
        self.into = -numpy.array([math.cos(elevation) * math.sin(azimuth), math.sin(elevation), math.cos(elevation) * math.cos(azimuth)])
        place = ((numpy.arange(size) + 0.5) / size - 0.5) * width
        self.origin = place[None, :, None] * right + place[:, None, None] * down

    def chord(self):
        """Entry and exit of the box [-1, 1]^3; equal where a ray misses."""
        with numpy.errstate(divide="ignore"):
            first, second = (-1 - self.origin) / self.into, (1 - self.origin) / self.into
        entry = numpy.minimum(first, second).max(axis=2)
        return entry, numpy.maximum(numpy.maximum(first, second).min(axis=2), entry)

    def line_integrals(self):
        """exp(-b^2 / (2 sigma^2)) sigma sqrt(pi/2) (erf(..) - erf(..)), b the distance from the origin."""
        entry, leave = self.chord()
        middle = -(self.origin @ self.into)
        beside = (self.origin ** 2).sum(axis=2) - middle ** 2
        erf = numpy.vectorize(math.erf)
        ends = erf((leave - middle) / (SIGMA * math.sqrt(2))) - erf((entry - middle) / (SIGMA * math.sqrt(2)))
        return numpy.exp(-beside / (2 * SIGMA ** 2)) * SIGMA * math.sqrt(math.pi / 2) * ends

    def depths(self):
        """Where they meet the sphere."""
        middle = -(self.origin @ self.into)
        beside = (self.origin ** 2).sum(axis=2) - middle ** 2
        return middle - numpy.sqrt(RADIUS ** 2 - beside)


class Runs:
    def __init__(self, asked, binaries, folder):
        self.asked, self.bin, self.folder = asked, pathlib.Path(binaries).resolve(), pathlib.Path(folder)
        for name, length in asked["reference_length"].items():
            (self.folder / f"{name}.yaml").write_text(f"reference_length: {length}\ntransfer:\n  colours: {asked['transfer']['colours']}\n"
                                                      f"  opacity: {asked['transfer']['opacity']}\n")
        self.made = {}

    def run(self, command):
        stats = self.folder / "stats.json"
        done = subprocess.run([self.bin / command.split()[0], *command.split()[1:], "--quiet", "--stats", stats], cwd=self.folder,
                              capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{command}: {done.stderr}")
        return json.loads(stats.read_text())

    def once(self, path, make):
        """The file, made by make() if it is not there."""
        if path not in self.made:
            make()
            self.made[path] = True
        return path

    def volume(self, n):
        """n samples an edge of the box [-1, 1]^3."""
        return self.once(f"gaussian-{n}.nrrd", lambda: self.run(
            f"vol-phantom gaussian --dims {n} --spacing {2 / (n - 1)!r} --origin -1 --type f64 -o gaussian-{n}.nrrd"))

    def camera(self, width, size=None):
        size = size or self.asked["size"]
        return f"--view {self.asked['view']} --size {size}x{size} --width {width}"

    def rmse(self, picture, truth, *options):
        done = subprocess.run([self.bin / "img-compare", picture, truth, "--json", "--metric", "rmse", *options], cwd=self.folder,
                              capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"img-compare {picture} {truth}: {done.stderr}")
        return json.loads(done.stdout)["all"]["rmse"]

    def closed_form(self, name, picture, channels="RGB"):
        return self.once(f"{name}.exr", lambda: write_exr(self.folder / f"{name}.exr", dict.fromkeys(channels, picture())))

    # One function a kind: the error at one value.

    def step(self, method, value, algorithm="packet"):
        volume, picture = self.volume(32), f"--scene step.yaml {self.camera(3)}"
        truth = self.once("steps.exr", lambda: self.run(f"vol-raycast {volume} -o steps.exr {picture} --quadrature reference"))
        self.run(f"vol-raycast {volume} -o picture.exr {picture} --quadrature {method} --step {value}v --algorithm {algorithm}")
        return self.rmse("picture.exr", truth)

    def step_plain(self, method, value):
        return self.step(method, value, "plain")

    def split(self, nodes, n):
        volume, picture = self.volume(n), f"--scene split.yaml {self.camera(3)}"
        truth = self.once(f"split-{n}.exr", lambda: self.run(f"vol-raycast {volume} -o split-{n}.exr {picture} --quadrature reference"))
        self.run(f"vol-raycast {volume} -o picture.exr {picture} --quadrature split --nodes {nodes}")
        return self.rmse("picture.exr", truth)

    def xray_truth(self, size):
        return self.closed_form(f"xray-{size}", lambda: Rays(self.asked["view"], 2, size).line_integrals())

    def grid(self, reconstruction, n):
        self.run(f"vol-raycast {self.volume(n)} -o picture.exr --model xray --quadrature reference --reconstruction {reconstruction} {self.camera(2)}")
        return self.rmse("picture.exr", self.xray_truth(self.asked["size"]))

    def coefficients(self, wavelet, n, levels):
        return self.once(f"{wavelet}-{n}-{levels}.vdb", lambda: self.run(
            f"vol-dwt {self.volume(n)} -o {wavelet}-{n}-{levels}.vdb --wavelet {wavelet} --levels {levels} --precision double"))

    def wavelet_grid(self, wavelet, n):
        size = self.asked["wavelet_size"]
        self.run(f"wavelet-raycast {self.coefficients(wavelet, n, 2)} -o picture.exr --depth 6 {self.camera(2, size)}")
        return self.rmse("picture.exr", self.xray_truth(size))

    def wavelet_levels(self, wavelet, dropped):
        """Without the `dropped` finest of 5 levels."""
        file, options = self.coefficients(wavelet, 64, 5), f"--depth 4 {self.camera(2, self.asked['wavelet_size'])}"
        truth = self.once(f"{wavelet}.exr", lambda: self.run(f"wavelet-raycast {file} -o {wavelet}.exr {options}"))
        self.run(f"wavelet-raycast {file} -o picture.exr --levels {dropped + 1}:5 {options}")
        return self.rmse("picture.exr", truth)

    def linearised(self, by, depth):
        """Of an optical depth of 3 through the middle; daubechies-4, of which 2000 coefficients are kept."""
        options = (f"--model composite --extinction 4 --budget 2000 --depth {depth} "
                   f"{self.camera(2, self.asked['wavelet_size'])}")
        file = self.coefficients("daubechies-4", 24, 2)
        truth = self.once(f"occluded-{depth}.exr", lambda: self.run(
            f"wavelet-raycast {file} -o occluded-{depth}.exr {options} --negative keep"))
        self.run(f"wavelet-raycast {file} -o picture.exr {options} --linearised {by}")
        return self.rmse("picture.exr", truth)

    def slice(self, volume, padding, compensate, name):
        """A slice against the direct sum over all voxels: relative, in the 2-norm."""
        size = self.asked["size"]
        voxels = isosurface.read_nrrd(self.folder / volume)
        if name not in self.made:
            self.made[name] = fourier_truth.direct_sum(voxels, self.asked["view"], size)
        self.run(f"vol-fft {volume} -o spectrum.nrrd --pad {padding} --compensate {compensate} --type f64")
        self.run(f"fvr-slice spectrum.nrrd -o views.nrrd --filter {compensate} --view {self.asked['view']} --size {size}x{size} --width {size} --wrap")
        found = isosurface.read_nrrd(self.folder / "views.nrrd").reshape(size, size)
        return float(numpy.linalg.norm(found - self.made[name]) / numpy.linalg.norm(self.made[name]))

    def unit_voxels(self, dims, name="gaussian"):
        return self.once(f"unit-{name}-{dims}.nrrd", lambda: self.run(f"vol-phantom {name} --dims {dims} --type f64 -o unit-{name}-{dims}.nrrd"))

    def width(self, padding, taps):
        return self.slice(self.unit_voxels(24), padding, f"es:{taps}", "noise")

    def padding(self, filter_name, padding):
        return self.slice(self.unit_voxels(24), padding, filter_name, "noise")

    def measures(self, n):
        if ("measures", n) not in self.made:
            record = self.run(f"isosurf-mc {self.volume(n)} -o mesh.ply --isovalue {ISOVALUE} --type f64")
            self.made["measures", n] = record["result"]["surfaces"][0]
        return self.made["measures", n]

    def mesh_area(self, _, n):
        return abs(self.measures(n)["area"] / (4 * math.pi * RADIUS ** 2) - 1)

    def mesh_volume(self, _, n):
        return abs(self.measures(n)["volume"] / (4 / 3 * math.pi * RADIUS ** 3) - 1)

    def surface(self, reconstruction, n):
        """Depth of the sphere where all rays meet it."""
        truth = self.closed_form("depth", lambda: Rays(self.asked["view"], 0.4, self.asked["size"]).depths(), ["depth"])
        self.run(f"isosurf-ray {self.volume(n)} -o picture.exr --isovalue {ISOVALUE} --reconstruction {reconstruction} {self.camera(0.4)}")
        return self.rmse("picture.exr", truth, "--channel", "depth")

    def image(self, _, step):
        """Within the box, where the picture is smooth."""
        picture = "--scene step.yaml --quadrature reference --tolerance 1e-8 --view {} --size 129x129 --width 0.8".format(self.asked["view"])
        truth = self.once("image.exr", lambda: self.run(f"vol-raycast {self.volume(129)} -o image.exr {picture}"))
        self.run(f"vol-raycast {self.volume(129)} -o picture.exr {picture} --image-step {step} --image-tolerance 1e6")
        return self.rmse("picture.exr", truth)


def main():
    arguments = records.tool_arguments(__doc__, "settings")
    asked = json.loads(pathlib.Path(arguments.settings).read_text())["sweep"]
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(asked, arguments.bin, folder)
        found = []
        for row in asked["rows"]:
            error = getattr(runs, row["kind"].replace("-", "_"))
            found.append({**row, "errors": [error(row["method"], value) for value in row["over"]]})
            print(row["kind"], row["method"], " ".join(f"{e:.3g}" for e in found[-1]["errors"]), flush=True)
    pathlib.Path(arguments.output).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
