#!/usr/bin/python3
"""Contact sheet after figure 4 of He 1998: for each wavelet a row of renderings and one of their absolute differences
from the truth, columns error bounds. And the same pictures, with the truth's own, as a list of pairs."""

import argparse
import pathlib
import shlex
import subprocess
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

import pairs  # noqa: E402
import records  # noqa: E402
import sweep  # noqa: E402

DIFFERENCE_SCALE = 0.1  # the difference, on the colour scale, that is drawn brightest


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("--bin", required=True)
    parser.add_argument("--table", required=True)
    parser.add_argument("--method", default="blind")
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    settings = records.load(arguments.settings)
    swept, out = settings["sweep"], pathlib.Path(settings["out"])
    dataset = next(d for d in swept["published_on"] if d in settings["datasets"])
    scene = swept["datasets"][dataset]["scenes"][0]
    chosen = [run for run in sweep.runs(swept, settings["datasets"])
              if (run.dataset, run.scene, run.method) == (dataset, scene, arguments.method)]
    row_of = {tuple(row[key] for key in records.KEY): row for row in records.read_csv(arguments.table)}
    truth = out / "truth" / dataset / scene / "reference.exr"

    def draw(command, shown):
        subprocess.run([*shlex.split(f"{arguments.bin}/{command} -o"), shown, "--quiet"], check=True)

    def picture(folder, run):
        """The rendering and its absolute difference from the truth; the differences share one colour scale."""
        image = out / "runs" / run.group / run.series / f"{run.name}.exr"
        shown, difference = folder / f"{run.name}.png", folder / f"{run.name}-error.png"
        draw(sweep.raycast(run, swept, out), shown)
        subprocess.run([f"{arguments.bin}/img-compare", image, truth, "--difference", difference, "--difference-scale",
                        str(DIFFERENCE_SCALE), "--metric", "max", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        return shown, difference

    wavelets, epsilons = swept["wavelets"], swept["epsilons"]
    figure, grid = plt.subplots(2 * len(wavelets), len(epsilons), figsize=(1.75 * len(epsilons), 3.6 * len(wavelets)),
                                squeeze=False)
    with tempfile.TemporaryDirectory() as folder:
        folder, pictures, others = pathlib.Path(folder), {"truth.png": f"{folder}/truth.png"}, []
        draw(sweep.reference(f"{dataset}/{scene}", swept, out), pictures["truth.png"])
        for run in chosen:
            line, column = 2 * wavelets.index(run.wavelet), [str(e) for e in epsilons].index(run.epsilon)
            shown, difference = picture(folder, run)
            row = row_of[tuple(getattr(run, key) for key in records.KEY)]
            title = f"{run.wavelet}, epsilon {run.epsilon}"
            figures = f"MSE {float(row['mse_truth']):.3g}, {int(row['samples']) / 1e6:.2f} M samples"
            grid[line, column].imshow(plt.imread(shown))
            grid[line, column].set_title(title, fontsize=6, pad=2)
            grid[line + 1, column].imshow(plt.imread(difference))
            grid[line + 1, column].set_title(figures, fontsize=6, pad=2)
            pictures |= {path.name: path for path in (shown, difference)}
            others.append(pairs.other(title, shown.name, difference.name, f"{figures}; error in false colours from 0 to {DIFFERENCE_SCALE:g}"))
        pairs.write(pathlib.Path(arguments.output).parent,
                    [pairs.entry(f"{dataset}, scene {scene}: the integral and {arguments.method} steps by an index",
                                 f"to a tolerance of {float(swept['tolerance']):g}", "truth.png", others)], pictures)
    for axes in grid.flat:
        axes.set_xticks([])
        axes.set_yticks([])
    figure.tight_layout(pad=0.3)
    figure.savefig(arguments.output, dpi=130, metadata={"Software": None})


if __name__ == "__main__":
    main()
