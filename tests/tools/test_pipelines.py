#!/usr/bin/python3
"""The pipelines' own small code: which runs a sweep file stands for, and what the check lets pass."""

import contextlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "pipelines"))
sys.path.insert(0, str(ROOT))
import check  # noqa: E402
import blobs  # noqa: E402
import fourier_truth  # noqa: E402
import isosurface  # noqa: E402
import numpy  # noqa: E402
import orders  # noqa: E402
import pareto  # noqa: E402
import pareto_table  # noqa: E402
import records  # noqa: E402
import renderers  # noqa: E402
import renderers_table  # noqa: E402
import renderers_times  # noqa: E402
import report  # noqa: E402
import report_markdown  # noqa: E402
import rounds  # noqa: E402
import sweep  # noqa: E402
import yaml  # noqa: E402

SWEEP = {
    "wavelets": ["haar", "coiflet-6"], "epsilons": [0, 3],
    "datasets": {"a": {"make": "m", "scenes": ["s", "t"]},
                 "b": {"make": "m", "sources": ["there"], "scenes": ["s"]},
                 "c": {"make": "m", "sources": ["gone"], "scenes": ["s"]},
                 "d": {"make": "m", "after": ["c"], "scenes": ["s"]}},
    "methods": {"uniform": {"quadratures": ["rectangle", "trapezoid"], "steps": ["1v", "2v", "4v"]},
                "guided": {"quadratures": ["trapezoid"], "steps": ["1v"], "index": "--x"}},
    "short": {"scenes": ["s"], "epsilons": [3], "steps": ["1v"]},
}
VOLUMES = {"there": {"file": str(ROOT / "LICENSE")}, "gone": {"file": "/no/such/file"}}


class Sweep(unittest.TestCase):
    def test_counts_and_names(self):
        datasets = sweep.datasets_at_hand(SWEEP, VOLUMES)
        self.assertEqual(list(datasets), ["a", "b"])  # c's file is gone, and d is made from c
        runs = sweep.runs(SWEEP, datasets)
        self.assertEqual(len(runs), 3 * (2 * 3 + 2 * 2))
        self.assertEqual(len({(run.group, run.name) for run in runs}), len(runs))

    def test_the_short_form_is_a_subset(self):
        datasets = sweep.datasets_at_hand(SWEEP, VOLUMES)
        short = sweep.runs(sweep.shortened(SWEEP), datasets)
        self.assertEqual(len(short), 2 * (2 + 2))
        self.assertLess(set(short), set(sweep.runs(SWEEP, datasets)))

    def test_relative_files_need_the_data_folder(self):
        saved = os.environ.pop("PRECIS_DATA", None)
        self.addCleanup(lambda: os.environ.update(PRECIS_DATA=saved) if saved else os.environ.pop("PRECIS_DATA", None))
        self.assertIsNone(sweep.locate({"file": "LICENSE"}))
        os.environ["PRECIS_DATA"] = str(ROOT)
        self.assertEqual(sweep.locate({"file": "LICENSE"}), str(ROOT / "LICENSE"))


class Rounds(unittest.TestCase):
    def test_everyone_runs_once_a_round_and_the_first_is_not_counted(self):
        order = []
        times = rounds.interleaved({n: (lambda n=n: order.append(n) or len(order)) for n in "abc"}, 4)
        self.assertEqual([len(t) for t in times.values()], [4, 4, 4])
        self.assertEqual([sorted(order[i:i + 3]) for i in range(0, 15, 3)], [list("abc")] * 5)
        self.assertGreater(len({tuple(order[i:i + 3]) for i in range(0, 15, 3)}), 1)  # the order rotates

    def test_interval_of_the_median(self):
        # 95 % of 9 values: ranks 2 and 8 (they hold the median with 96 %, ranks 3 and 7 with 82 %); of 5 not even the ends do.
        self.assertEqual(rounds.interval([3, 9, 1, 7, 5, 2, 8, 4, 6]), (5, 2, 8))
        self.assertEqual(rounds.interval([1, 2, 3, 4, 5]), (3, 3, 3))  # so none is shown
        self.assertEqual(rounds.interval(range(25))[1:], (7, 17))  # tables of the sign test

    def test_ratio_is_taken_round_by_round(self):
        self.assertEqual(rounds.ratio([2, 20, 200], [1, 10, 100]), (2, 2, 2))


