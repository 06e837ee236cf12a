#!/usr/bin/python3
"""Meshes of isosurfaces: ours and, where installed, VTK's Flying Edges, scikit-image's marching cubes and OpenVDB's
volumeToMesh, on the same volumes.
Times interleaved; every mesh as its program made it, before any welding, counted by one checker, mesh_counts()."""

import argparse
import csv
import importlib.util
import json
import os
import pathlib
import subprocess
import tempfile
import time

import numpy

import rounds
import sweep

TYPES = {"uint8": "u1", "uchar": "u1", "unsigned char": "u1", "int8": "i1", "signed char": "i1", "uint16": "u2",
         "unsigned short": "u2", "ushort": "u2", "int16": "i2", "short": "i2", "uint32": "u4", "int32": "i4", "int": "i4",
         "float": "f4", "double": "f8"}


def read_nrrd(path):
    """Voxels as [z, y, x] of a raw NRRD as our tools write it."""
    data = pathlib.Path(path).read_bytes()
    end = data.index(b"\n\n") + 2
    fields = dict(line.split(": ", 1) for line in data[:end].decode().splitlines()[1:] if ": " in line and line[0] != "#")
    dims = [int(n) for n in fields["sizes"].split()]
    voxels = numpy.frombuffer(data, dtype="<" + TYPES[fields["type"]], offset=end).reshape(dims[::-1])
    return voxels.copy()  # scikit-image refuses memory that is read only


def write_nrrd(path, voxels, spacing=1):
    sizes = " ".join(str(n) for n in reversed(voxels.shape))
    header = f"NRRD0004\ntype: float\ndimension: 3\nsizes: {sizes}\nspacings: {spacing!r} {spacing!r} {spacing!r}\nencoding: raw\nendian: little\n\n"
    pathlib.Path(path).write_bytes(header.encode() + voxels.astype("<f4").tobytes())


def noisy_ball(edge):
    axis = numpy.linspace(-1, 1, edge, dtype="f4")
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
    step = numpy.clip((0.6 - numpy.sqrt(x * x + y * y + z * z)) * edge / 4 + 0.5, 0, 1)
    return step + numpy.random.default_rng(1).normal(0, 0.25, step.shape).astype("f4")


