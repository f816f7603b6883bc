#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Claims about drivers/plot/plot.py, on result folders written here. Exit status 77: nothing to draw with."""

import contextlib
import importlib.util
import io
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

try:
    import h5py
    import matplotlib.image
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../drivers/plot/plot.py")
specification = importlib.util.spec_from_file_location("plot", SCRIPT)
plot = importlib.util.module_from_spec(specification)
specification.loader.exec_module(plot)

HEADER = ("step,time,dt,error,accepted,iterations,epsilon,critical_dt,diffusion_stages,reaction_steps,"
          "wall_seconds\n")
CASE = 'title = "A synthetic wave"\n[method]\nname = "adaptive-strang"\ntolerance = 1e-3\n'


def write_state(folder, step, time, species, x, y=None, case=CASE):
    with h5py.File(os.path.join(folder, f"fields-{step:06d}.h5"), "w") as file:
        file.attrs["time"] = time
        file.attrs["step"] = step
        file.attrs["species"] = list(species)
        file.attrs["case"] = case
        file["x"] = x
        if y is not None:
            file["y"] = y
        for name, values in species.items():
            file[name] = values


def front(x, time):
    return 1.0 / (1.0 + np.exp(80.0 * (x - 0.2 - 0.6 * time)))


def write_1d(folder, outputs=11):
    x = np.linspace(0.0, 1.0, 401)
    for i in range(outputs):
        t = 0.1 * i
        write_state(folder, 20 * i, t, {"a": front(x, t), "b": front(x, t) * (1 - front(x, t + 0.4)),
                                        "c": 10.0 ** (6.0 * front(x, t) - 6.0)}, x)


def write_history(folder, lines=60):
    with open(os.path.join(folder, "history.csv"), "w") as file:
        file.write(HEADER)
        time, dt = 0.0, 1e-6
        for i in range(lines):
            accepted = i % 7 != 6
            error = 1e-3 * (0.4 + 0.3 * math.sin(i)) if accepted else 3e-3
            file.write(f"{i},{time},{dt},{error},{int(accepted)},1,0.05,{2 * dt},{5 + i},{100 + i},{0.01 * i}\n")
            time += dt if accepted else 0.0
            dt = min(dt * 1.5, 0.03) if accepted else dt * 0.5