class Isosurface(unittest.TestCase):
    def test_programs_are_timed_with_the_threads_they_use(self):
        cores = os.cpu_count()
        for threads in (1, cores, cores + 1):
            self.assertTrue(isosurface.runs_with(isosurface.Ours.name, threads))
            self.assertEqual(isosurface.runs_with(isosurface.ScikitImage.name, threads), threads == 1)
            self.assertEqual(isosurface.runs_with(isosurface.OpenVDB.name, threads), threads == cores)


class Orders(unittest.TestCase):
    def row(self, kind, over, error, order, **more):
        return {"kind": kind, "over": over, "asymptotic": 3, "errors": [error(v) for v in over], "order": order, **more}

    def test_slopes_of_powers_are_their_exponents(self):
        for order in (1, 2, 4):
            self.assertAlmostEqual(orders.slope(self.row("step", [2, 1, 0.5, 0.25], lambda h: 7 * h ** order, order)), order)
            self.assertAlmostEqual(orders.slope(self.row("grid", [9, 17, 33], lambda n: (n - 1) ** -order, order)), order)
            self.assertAlmostEqual(orders.slope(self.row("wavelet-levels", [3, 2, 1], lambda m: 2 ** (m * order), order)), order)
        self.assertAlmostEqual(orders.slope(self.row("width", [2, 4, 6], lambda n: 10 ** (-0.9 * n), 0.9)), 0.9)

    def test_only_the_finest_count(self):
        row = self.row("step", [4, 1, 0.5, 0.25], lambda h: h ** 2 if h < 4 else 100, 2)
        self.assertAlmostEqual(orders.slope(row), 2)

    def test_below_theory_needs_a_reason(self):
        for order, reason, verdict in ((2, {}, "kept"), (2.19, {}, "kept"), (2.21, {}, "BELOW"), (3, {"reason": "r"}, "explained"),
                                       (1, {}, "kept")):
            self.assertEqual(orders.verdict(self.row("step", [1, 0.5, 0.25], lambda h: h ** 2, order, **reason)), verdict)


