#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""usage: xdmf_test.py PROGRAM. ParaView opens fields.xdmf: every reader it has gives the times, places and values of the files, in one and
two dimensions. Exit status 77: no ParaView here (Debian: python3-paraview)."""

import glob
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

INSIDE_PARAVIEW = """
import json, sys
from paraview import servermanager, simple
from vtk.util.numpy_support import vtk_to_numpy
path, name = sys.argv[1:3]
reader = getattr(simple, name)(**{"FileNames" if name == "XDMFReader" else "FileName": [path]})
reader.UpdatePipeline()
times = list(reader.TimestepValues)
reader.UpdatePipeline(times[-1])
data = servermanager.Fetch(reader)
n = data.GetNumberOfPoints()
u = vtk_to_numpy(data.GetPointData().GetArray("u"))
print("ANSWER" + json.dumps({"times": times, "u": u.tolist(), "places": [data.GetPoint(i) for i in range(n)]}))
"""

CASE = """
[grid]
points = {points}
lower = {lower}
upper = {upper}
[model]
name = "custom"
species = ["u"]
[model.reaction]
u = "1.0"
[initial]
u = "x + 10*y"
[time]
end = 1.0
[output]
every = 0.5
"""


class XdmfTest(unittest.TestCase):
    def check(self, points, lower, upper):
        import json
        with tempfile.TemporaryDirectory() as folder:
            case = os.path.join(folder, "case.toml")
            with open(case, "w") as file:
                file.write(CASE.format(points=points, lower=lower, upper=upper))
            subprocess.run([PROGRAM, "run", case, "-o", folder + "/out", "--quiet"], check=True)
            self.assertEqual(len(glob.glob(folder + "/out/fields-*.h5")), 3)
            script = os.path.join(folder, "inside.py")
            with open(script, "w") as file:
                file.write(INSIDE_PARAVIEW)
            for reader in ("Xdmf3ReaderS", "Xdmf3ReaderT", "XDMFReader"):
                result = subprocess.run([PVBATCH, script, folder + "/out/fields.xdmf", reader], capture_output=True, text=True, timeout=100)
                self.assertEqual(result.returncode, 0, result.stderr[-2000:])
                answer = json.loads(result.stdout.split("ANSWER")[1])
                self.assertEqual(answer["times"], [0.0, 0.5, 1.0], reader)
                self.assertEqual(len(answer["u"]), points[0] * (points[1] if len(points) > 1 else 1), reader)
                for u, (x, y, z) in zip(answer["u"], answer["places"]):
                    self.assertAlmostEqual(u, x + 10 * y + 1.0, 9, reader)
                    self.assertEqual(z, 0.0, reader)
                places = answer["places"]
                self.assertEqual((min(p[0] for p in places), max(p[0] for p in places)), (lower[0], upper[0]), reader)

    def test_a_line_is_where_it_belongs(self):
        self.check([9], [-1.0], [1.0])

    def test_a_plane_is_where_it_belongs(self):
        self.check([9, 7], [-1.0, 2.0], [1.0, 3.5])


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    PVBATCH = shutil.which("pvbatch")
    if PVBATCH is None:
        print("skipped: no ParaView")
        sys.exit(77)
    unittest.main()
