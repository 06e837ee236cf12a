#!/usr/bin/python3
"""One data set and scene from random views: --max-error at every bound, and the picture that most would cast instead,
each with its time and its largest error against the reference integral."""

import json
import math
import pathlib
import random

import raycaster
import records
import rounds
import sweep


def views(asked, group):
    """AZIMUTH,ELEVATION of every view: uniform over the sphere, the same for a group in every run."""
    draw = random.Random(f"{asked['seed']} {group}")
    for _ in range(asked["views"]):
        yield f"{draw.uniform(-180, 180):.2f},{math.degrees(math.asin(draw.uniform(-1, 1))):.2f}"


def main():
    arguments = records.tool_arguments(__doc__, "settings", "group")
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, dataset = settings["sweep"], arguments.group.split("/")[0]
    folder = pathlib.Path(settings["out"]) / "pictures" / arguments.group
    caster = raycaster.Raycaster(arguments.bin, raycaster.volume_at(settings, dataset), sweep.scene(arguments.group), asked["size"],
                                 folder / "truth.exr", folder)
    found = []
    for view in views(asked, arguments.group):
        caster.render(f"--view {view} --quadrature reference --tolerance {asked['tolerance']}")
        (folder / "picture.exr").replace(caster.truth)
        for bound in [None, *asked["bounds"]]:
            options = asked["beside"] if bound is None else f"--max-error {bound}"
            stats = caster.render(f"--view {view} {options}", repeat=3)
            if stats is None:  # status 2: the bound cannot be kept, and nothing was drawn
                found.append({"view": view, "bound": bound, "refused": True})
                continue
            mse, largest = caster.error()
            found.append({"view": view, "bound": bound, "refused": False, "largest": largest, "mse": mse,
                          "estimate": (stats.get("error") or {}).get("pixel_maximum_estimate"),
                          "samples": stats["counts"]["samples"], "caster": stats["result"]["caster"],
                          "seconds": min(stats["time_s"]["phases"]["render"])})
    rounds.say(f"{arguments.group}: {asked['views']} views")
    pathlib.Path(arguments.output).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