class Pareto(unittest.TestCase):
    RUNS = [{"setting": s, "baseline": b, "mse": m, "seconds": t}
            for s, b, m, t in [("u1", True, 1, 1), ("u2", True, .1, 2), ("u3", True, .01, 9), ("o1", False, .05, 3), ("o2", False, .5, 1)]]

    def test_contenders_are_the_fastest_that_keep_the_error(self):
        def chosen(target, count):
            return set(pareto.contenders(self.RUNS, [target], count, None))
        self.assertEqual(chosen(1, 1), {"u1", "o2"})
        self.assertEqual(chosen(.1, 1), {"u2", "o1"})
        self.assertEqual(chosen(.02, 2), {"u3"})

    def test_where_uniform_sampling_misses_the_error_its_most_accurate_stands_in(self):
        runs = [*self.RUNS, {"setting": "u4", "baseline": True, "mse": .0105, "seconds": 8},
                {"setting": "slow", "baseline": True, "mse": .001, "seconds": 99}, {"setting": "o3", "baseline": False, "mse": 1e-4, "seconds": 4}]
        standing_in = pareto.stand_in(runs, 10)
        self.assertEqual(standing_in, "u4")  # as accurate as u3 but for a tenth, and faster; "slow" is left out
        self.assertEqual(set(pareto.contenders(runs, [5e-4], 2, standing_in)), {"u4", "o3"})
        runs = [r | {"method": r["setting"], "index_s": 2.0 if r["setting"] == "o3" else None} for r in runs]
        times = {"2": {r["setting"]: {"screened": 1, "rounds": [r["seconds"]] * 9} for r in runs}}  # u3 too, for another target
        row, = pareto_table.equal_error({"targets": [5e-4], "limit_s": 10}, {"a/b": (runs, times)})
        self.assertEqual((row["uniform"], row["other"], row["ratio"], row["reached"]), ("u4", "o3", (2, 2, 2), False))
        self.assertRegex(pareto_table.equal_error_table([row]), r"over 2\.00.*over 1\.33")  # of a first picture too
        self.assertIsNone(pareto.stand_in([], 1))

    def test_a_median_is_a_bound_where_a_bound_lies_below_it(self):
        def row(ratio, reached):
            return {"group": "a/b", "target": 1, "threads": "2", "ratio": (ratio,) * 3, "reached": reached}
        self.assertIn("| 3 | 1 | 0 | 2.00 |", pareto_table.summary([row(1, True), row(2, True), row(3, False)]))
        self.assertIn("| 3 | 1 | 0 | over 2.00 |", pareto_table.summary([row(1, False), row(2, True), row(3, True)]))
        self.assertIn("| 2 | 1 | 0 | over 2.00 |", pareto_table.summary([row(1, True), row(3, False)]))
        # A bound below 1 does not say slower; what the others miss is counted.
        self.assertIn("| 2 | 1 | 1 | over 0.70 | 1 | 0 |",
                      pareto_table.summary([row(.8, False), row(.6, True), row(1, True) | {"ratio": None}]))

    def test_screening_takes_the_shortest_of_several_times(self):
        sequence = iter([3, 5, 4, 1, 9, 9])  # of u1, u2, o2 and again
        asked = {"targets": [1], "screened": 2, "screenings": 2, "limit_s": 10}
        found = pareto.screened(self.RUNS[:2] + self.RUNS[4:], asked, lambda run: next(sequence))
        self.assertEqual([(run["setting"], run["seconds"]) for run in found], [("u1", 1), ("u2", 5), ("o2", 4)])

    def test_settings_are_chosen_by_other_times_than_measured(self):
        runs = [{"setting": "u", "method": "uniform", "baseline": True, "mse": 1, "index_s": None, "seconds": 8},
                {"setting": "lucky", "method": "split", "baseline": False, "mse": 1, "index_s": None, "seconds": 1},
                {"setting": "index", "method": "index", "baseline": False, "mse": 1, "index_s": 2.0, "seconds": 3}]

        def timed(**screened_and_round):
            return {name: {"screened": screened, "rounds": [measured] * 9} for name, (screened, measured) in screened_and_round.items()}
        # By the rounds alone, or by the first pass, "lucky" would be the fastest.
        times = {"2": timed(u=(8.0, 8.0), lucky=(9.0, 1.0), index=(3.0, 2.0)),
                 "1": timed(u=(9.0, 12.0), lucky=(1.0, 9.0), index=(3.0, 3.0))}
        two, one = pareto_table.equal_error({"targets": [1]}, {"a/b": (runs, times)})
        self.assertEqual((two["uniform"], two["other"], two["ratio"]), ("u", "index", (4, 4, 4)))
        self.assertEqual((two["ms"], two["build_ms"], two["first"]), ([8000, 2000], 2000, 2))
        self.assertEqual((one["other"], one["ratio"], one["build_ms"]), ("lucky", (12 / 9,) * 3, None))  # each number of threads its own
        row, = pareto_table.equal_error({"targets": [0.5]}, {"a/b": (runs, {"2": times["2"]})})
        self.assertEqual((row["uniform"], row["other"], row["ratio"], row["build_ms"]), (None, None, None, None))
        self.assertIn("none reaches it", pareto_table.equal_error_table([row]))

    def test_another_size_is_asked_for_what_stands_under_it(self):
        asked = {"size": "2x2", "targets": [1, 2], "tolerance": 3, "datasets": {"a": {"scenes": ["s", "t"]}, "b": {"scenes": ["s"]}},
                 "at_sizes": {"4x4": {"targets": [1], "only": ["a"], "scenes": ["s"], "of_methods": ["n"]}},
                 "methods": {"m": {"render": "m"}, "n": [{"render": "n"}, {"render": "o", "only_size": "2x2"}]}}
        self.assertEqual(sweep.groups(asked, ["a", "b"]), ["a/s", "a/t", "b/s", "a/s@4x4"])
        self.assertIs(sweep.of_group(asked, "a/t"), asked)
        there = sweep.of_group(asked, "a/s@4x4")
        self.assertEqual((there["size"], there["targets"], there["tolerance"]), ("4x4", [1], 3))
        self.assertEqual(sweep.scene("a/s@4x4"), sweep.scene("a/s"))
        self.assertEqual([family["render"] for _, family in pareto.families(asked)], ["m", "n", "o"])
        self.assertEqual([family["render"] for _, family in pareto.families(there)], ["n"])
        runs = [{"setting": s, "method": s, "baseline": s == "u", "mse": 1, "index_s": None} for s in "uo"]
        times = {"2": {s: {"screened": 1, "rounds": [1] * 9} for s in "uo"}}
        rows = list(pareto_table.equal_error(asked, {"a/s@4x4": (runs, times)}))
        self.assertEqual([row["target"] for row in rows], [1])

    def test_whole_sweep_has_no_setting_twice(self):
        asked = yaml.safe_load((ROOT / "pipelines/pareto.yaml").read_text())
        named = [pareto.setting_of(family, name, values | {rung: value}) for name, family in pareto.families(asked)
                 for values, rung, ladder in pareto.curves(family) for value in ladder]
        self.assertEqual(sorted(named), sorted(set(named)))

    def test_uniform_sampling_may_end_rays_as_early_as_the_others(self):
        asked = yaml.safe_load((ROOT / "pipelines/pareto.yaml").read_text())
        for size in (asked["size"], *asked["at_sizes"]):
            at = asked if size == asked["size"] else {**asked, **asked["at_sizes"][size], "size": size}
            ends = {True: set(), False: set()}
            for _, family in pareto.families(at):
                for values, rung, ladder in pareto.curves(family):
                    options = family["render"].format(**values | {rung: ladder[0]}).split()
                    if "--termination" in options:
                        ends[bool(family.get("baseline"))].add(options[options.index("--termination") + 1])
            self.assertLessEqual(ends[False], ends[True], size)

    def test_curves_are_all_combinations(self):
        found = list(pareto.curves({"with": {"a": [1, 2], "b": [3]}, "ladder": {"c": [5, 6]}}))
        self.assertEqual(found, [({"a": "1", "b": "3"}, "c", ["5", "6"]), ({"a": "2", "b": "3"}, "c", ["5", "6"])])


