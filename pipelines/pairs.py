"""Pictures that the report offers for comparison, truth beside approximation: files in NAME/pairs and a list of them, pairs.json.

A list has one entry a truth:
    {"title": ..., "truth": {"label", "picture"}, "others": [{"label", "picture", "error" or "", "figures" or ""}, ...]}
where pictures are names of PNG files beside the list; `error` is the picture of the difference, `figures` what is known of it."""

import json
import pathlib
import shutil

LIST = "pairs/pairs.json"


def other(label, picture, error="", figures=""):
    return {"label": label, "picture": picture, "error": error, "figures": figures}


def entry(title, truth_label, truth, others):
    return {"title": title, "truth": {"label": truth_label, "picture": truth}, "others": others}


def write(folder, entries, pictures):
    """Makes folder/pairs anew. `pictures`: {name in the entries: path of a PNG file}, which are copied."""
    place = pathlib.Path(folder) / "pairs"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    for name, path in pictures.items():
        shutil.copyfile(path, place / name)
    (pathlib.Path(folder) / LIST).write_text(json.dumps(entries, indent=1) + "\n")


def read(folder):
    path = pathlib.Path(folder) / LIST
    return json.loads(path.read_text()) if path.exists() else []