def mesh_counts(triangles):
    """Counts of a mesh as a complex of vertex numbers, positions apart. boundary: edges of one triangle; faults: edges of
    more than two, or run along twice the same way."""
    triangles = numpy.asarray(triangles, dtype=numpy.int64)
    if len(triangles) == 0:
        return {"triangles": 0, "components": 0, "euler": 0, "boundary": 0, "faults": 0}
    vertices, triangles = numpy.unique(triangles, return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    ways = numpy.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    low, high = ways.min(axis=1), ways.max(axis=1)
    edges, inverse, number = numpy.unique(low * len(vertices) + high, return_inverse=True, return_counts=True)
    balance = numpy.bincount(inverse, weights=numpy.where(ways[:, 0] == low, 1, -1))
    # The smallest vertex of each component: of a vertex and its neighbours, and then of what these stand for.
    ends = numpy.concatenate([edges // len(vertices), edges % len(vertices)])
    others = numpy.concatenate([edges % len(vertices), edges // len(vertices)])
    order = numpy.argsort(ends, kind="stable")
    others, starts = others[order], numpy.flatnonzero(numpy.diff(ends[order], prepend=-1))
    label = numpy.arange(len(vertices))
    while True:
        new = numpy.minimum(label, numpy.minimum.reduceat(label[others], starts))
        numpy.minimum.at(new, label, new.copy())  # and of what stood for it
        new = new[new]
        if (new == label).all():
            break
        label = new
    return {"triangles": len(triangles), "components": len(numpy.unique(label)),
            "euler": len(vertices) - len(edges) + len(triangles), "boundary": int((number == 1).sum()),
            "faults": int(((number > 2) | ((number == 2) & (balance != 0))).sum())}


def read_ply(path):
    """Triangles of a PLY file as isosurf-mc writes it."""
    data = pathlib.Path(path).read_bytes()
    end = data.index(b"end_header\n") + 11
    head = data[:end].decode().splitlines()
    count = {line.split()[1]: int(line.split()[2]) for line in head if line.startswith("element")}
    size = sum({"float": 4, "double": 8}[line.split()[1]] for line in head if line.startswith("property") and "list" not in line)
    faces = numpy.frombuffer(data, dtype=[("n", "u1"), ("v", "<u4", 3)], offset=end + size * count["vertex"])
    return faces["v"]


class Ours:
    name = "isosurf-mc"

    def __init__(self, binaries):
        self.tool = pathlib.Path(binaries) / "isosurf-mc"
        self.folder = tempfile.TemporaryDirectory()
        self.mesh = pathlib.Path(self.folder.name) / "mesh.ply"

    def run(self, path, isovalue, threads, options=()):
        stats = pathlib.Path(self.folder.name) / "stats.json"
        subprocess.run([self.tool, path, f"--isovalue={isovalue}", "-o", self.mesh, "--threads", str(threads), "--no-weld",
                        "--no-measures", "--quiet", "--stats", stats, *options], check=True)
        return json.loads(stats.read_text())["time_s"]["phases"]["extract"][0]

    def seconds(self, path, voxels, isovalue, threads):
        return self.run(path, isovalue, threads)

    def triangles(self, path, voxels, isovalue):
        self.run(path, isovalue, 0)
        return read_ply(self.mesh)


class FlyingEdges:
    name = "VTK Flying Edges"

    def __init__(self):
        import vtk
        from vtk.util import numpy_support

        self.vtk, self.support = vtk, numpy_support
        self.held = None

    def image(self, voxels):
        if self.held is None or self.held[0] is not voxels:
            image = self.vtk.vtkImageData()
            image.SetDimensions(*reversed(voxels.shape))
            image.GetPointData().SetScalars(self.support.numpy_to_vtk(voxels.ravel(), deep=True))
            self.held = (voxels, image)
        return self.held[1]

    def run(self, voxels, isovalue, threads):
        image = self.image(voxels)
        self.vtk.vtkSMPTools.Initialize(threads)
        surface = self.vtk.vtkFlyingEdges3D()
        surface.SetInputData(image)
        surface.SetValue(0, isovalue)
        surface.ComputeNormalsOn()
        surface.ComputeScalarsOff()
        started = time.perf_counter()
        surface.Update()
        return time.perf_counter() - started, surface.GetOutput()

    def seconds(self, path, voxels, isovalue, threads):
        return self.run(voxels, isovalue, threads)[0]

    def triangles(self, path, voxels, isovalue):
        cells = self.run(voxels, isovalue, 1)[1].GetPolys()
        return self.support.vtk_to_numpy(cells.GetConnectivityArray()).reshape(-1, 3)


class ScikitImage:
    name = "scikit-image"

    def run(self, voxels, isovalue):
        from skimage import measure

        started = time.perf_counter()
        faces = measure.marching_cubes(voxels, isovalue)[1]
        return time.perf_counter() - started, faces

    def seconds(self, path, voxels, isovalue, threads):
        return self.run(voxels, isovalue)[0]

    def triangles(self, path, voxels, isovalue):
        return self.run(voxels, isovalue)[1]


class OpenVDB:
    """Dual contouring of a grid that holds every voxel. Its quadrilaterals are counted as two triangles each. The grid's
    background closes the surface at the volume's border."""
    name = "OpenVDB volumeToMesh"

    def __init__(self, module):
        self.module = module
        self.held = None

    def run(self, voxels, isovalue):
        if self.held is None or self.held[0] is not voxels:
            grid = self.module.FloatGrid(background=float(voxels.min()) - 1)
            grid.copyFromArray(numpy.ascontiguousarray(voxels, dtype="f4"))
            self.held = (voxels, grid)
        started = time.perf_counter()
        _, triangles, quads = self.held[1].convertToPolygons(isovalue=isovalue, adaptivity=0)
        seconds = time.perf_counter() - started
        quads = numpy.asarray(quads, dtype=numpy.int64).reshape(-1, 4)
        parts = [numpy.asarray(triangles, dtype=numpy.int64).reshape(-1, 3), quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
        return seconds, numpy.concatenate(parts)

    def seconds(self, path, voxels, isovalue, threads):
        return self.run(voxels, isovalue)[0]

    def triangles(self, path, voxels, isovalue):
        return self.run(voxels, isovalue)[1]


ONE_THREAD = ("scikit-image",)       # which has no more
ALL_THREADS = ("OpenVDB volumeToMesh",)  # whose Python module says not how many; as many as there are cores


def runs_with(name, threads):
    """Whether a program runs with that many threads."""
    if name in ONE_THREAD:
        return threads == 1
    return name not in ALL_THREADS or threads == os.cpu_count()


def programs(binaries):
    found = [Ours(binaries)]
    if importlib.util.find_spec("vtk"):
        found.append(FlyingEdges())
    if importlib.util.find_spec("skimage"):
        found.append(ScikitImage())
    for name in ("pyopenvdb", "openvdb"):
        if importlib.util.find_spec(name):
            found.append(OpenVDB(importlib.import_module(name)))
            break
    return found


def measured(dataset, path, config, contenders):
    voxels = read_nrrd(path)
    rows = []
    for isovalue in config["datasets"][dataset]["isovalues"]:
        counts = {p.name: mesh_counts(p.triangles(path, voxels, isovalue)) for p in contenders}
        for threads in config["threads"]:
            timed = [p for p in contenders if runs_with(p.name, threads)]
            times = rounds.interleaved(
                {p.name: (lambda p=p: p.seconds(path, voxels, isovalue, threads)) for p in timed}, config["rounds"])
            ours = times[contenders[0].name]
            for p in timed:
                median, low, high = rounds.interval(times[p.name])
                rows.append({"volume": dataset, "isovalue": isovalue, "program": p.name, "threads": threads,
                             "seconds": f"{median:.4f}", "seconds_low": f"{low:.4f}", "seconds_high": f"{high:.4f}",
                             "times_ours": rounds.shown(rounds.ratio(times[p.name], ours)), **counts[p.name]})
                rounds.say(f"{dataset} at {isovalue}, {threads} threads, {p.name}: {median:.3f} s")
    return rows


def random_faults(config, contenders):
    """Random volumes within a border outside, of noise and of integers 0 to 3 whose isovalue is one of them: how often a mesh
    is not closed and manifold, and how far its components and Euler characteristic are from those of isosurf-mc, which
    tests/isosurface compares with the trilinear field's."""
    asked = config["random"]
    generator = numpy.random.default_rng(asked["seed"])
    side = asked["edge"] + 2
    shape = (asked["volumes"], asked["edge"], asked["edge"], asked["edge"])
    kinds = [("noise", 0.0, generator.uniform(-1, 1, shape)), ("integers", 2.0, generator.integers(0, 4, shape))]
    rows = []
    for kind, isovalue, values in kinds:
        # All volumes in one, one behind the other: their borders keep them apart.
        voxels = numpy.full((asked["volumes"] * side, side, side), -1, dtype="f4")
        voxels.reshape(asked["volumes"], side, side, side)[:, 1:-1, 1:-1, 1:-1] = values
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "random.nrrd"
            write_nrrd(path, voxels)
            counts = {p.name: mesh_counts(p.triangles(path, voxels, isovalue)) for p in contenders}
        ours = counts[contenders[0].name]
        rows += [{"volume": f"{asked['volumes']} of {kind}", "isovalue": isovalue, "program": name, **found,
                  "components_against_isosurf_mc": found["components"] - ours["components"],
                  "euler_against_isosurf_mc": found["euler"] - ours["euler"]} for name, found in counts.items()]
    return rows


COLUMNS = ["volume", "isovalue", "program", "threads", "seconds", "seconds_low", "seconds_high", "times_ours", "triangles",
           "components", "euler", "boundary", "faults", "components_against_isosurf_mc",
           "euler_against_isosurf_mc"]


def write(rows, csv_path, markdown_path):
    with open(csv_path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="")
        writer.writeheader()
        writer.writerows(rows)
    lines = ["Meshes of isosurfaces as each program makes them, before any welding. `times_ours`: median of the rounds' ratios, above",
             "1 is slower than ours. `boundary`: edges of one triangle; `faults`: edges of more than two triangles or of two that",
             "disagree about the outside. The last rows, random volumes closed by a border, of noise and of integers with the isovalue",
             "one of them: how far components and Euler characteristic, all volumes together, are from isosurf-mc's own, which its",
             "tests compare with the trilinear field's. OpenVDB makes quadrilaterals by dual contouring, counted as two triangles each,",
             "on all cores; its background closes the surface at the volume's border.", "",
             "| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    lines += ["| " + " | ".join(str(row.get(column, "")) for column in COLUMNS) + " |" for row in rows]
    pathlib.Path(markdown_path).write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--noisy", nargs=2, metavar=("EDGE", "FILE"))
    parser.add_argument("--settings")
    parser.add_argument("--bin")
    parser.add_argument("--csv")
    parser.add_argument("--markdown")
    arguments = parser.parse_args()
    if arguments.noisy:
        write_nrrd(arguments.noisy[1], noisy_ball(int(arguments.noisy[0])))
        return
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    config = settings["sweep"]
    contenders = programs(arguments.bin)
    rows = []
    for dataset in settings["datasets"]:
        rows += measured(dataset, sweep.volume(dataset, settings["out"]), config, contenders)
    write(rows + random_faults(config, contenders), arguments.csv, arguments.markdown)


if __name__ == "__main__":
    main()
