#!/usr/bin/python3
"""Tables, plot and contact sheet of a `curvilinear` sweep."""

import argparse
import csv
import json
import pathlib
import statistics

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

import records  # noqa: E402
import rounds  # noqa: E402

COUNTS = ["cells", "circles", "sheets", "points", "samples", "redundant", "holes"]


def rows_of(grid):
    for drawn in grid["drawn"]:
        yield {"grid": grid["grid"], "size": drawn["size"], "setting": drawn["setting"], **{c: drawn["counts"][c] for c in COUNTS},
               "rmse": f"{drawn['rmse']:.3g}", "max": f"{drawn['max']:.3g}"}


def lines(header, rows):
    table = [header, ["---"] * len(header), *rows]
    return "\n" + "".join("| " + " | ".join(map(str, line)) + " |\n" for line in table)


def timed(grid):
    return bool(grid["seconds"])


def tricubic_over_trilinear(grids, asked):
    text = ("\n## Tricubic over trilinear\n\nTimes are medians of 3 interleaved runs (rays: of one run), all threads, of the picture alone. The paper's are seconds on"
            " a Sun 4/690MP; its trilinear ones compute\nthe tricubic control points too, ours do not.\n")
    rows = []
    for grid in filter(timed, grids):
        paper = asked["grids"][grid["grid"]].get("published")
        said = f"{paper['tricubic']} / {paper['trilinear']} = {paper['tricubic'] / paper['trilinear']:.2f}" if paper else ""
        seconds = grid["seconds"]
        rows.append([grid["grid"], *(f"{1e3 * statistics.median(seconds[kind]):.1f}" for kind in ("tricubic", "trilinear")),
                     *(rounds.shown(rounds.ratio(seconds[prefix + "tricubic"] if not prefix else seconds["physical"],
                                                 seconds[prefix + "trilinear"])) for prefix in ("", "physical ")), said])
    return text + lines(["grid", "tricubic, ms", "trilinear, ms", "ratio", "ratio, physical", "published"], rows)


def sheets_and_rays(grids, asked):
    text = ("\n## Sheets of physical thickness and rays\n\nRMSE and largest difference of linear colours from the same picture by rays, tolerance"
            f" {asked['tolerance']}, which has no holes;\n*rays / sheets*: times. Large differences are single pixels where the tricubic value leaves the range of the grid's points: there the\ndefault transfer function is opaque, and what is opaque between two surfaces is not seen. *within*: --max-error, which draws such pixels by rays.\n")
    rows = []
    names = [name for name, setting in asked["settings"].items() if "physical" in setting.get("options", "")]
    for grid in grids:
        for name in names:
            drawn = next(d for d in grid["drawn"] if d["setting"] == name and d["size"] == asked["sizes"][0])
            ms, ratio = "", ""
            if timed(grid):
                reference = statistics.median(grid["seconds"]["rays trilinear" if "trilinear" in name else "rays"])
                own = statistics.median(grid["seconds"][name])
                ms, ratio = f"{1e3 * own:.1f}", f"{reference / own:.1f}"
            rows.append([grid["grid"], name, f"{drawn['rmse']:.2g}", f"{drawn['max']:.2g}", drawn["counts"]["holes"], ms, ratio])
        if timed(grid):
            rows.append([grid["grid"], "rays", "", "", 0, f"{1e3 * statistics.median(grid['seconds']['rays']):.0f}", "1"])
    return text + lines(["grid", "setting", "RMSE", "largest", "holes", "ms", "rays / sheets"], rows)


def peers(found):
    if "absent" in found:
        return f"\n## Beside VTK\n\nVTK was left out: {found['absent']}.\n"
    text = ("\n## Beside VTK\n\nThe Blunt Fin's grid carrying a field known in closed form (pipelines/peers/vtk_grid.py), 512 x 512, 2 threads;"
            " errors against the field itself\nby rays on the grid refined four times along each axis. VTK draws tetrahedra, which are made beforehand,"
            " into 8 bits, of which alone an RMSE of\n0.0011 comes; its times are those of frames in a window.\n")
    rows = [[r["name"], f"{r['rmse']:.2g}", f"{r['max']:.2g}", f"{1e3 * statistics.median(r['seconds']):.0f}",
             f"{statistics.median(r['seconds']) / statistics.median(found['rows'][0]['seconds']):.2f}"] for r in found["rows"]]
    return text + lines(["program", "RMSE", "largest", "ms", "of the time of the first"], rows)


def drift(rows):
    return ("\n## Drift of forward differences\n\nThe largest distance of points from the Bernstein sum over the size of the cell, of 16 solids;"
            " *far*: float with coordinates 1000 cells off.\n" + lines(list(rows[0]), [list(r.values()) for r in rows]))


def homogeneous(rows):
    """A line a grid: physical thickness by throttle, then the plain sheets."""
    found = {}
    for row in rows:
        found.setdefault(row["grid"], {})[row["sheets"], row["throttle"]] = f"{100 * float(row['rms']):.2g} / {100 * float(row['largest']):.2g}"
    columns = list(next(iter(found.values())))
    header = ["grid", *(f"{sheets}, throttle {throttle}" for sheets, throttle in columns)]
    return ("\n## Homogeneous medium\n\nOptical depth of sheets against extinction times the length of the pixel's ray inside the grid (by rays), 512 x"
            " 512 pixels, relative errors in per cent, RMS /\nlargest, over pixels whose chord exceeds a tenth of the longest. Opacity by layers follows"
            " no length: what is left under the extinction that fits best is the glow.\n"
            + lines(header, [[grid, *cells.values()] for grid, cells in found.items()]))


