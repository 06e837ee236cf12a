#!/usr/bin/python3
"""Errors of many images against two references, by img-compare: the truth, and uniform sampling at the standard
distance with the image's own quadrature (uniform-QUADRATURE.exr; the quadrature is a part of the image's name)."""

import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import sys


def figures(tool, image, reference):
    done = subprocess.run([tool, image, reference, "--json", "--metric", "mse_byte"], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(done.stderr.strip() or f"{tool} ended with status {done.returncode} on {image}")
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tool")
    parser.add_argument("--truth", required=True)
    parser.add_argument("--uniform", nargs="+", required=True)
    parser.add_argument("--series", nargs="+", required=True, help="folders of images")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    uniform = {pathlib.Path(path).stem.removeprefix("uniform-"): path for path in arguments.uniform}

    def both(image):
        name = pathlib.Path(image).stem
        quadrature = next(part for part in name.split("_") if part in uniform)
        return name, {"truth": figures(arguments.tool, image, arguments.truth),
                      "uniform": figures(arguments.tool, image, uniform[quadrature])}

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        images = sorted(str(path) for folder in arguments.series for path in pathlib.Path(folder).glob("*.exr"))
        errors = dict(pool.map(both, images))
    pathlib.Path(arguments.output).write_text(json.dumps(errors, indent=1))


if __name__ == "__main__":
    main()
