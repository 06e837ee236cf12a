#!/usr/bin/python3
"""Contact sheets of `fourier`: what the paper's Figures 4.2 to 4.9 show (filters, with what each is wrong by), and models: shading,
bands, edges, and a turn. The filters' pictures also as a list of pairs."""

import json
import pathlib
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy  # noqa: E402

import fourier  # noqa: E402
import pairs  # noqa: E402
import records  # noqa: E402
import sweep  # noqa: E402

FILTERS = [("nearest", 1, False, "4.2: nearest"), ("trilinear", 1, False, "4.4: trilinear"),
           ("trilinear", 1, True, "4.5: the same, compensated"), ("catmull-rom-fast", 1, True, "4.8: the paper's cubic, compensated"),
           ("catmull-rom", 1, False, "Catmull-Rom, 64 samples"), ("trilinear", 2, False, "4.9: trilinear, padding 2"),
           ("es:6", 2, True, "es:6, padding 2")]
TURN = 6


def grey(picture, largest):
    return numpy.clip(picture / largest, 0, 1) ** (1 / 2.2)


def sheet(rows, path):
    """Rows of (title, picture, largest value shown)."""
    columns = max(len(row) for row in rows)
    figure, grid = plt.subplots(len(rows), columns, figsize=(1.9 * columns, 2.1 * len(rows)), squeeze=False, constrained_layout=True)
    for axes in grid.flat:
        axes.axis("off")
    for line, row in zip(grid, rows):
        for axes, (title, picture, largest) in zip(line, row):
            axes.set_title(title, fontsize=6.5)
            if picture.ndim == 3:
                axes.imshow(grey(picture, largest), interpolation="nearest")
            elif largest is None:  # an error: white is none
                most = abs(picture).max()
                axes.imshow(picture, cmap="RdBu", vmin=-most, vmax=most, interpolation="nearest")
            else:
                axes.imshow(grey(picture, largest), cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    figure.savefig(path, dpi=130, metadata={"Software": None})
    plt.close(figure)


def filters(tools, config, volume, dataset, size):
    path, _ = tools.resampled(volume, size)
    views, width = [config["oblique"], "90,0"], fourier.pixels(config, size)
    spectrum, _ = tools.spectrum(path, 2, "es:12", "--type", "f64")
    truth = tools.pictures(spectrum, views, width)[0]
    shown, wrong = [(f"{dataset}, {size}$^3$: truth", truth[0], truth[0].max())], [("4.3: 90 degrees, exact", truth[1], truth[1].max())]
    for name, padding, compensated, title in FILTERS:
        spectrum, _ = tools.spectrum(path, padding, name if compensated else "none")
        picture = tools.pictures(spectrum, views, width, "--filter", name)[0][0]
        shown.append((title, picture, truth[0].max()))
        wrong.append((f"error, up to {abs(picture - truth[0]).max() / truth[0].max():.2g}", picture - truth[0], None))
    return [shown, wrong]


def compared(rows, dataset, size, folder, output):
    """The filters' pictures, in the two rows of the sheet, as pairs: each beside the truth, errors red and blue to their largest."""
    (_, truth, most), *shown = rows[0]
    pictures, others = {"truth.png": folder / "truth.png"}, []
    plt.imsave(pictures["truth.png"], grey(truth, most), cmap="gray", vmin=0, vmax=1)
    for n, ((title, picture, _), (says, error, _)) in enumerate(zip(shown, rows[1][1:])):
        names = f"{n}.png", f"{n}-error.png"
        pictures |= {name: folder / name for name in names}
        plt.imsave(pictures[names[0]], grey(picture, most), cmap="gray", vmin=0, vmax=1)
        largest = abs(error).max()
        plt.imsave(pictures[names[1]], error, cmap="RdBu", vmin=-largest, vmax=largest)
        others.append(pairs.other(title, *names, f"{says} of the largest pixel; red too dark, blue too bright"))
    pairs.write(output, [pairs.entry(f"{dataset}, {size}^3: what each filter makes of its spectrum", "es:12, f64", "truth.png", others)], pictures)


def models(tools, config, volume, dataset, size):
    path, voxels = tools.resampled(volume, size)
    view, width = [config["oblique"]], fourier.pixels(config, size)  # so that nothing wraps around
    top = float(voxels.max())

    def drawn(options, *render, title):
        spectrum, _ = tools.spectrum(path, 2, "es:6", *options)
        picture = tools.pictures(spectrum, view, width, *render)[0][0]
        return f"{dataset}: {title}", picture, picture.max()

    row = [drawn((), title="plain"), drawn(("--shading", "depth-cue"), title="depth cue"),
           drawn(("--shading", "directional"), "--light", "0.6,0.6,0.5", title="directional light"),
           drawn(("--edges",), title="Canny edges")]
    bands = [f"{top * lo:g}:{top * hi:g}" for lo, hi in ((0.08, 0.25), (0.25, 0.5), (0.5, 1))]
    spectrum, _ = tools.spectrum(path, 2, "es:6", "--bands", ",".join(bands))
    weights, channels = [1, 1, 2], [[0.9, 0.4, 0.1], [0.3, 0.8, 0.2], [0.2, 0.5, 1.0]]
    planes = [tools.pictures(spectrum, view, width, "--band-weights", ",".join(str(w * c[k]) for w, c in zip(weights, channels)))[0][0]
              for k in range(3)]
    colour = numpy.stack(planes, axis=-1)
    row.append((f"{dataset}: three bands", colour, colour.max()))
    return row


def turn(tools, config, volume, dataset, size):
    path, _ = tools.resampled(volume, size)
    spectrum, _ = tools.spectrum(path, 2, "es:6")
    width = fourier.pixels(config, size)
    views = [f"{360 * i / TURN:g},15" for i in range(TURN)]
    found = tools.pictures(spectrum, views, width)[0]
    return [(f"{dataset}, {v}", picture, found.max()) for v, picture in zip(views, found)]


def main():
    arguments = records.tool_arguments(__doc__, "settings")
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    config = settings["sweep"]
    size = min(128, max(config["sizes"]))
    with tempfile.TemporaryDirectory(dir=settings["out"]) as folder:
        tools = fourier.Tools(arguments.bin, folder)
        volumes = {d: sweep.volume(d, settings["out"]) for d in settings["datasets"]}
        first = "head" if "head" in volumes else next(iter(volumes))
        rows = filters(tools, config, volumes[first], first, size)
        sheet(rows, pathlib.Path(arguments.output) / "pictures.png")
        compared(rows, first, size, pathlib.Path(folder), arguments.output)
        rows = [models(tools, config, volume, name, size) for name, volume in volumes.items()]
        last = "bonsai" if "bonsai" in volumes else first
        sheet([*rows, turn(tools, config, volumes[last], last, size)], pathlib.Path(arguments.output) / "models.png")


if __name__ == "__main__":
    main()
