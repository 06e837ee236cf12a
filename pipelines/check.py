#!/usr/bin/python3
"""Holds the accuracy columns of a regenerated table against the committed one.

Rows are matched by what was run; the committed table may hold more, but where the sweep file says `every_row`. Status 1 and
a line for each row that moved further than the sweep file's `check` allows, or that only one of the tables has. A cell may hold several
figures, each of which is held. `check_of: {METHOD: {COLUMN: ...}}` allows a method's rows something else where the kernels ran on other
lanes than those that the committed tables were made with."""

import argparse
import math
import sys

import yaml

import records


def agree(new, old, allowed):
    """Whether two figures are as near as that; what is infinite or no number only agrees with itself."""
    within = allowed.get("relative", 0) * max(abs(new), abs(old)) + allowed.get("absolute", 0)
    return new == old or (math.isfinite(within) and abs(new - old) <= within)


def moved(row, committed, tolerances):
    for column, allowed in tolerances.items():
        if row[column] == committed[column]:
            continue
        if not allowed.get("equal"):
            new, old = ([float(figure) for figure in table[column].split()] for table in (row, committed))
            if len(new) == len(old) and all(agree(a, b, allowed) for a, b in zip(new, old)):
                continue
        yield f"{column} {committed[column]} -> {row[column]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sweep", help="pipelines/NAME.yaml")
    parser.add_argument("regenerated")
    parser.add_argument("committed")
    parser.add_argument("--other-lanes", action="store_true", help="the kernels' lanes are not those of the committed tables")
    arguments = parser.parse_args()
    with open(arguments.sweep) as file:
        swept = yaml.safe_load(file)
    tolerances, special, keys = swept["check"], swept.get("check_of", {}) if arguments.other_lanes else {}, swept.get("key", records.KEY)
    committed = {tuple(row[key] for key in keys): row for row in records.read_csv(arguments.committed)}
    regenerated = records.read_csv(arguments.regenerated)
    if not regenerated:
        sys.exit("check: the regenerated table is empty")
    bad = 0
    for row in regenerated:
        key = tuple(row[key] for key in keys)
        allowed = {**tolerances, **special.get(row.get("method"), {})}
        differences = list(moved(row, committed[key], allowed)) if key in committed else ["not in the committed table"]
        if differences:
            bad += 1
            print(f"{' '.join(part for part in key if part)}: {', '.join(differences)}")
    moved_rows = bad
    if swept.get("every_row"):
        for key in committed.keys() - {tuple(row[key] for key in keys) for row in regenerated}:
            bad += 1
            print(f"{' '.join(part for part in key if part)}: not in the regenerated table")
    stated = ", ".join(f"{column} {' + '.join(kind if value is True else f'{kind} {value:g}' for kind, value in allowed.items())}"
                       for column, allowed in tolerances.items())
    print(f"check: {len(regenerated) - moved_rows} of {len(regenerated)} rows agree with {arguments.committed} ({stated})")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