class PlotTest(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = self.scratch.name
        self.addCleanup(self.scratch.cleanup)

    def plot(self, *arguments):
        """As the program would call it, without the cost of a new interpreter."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = plot.main([self.folder, *arguments])
        plot.plt.close("all")
        return subprocess.CompletedProcess(arguments, status, out.getvalue(), err.getvalue())

    def svg(self, *arguments):
        target = os.path.join(self.folder, "picture.svg")
        result = self.plot("-o", target, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout, target + "\n")
        with open(target) as file:
            return file.read()

    def test_axes_name_the_units_of_the_case(self):
        x = np.linspace(0.0, 1.0, 11)
        for step in range(3):
            write_state(self.folder, step, float(step), {"u": x, "v": x}, x, case='[model]\nunits = { x = "cm", t = "s", u = "<mM>" }\n')
        write_history(self.folder)
        text = self.svg()
        for label in ("x [cm]", "t [s]", "u [&lt;mM&gt;]", "step size Δt [s]"):
            self.assertIn(label, text)
        self.assertNotIn("v [", text)

    def test_default_picture_is_a_png_in_the_folder_with_something_drawn(self):
        write_1d(self.folder)
        write_history(self.folder)
        result = subprocess.run([SCRIPT, self.folder], capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        target = os.path.join(self.folder, "plot.png")
        self.assertEqual(result.stdout, target + "\n")
        pixels = matplotlib.image.imread(target)
        self.assertGreater(pixels.shape[1], 1000)
        self.assertGreater(np.mean(np.any(pixels[..., :3] < 0.9, axis=2)), 0.005)

    def test_labels_of_times_next_to_each_other_do_not_overlap(self):
        self.assertEqual(plot.apart([0.0, 0.01, 0.5, 0.51, 1.0], 0.12), [0.0, 0.5, 1.0])

    def test_one_dimension_shows_species_times_steps_and_tolerance(self):
        write_1d(self.folder)
        write_history(self.folder)
        text = self.svg()
        for label in ("A synthetic wave", ">a<", ">b<", ">c<", "a: profiles stacked in time", "log c: profiles stacked in time", "accepted", "rejected",
                      "52 steps accepted, 8 rejected", "step size", "critical step", "error estimate",
                      "tolerance 0.001"):
            self.assertIn(label, text)

    def test_errors_of_multistep_methods_are_in_units_of_their_tolerance(self):
        x = np.linspace(0.0, 1.0, 11)
        for step in (0, 1):
            write_state(self.folder, step, float(step), {"u": x}, x, case='[method]\nname = "sbdf"\nrelative_tolerance = 1e-6\n')
        write_history(self.folder)
        text = self.svg()
        self.assertIn("error estimate / tolerance 1e-06", text)
        self.assertIn(">order<", text)

    def test_shift_cost_wall_time_and_ranks_have_panels(self):
        write_1d(self.folder)
        write_history(self.folder)
        with open(os.path.join(self.folder, "summary.json"), "w") as file:
            file.write('{"imbalance": 1.25, "rank_work": [{"reaction_seconds": 1.0}, {"reaction_seconds": 1.5, "diffusion_seconds": "nan"}]}')
        text = self.svg()
        for label in ("shift ε", "what a step takes", "diffusion stages", "wall time [s]", "imbalance of the reaction 1.25", ">rank<"):
            self.assertIn(label, text)

    def test_an_animation_has_a_frame_for_each_state(self):
        from PIL import Image
        x, y = np.linspace(0.0, 1.0, 31), np.linspace(0.0, 0.5, 21)
        for i in range(4):
            write_state(self.folder, i, 0.5 * i, {"u": front(np.hypot(*np.meshgrid(x, y)), 0.25 * i)}, x, y)
        target = os.path.join(self.folder, "film.gif")
        self.assertEqual(self.plot("-o", target).returncode, 0)
        with Image.open(target) as film:
            self.assertEqual(film.n_frames, 4)

    def test_one_state_is_no_animation(self):
        write_1d(self.folder, outputs=1)
        result = self.plot("-o", os.path.join(self.folder, "film.gif"))
        self.assertEqual(result.returncode, 5)
        self.assertIn("two states", result.stderr)

    def test_an_order_study_is_drawn_with_the_orders_observed(self):
        rows = [{"step": 0.1 / 2**k, "variant": v, "error": 0.01 / 2 ** (p * k), "order": None} for v, p in (("lie", 1), ("strang", 2))
                for k in range(4)] + [{"step": 0.2, "variant": "lie", "error": "nan"}]
        with open(os.path.join(self.folder, "converge.json"), "w") as file:
            json.dump({"kind": "global", "reference": "cvode", "rows": rows}, file)
        text = self.svg()
        for label in ("lie, order 1.00", "strang, order 2.00", "global error; reference: cvode"):
            self.assertIn(label, text)

    def test_species_option_draws_only_what_was_asked(self):
        write_1d(self.folder)
        text = self.svg("--species", "b")
        self.assertIn(">b<", text)
        self.assertNotIn(">a<", text)

    def test_two_dimensions_are_drawn_as_maps_at_several_times(self):
        x, y = np.linspace(0.0, 1.0, 161), np.linspace(0.0, 0.5, 81)
        radius = np.hypot(*np.meshgrid(x, y))
        for i in range(9):
            write_state(self.folder, 10 * i, 0.25 * i, {"u": front(radius, 0.25 * i), "v": 1.0 - radius}, x, y)
        write_history(self.folder)
        text = self.svg()
        for label in ("u, t = 0<", "u, t = 2<", "v, t = 2<", "step size"):
            self.assertIn(label, text)
        self.assertEqual(text.count("u, t = "), 4)

    def test_times_are_ordered_by_step_number_not_by_name(self):
        x = np.linspace(0.0, 1.0, 11)
        for step, time in ((999999, 1.0), (1000000, 2.0), (0, 0.0)):
            write_state(self.folder, step, time, {"u": x + time}, x)
        self.assertIn("stacked in time", self.svg())

    def test_one_output_without_history_is_enough(self):
        write_1d(self.folder, outputs=1)
        text = self.svg()
        self.assertIn("t = 0<", text)
        self.assertNotIn("step size", text)

    def test_empty_history_is_not_an_error(self):
        write_1d(self.folder)
        for content in ("", HEADER, HEADER + "1,0.5,1e-"):
            with open(os.path.join(self.folder, "history.csv"), "w") as file:
                file.write(content)
            self.assertNotIn("step size", self.svg())

    def test_fixed_steps_without_estimate_say_so(self):
        write_1d(self.folder, outputs=2)
        with open(os.path.join(self.folder, "history.csv"), "w") as file:
            file.write(HEADER + "".join(f"{i},{0.01 * i},0.01,nan,1,0,,,5,100,0.1\n" for i in range(20)))
        self.assertIn("this method estimates no error", self.svg())

    def test_values_that_are_not_finite_are_counted_and_left_out(self):
        x = np.linspace(0.0, 1.0, 101)
        for i in range(4):
            u = front(x, 0.1 * i)
            u[3], u[7] = math.nan, math.inf
            write_state(self.folder, i, 0.1 * i, {"u": u, "v": np.full_like(x, math.nan)}, x)
        text = self.svg()
        self.assertIn("8 values are not finite", text)
        self.assertIn("404 values are not finite", text)

    def test_constant_fields_are_drawn(self):
        x = y = np.linspace(0.0, 1.0, 9)
        write_state(self.folder, 0, 0.0, {"u": np.zeros((9, 9)), "v": np.full((9, 9), -3.0)}, x, y)
        self.svg()

    def test_a_broken_file_among_good_ones_is_skipped_with_a_word(self):
        write_1d(self.folder)
        with open(os.path.join(self.folder, "fields-000100.h5"), "wb") as file:
            file.write(b"not HDF5")
        result = self.plot()
        self.assertEqual(result.returncode, 0)
        self.assertIn("fields-000100.h5", result.stderr)

    def test_unknown_species_is_named_with_the_known_ones(self):
        write_1d(self.folder, outputs=1)
        result = self.plot("--species", "z")
        self.assertEqual(result.returncode, 3)
        self.assertIn("there is no 'z'; there are a, b, c", result.stderr)

    def test_folder_without_results_is_an_input_output_error(self):
        result = self.plot()
        self.assertEqual(result.returncode, 5)
        self.assertIn("no results here", result.stderr)
        self.folder += "/absent"
        self.assertEqual(self.plot().returncode, 5)

    def test_wrong_option_is_a_usage_error(self):
        self.assertEqual(subprocess.run([SCRIPT, self.folder, "--nonsense"], capture_output=True).returncode, 2)

    def test_target_that_cannot_be_written_is_an_input_output_error(self):
        write_1d(self.folder, outputs=1)
        self.assertEqual(self.plot("-o", os.path.join(self.folder, "absent/plot.png")).returncode, 5)
        self.assertEqual(self.plot("-o", os.path.join(self.folder, "plot.nonsense")).returncode, 5)


if __name__ == "__main__":
    unittest.main()
