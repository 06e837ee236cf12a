"""What a Fourier slice should have been: the picture of the volume's own transform, summed directly, and figures of error."""

import numpy


def axes(view):
    """Right and down, x y z, of a camera at AZIMUTH,ELEVATION (lib/camera)."""
    azimuth, elevation = (numpy.deg2rad(float(angle)) for angle in view.split(","))
    into = -numpy.array([numpy.cos(elevation) * numpy.sin(azimuth), numpy.sin(elevation), numpy.cos(elevation) * numpy.cos(azimuth)])
    right = numpy.array([numpy.cos(azimuth), 0, -numpy.sin(azimuth)])
    return right, numpy.cross(into, right)


def direct_sum(voxels, view, width):
    """Picture of width^2 pixels, an even number, of [z, y, x] unit voxels, `width` voxels wide: every frequency of the picture's own that lies
    in the volume's Nyquist box summed over all voxels, and the inverse transform of these. No view along an axis: what lies
    on a face of the box counts once."""
    right, down = axes(view)
    f = numpy.fft.fftshift(numpy.fft.fftfreq(width))  # cycles a voxel
    rows = numpy.append(f, 0.5)  # of an even height the unpaired line is the mean of both, -1/2 and 1/2
    v, u = numpy.meshgrid(rows, f[f <= 0], indexing="ij")  # half the plane; the rest is its mirror image
    along = [u * right[a] + v * down[a] for a in range(3)]
    inside = numpy.logical_and.reduce([abs(g) <= 0.5 for g in along])
    waves = []
    for g, n in zip(along, voxels.shape[::-1]):
        place = numpy.arange(n) - (n - 1) / 2
        waves.append(numpy.exp(-2j * numpy.pi * numpy.outer(place, g[inside])))
    nz, ny, nx = voxels.shape
    sums = numpy.empty(int(inside.sum()), complex)
    for first in range(0, sums.size, 512):
        part = slice(first, first + 512)
        along_x = voxels.reshape(-1, nx) @ waves[0][:, part].real + 1j * (voxels.reshape(-1, nx) @ waves[0][:, part].imag)
        along_y = (along_x.reshape(nz, ny, -1) * waves[1][None, :, part]).sum(axis=1)
        sums[part] = (along_y * waves[2][:, part]).sum(axis=0)
    # The inverse from the half plane, by its definition: along y, then twice the real part but for u = 0, and for the
    # unpaired line of an even width, which has no mirror image in the plane.
    plane = numpy.zeros(u.shape, complex)
    plane[inside] = sums
    plane[[0, -1], 1:] *= 0.5
    plane[-1, 0] = 0  # where both unpaired lines meet, the real part pairs the corners
    place = numpy.arange(width) - (width - 1) / 2
    back = numpy.exp(2j * numpy.pi * numpy.outer(place, rows)) @ plane
    twice = numpy.where((f[f <= 0] == 0) | (f[f <= 0] == -0.5), 1.0, 2.0)
    picture = (back * twice) @ numpy.exp(2j * numpy.pi * numpy.outer(f[f <= 0], place))
    return picture.real / width ** 2


def voxel_sum(voxels, width):
    """The same along z: plain sums, in the middle of the picture, y up."""
    picture = numpy.zeros((width, width))
    edge = (width - voxels.shape[1]) // 2
    picture[edge:edge + voxels.shape[1], edge:edge + voxels.shape[2]] = voxels.astype(float).sum(axis=0)[::-1]
    return picture


def silhouette(voxels, view, width):
    """Pixels within two of one onto which a voxel above a twentieth of the largest falls."""
    right, down = axes(view)
    z, y, x = (numpy.nonzero(voxels > voxels.max() / 20)[a] - (voxels.shape[a] - 1) / 2 for a in range(3))
    column = numpy.rint(x * right[0] + y * right[1] + z * right[2] + (width - 1) / 2).astype(int)
    row = numpy.rint(x * down[0] + y * down[1] + z * down[2] + (width - 1) / 2).astype(int)
    hit = numpy.zeros((width + 4, width + 4), bool)
    ok = (row >= 0) & (row < width) & (column >= 0) & (column < width)
    hit[row[ok] + 2, column[ok] + 2] = True
    return numpy.logical_or.reduce([hit[a:a + width, b:b + width] for a in range(5) for b in range(5)])


def figures(picture, truth, object_there):
    """Relative L2 error, over the whole picture and over the middle half of its width and height; the largest, as a share of
    the truth's largest; ghosts: the error's energy outside the object, as a share of the truth's."""
    error, n = picture - truth, len(truth)
    middle = slice(n // 4, n - n // 4)
    norm = numpy.linalg.norm
    return {"l2": norm(error) / norm(truth), "l2_centre": norm(error[middle, middle]) / norm(truth[middle, middle]),
            "largest": abs(error).max() / abs(truth).max(),
            "ghosts": float((error[~object_there] ** 2).sum() / (truth ** 2).sum())}