class Renderers(unittest.TestCase):
    FAMILY = {"draw": "tool {volume} --scene {scene} --filter {filter} --in {made}", "with": {"filter": ["a", "b"]}, "ladder": {"padding": [1, 2]}}

    def row(self, method, setting, rmse, seconds, **more):
        return {"method": method, "setting": setting, "rmse": rmse, "seconds": seconds, **more}

    def test_ladders_and_their_names(self):
        ladders = list(renderers.settings_of(self.FAMILY))
        self.assertEqual(ladders, [[{"filter": f, "padding": p} for p in "12"] for f in "ab"])
        self.assertEqual(renderers.shown(self.FAMILY, ladders[1][0]), "--filter b (padding 1)")

    def test_whole_sweep_has_no_setting_twice(self):
        asked = yaml.safe_load((ROOT / "pipelines/renderers.yaml").read_text())
        for name, picture in asked["pictures"].items():
            named = [(method, renderers.shown(family, values)) for method, family in pareto.families(picture)
                     for ladder in renderers.settings_of(family) for values in ladder]
            self.assertEqual(len(named), len(set(named)), name)

    def test_methods_far_behind_are_timed_once(self):
        rows = [self.row("a", "coarse", 1, 1), self.row("a", "fine", .1, 3), self.row("b", "any", .1, 50), self.row("c", "none", 5, 1)]
        chosen = renderers_times.contenders(rows, [1, .5], 20)
        self.assertEqual({key: near for key, (_, near) in chosen.items()}, {("a", "coarse"): True, ("a", "fine"): True, ("b", "any"): True})
        chosen = renderers_times.contenders(rows, [1], 20)
        self.assertEqual({key: near for key, (_, near) in chosen.items()}, {("a", "coarse"): True, ("b", "any"): False})

    def test_who_wins(self):
        rows = [self.row("a", "x", .4, 2, rounds=[2, 2, 2]), self.row("b", "y", .1, 1, rounds=[1, 1, 1]), self.row("b", "untimed", .1, .5)]
        swept = {"pictures": {"xray": {"methods": ["a", "b", "c"]}}, "targets": [.5, .2, .01]}
        lines = renderers_table.winners(swept, "xray", {("d", "xray"): rows}).splitlines()[2:]
        self.assertEqual(lines, ["| d | 0.5 | 2e+03 | **1e+03** | - | 2.00 |", "| d | 0.2 | - | **1e+03** | - |  |", "| d | 0.01 | - | - | - |  |"])

    def test_a_single_run_is_held_against_the_median_of_the_rounds(self):
        self.assertEqual(renderers_table.lead([1, 2, 4], [10]), "5.00")  # not 10 / 1, of which only the first is round by round
        self.assertEqual(renderers_table.lead([1, 2, 4], [2, 4, 8]), "2.00")

    def test_xrays_of_the_phantom_are_sums_of_its_samples(self):
        # By Poisson's formula: what a sum over all z misses of the integral is exp(-2 pi^2 sigma^2), sigma 1 and more.
        edge = 24
        found = blobs.scaled(edge)
        voxels = blobs.sampled(edge, found)
        self.assertAlmostEqual(voxels.max(), 255)
        right, down = fourier_truth.axes("0,0")
        picture = blobs.xray(edge, right, down, edge, edge)
        self.assertLess(abs(picture - voxels.sum(axis=0)[::-1]).max(), 1e-6 * picture.max())
        self.assertLess(max(abs(voxels[side]).max() for side in (0, -1)), 1e-6 * 255)  # it ends inside the box
        dense = blobs.sampled(edge, found, 3)
        self.assertLess(abs(dense[::3, ::3, ::3] - voxels).max(), 1e-9)


