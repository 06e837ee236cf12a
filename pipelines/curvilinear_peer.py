#!/usr/bin/python3
"""VTK's unstructured-grid volume mappers beside curv-tricubic: one grid carrying a field known in closed form, every frame's time
and its error against the field itself, drawn by rays on a refined grid."""

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


def main():
    arguments = records.tool_arguments(__doc__, "settings")
    output = pathlib.Path(arguments.output)
    if not shutil.which("xvfb-run") or not importlib.util.find_spec("vtk"):
        output.write_text(json.dumps({"absent": "python3-vtk9 or xvfb is not installed"}))
        return
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    sweep_of, folder = settings["sweep"], (pathlib.Path(settings["out"]) / "peer").resolve()
    asked, size = sweep_of["peer"], sweep_of["sizes"][0]
    folder.mkdir(parents=True, exist_ok=True)
    entry = yaml.safe_load((sweep.ROOT / "configs/data.yaml").read_text())["grids"][asked["grid"]]
    coarse, refined, scene = folder / "coarse.vts", folder / "refined.vts", folder / "scene.yaml"
    made = subprocess.run([*MAKER, "make", sweep.locate(entry), sweep.locate({"file": entry["solution"]}), str(asked["refined"]), coarse,
                           refined], check=True, stdout=subprocess.PIPE, text=True)
    box = json.loads(made.stdout)
    width = WIDTH * box["longest"]
    scene.write_text(yaml.safe_dump({"camera": {"target": box["centre"]}, "reference_length": UNIT, "transfer": transfer()}))
    azimuth, elevation = (float(x) for x in asked["view"].split(","))

    def words(grid, turn=0):
        return [str(grid), "--variable", "field", "--scene", str(scene), "--view", f"{azimuth + turn},{elevation}", "--width", str(width)]

    curvilinear.Drawer(arguments.bin, words(refined), size, folder).draw(f"--method rays --tolerance {sweep_of['tolerance']}", "truth")
    truth = folder / "truth.exr"
    rounds.say("peer: the truth")
    described = {"extinction": EXTINCTION, "colours": COLOURS, "unit": UNIT, "width": width, "centre": box["centre"], "elevation": elevation,
                 "size": int(size.split("x")[0])}
    turn = [0]
    errors, contenders, workers = {}, {}, []
    for name, mapper in asked["mappers"].items():
        worker = Worker(coarse, described, 2, mapper)
        workers.append(worker)
        name = f"VTK, {name}"
        picture = folder / f"{mapper}.tif"
        worker.ask(azimuth)
        worker.ask(azimuth, picture)
        errors[name] = curvilinear.Drawer(arguments.bin, [], size, folder).compare(picture, truth)
        # A hair further round, so that nothing is served from a cache.
        contenders[name] = lambda w=worker: min(w.ask(azimuth + turn[0] + 1e-3 * k) for k in range(2))
    for name, options in asked["ours"].items():
        drawer = curvilinear.Drawer(arguments.bin, words(coarse), size, folder)
        drawer.draw(options, "ours")
        errors[name] = drawer.compare(folder / "ours.exr", truth)
        repeat = 1 if "rays" in name else 3
        contenders[name] = lambda o=options, r=repeat: curvilinear.Drawer(arguments.bin, words(coarse, turn[0]), size, folder).seconds(
            f"{o} --threads 2", r)
    rounds.say(f"peer: {len(errors)} pictures")

    def before(number):
        turn[0] = max(number, 0)

    quick = {name: c for name, c in contenders.items() if not name.startswith("rays")}
    seconds = rounds.interleaved(quick, asked["rounds"], before=before)
    turn[0] = 0
    for name in contenders.keys() - quick.keys():
        seconds[name] = [contenders[name]()]
    for worker in workers:
        worker.close()
    output.write_text(json.dumps({"rows": [{"name": name, "rmse": errors[name][0], "max": errors[name][1], "seconds": seconds[name]}
                                           for name in contenders]}, indent=1))


if __name__ == "__main__":
    main()
