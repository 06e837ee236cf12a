#!/usr/bin/python3
"""Times of the same pictures of ever larger volumes, interleaved, and how they grow beside the samples."""

import itertools
import json
import pathlib
import statistics

import raycaster
import records
import rounds
import sweep

COLUMNS = ["scene", "setting", "picture", "threads", "volume", "samples", "ms", "ns a sample", "growth of samples", "growth of time", "time over samples"]


def measured(settings, binaries):
    """{(scene, setting, picture, threads): {volume: (samples, seconds of each round)}}"""
    asked, found = settings["sweep"], {}
    scenes = dict.fromkeys(g.split("/")[1] for g in settings["groups"])
    for scene, (picture, sizes), (name, options) in itertools.product(scenes, asked["pictures"].items(), asked["settings"].items()):
        own = {g.split("/")[0]: raycaster.Raycaster(binaries, raycaster.volume_at(settings, g.split("/")[0]), sweep.scene(g),
                                                    sizes[g.split("/")[0]], None, pathlib.Path(settings["out"]) / "pictures" / g)
               for g in settings["groups"] if g.split("/")[1] == scene}
        samples = {volume: caster.render(options)["counts"]["samples"] for volume, caster in own.items()}
        for threads in asked["threads"]:
            times = rounds.interleaved({volume: lambda c=caster, o=options, t=threads: c.seconds(o, t, asked["repeats"])
                                        for volume, caster in own.items()}, asked["rounds"])
            found[scene, name, picture, threads] = {volume: (samples[volume], times[volume]) for volume in own}
            rounds.say(f"{scene}: {name}, {picture}, {threads} threads")
    return found


def rows_of(found):
    for (scene, name, picture, threads), volumes in found.items():
        before = None
        for volume, (samples, seconds) in volumes.items():
            median = statistics.median(seconds)
            row = dict.fromkeys(COLUMNS, "") | {"scene": scene, "setting": name, "picture": picture, "threads": threads, "volume": volume, "samples": samples,
                                                "ms": f"{1e3 * median:.2f}", "ns a sample": f"{1e9 * median / samples:.2f}"}
            if before:
                more = samples / before[0]
                row |= {"growth of samples": f"{more:.2f}", "growth of time": rounds.shown(rounds.ratio(seconds, before[1])),
                        "time over samples": rounds.shown(rounds.ratio([s / more for s in seconds], before[1]))}
            before = samples, seconds
            yield row


def main():
    arguments = records.table_arguments(__doc__, "settings", tools=True)
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, rows = settings["sweep"], list(rows_of(measured(settings, arguments.bin)))
    said = ", ".join(f"*{name}*: `{options}`" for name, options in asked["settings"].items())
    pictures = "; ".join(f"*{name}*: {', '.join(f'{p} pixels of {v}' for v, p in sizes.items())}" for name, sizes in asked["pictures"].items())
    text = (f"# A frame's time over the size of the volume\n\nThe bust phantom in bytes, in the same box at every size, steps of half a voxel. {said}."
            f" Pictures: {pictures}.\nMedians of {asked['rounds']} interleaved rounds; growth from the size before with its 95 % interval;"
            " *time over samples* at most 1: time grows\nno faster than the samples.\n\n")
    records.write_table(arguments, COLUMNS, rows, text)


if __name__ == "__main__":
    main()
