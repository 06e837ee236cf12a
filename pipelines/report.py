#!/usr/bin/python3
"""One page of all results: tables that can be sorted, plots, contact sheets, and pictures laid over their truth with a slider.

The page is a single file that asks nobody for anything. It is made of what stands in results/ (--full) or of what the short forms
left in out/ (--short): tables as Markdown and CSV, pictures as PNG, and the lists of pairs (pairs.py). Nothing is computed anew."""

import argparse
import base64
import csv
import html
import io
import os
import pathlib
import posixpath
import struct
import subprocess
import sys

import pairs
from report_markdown import identifier, links, table, to_html

try:
    import PIL.Image
except ImportError:  # pictures then go in as they are
    PIL = None

ROOT = pathlib.Path(__file__).resolve().parent.parent
HERE = ROOT / "pipelines"
WIDEST = 1600  # pixels of a contact sheet; wider ones are scaled down
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


def sweeps():
    """(name, what it measures) of every sweep, in the order of pipelines/sweeps.txt."""
    lines = (HERE / "sweeps.txt").read_text().splitlines()
    listed = [line.split(None, 2) for line in lines if line and not line.startswith("#")]
    return [(name, what.strip()) for name, _, what in listed]


def picture(path):
    """(address, width, height): the file as a data URI, without loss and smaller than PNG where that can be had."""
    data = path.read_bytes()
    width, height = struct.unpack(">II", data[16:24])
    kind = "png"
    if PIL:
        image = PIL.Image.open(path)
        if image.mode == "P" or (image.mode == "RGBA" and image.getextrema()[3] == (255, 255)):
            image = image.convert("RGB")
        if width > WIDEST:
            image = image.resize((WIDEST, round(height * WIDEST / width)), PIL.Image.LANCZOS)
        packed = io.BytesIO()
        image.save(packed, "WEBP", lossless=True, quality=40, method=2)
        if width > WIDEST or len(packed.getvalue()) < len(data):
            (width, height), data, kind = image.size, packed.getvalue(), "webp"
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}", width, height


def img(path, alt, width=None, height=None, attributes=""):
    address, own_width, own_height = picture(path)
    return (f'<img src="{address}" alt="{html.escape(alt)}" width="{width or own_width}" height="{height or own_height}"'
            f"{attributes and ' ' + attributes}>")


def figure(path, name, caption):
    return f'<figure id="{identifier(name)}">{img(path, caption)}<figcaption>{html.escape(caption)}</figcaption></figure>'


def pair(folder, entry):
    """The truth, the approximations to choose from, and the error of the one that is chosen."""
    place = folder / "pairs"
    truth, others = entry["truth"], entry["others"]
    _, width, height = picture(place / truth["picture"])
    scale = max(1, round(420 / width))
    width, height = scale * width, scale * height

    def chosen(n, kind=""):
        return f'class="{kind}" data-choice="{n}"{" hidden" if n else ""}'

    options = "".join(f'<option value="{n}">{html.escape(o["label"])}</option>' for n, o in enumerate(others))
    shown = "".join(img(place / o["picture"], o["label"], width, height, chosen(n, "other")) for n, o in enumerate(others))
    errors = "".join(img(place / o["error"], f"error of {o['label']}", width, height, chosen(n, "error"))
                     for n, o in enumerate(others) if o["error"])
    figures = "".join(f'<p {chosen(n, "figures")}>{html.escape(o["figures"])}</p>' for n, o in enumerate(others) if o["figures"])
    label = html.escape(f"{entry['title']}: how much of the truth is shown")
    return (f'<figure class="pair"><figcaption>{html.escape(entry["title"])}</figcaption>'
            f'<label>Beside the truth: <select>{options}</select></label>'
            f'<div class="row"><div class="column" style="width:{width}px"><div class="view">'
            f'{img(place / truth["picture"], truth["label"], width, height)}{shown}'
            f'<span class="bar"></span><b class="left">truth: {html.escape(truth["label"])}</b><b class="right">approximation</b></div>'
            f'<input type="range" min="0" max="100" step="0.5" value="50" aria-label="{label}">{figures}</div>'
            + (f'<div class="column" style="width:{width}px">{errors}<p class="figures">The error of the approximation.</p></div>' if errors else "")
            + "</div></figure>")


def all_rows(path, name):
    """A CSV file, folded up."""
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return (f'<details id="{identifier(name)}"><summary>{html.escape(name)}: all {len(rows)} rows</summary>'
            f"{table(header, rows)}</details>"), len(rows)


