#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""usage: examples_test.py PROGRAM SOURCES. What the documentation says to type works: the cases printed in it run, and the reader reads what
they wrote. Exit status 77: no h5py here."""

import os
import re
import subprocess
import sys
import tempfile
import unittest

try:
    import h5py  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)


def blocks(page, language):
    with open(os.path.join(SOURCES, page), encoding="utf-8") as file:
        return re.findall(rf"```{language}\n(.*?)```", file.read(), re.S)


class Examples(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = self.scratch.name
        self.addCleanup(self.scratch.cleanup)

    def run_case(self, text, name, *overrides):
        case = os.path.join(self.folder, name + ".toml")
        with open(case, "w") as file:
            file.write(text)
        result = subprocess.run([PROGRAM, "run", case, *overrides, "-o", os.path.join(self.folder, name), "--quiet"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, name + ": " + result.stderr)

    def reader(self):
        space = {}
        for code in blocks("docs/reading-results.md", "python"):
            exec(code, space)
        return space

    def test_the_reader_is_short(self):
        code = blocks("docs/reading-results.md", "python")[0]
        self.assertLessEqual(len(code.strip().splitlines()), 30)

    def test_the_spiral_of_the_tutorial_is_as_accurate_as_it_says(self):
        text, = blocks("docs/tutorial.md", "toml")
        self.run_case(text, "spiral", "time.end=2")
        self.run_case(text, "finer", "time.end=2", "method.tolerance=1e-7")
        reader = self.reader()
        spiral, finer = (reader["states"](os.path.join(self.folder, name)) for name in ("spiral", "finer"))
        self.assertEqual([state.time for state in spiral], [0.0, 0.5, 1.0, 1.5, 2.0])
        self.assertEqual(spiral[-1]["u"].shape, (201, 201))
        self.assertEqual((spiral[-1].x[-1], spiral[-1].y[-1]), (40.0, 40.0))
        self.assertLess(reader["difference"](spiral[-1], finer[-1]), 1e-4)
        self.assertGreater(reader["difference"](spiral[-1], finer[0]), 0.1)

    def test_states_on_grids_of_which_one_has_the_points_of_the_other_are_compared(self):
        text = blocks("docs/custom-models.md", "toml")[0]
        self.run_case(text, "coarse", "time.end=0.1")
        self.run_case(text, "fine", "time.end=0.1", "grid.points=[801]")
        reader = self.reader()
        coarse, fine = (reader["states"](os.path.join(self.folder, name)) for name in ("coarse", "fine"))
        self.assertLess(reader["difference"](coarse[-1], fine[-1]), 1e-3)
        self.assertIsNone(fine[-1].y)

    def test_the_model_of_the_readme_runs(self):
        self.run_case(blocks("README.md", "toml")[0], "readme", "time.end=20", "output.every=10")
        self.assertEqual(len(self.reader()["states"](os.path.join(self.folder, "readme"))), 3)


if __name__ == "__main__":
    PROGRAM, SOURCES = sys.argv[1:3]
    del sys.argv[1:3]
    unittest.main()
