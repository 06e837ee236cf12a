"""teem's miter: the command that casts one picture of a scene, and its picture as linear RGB over black.

A whole process, started for every picture: its time is less that of the same command at 8 x 8 pixels (start and load)."""

import math
import pathlib
import subprocess
import time

import numpy

import pictures


class Miter:
    def __init__(self, volume, scene, folder):
        self.scene, self.folder = scene, pathlib.Path(folder)
        voxels = pictures.read_nrrd(volume)
        self.edge = max(voxels.shape) - 1
        centred = 'centerings: node node node\nspacings: 1 1 1\n'
        pictures.write_nrrd(self.folder / "miter.nrrd", voxels.astype(numpy.float32), centred)
        values = numpy.arange(256.0)
        points = numpy.array(scene["opacity"])
        table = numpy.stack([*(numpy.interp(values, *numpy.array([[c[0], c[k]] for c in scene["colours"]]).T) for k in (1, 2, 3)),
                             numpy.interp(values, points[:, 0], points[:, 1])], 1).astype(numpy.float32)
        pictures.write_nrrd(self.folder / "function.nrrd", table, 'axis mins: nan 0\naxis maxs: nan 255\ncenterings: none node\n'
                            'labels: "RGBA" "gage(scalar:v)"\n')

    def run(self, size, azimuth, step, threads):
        a, e = math.radians(azimuth), math.radians(self.scene["elevation"])
        eye = [6 * c for c in (math.cos(e) * math.sin(a), math.sin(e), math.cos(e) * math.cos(a))]
        voxel, window, depth = 2 / self.edge, self.scene["width"], 1.75  # hoover scales the volume to [-1, 1]
        light = self.scene.get("shading") or {"ambient": 1, "diffuse": 0, "specular": 0, "exponent": 10}
        view = ["-fr", *eye, "-at", 0, 0, 0, "-up", 0, 1, 0, "-or", "-rh", "-dn", -depth, "-di", 0, "-df", depth, "-ar",
                "-ur", -window, window, "-vr", -window, window, "-is", size, size]
        command = ["teem-miter", "-i", self.folder / "miter.nrrd", "-txf", self.folder / "function.nrrd", "-ads", light["ambient"],
                   light["diffuse"], light["specular"], "-sp", light["exponent"], "-ref", voxel, "-step", step * voxel, "-k00",
                   "tent", "-k11", "cubicd:1,0", "-nt", threads, *view, "-o", self.folder / "miter-picture.nrrd"]
        if not self.scene.get("shading"):
            command += ["-ss", "none"]
        started = time.perf_counter()
        subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return time.perf_counter() - started

    def frame(self, azimuth, step, threads):
        """Seconds of a picture, which stays in miter-picture.nrrd."""
        start_up = self.run(8, azimuth, step, threads)
        return self.run(self.scene["size"], azimuth, step, threads) - start_up

    def save(self, path):
        rgba = pictures.read_nrrd(self.folder / "miter-picture.nrrd")[..., :4]  # colour is not multiplied by opacity
        pictures.write_tiff(path, rgba[..., :3] * rgba[..., 3:4])
