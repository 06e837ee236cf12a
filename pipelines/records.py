"""Reads what a sweep left behind: stats records of the runs and errors of their pictures, as rows of one table."""

import argparse
import csv
import json
import pathlib

import sweep

KEY = ["dataset", "scene", "method", "wavelet", "epsilon", "quadrature", "step"]
ACCURACY = ["samples", "mse_uniform", "mse_truth"]
COST = ["time_s", "index_s", "transform_s"]
COLUMNS = KEY + ACCURACY + COST


def table_arguments(description, *inputs, folder=False, tools=False):
    """The command line of a program that makes tables: its inputs (of "found..." one or more), --bin where it runs `tools`, and
    as -o a folder for what it makes, or else --csv and --markdown."""
    parser = argparse.ArgumentParser(description=description)
    for name in inputs:
        parser.add_argument(name.removesuffix("..."), nargs="+" if name.endswith("...") else None)
    if tools:
        parser.add_argument("--bin", required=True, help="folder of the tools")
    if folder:
        parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder")
    else:
        parser.add_argument("--csv", required=True)
        parser.add_argument("--markdown", required=True)
    return parser.parse_args()


def tool_arguments(description, *inputs):
    """The command line of a program that runs tools: its inputs, --bin where the tools are, and -o what it makes."""
    parser = argparse.ArgumentParser(description=description)
    for name in inputs:
        parser.add_argument(name)
    parser.add_argument("--bin", required=True, help="folder of the tools")
    parser.add_argument("-o", "--output", required=True)
    return parser.parse_args()


def write_table(arguments, columns, rows, text):
    """The rows as --csv, and behind `text` as --markdown."""
    with open(arguments.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    lines = [columns, ["---"] * len(columns)] + [[row[c] for c in columns] for row in rows]
    pathlib.Path(arguments.markdown).write_text(text + "".join("| " + " | ".join(map(str, c)) + " |\n" for c in lines))


def load(path):
    return json.loads(pathlib.Path(path).read_text())


def number(value, digits):
    return "" if value is None else f"{value:.{digits}g}"


def byte_scale_mse(figures):
    """Mean over the channels, on the byte scale, of one result of img-compare --json."""
    return figures["all"]["mse_byte"]


def rows(settings):
    """One dict a run, in the order of the sweep; figures as they are written to the table."""
    out = pathlib.Path(settings["out"])
    errors = {group: load(out / "errors" / f"{group}.json") for group in settings["groups"]}
    for run in sweep.runs(settings["sweep"], settings["datasets"]):
        folder = out / "runs" / run.group / run.series
        stats = load(folder / f"{run.name}.json")
        row = {key: getattr(run, key) for key in KEY}
        row["index_s"] = ""
        row["samples"] = str(stats["counts"]["samples"])
        row["mse_uniform"] = number(byte_scale_mse(errors[run.group][run.name]["uniform"]), 6)
        row["mse_truth"] = number(byte_scale_mse(errors[run.group][run.name]["truth"]), 6)
        row["time_s"] = number(sweep.render_seconds(stats), 4)
        if run.wavelet:
            row["index_s"] = number(load(folder / f"{run.name}.index.json")["time_s"]["compute"], 4)
            transform = load(out / "coefficients" / run.dataset / f"{run.wavelet}.json")
            row["transform_s"] = number(transform["time_s"]["compute"], 4)
        yield row


def write_csv(path, table):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


def read_csv(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))