class Check(unittest.TestCase):
    def verdict(self, committed, regenerated, tolerances="check: {samples: {relative: 0.001}, mse_truth: {relative: 0.01, absolute: 1.0e-6}}", options=()):
        with tempfile.TemporaryDirectory() as folder:
            paths = []
            for name, table in (("old", committed), ("new", regenerated)):
                rows = [dict(zip(records.KEY, key.split())) | figures for key, figures in table.items()]
                paths.append(f"{folder}/{name}.csv")
                records.write_csv(paths[-1], rows)
            pathlib.Path(f"{folder}/sweep.yaml").write_text(tolerances)
            saved, sys.argv = sys.argv, ["check", *options, f"{folder}/sweep.yaml", paths[1], paths[0]]
            said = io.StringIO()
            try:
                with contextlib.redirect_stdout(said):
                    return check.main(), said.getvalue()
            finally:
                sys.argv = saved

    ROW = "a s m w 3 q 1v"

    def test_within_and_beyond_the_tolerance(self):
        committed = {self.ROW: {"samples": 100000, "mse_truth": 0.5}}
        for samples, mse, status in [(100000, 0.5, 0), (100090, 0.504, 0), (100200, 0.5, 1), (100000, 0.51, 1)]:
            got, said = self.verdict(committed, {self.ROW: {"samples": samples, "mse_truth": mse}})
            self.assertEqual(got, status, said)
            self.assertEqual("a s m w 3 q 1v:" in said, bool(status), said)

    def test_words_and_missing_rows(self):
        tolerances = "check: {samples: {equal: true}}\nevery_row: true"
        two = {self.ROW: {"samples": "kept"}, "b s m w 3 q 1v": {"samples": "refused"}}
        self.assertEqual(self.verdict(two, two, tolerances)[0], 0)
        got, said = self.verdict(two, {**two, self.ROW: {"samples": "NOT KEPT"}}, tolerances)
        self.assertEqual(got, 1)
        self.assertIn("samples kept -> NOT KEPT", said)
        got, said = self.verdict(two, {self.ROW: two[self.ROW]}, tolerances)
        self.assertEqual(got, 1)
        self.assertIn("b s m w 3 q 1v: not in the regenerated table", said)

    def test_cells_of_several_figures_and_what_is_no_number(self):
        tolerances = "check: {samples: {relative: 0.1}, mse_truth: {relative: 0.01}}"
        committed = {self.ROW: {"samples": "1 20 300", "mse_truth": "inf"}}
        for samples, mse, status in [("1 21 300", "inf", 0), ("1 20 400", "inf", 1), ("1 20", "inf", 1), ("1 nan 300", "inf", 1),
                                     ("1 20 300", "nan", 1), ("1 20 300", "0.5", 1), ("1 20 300", "", 1)]:
            self.assertEqual(self.verdict(committed, {self.ROW: {"samples": samples, "mse_truth": mse}}, tolerances)[0], status, (samples, mse))

    def test_what_one_method_is_allowed(self):
        tolerances = "check: {samples: {relative: 0.01}, mse_truth: {relative: 0.01}}\ncheck_of: {m: {samples: {relative: 0.1}}}"
        other = "a s n w 3 q 1v"
        committed = {key: {"samples": 100, "mse_truth": 1} for key in (self.ROW, other)}
        moved = {**committed, self.ROW: {"samples": 105, "mse_truth": 1}}
        lanes = ["--other-lanes"]
        self.assertEqual(self.verdict(committed, moved, tolerances, lanes)[0], 0)
        self.assertEqual(self.verdict(committed, moved, tolerances)[0], 1)  # on the lanes of the committed table nothing more is allowed
        self.assertEqual(self.verdict(committed, {**committed, self.ROW: {"samples": 105, "mse_truth": 1.05}}, tolerances, lanes)[0], 1)
        got, said = self.verdict(committed, {**committed, other: {"samples": 105, "mse_truth": 1}}, tolerances, lanes)
        self.assertEqual(got, 1)
        self.assertIn("a s n w 3 q 1v: samples 100 -> 105", said)

    def test_a_row_that_nobody_committed(self):
        got, said = self.verdict({}, {self.ROW: {"samples": 1, "mse_truth": 0}})
        self.assertEqual(got, 1)
        self.assertIn("not in the committed table", said)


