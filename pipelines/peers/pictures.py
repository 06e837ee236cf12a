"""Pictures of other programs as float TIFF files, linear, that img-compare reads; volumes and pictures as raw NRRD."""

import struct

import numpy


def write_tiff(path, rgb):
    """rgb: float array of rows from the top, columns, three channels."""
    height, width, _ = rgb.shape
    data = numpy.ascontiguousarray(rgb, "<f4").tobytes()
    short, long = 3, 4
    bits, formats = struct.pack("<3H", 32, 32, 32), struct.pack("<3H", 3, 3, 3)
    first = 8 + 2 + 10 * 12 + 4
    tags = [(256, long, 1, width), (257, long, 1, height), (258, short, 3, first), (259, short, 1, 1), (262, short, 1, 2),
            (273, long, 1, first + 12), (277, short, 1, 3), (278, long, 1, height), (279, long, 1, len(data)),
            (339, short, 3, first + 6)]
    with open(path, "wb") as file:
        file.write(struct.pack("<2sHIH", b"II", 42, 8, len(tags)))
        for tag in tags:
            file.write(struct.pack("<HHII", *tag))
        file.write(struct.pack("<I", 0) + bits + formats + data)


def read_pgm(path):
    """Three channels of the grey of a binary PGM of 8 bits, taken as linear."""
    with open(path, "rb") as file:
        _, size, _ = (file.readline() for _ in range(3))
        width, height = map(int, size.split())
        grey = numpy.frombuffer(file.read(), numpy.uint8).reshape(height, width, 1) / 255
    return numpy.repeat(grey, 3, 2)


def read_nrrd(path):
    """A raw NRRD of u8 or float, slowest axis first."""
    with open(path, "rb") as file:
        head, _, data = file.read().partition(b"\n\n")
    fields = dict(line.split(": ", 1) for line in head.decode("latin-1").split("\n") if ": " in line)
    kind = {"float": "<f4", "double": "<f8"}.get(fields["type"], "u1")
    return numpy.frombuffer(data, kind).reshape([int(s) for s in reversed(fields["sizes"].split())])


def write_nrrd(path, array, fields=""):
    kind = {"uint8": "uint8", "float32": "float"}[str(array.dtype)]
    sizes = " ".join(map(str, reversed(array.shape)))
    with open(path, "wb") as file:
        file.write(f"NRRD0004\ntype: {kind}\ndimension: {array.ndim}\nsizes: {sizes}\n{fields}encoding: raw\nendian: little\n\n"
                   .encode())
        array.tofile(file)


def ball(n):
    """A rippled ball with a blob in it, values 0 to 255, 0 outside: something to skip, something to see."""
    g = numpy.linspace(-1, 1, n, dtype=numpy.float32)
    z, y, x = numpy.meshgrid(g, g, g, indexing="ij", sparse=True)
    r = numpy.sqrt(x * x + y * y + z * z)
    ripple = 0.35 + 0.25 * numpy.cos(20 * r)
    blob = 0.7 * numpy.exp(-25 * ((x - 0.3) ** 2 + y * y + z * z))
    return numpy.rint(255 * numpy.clip((0.9 - r) * 10, 0, 1) * numpy.minimum(1, ripple + blob)).astype(numpy.uint8)
