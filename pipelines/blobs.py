#!/usr/bin/python3
"""The phantom of `renderers`: Gaussians that end well inside the box. As a volume of float voxels, spacing 1; as one of the same
field three times as dense; and as a curvilinear grid of the same points. Its X-rays are known in closed form."""

import argparse
import math
import pathlib

import numpy

import isosurface

PEAK = 255
DENSER = 3
LEAST = 1.0     # standard deviation in voxels: exp(-pi^2 / 2) = 0.7 % of it is left at the Nyquist frequency
REACH = 5.5     # standard deviations from a centre to the box at least: 3e-7 is left there


def blobs(edge, seed=1):
    """(amplitudes, centres x y z, standard deviations) in voxels, the first at (0, 0, 0); as many as the edge has voxels, the
    wider the nearer to the middle."""
    half = (edge - 1) / 2
    random = numpy.random.default_rng(seed)
    sigma = LEAST * (0.9 * half / REACH / LEAST) ** random.uniform(0, 1, edge)
    direction = random.normal(size=(edge, 3))
    direction /= numpy.linalg.norm(direction, axis=1)[:, None]
    away = (half - REACH * sigma) * random.uniform(0, 1, edge) ** (1 / 3)
    amplitude = random.uniform(0.4, 1, edge)
    return amplitude, half + away[:, None] * direction, sigma


def sampled(edge, found, denser=1):
    """Voxels [z, y, x]."""
    amplitude, centre, sigma = found
    axis = numpy.arange(denser * (edge - 1) + 1) / denser
    x, y, z = (numpy.exp(-((axis[:, None] - centre[:, a]) / sigma) ** 2 / 2) for a in range(3))
    plane = (z[:, None, :] * y[None, :, :] * amplitude).reshape(-1, len(amplitude))
    return (plane @ x.T).reshape(len(axis), len(axis), len(axis))


def scaled(edge):
    """The blobs with a peak of PEAK among the voxels."""
    amplitude, centre, sigma = blobs(edge)
    return amplitude * PEAK / sampled(edge, (amplitude, centre, sigma)).max(), centre, sigma


def xray(edge, right, down, width, size):
    """Integrals along the whole of every ray of an orthographic picture about the middle of the box: the sum of
    a sigma sqrt(2 pi) exp(-b^2 / (2 sigma^2)), b the distance of ray and centre."""
    amplitude, centre, sigma = scaled(edge)
    place = ((numpy.arange(size) + 0.5) / size - 0.5) * width
    centre = centre - (edge - 1) / 2
    u, v = centre @ right, centre @ down
    across = numpy.exp(-((place[:, None] - u) / sigma) ** 2 / 2)
    along = numpy.exp(-((place[:, None] - v) / sigma) ** 2 / 2)
    return (along * (amplitude * sigma * math.sqrt(2 * math.pi))) @ across.T


def write_grid(path, voxels):
    """VTK XML structured grid of points at the voxels."""
    nz, ny, nx = voxels.shape
    z, y, x = numpy.meshgrid(*(numpy.arange(n) for n in voxels.shape), indexing="ij")
    points = numpy.stack([x, y, z], axis=-1).reshape(-1, 3)
    extent = f"0 {nx - 1} 0 {ny - 1} 0 {nz - 1}"

    def array(name, components, numbers):
        return (f'<DataArray type="Float32" Name="{name}" NumberOfComponents="{components}" format="ascii">\n'
                + "\n".join(" ".join(f"{n:.9g}" for n in row) for row in numbers.reshape(-1, nx * components)) + "\n</DataArray>\n")

    pathlib.Path(path).write_text(
        f'<?xml version="1.0"?>\n<VTKFile type="StructuredGrid" version="0.1" byte_order="LittleEndian">\n<StructuredGrid WholeExtent="{extent}">\n'
        f'<Piece Extent="{extent}">\n<PointData Scalars="f">\n{array("f", 1, voxels)}</PointData>\n<Points>\n{array("Points", 3, points)}</Points>\n'
        "</Piece>\n</StructuredGrid>\n</VTKFile>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--edge", type=int, help="voxels; without it the volume is there, and its grid is made")
    parser.add_argument("--volume", required=True)
    parser.add_argument("--dense")
    parser.add_argument("--grid", required=True)
    arguments = parser.parse_args()
    if arguments.edge:
        found = scaled(arguments.edge)
        isosurface.write_nrrd(arguments.volume, sampled(arguments.edge, found))
        isosurface.write_nrrd(arguments.dense, sampled(arguments.edge, found, DENSER), 1 / DENSER)
    write_grid(arguments.grid, isosurface.read_nrrd(arguments.volume))


if __name__ == "__main__":
    main()
