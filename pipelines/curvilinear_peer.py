#!/usr/bin/python3
"""VTK's unstructured-grid volume mappers beside curv-tricubic on one grid carrying a field known in closed form. `truth`: the field
itself, drawn by rays on a refined grid; `frames`: every frame's time and its error against that."""

import importlib.util
import json
import math
import pathlib
import shutil
import subprocess
import sys

import yaml

import curvilinear
import records
import rounds
import sweep

CALLER = pathlib.Path(__file__).parent / "peers/vtk_grid.py"
MAKER = ["/usr/bin/python3", "-B", CALLER]
WIDTH, UNIT = 1.28, 0.5                 # width of the picture, of the grid's longest edge; world length of the opacities
EXTINCTION = [[0, 0], [1, 0.25]]        # of a unit
COLOURS = [[0, 0.1, 0.2, 0.9], [0.5, 0.2, 0.8, 0.3], [1, 0.95, 0.5, 0.1]]
KNOTS = 64                              # of our opacity, 1 - exp(-extinction), which is linear between them


def transfer():
    low, high = EXTINCTION[0][1], EXTINCTION[1][1]
    opacity = [[n / KNOTS, -math.expm1(-(low + (high - low) * n / KNOTS))] for n in range(KNOTS + 1)]
    return {"colours": COLOURS, "opacity": opacity}


class Worker:
    def __init__(self, grid, scene, threads, mapper):
        words = ["env", f"LP_NUM_THREADS={threads}", "xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset", *MAKER, "draw", grid,
                 json.dumps(scene), threads, mapper]
        self.process = subprocess.Popen([str(w) for w in words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, azimuth, save=None):
        self.process.stdin.write(json.dumps({"azimuth": azimuth, "save": save and str(save)}) + "\n")
        self.process.stdin.flush()
        while True:
            answer = self.process.stdout.readline()
            if not answer:
                sys.exit("curvilinear_peer: VTK ended without an answer")
            if answer.startswith("{"):
                return json.loads(answer)["seconds"]

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def truth(asked, size, tolerance, binaries, folder):
    entry = yaml.safe_load((sweep.ROOT / "configs/data.yaml").read_text())["grids"][asked["grid"]]
    made = subprocess.run([*MAKER, "make", sweep.locate(entry), sweep.locate({"file": entry["solution"]}), str(asked["refined"]),
                           folder / "coarse.vts", folder / "refined.vts"], check=True, stdout=subprocess.PIPE, text=True)
    box = json.loads(made.stdout)
    scene = {"camera": {"target": box["centre"]}, "reference_length": UNIT, "transfer": transfer()}
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene))
    words = words_of(asked, folder, "refined", box)
    curvilinear.Drawer(binaries, words, size, folder).draw(f"--method rays --tolerance {tolerance}", "truth")
    rounds.say("peer: the truth")
    return box


def words_of(asked, folder, grid, box, turn=0):
    azimuth, elevation = (float(x) for x in asked["view"].split(","))
    return [str(folder / f"{grid}.vts"), "--variable", "field", "--scene", str(folder / "scene.yaml"), "--view", f"{azimuth + turn},{elevation}",
            "--width", str(WIDTH * box["longest"])]


def frames(asked, size, binaries, folder):
    box = json.loads((folder / "truth.json").read_text())
    azimuth, elevation = (float(x) for x in asked["view"].split(","))
    described = {"extinction": EXTINCTION, "colours": COLOURS, "unit": UNIT, "width": WIDTH * box["longest"], "centre": box["centre"],
                 "elevation": elevation, "size": int(size.split("x")[0])}
    turn = [0]
    errors, seconds, contenders, workers = {}, {}, {}, []
    for name, mapper in asked["mappers"].items():
        worker = Worker(folder / "coarse.vts", described, 2, mapper)
        workers.append(worker)
        name = f"VTK, {name}"
        picture = folder / f"{mapper}.tif"
        worker.ask(azimuth)
        worker.ask(azimuth, picture)
        errors[name] = curvilinear.Drawer(binaries, [], size, folder).compare(picture, folder / "truth.exr")
        # A hair further round, so that nothing is served from a cache.
        contenders[name] = lambda w=worker: min(w.ask(azimuth + turn[0] + 1e-3 * k) for k in range(2))
    for name, options in asked["ours"].items():
        def drawer():
            return curvilinear.Drawer(binaries, words_of(asked, folder, "coarse", box, turn[0]), size, folder)
        options += " --threads 2"
        stats = drawer().draw(options, "ours")
        errors[name] = drawer().compare(folder / "ours.exr", folder / "truth.exr")
        if "rays" in name:  # once is long enough
            seconds[name] = stats["time_s"]["phases"]["render"]
        else:
            contenders[name] = lambda o=options, d=drawer: d().seconds(o, 3)
    rounds.say(f"peer: {len(errors)} pictures")

    def before(number):
        turn[0] = max(number, 0)

    seconds = {**rounds.interleaved(contenders, asked["rounds"], before=before), **seconds}
    for worker in workers:
        worker.close()
    return {"rows": [{"name": name, "rmse": errors[name][0], "max": errors[name][1], "seconds": seconds[name]} for name in errors]}


def main():
    arguments = records.tool_arguments(__doc__, "what", "settings")
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    sweep_of, folder = settings["sweep"], (pathlib.Path(settings["out"]) / "peer").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    if not shutil.which("xvfb-run") or not importlib.util.find_spec("vtk"):
        found = {"absent": "python3-vtk9 or xvfb is not installed"}
    elif arguments.what == "truth":
        found = truth(sweep_of["peer"], sweep_of["sizes"][0], sweep_of["tolerance"], arguments.bin, folder)
    else:
        found = frames(sweep_of["peer"], sweep_of["sizes"][0], arguments.bin, folder)
    pathlib.Path(arguments.output).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
