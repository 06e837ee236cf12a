#!/usr/bin/python3
"""Our ray caster beside others on the same volume, view, transfer function and step; runs interleaved, the camera turned one
degree a round; every picture's error is against the reference integral."""

import csv
import importlib.util
import itertools
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys

import yaml

import raycaster
import records
import rounds
import sweep

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "peers"))
CALLERS = pathlib.Path(__file__).resolve().parent / "peers"
WIDTH = 1.6  # of the window, in edges: vol-raycast's default
SCREENING = 5  # rounds in which the fastest of our settings is chosen


class Worker:
    """A caster in a process of its own that casts a frame for a line and answers with a line."""

    def __init__(self, command):
        self.process = subprocess.Popen([str(c) for c in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit("peers: a caster ended without an answer: " + " ".join(self.process.args))
        return json.loads(answer)["seconds"]

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def missing():
    """{peer: why it is skipped}"""
    found = {}
    if not shutil.which("xvfb-run") or not importlib.util.find_spec("vtk"):
        found["VTK"] = "python3-vtk9 or xvfb is not installed"
    if not shutil.which("teem-miter"):
        found["teem"] = "teem-apps is not installed"
    return found


class Bench:
    """One scene: our caster and the peers', and what was measured."""

    def __init__(self, settings, binaries, scene):
        self.asked, self.out, self.name = settings["sweep"], pathlib.Path(settings["out"]), scene
        group = f"ball/{scene}"
        self.folder = self.out / "pictures" / group
        self.volume = sweep.volume("ball", settings["out"])
        size = self.asked["size"]
        self.own = raycaster.Raycaster(binaries, self.volume, sweep.scene(group), size,
                                       self.out / "truth" / group / "reference.exr", self.folder)
        described = yaml.safe_load((sweep.ROOT / sweep.scene(group)).read_text())
        self.scene = {"opacity": described["transfer"]["opacity"], "colours": described["transfer"]["colours"],
                      "elevation": described["camera"]["elevation"], "width": WIDTH, "size": int(size.split("x")[0]),
                      "shading": described.get("shading")}
        self.edge = self.asked["datasets"]["ball"]["edge"]
        self.round = 0
        self.errors = {}  # options: (MSE, largest)
        self.rough = {}

    def turned(self):
        """The azimuth of the round at hand."""
        return self.asked["azimuth"] + self.round

    def ours(self, options, threads):
        view = f" --view {self.turned()},{self.scene['elevation']}"
        return self.own.seconds(options + view, threads, 3 if self.rough.get(options, 0) < 0.3 else 2)

    def measure_ours(self, options):
        stats = self.own.render(options, repeat=2)
        self.rough[options] = min(stats["time_s"]["phases"]["render"])
        self.errors[options] = self.own.error()
        return self.errors[options]

    def vtk(self, threads, *more):
        return Worker(["env", f"LP_NUM_THREADS={threads}", "xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset", "/usr/bin/python3", "-B", CALLERS / "vtk_worker.py",
                       self.volume, json.dumps(self.scene), threads, *more])

    def vtk_frame(self, worker, step, save=None, frames=2):
        """The fastest of some frames, each a hair further round, so that none is served from a cache."""
        if save:
            return worker.ask(json.dumps({"azimuth": self.asked["azimuth"], "step": step, "save": str(save)}))
        return min(worker.ask(json.dumps({"azimuth": self.turned() + 1e-3 * k, "step": step})) for k in range(frames))

    def volpack(self):
        points = [str(v) for point in self.scene["opacity"] for v in point]
        half = WIDTH / 2 * (self.edge - 1) / self.edge  # its unit cube spans whole voxels, ours the centres
        return Worker([self.out / "volpack", self.volume, self.edge, self.scene["size"], half, *self.asked["volpack_shift"], *points])

    def interleaved(self, contenders, count=None):
        """As rounds.interleaved, the camera a degree further in each round; `count` rounds in place of those asked for."""
        def turn(number):
            self.round = max(number, 0)
        times = rounds.interleaved(contenders, count or self.asked["rounds"], before=turn)
        self.round = 0
        return times


def choices(asked):
    """Every setting of ours that a peer's error may be met with."""
    listed = list(asked["further"])
    for template in asked["ours"]:
        used = [k for k in asked["values"] if "{" + k + "}" in template]
        for values in itertools.product(*(asked["values"][k] for k in used)):
            listed.append(template.format(**dict(zip(used, values))))
    return listed


def fastest(bench, error, count):
    able = [o for o, (mse, _) in bench.errors.items() if mse <= error]
    return sorted(able, key=bench.rough.get)[:count]


def screened(bench, contenders):
    """The fastest of `contenders`, by rounds of their own: a choice by the rounds that go into the table would be one of luck."""
    times = bench.interleaved(contenders, SCREENING) if len(contenders) > 1 else {}
    return min(contenders, key=lambda o: statistics.median(times.get(o, [0])), default=None)


def same_step(bench, rows, absent):
    """Table 1: one step, each thread count."""
    asked = bench.asked
    for threads in asked["threads"]:
        options = f"{asked['same']} --termination {asked['termination'] if 'sharp' in bench.name else 0}"
        error = bench.measure_ours(options)
        worker = None
        contenders = {"Precis": lambda: bench.ours(options, threads)}
        saved = bench.folder / "vtk.tif"
        if "VTK" not in absent:
            worker = bench.vtk(threads)
            bench.vtk_frame(worker, asked["same_step"], saved)
            peer_error = bench.own.error(saved)
            contenders["VTK"] = lambda: bench.vtk_frame(worker, asked["same_step"])
        times = bench.interleaved(contenders)
        rows.append(row("same step", bench, threads, "Precis", options, error, times["Precis"]))
        if worker:
            worker.close()
            rows.append(row("same step", bench, threads, "VTK", f"step {asked['same_step']}", peer_error, times["VTK"],
                            rounds.ratio(times["VTK"], times["Precis"]), options))
        rounds.say(f"{bench.name}: same step, {threads} threads")


def equal_error(bench, rows):
    """Table 2: VTK at several steps, ours at no more error."""
    worker, saved = bench.vtk(2), bench.folder / "vtk.tif"
    for step in bench.asked["vtk_steps"]:
        bench.vtk_frame(worker, step, saved)
        error = bench.own.error(saved)
        contenders = {o: (lambda o=o: bench.ours(o, 2)) for o in fastest(bench, error[0], 3)}
        against(bench, rows, "equal error", 2, "VTK", f"step {step}", error, lambda: bench.vtk_frame(worker, step), contenders)
    worker.close()


def against(bench, rows, table, threads, peer, setting, error, frame, contenders):
    best = screened(bench, contenders)
    times = bench.interleaved({peer: frame, **({best: contenders[best]} if best else {})})
    rows.append(row(table, bench, threads, peer, setting, error, times[peer], rounds.ratio(times[peer], times[best]) if best else None,
                    best))
    if best:
        rows.append(row(table, bench, threads, "Precis", best, bench.errors[best], times[best]))
    rounds.say(f"{bench.name}: {table}, {peer} {setting}")


def shear_warp(bench, rows):
    """Table 3: VolPack, one thread."""
    worker, saved = bench.volpack(), bench.folder / "volpack.pgm"
    worker.ask(f"{bench.turned()} {bench.scene['elevation']} {saved}")
    import pictures
    pictures.write_tiff(bench.folder / "volpack.tif", pictures.read_pgm(saved))
    error = bench.own.error(bench.folder / "volpack.tif")
    contenders = {o: (lambda o=o: bench.ours(o, 1)) for o in fastest(bench, error[0], 12)}  # the rough times are of two threads
    against(bench, rows, "shear-warp", 1, "VolPack", "one sample a slice", error,
            lambda: min(worker.ask(f"{bench.turned()} {bench.scene['elevation']} -") for _ in range(3)), contenders)
    worker.close()


def opengl(bench, rows):
    """Table 1 once more: VTK's OpenGL mapper, on Mesa where there is no GPU: seconds a frame."""
    worker, saved = bench.vtk(2, "gpu"), bench.folder / "vtk-gpu.tif"
    options = f"{bench.asked['same']} --termination {bench.asked['termination'] if 'sharp' in bench.name else 0}"
    bench.measure_ours(options)
    bench.vtk_frame(worker, bench.asked["same_step"], saved)
    seconds, own = [], []
    for _ in range(bench.asked["slow_rounds"]):
        seconds.append(bench.vtk_frame(worker, bench.asked["same_step"], frames=1))
        own.append(bench.ours(options, 2))
    worker.close()
    rows.append(row("same step", bench, 2, "VTK, OpenGL on Mesa", f"step {bench.asked['same_step']}", bench.own.error(saved), seconds,
                    rounds.ratio(seconds, own), options))
    rounds.say(f"{bench.name}: VTK over OpenGL")


def miter(bench, rows):
    """Table 1 once more: teem, which takes seconds a frame."""
    import teem
    caster = teem.Miter(bench.volume, bench.scene, bench.folder)
    options = f"{bench.asked['same']} --termination 0"
    bench.measure_ours(options)
    seconds, own = [], []
    for _ in range(bench.asked["slow_rounds"]):
        seconds.append(caster.frame(bench.turned(), bench.asked["same_step"], 2))
        own.append(bench.ours(options, 2))
    caster.save(bench.folder / "teem.tif")
    rows.append(row("same step", bench, 2, "teem", f"step {bench.asked['same_step']}", bench.own.error(bench.folder / "teem.tif"),
                    seconds, rounds.ratio(seconds, own), options))
    rounds.say(f"{bench.name}: teem")


def row(table, bench, threads, program, setting, error, seconds, ratio=None, ours=""):
    return {"table": table, "scene": bench.name, "threads": threads, "program": program, "setting": setting,
            "mse": f"{error[0]:.4g}", "max_error": f"{error[1]:.3g}", "time_s": f"{statistics.median(seconds):.4g}",
            "ratio": f"{ratio[0]:.3g}" if ratio else "", "ratio_low": f"{ratio[1]:.3g}" if ratio else "",
            "ratio_high": f"{ratio[2]:.3g}" if ratio else "", "ours": ours or ""}


SENTENCES = {
    "same step": "## Same step\n\nRectangle rule at half a voxel in all, space skipped that the transfer function makes invisible; in the"
                 " sharp scenes VTK and Precis end\nrays at {termination} of the light. *Ratio*: the program's time over ours. teem runs"
                 " without early termination, as a whole process less its start, {slow_rounds} rounds;"
                 "\nVTK over OpenGL is timed by the whole frame, {slow_rounds} rounds, and its error is that of 8 bits.",
    "equal error": "## Equal error\n\nVTK at several steps, and the fastest setting of ours whose error is no larger: any step,"
                   " quadrature and image refinement.\nIts error hardly falls with the step: it computes in 15 bits after the point.",
    "shear-warp": "## Shear-warp\n\nVolPack on one thread, classified beforehand, against our fastest setting at no more error. Its"
                  " picture lies beside the others' by a\nfraction of a pixel, which is corrected here: its volume is moved by {volpack_shift}"
                  " voxels to the right and up, found by least squares.",
}


def write(rows, settings, absent, arguments, host):
    asked = settings["sweep"]
    with open(arguments.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    text = (f"# Beside other ray casters\n\nA rippled ball of {asked['datasets']['ball']['edge']}^3 u8 voxels, {asked['size']} pixels,"
            f" orthographic, view {asked['azimuth']},20 and a degree\nfurther each round; grey is the value. MSE on the byte scale and largest"
            f" error (0..1) against the reference integral; VTK's from its own\n16-bit image. VTK's time is that of its CPU mapper alone; what only volume and transfer function decide (tables, empty space) is made"
            " beforehand in all."
            f" Ratios: median of {asked['rounds']} interleaved rounds with its 95 % interval; above 1\nours is faster. {host}.\n"
            "In the shaded scenes their gradients are interpolated from the voxels and VTK's normals are quantised; ours are those of"
            " the\ninterpolated field. teem lights only what faces the light, VTK and Precis both sides.\n")
    for peer, why in absent.items():
        text += f"\n{peer} was skipped: {why}.\n"
    for table, sentence in SENTENCES.items():
        lines = [["scene", "threads", "program", "setting", "MSE", "largest", "ms", "ratio", "ours"], ["---"] * 9]
        for r in (r for r in rows if r["table"] == table):
            ratio = f"{r['ratio']} ({r['ratio_low']} to {r['ratio_high']})" if r["ratio"] else ""
            lines.append([r["scene"], r["threads"], r["program"], r["setting"], r["mse"], r["max_error"],
                          f"{1e3 * float(r['time_s']):.1f}", ratio, r["ours"]])
        if len(lines) > 2:
            text += "\n" + sentence.format(**asked) + "\n\n" + "".join("| " + " | ".join(map(str, c)) + " |\n" for c in lines)
    pathlib.Path(arguments.markdown).write_text(text)


def main():
    arguments = records.table_arguments(__doc__, "settings", tools=True)
    settings = json.loads(pathlib.Path(arguments.settings).read_text())
    asked, rows, absent = settings["sweep"], [], missing()
    if not os.access(pathlib.Path(settings["out"]) / "volpack", os.X_OK):
        absent["VolPack"] = "libvolpack1-dev is not installed"
    for scene in asked["datasets"]["ball"]["scenes"]:
        bench = Bench(settings, arguments.bin, scene)
        same_step(bench, rows, absent)
        if "VTK" not in absent:
            opengl(bench, rows)
        if "teem" not in absent:
            miter(bench, rows)
        if bench.scene["shading"]:
            continue
        for options in choices(asked):
            bench.measure_ours(options)
        rounds.say(f"{scene}: {len(bench.errors)} settings of ours")
        if "VTK" not in absent:
            equal_error(bench, rows)
        if "VolPack" not in absent:
            shear_warp(bench, rows)
    stats = bench.own.render(asked["same"])["host"]
    write(rows, settings, absent, arguments, f"{stats['cpu']}, {stats['simd']}")


if __name__ == "__main__":
    main()
