#!/usr/bin/python3
"""One data set and one kind of picture of `renderers`: of every method the settings that are the fastest at some error again, in
interleaved rounds; once, where a method is so far behind that rounds would say no more."""

import json
import pathlib
import statistics

import records
import renderers
import rounds


def contenders(rows, targets, near):
    """{(method, setting): (row, whether it is near)}: of every method the fastest at each target. Near: not slower than so many
    times the fastest of all at one of the targets."""
    chosen = {}
    for target in targets:
        able = [row for row in rows if row["rmse"] <= target]
        for method in dict.fromkeys(row["method"] for row in able):
            best = min((row for row in able if row["method"] == method), key=lambda row: row["seconds"])
            key = best["method"], best["setting"]
            is_near = best["seconds"] <= near * min(row["seconds"] for row in able)
            chosen[key] = best, is_near or chosen.get(key, (best, False))[1]
    return chosen


def times(gallery, rows, log):
    """[{method, setting, seconds of each round, once}]"""
    asked, once = gallery.asked, {}
    chosen = contenders(rows, gallery.targets, asked["near"])
    picture = gallery.folder / "timed.exr"

    def one(row):
        drawn, prepared = gallery.draw(row["family"], row["values"], picture, asked["repeats"])
        costs = renderers.costs(drawn, prepared)
        once.setdefault((row["method"], row["setting"]), []).append(costs["once"])
        return costs["seconds"]

    found = rounds.interleaved({key: lambda row=row: one(row) for key, (row, near) in chosen.items() if near}, asked["rounds"])
    found |= {key: [one(row)] for key, (row, near) in chosen.items() if not near}
    gallery.forget()
    log(f"{len(chosen)} settings, {sum(near for _, near in chosen.values())} of them in {asked['rounds']} rounds")
    return [{"method": method, "setting": setting, "seconds": taken, "once": statistics.median(once[method, setting])}
            for (method, setting), taken in found.items()]


def main():
    arguments = records.tool_arguments(__doc__, "settings", "dataset", "picture", "rows")
    gallery = renderers.Gallery(arguments.bin, records.load(arguments.settings), arguments.dataset, arguments.picture)
    found = times(gallery, records.load(arguments.rows), lambda text: rounds.say(f"{arguments.dataset}, {arguments.picture}: {text}"))
    pathlib.Path(arguments.output).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