def memory(found):
    return ("\n## Memory\n\n" + "; ".join(f"{name} {value:.0f} bytes a cell" for name, value in found["bytes_per_cell"].items())
            + f", the grid itself and its value among them: largest resident size at {found['cells'][1]} cells less that at"
            f" {found['cells'][0]}.\n")


def sheet(path, grids, asked):
    """A row a grid, a column a setting."""
    chosen = asked["pictures"]
    figure, axes = plt.subplots(len(grids), len(chosen), figsize=(2.2 * len(chosen), 2.3 * len(grids)), squeeze=False)
    for row, grid in zip(axes, grids):
        for place, name in zip(row, chosen):
            place.imshow(plt.imread(pathlib.Path(grid["folder"]) / f"{name}.png"))
            place.set_title(f"{grid['grid']}: {name}", fontsize=6, pad=2)
            place.set_xticks([])
            place.set_yticks([])
    figure.tight_layout(pad=0.3)
    figure.savefig(path, dpi=130, metadata={"Software": None})


def throttle_plot(path, grids, asked):
    """Error over throttle, sheets of physical thickness; and over time where there are times."""
    plots = 2 if any(map(timed, grids)) else 1
    figure, axes = plt.subplots(1, plots, figsize=(5 * plots, 4), squeeze=False)
    settings = {name: s.get("throttle", 1) for name, s in asked["settings"].items() if s.get("options") == "--thickness physical"}
    ordered = sorted(settings, key=settings.get)
    for number, grid in enumerate(grids):
        colour = f"C{number}"
        errors = {d["setting"]: d["rmse"] for d in grid["drawn"] if d["size"] == asked["sizes"][0]}
        axes[0][0].loglog([settings[n] for n in ordered], [errors[n] for n in ordered], "o-", color=colour, label=grid["grid"])
        if timed(grid):
            axes[0][1].loglog([1e3 * statistics.median(grid["seconds"][n]) for n in ordered], [errors[n] for n in ordered], "o-",
                              color=colour, label=grid["grid"])
    axes[0][0].set_xlabel("throttle, pixels")
    axes[0][0].set_ylabel("RMSE against rays")
    axes[0][0].legend(fontsize=7)
    if plots > 1:
        axes[0][1].set_xlabel("ms")
        axes[0][1].legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=110, metadata={"Software": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("found", nargs="+")
    arguments = parser.parse_args()
    asked = json.loads(pathlib.Path(arguments.settings).read_text())["sweep"]
    parts = {pathlib.Path(path).stem: pathlib.Path(path) for path in arguments.found}
    read = [json.loads(pathlib.Path(path).read_text()) for path in arguments.found if pathlib.Path(path).parent.name in ("drawn", "times")]
    seconds_of = {part["grid"]: part["seconds"] for part in read if "seconds" in part}
    grids = [{**part, "seconds": seconds_of.get(part["grid"], {})} for part in read if "drawn" in part]
    folder = pathlib.Path(arguments.output)
    rows = [row for grid in grids for row in rows_of(grid)]
    with open(folder / "table.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    text = (f"# Curvilinear grids by sheets and rays\n\n{asked['sizes'][0]} pixels where nothing else is said. The delta wing is a phantom of the"
            " paper's size and kind, 40 x 80 x 40: the original grid is not\npublic. Pictures: [contact sheet](pictures.png); errors by"
            " throttle and time: [plot](throttle.png).\n")
    if any(map(timed, grids)):
        text += tricubic_over_trilinear(grids, asked)
    text += sheets_and_rays(grids, asked)
    for name, write, load in (("peer", peers, lambda path: json.loads(path.read_text())), ("homogeneous", homogeneous, records.read_csv),
                              ("drift", drift, records.read_csv),
                              ("memory", memory, lambda path: json.loads(path.read_text()))):
        if name in parts:
            text += write(load(parts[name]))
    text += ("\n## All settings\n\n*rmse*, *max*: of physical thickness against rays, else against the same options at a throttle of"
             f" {asked['finest']}. *holes*: pixels without a sample between\ntwo with; *redundant*: points that fall on a pixel their sheet has"
             " already; *circles*: of cells that hide one another in turn.\n")
    header = [*rows[0], "ms"]
    seconds = {(grid["grid"], name): statistics.median(s) for grid in grids for name, s in grid["seconds"].items()}
    text += lines(header, [[*row.values(), f"{1e3 * seconds[row['grid'], row['setting']]:.1f}"
                            if row["size"] == asked["sizes"][0] and (row["grid"], row["setting"]) in seconds else ""] for row in rows])
    (folder / "table.md").write_text(text)
    sheet(folder / "pictures.png", grids, asked)
    throttle_plot(folder / "throttle.png", grids, asked)


if __name__ == "__main__":
    main()
