#!/usr/bin/python3
"""Table of a `bounds` sweep: for every scene and bound the largest error of all views, and what the bound cost."""

import json
import pathlib
import statistics

import records

COLUMNS = ["dataset", "scene", "setting", "views", "refused", "largest", "estimate", "kept", "samples", "ms"]


def is_over(picture, asked):
    """The truth itself is known to its tolerance."""
    return not picture["refused"] and picture["bound"] is not None and picture["largest"] > float(picture["bound"]) + asked["tolerance"]


def rows_of(group, pictures, asked):
    for bound in dict.fromkeys(p["bound"] for p in pictures):
        drawn = [p for p in pictures if p["bound"] == bound and not p["refused"]]
        refused = sum(p["refused"] for p in pictures if p["bound"] == bound)
        row = dict.fromkeys(COLUMNS, "")
        row |= dict(zip(COLUMNS, group.split("/")))
        row |= {"setting": "uniform" if bound is None else f"--max-error {float(bound):g}", "views": len(drawn) + refused,
                "refused": refused}
        if drawn:
            largest = max(p["largest"] for p in drawn)
            row |= {"largest": f"{largest:.3g}", "samples": round(statistics.median(p["samples"] for p in drawn)),
                    "ms": f"{1e3 * statistics.median(p['seconds'] for p in drawn):.2f}"}
            if bound is not None:
                over = sum(is_over(p, asked) for p in drawn)
                row |= {"estimate": f"{max(p['estimate'] for p in drawn):.3g}", "kept": f"NO, {over} not" if over else "yes"}
        yield row


def main():
    arguments = records.table_arguments(__doc__, "settings")
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, rows, missed = settings["sweep"], [], 0
    for group in settings["groups"]:
        drawn = json.loads((pathlib.Path(settings["out"]) / "bounds" / f"{group}.json").read_text())
        missed += sum(is_over(p, asked) for p in drawn)
        rows += rows_of(group, drawn, asked)
    pictures = sum(r["views"] for r in rows if r["setting"] != "uniform")
    refused = sum(r["refused"] for r in rows)
    text = (f"# Whether --max-error keeps its bound\n\n{pictures} pictures of {asked['size']} pixels from {asked['views']} random views of each"
            f" scene: {'none' if not missed else missed} over its bound, {refused} refused (status 2).\n*Largest*: measured against the"
            " reference integral, over all views; *estimate*: what the tool said beforehand. Linear colours,\n0 to 1; a picture's error"
            f" may exceed its bound by the truth's own tolerance, {asked['tolerance']}. *uniform*: `{asked['beside']}`.\nTimes and samples are"
            " medians of the views, all threads; what is prepared once a scene is not in them.\n\n")
    records.write_table(arguments, COLUMNS, rows, text)


if __name__ == "__main__":
    main()