class Reproduce(unittest.TestCase):
    def reproduce(self, *arguments):
        return subprocess.run([ROOT / "pipelines/reproduce", *arguments], capture_output=True, text=True)

    def test_every_sweep_is_listed_once(self):
        names = [name for name, _ in report.sweeps()]
        self.assertEqual(sorted(names), sorted(path.stem for path in (ROOT / "pipelines").glob("*.yaml")))
        said = self.reproduce("--help").stdout
        for name, what in report.sweeps():
            self.assertTrue(what)
            self.assertRegex(said, rf"(?m)^  {name} +{re.escape(what)}$")

    def test_every_sweep_names_its_pictures(self):
        volumes = yaml.safe_load((ROOT / "configs/data.yaml").read_text())["volumes"]
        for name, _ in report.sweeps():
            written = yaml.safe_load((ROOT / "pipelines" / f"{name}.yaml").read_text())
            for config in (written, sweep.shortened(written)):
                with self.subTest(name, short=config is not written):
                    config = sweep.with_datasets(config)
                    groups = sweep.groups(config, sweep.datasets_at_hand(config, volumes))
                    self.assertEqual(len(groups), len(set(groups)))

    @unittest.skipUnless(shutil.which("snakemake") and (ROOT / "build/release/tests/stability/stability").exists()
                         and (ROOT / "build/release/bin/vol-raycast").exists(), "needs snakemake and the release build")
    def test_every_short_sweep_can_be_planned(self):
        with tempfile.TemporaryDirectory() as folder:  # planning writes: into a tree of links, the pipelines copied
            tree = pathlib.Path(folder)
            shutil.copytree(ROOT / "pipelines", tree / "pipelines")
            for name in ("build", "configs", "lib", "tools", "tests"):
                (tree / name).symlink_to(ROOT / name)
            for name, _ in report.sweeps():
                with self.subTest(name):
                    done = subprocess.run(["snakemake", "-n", "-s", "pipelines/Snakefile", "--configfile", f"pipelines/{name}.yaml",
                                           "--cores", "1", "--config", "short_form=true"], cwd=tree, capture_output=True, text=True,
                                          env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_what_is_checked_has_a_table_to_be_held_against(self):
        marked = re.findall(r"(?m)^([a-z-]+) +check ", (ROOT / "pipelines/sweeps.txt").read_text())
        self.assertGreater(len(marked), 3)
        for name, _ in report.sweeps():
            settings = yaml.safe_load((ROOT / f"pipelines/{name}.yaml").read_text())
            self.assertEqual(settings["name"], name)
            table = ROOT / f"results/{name}/table.csv"
            if name in marked or ("check" in settings and table.exists()):
                rows = records.read_csv(table)
                self.assertLessEqual({*settings["check"], *settings.get("key", records.KEY)}, set(rows[0]), name)

    def test_unknown_words_are_refused(self):
        for word in ("--short", "nothing"):
            found = self.reproduce(word)
            self.assertEqual((found.returncode, found.stdout), (2, ""))
            self.assertIn(word, found.stderr)


def numbered(cells):
    """The numbers that cells like `figs. 2 to 4, 7: ...; 9 to 11` name, ranges filled, as (chapter or 0, number)."""
    found = set()
    for cell in cells:
        for first, last in re.findall(r"(\d+(?:\.\d+)?)(?: to (\d+(?:\.\d+)?))?", cell):
            parts = [tuple(map(int, f"0.{n}".split(".")[-2:])) for n in (first, last or first)]
            found |= {(parts[0][0], n) for n in range(parts[0][1], parts[1][1] + 1)}
    return found


class FrontPage(unittest.TestCase):
    TEXT = (ROOT / "results/README.md").read_text()

    def test_links_of_all_pages_lead_to_what_is_there(self):
        pages = [ROOT / "README.md", ROOT / "lib/README.md", *(ROOT / "results").glob("**/*.md")]
        self.assertGreater(len(pages), 5)
        for page in pages:
            for words, target in report_markdown.links(page.read_text()):
                if not re.match(r"[a-z]+:", target):
                    self.assertTrue((page.parent / target.split("#")[0]).exists(), f"{page}: [{words}]({target})")

    def test_every_figure_and_table_of_the_papers_is_named(self):
        papers = {"Gross": ([(0, n) for n in range(1, 16)], []), "He": ([(0, n) for n in range(1, 5)], [(0, 1), (0, 2)]),
                  "Bethel": ([(0, n) for n in range(1, 6)], []),
                  "Cheng": ([(c, n) for c, last in ((1, 4), (2, 17), (3, 5), (4, 20)) for n in range(1, last + 1)], [(4, n) for n in range(1, 7)])}
        for paper, (figures, tables) in papers.items():
            section = re.search(rf"(?ms)^## {paper}[^\n]*\n(.*?)(?=^## |\Z)", self.TEXT)[1]
            rows = [report_markdown.cells(line) for line in section.splitlines() if line.startswith("|")][2:]
            self.assertTrue(all(there and here for there, here in rows), paper)
            for kind, wanted in (("fig", figures), ("table", tables)):
                named = numbered([there for there, _ in rows if there.startswith(kind)])
                self.assertEqual(set(wanted) - named, set(), f"{paper}: no row for these {kind}s")

    def test_what_a_sweep_left_is_reached_from_it(self):
        reached = {target for _, target in report_markdown.links(self.TEXT)}
        for path in (ROOT / "results").glob("*/*"):
            if path.suffix in (".md", ".png"):
                self.assertIn(str(path.relative_to(ROOT / "results")), reached)


class Markdown(unittest.TestCase):
    def test_a_table_and_what_stands_in_a_line(self):
        made = report_markdown.to_html("# A *b*\n\nx < `*y*` and\n[z](q.md)\n\n| a | b |\n|---|---|\n| **1** | <2 |\n",
                                       lambda target: "#there" if target == "q.md" else None, 2)
        self.assertIn("<h2>A <em>b</em></h2>", made)
        self.assertIn('<p>x &lt; <code>*y*</code> and <a href="#there">z</a></p>', made)
        self.assertIn("<td><strong>1</strong><td>&lt;2</tbody>", made)

    def test_products_are_no_emphasis_and_unknown_links_are_words(self):
        self.assertEqual(report_markdown.inline("2 * 3 * 4 and a*b*c, [w](gone.md)", lambda target: None), "2 * 3 * 4 and a*b*c, w")


if __name__ == "__main__":
    unittest.main()
