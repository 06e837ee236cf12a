#!/usr/bin/python3
"""The page of all results in a browser: it says nothing on the console, asks nobody for anything, its tables sort when their heads are
clicked, its pairs of pictures follow the slider and the choice, and its links lead somewhere. Status 77: no browser is installed.

    report.py [PAGE]      of a page that was made before, or of one that is made of results/ now"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import browser

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGE = pathlib.Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 and sys.argv[1].endswith(".html") else None


def column(page, table, index):
    return page.value(f"[...document.querySelectorAll('table')[{table}].tBodies[0].rows].map(r => r.cells[{index}].textContent.trim())")


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.file = PAGE or pathlib.Path(cls.folder.name) / "report.html"
        if not PAGE:
            subprocess.run([sys.executable, "-B", ROOT / "pipelines/report.py", "-o", cls.file], check=True, capture_output=True)
        cls.page = browser.Page(browser.found(), cls.file.as_uri())

    @classmethod
    def tearDownClass(cls):
        cls.page.close()
        cls.folder.cleanup()

    def tearDown(self):
        self.assertEqual(self.page.complaints, [])

    def test_it_is_one_file_of_a_size_to_be_sent_around(self):
        self.assertEqual([url for url in self.page.requests if not url.startswith("data:")], [self.file.as_uri()])
        # And what a page could ask for later: nothing in it names another place.
        outside = self.page.value("""[...document.querySelectorAll('[src], [href], [srcset], [action]')].flatMap(e =>
            ['src', 'href', 'srcset', 'action'].map(a => e.getAttribute(a)).filter(v => v && !/^(data:|#)/.test(v)))""")
        self.assertEqual(outside, [])
        self.assertLess(self.file.stat().st_size, 10e6)

    def test_pictures_are_drawn(self):
        broken = self.page.value("Promise.all([...document.images].map(i => i.decode().then(() => i.naturalWidth > 0, () => false)))"
                                 ".then(ok => ok.filter(x => !x).length)")
        self.assertEqual(broken, 0)
        self.assertGreater(self.page.value("document.images.length"), 10)
        self.assertEqual(self.page.value("[...document.images].filter(i => !i.alt).length"), 0)

    def test_links_lead_to_what_is_there_once(self):
        self.assertEqual(self.page.value("[...document.links].filter(a => !document.getElementById(a.hash.slice(1))).map(a => a.hash)"), [])
        twice = self.page.value("(ids => ids.filter((id, i) => ids.indexOf(id) !== i))([...document.querySelectorAll('[id]')].map(e => e.id))")
        self.assertEqual(twice, [])

    def test_every_sweep_with_results_has_its_section(self):
        for place in (ROOT / "results").glob("*/table.csv"):
            self.assertTrue(self.page.value(f"!!document.getElementById({json.dumps(place.parent.name)})"), place)

    def test_a_click_on_a_head_sorts(self):
        # A table of more than ten rows with a column of plain numbers that is not in order yet.
        table, index = self.page.value("""(() => { const tables = [...document.querySelectorAll('table')];
            for (const [t, table] of tables.entries()) {
              if (table.closest('details')) continue;
              for (let c = 0; c < table.tHead.rows[0].cells.length; ++c) {
                const v = [...table.tBodies[0].rows].map(r => r.cells[c].textContent.trim());
                if (v.length > 10 && v.every(x => x !== '' && !isNaN(x)) && v.some((x, i) => i && +x < +v[i - 1])) return [t, c];
              } } })()""")
        self.page.value(f"""document.querySelectorAll('table')[{table}].tHead.rows[0].cells[{index}].id = 'clicked'""")
        before = [column(self.page, table, c) for c in (0, index)]
        numbers = sorted(map(float, before[1]))
        self.page.click("#clicked button")
        self.assertEqual(list(map(float, column(self.page, table, index))), numbers)
        self.assertEqual(self.page.value("document.getElementById('clicked').getAttribute('aria-sort')"), "ascending")
        self.page.click("#clicked button")
        self.assertEqual(list(map(float, column(self.page, table, index))), numbers[::-1])
        self.assertEqual(self.page.value("document.getElementById('clicked').getAttribute('aria-sort')"), "descending")
        after = [column(self.page, table, c) for c in (0, index)]
        self.assertEqual(sorted(zip(*after)), sorted(zip(*before)))  # whole rows moved, none was lost

    def test_order_of_figures_words_and_nothing(self):
        ordered = self.page.value("""(() => { const t = document.createElement('table');
            t.innerHTML = '<thead><tr><th>v</th></tr></thead><tbody>' +
              ['10', '', 'none', '9.5 (9 to 11)', '-1e-3', '1,200', '**no**', '2 4 6', '0.5v'].map(v => `<tr><td>${v}</td></tr>`).join('') + '</tbody>';
            sortBy(t, 0); const up = [...t.tBodies[0].rows].map(r => r.textContent);
            sortBy(t, 0); return [up, [...t.tBodies[0].rows].map(r => r.textContent)]; })()""")
        figures = ["-1e-3", "0.5v", "2 4 6", "9.5 (9 to 11)", "10", "1,200"]
        self.assertEqual(ordered[0][:6], figures)
        self.assertEqual(ordered[1][:6], figures[::-1])
        self.assertEqual([way[-1] for way in ordered], ["", ""])

    def edge(self):
        """Where the bar is and the approximation begins, in percent of the width."""
        clip = self.page.value("getComputedStyle(document.querySelector('.pair .other')).clipPath")
        left = re.fullmatch(r"inset\(0(?:px)? 0(?:px)? 0(?:px)? ([\d.]+)%\)", clip)
        self.assertTrue(left, clip)
        return float(left[1])

    def test_the_slider_moves(self):
        self.page.value("document.querySelectorAll('.pair')[0].id = 'pair'")
        self.assertEqual(self.edge(), 50)
        self.page.drag("#pair .view", 0.5, 0.2)
        self.assertAlmostEqual(self.edge(), 20, delta=1)  # of some hundred pixels
        self.page.click("#pair input")
        self.assertAlmostEqual(self.edge(), 50, delta=1)
        views, choices = {}, self.page.value("document.querySelectorAll('#pair option').length")
        self.assertGreater(choices, 1)
        for choice in (0, choices - 1):
            self.page.value(f"(s => {{ s.value = '{choice}'; s.dispatchEvent(new Event('change')); }})(document.querySelector('#pair select'))")
            shown = self.page.value("[...document.querySelectorAll('#pair [data-choice]')].filter(e => !e.hidden).map(e => e.dataset.choice)")
            self.assertEqual(set(shown), {str(choice)})
            for end, place in (("truth", 1), ("approximation", 0)):
                self.page.drag("#pair .view", 0.5, place)
                views[choice, end] = self.page.screenshot("#pair .view")
        # All truth is the same whatever is chosen; all approximation is not.
        self.assertEqual(views[0, "truth"], views[choices - 1, "truth"])
        self.assertNotEqual(views[0, "approximation"], views[choices - 1, "approximation"])
        self.assertNotEqual(views[0, "approximation"], views[0, "truth"])

    def test_it_fits_narrow_and_wide_windows(self):
        for width in (360, 1280, 1920):
            self.page.resize(width, 900)
            self.assertLessEqual(self.page.value("document.documentElement.scrollWidth"), width)
        self.page.resize(1280, 900)


if __name__ == "__main__":
    if not browser.found():
        print(f"skipped: no browser here ({', '.join(browser.NAMES)}); pipelines/setup test installs one")
        sys.exit(77)
    unittest.main()
