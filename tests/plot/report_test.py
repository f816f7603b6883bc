#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Claims about drivers/plot/report.py; those about the plot in the page are tried out in headless Chromium where there is one.
Exit status 77: nothing to draw with."""

import contextlib
import html.parser
import importlib.util
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
try:
    import h5py  # noqa: F401
    import matplotlib.image
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)


def load(name, path):
    specification = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


report = load("report", os.path.join(HERE, "../../drivers/plot/report.py"))
results = load("plot_test", os.path.join(HERE, "plot_test.py"))
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

SUMMARY = {
    "status": "done", "note": "a <note> & more", "advice": ["error in time: small"], "model": "bz", "method": "adaptive-strang",
    "grid": {"points": [401]}, "time": 1.0, "steps": {"accepted": 52, "rejected": 8}, "work": {"diffusion_stages": 1234567, "sweeps": 0},
    "wall_seconds": {"diffusion": 0.5, "reaction": 1.5, "output": 0.1, "total": 2.1}, "ranks": 2, "imbalance": 1.31,
    "rank_work": [{"reaction_newton_iterations": n, "diffusion_seconds": 0.2, "reaction_seconds": 0.1 * n, "communication_seconds": 0.05}
                  for n in (7, 12)],
    "peak_memory_mib": 31.5, "version": "0.1.0", "checksum": "00ff"}


class Page(html.parser.HTMLParser):
    """Elements and text of a page; complains of ends without a beginning."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements, self.text, self.sources = [], [], "", []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        self.elements.append(tag)
        self.sources += [value for name, value in attributes if name in ("src", "href")]
        if tag not in ("meta", "img", "input", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        self.text += data


class ReportTest(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = self.scratch.name
        self.addCleanup(self.scratch.cleanup)

    def write(self, lines=60):
        results.write_1d(self.folder)
        results.write_history(self.folder, lines)
        with open(os.path.join(self.folder, "summary.json"), "w") as file:
            json.dump(SUMMARY, file)

    def report(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = report.main([self.folder, *arguments])
        self.assertEqual(status, 0, err.getvalue())
        with open(out.getvalue().strip(), encoding="utf-8") as file:
            return file.read()

    def test_it_has_facts_advice_pictures_tables_and_the_case(self):
        self.write()
        page = Page(self.report())
        for words in ("A synthetic wave", "52 accepted, 8 rejected", "error in time: small", "a <note> & more", "1 234 567", "adaptive-strang",
                      "Each process", "32 MiB a process", "00ff", 'title = "A synthetic wave"'):
            self.assertIn(words, page.text)
        self.assertGreaterEqual(page.elements.count("img"), 3)

    def test_it_needs_no_other_file_and_no_network(self):
        self.write()
        text = self.report()
        page = Page(text)
        self.assertTrue(all(source.startswith("data:image/") for source in page.sources), page.sources)
        self.assertNotIn("@import", text)
        for address in re.findall(r"https?://[^\s\"']+", text):
            self.assertEqual(address, "http://www.w3.org/2000/svg")

    def test_without_history_and_summary_there_are_still_pictures(self):
        results.write_1d(self.folder)
        page = Page(self.report())
        self.assertGreaterEqual(page.elements.count("img"), 1)
        self.assertNotIn("svg", page.elements)

    def test_of_many_steps_the_extremes_and_the_rejected_are_kept(self):
        n = 50000
        history = {"time": np.linspace(0, 1, n), "dt": np.full(n, 1e-3), "error": np.full(n, 1e-5), "accepted": np.full(n, True)}
        history["dt"][12345] = 1e-9
        history["error"][777] = 0.5
        history["accepted"][[4, 40000]] = False
        chosen = report.chosen_steps(history)
        self.assertLess(len(chosen), 6000)
        for index in (0, 4, 777, 12345, 40000, n - 1):
            self.assertIn(index, chosen)

    def test_nothing_in_a_title_becomes_markup(self):
        x = np.linspace(0.0, 1.0, 11)
        for step in (0, 1):
            results.write_state(self.folder, step, float(step), {"u": x}, x, case='title = "<script>alert(1)</script>"\n[model]\nunits = { t = "</script>" }\n')
        results.write_history(self.folder)
        page = self.report()
        self.assertNotIn("<script>alert", page)
        self.assertEqual(page.count("</script>"), 2)

    def test_a_folder_without_results_is_an_input_output_error(self):
        with contextlib.redirect_stderr(io.StringIO()):
            self.assertEqual(report.main([self.folder]), 5)

    def browse(self, page, *options):
        target = os.path.join(self.folder, "page.html")
        with open(target, "w", encoding="utf-8") as file:
            file.write(page)
        return subprocess.run([CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1150,2600",
                               f"--user-data-dir={self.folder}/browser", *options, "file://" + target],
                              capture_output=True, text=True, timeout=60)

    @unittest.skipUnless(CHROMIUM, "no Chromium")
    def test_the_plot_of_the_steps_answers_to_its_controls(self):
        self.write()
        driver = """
<script>
const out = [], svg = document.querySelector("#steps svg"), set = (id, value) => {
  const e = document.getElementById(id);
  if (typeof value === "boolean") e.checked = value; else e.value = value;
  e.dispatchEvent(new Event("change"));
};
const ticks = () => [...svg.querySelectorAll("text")].map((e) => e.textContent).join("|");
const at = (type, fx, fy) => {
  const r = svg.getBoundingClientRect();
  svg.dispatchEvent(new PointerEvent(type, { clientX: r.left + fx * r.width, clientY: r.top + fy * r.height, pointerId: 1, bubbles: true }));
};
svg.setPointerCapture = () => {};
out.push("rejected " + svg.querySelectorAll(".rejected path").length);
out.push("line " + (svg.querySelector("path.accepted").getAttribute("d").length > 100));
out.push("first " + ticks());
set("choose-y", "error"); out.push("error " + ticks());
set("choose-log", false); out.push("linear " + ticks());
set("choose-x", "attempt"); out.push("attempt " + ticks());
at("pointerdown", 0.3, 0.5); at("pointermove", 0.5, 0.5); at("pointerup", 0.5, 0.5); out.push("zoomed " + ticks());
at("pointermove", 0.4, 0.5); out.push("help " + document.querySelector("#steps .help").textContent);
document.getElementById("show-all").click(); out.push("all " + ticks());
const pre = document.createElement("pre"); pre.id = "answers"; pre.textContent = out.join("\\n"); document.body.append(pre);
</script>"""
        dom = self.browse(self.report() + driver, "--dump-dom").stdout
        found = re.search(r'<pre id="answers">(.*?)</pre>', dom, re.S)
        self.assertIsNotNone(found, dom[-500:])
        answers = dict(line.split(" ", 1) for line in found[1].splitlines())
        self.assertEqual(answers["rejected"], "8")
        self.assertEqual(answers["line"], "true")
        self.assertIn("step size Δt", answers["first"])
        self.assertIn("1e-4", answers["first"])
        self.assertIn("error estimate", answers["error"])
        self.assertNotIn("1e-4", answers["linear"].split("|"))
        self.assertIn("number of the attempt", answers["attempt"])
        self.assertIn("|50|", answers["attempt"])
        self.assertNotIn("|50|", answers["zoomed"])
        self.assertRegex(answers["help"], r"attempt \d+ at t = .*(accepted|rejected): step size")
        self.assertEqual(answers["all"], answers["attempt"])

    @unittest.skipUnless(CHROMIUM, "no Chromium")
    def test_a_browser_shows_something_everywhere(self):
        self.write()
        shot = os.path.join(self.folder, "shot.png")
        self.browse(self.report(), "--hide-scrollbars", f"--screenshot={shot}")
        pixels = matplotlib.image.imread(shot)[..., :3]
        self.assertGreater(pixels.shape[0], 2000)
        for band in np.array_split(pixels, 8):
            self.assertGreater(np.mean(np.any(band < 0.85, axis=2)), 0.002)


if __name__ == "__main__":
    unittest.main()
