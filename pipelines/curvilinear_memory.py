#!/usr/bin/python3
"""Memory of curv-tricubic by cells: the largest resident size on twisted boxes of 32^3 and 64^3 cells, the picture small."""

import json
import pathlib
import subprocess
import tempfile

import records

EDGES = (32, 64)


def main():
    arguments = records.tool_arguments(__doc__)
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        grid, stats, picture = (pathlib.Path(folder) / name for name in ("grid.vts", "stats.json", "picture.exr"))
        for edge in EDGES:
            subprocess.run([f"{arguments.bin}/vol-phantom", "twisted-box", "--dims", "x".join([str(edge + 1)] * 3), "-o", grid], check=True)
            for name, options in {"sheets": [], "physical": ["--thickness", "physical"], "rays": ["--method", "rays", "--tolerance", "1e-2"]}.items():
                subprocess.run([f"{arguments.bin}/curv-tricubic", grid, "-o", picture, "--size", "32x32", "--stats", stats, "--quiet", *options],
                               check=True)
                found.setdefault(name, []).append(json.loads(stats.read_text())["peak_rss_bytes"])
    cells = [edge ** 3 for edge in EDGES]
    per_cell = {name: (peaks[1] - peaks[0]) / (cells[1] - cells[0]) for name, peaks in found.items()}
    pathlib.Path(arguments.output).write_text(json.dumps({"cells": cells, "bytes": found, "bytes_per_cell": per_cell}, indent=1))


if __name__ == "__main__":
    main()