class Page:
    """What stands where: files of the results by their path below results/, as far as they are in the page."""

    def __init__(self, folders, front):
        self.folders = folders
        self.captions = {target: words for words, target in links(front) if target.endswith(".png")}
        self.files = {f"{name}/{file.name}": file for name, folder in folders.items() for file in sorted(folder.glob("*"))
                      if file.suffix in (".md", ".csv", ".png")}

    def resolver(self, below):
        """Of a text that lies at results/<below>: links to what is in the page; others lose their address."""
        def resolve(target):
            path = posixpath.normpath(posixpath.join(below, target.split("#")[0]))
            return f"#{identifier(path)}" if path in self.files else None
        return resolve

    def ordered(self, name, suffix):
        """Files of a sweep: tables first, pictures in the order in which the front page names them."""
        found = [path for path in self.files if path.startswith(f"{name}/") and path.endswith(suffix)]
        rank = list(self.captions)
        return sorted(found, key=lambda p: (not p.endswith(f"/table{suffix}"), rank.index(p) if p in rank else len(rank), p))

    def section(self, name, what):
        folder, resolve = self.folders[name], self.resolver(name)
        parts = [f'<section><h2 id="{name}">{html.escape(name)}: {html.escape(what)}</h2>']
        parts += [pair(folder, entry) for entry in pairs.read(folder)]
        shown = 0
        for path in self.ordered(name, ".md"):
            text = self.files[path].read_text()
            shown += sum(line.startswith("|") for line in text.splitlines())
            parts.append(f'<div id="{identifier(path)}">{to_html(text, resolve, 3)}</div>')
        sheets = [figure(self.files[path], path, self.captions.get(path, path)) for path in self.ordered(name, ".png")]
        parts.append(f'<div class="sheet">{"".join(sheets)}</div>')
        for path in self.ordered(name, ".csv"):
            rows, count = all_rows(self.files[path], path)
            if count > shown or not path.endswith("/table.csv"):
                parts.append(rows)
            else:  # every row stands in the tables above
                parts.insert(1, f'<span id="{identifier(path)}"></span>')
        return "\n".join(parts) + "</section>"


def commit():
    try:
        run = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=12"]
        return subprocess.run(run, check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def page(form):
    """The whole page as text."""
    def place(name):
        return ROOT / "results" / name if form == "full" else ROOT / "out" / f"{name}-short" / "results"
    listed = [(name, what) for name, what in sweeps() if place(name).is_dir()]
    if not listed:
        raise SystemExit("report: no sweep has left anything; run pipelines/reproduce")
    front = (ROOT / "results/README.md").read_text()
    made = Page({name: place(name) for name, _ in listed}, front)
    if form == "full":
        opening = to_html(front, made.resolver(""))
    else:
        opening = ("<h1>Results, short forms</h1><p>Smaller pictures, fewer settings and data sets, each timed once: what a few minutes give."
                   " <code>pipelines/reproduce --full</code> runs all of it.</p>")
    contents = "".join(f'<li><a href="#{name}">{html.escape(name)}</a></li>' for name, _ in listed)
    style, script = ((HERE / f"report_page.{kind}").read_text() for kind in ("css", "js"))
    body = "\n".join(made.section(name, what) for name, what in listed)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Precis: results</title>
<link rel="icon" href="data:,">
<style>
{style}</style></head>
<body><main>
<nav aria-label="Sweeps"><ul><li><a href="#top">Results</a></li>{contents}</ul></nav>
<div id="top">{opening}
<p class="made">Precis, {html.escape(commit())}. A click on a table's head sorts it. Pictures are as computed; sheets of more than
{WIDEST} pixels are scaled down.</p></div>
{body}
</main>
<script>
{script}</script></body></html>
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--full", dest="form", action="store_const", const="full", default="full", help="of results/ (default)")
    form.add_argument("--short", dest="form", action="store_const", const="short", help="of out/NAME-short/results")
    parser.add_argument("-o", "--output", default="results/report.html")
    arguments = parser.parse_args()
    text = page(arguments.form)
    beside = pathlib.Path(f"{arguments.output}.part")
    beside.write_text(text)
    os.replace(beside, arguments.output)
    print(f"report: {arguments.output}, {len(text.encode()) / 1e6:.1f} MB", file=sys.stderr)


if __name__ == "__main__":
    main()
