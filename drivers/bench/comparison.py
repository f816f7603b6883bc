# SPDX-License-Identifier: BSD-3-Clause
"""What the comparisons share: runs of the program and of the peers on the same problem from the same state, errors, interpolation."""
import glob
import hashlib
import json
import math
import os
import subprocess
import tomllib

import h5py
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PEERS = os.path.join(ROOT, "drivers", "bench", "peers")
QUIET = ["output.times=[]", "output.every=0", "output.steps=0", "output.checkpoint.every_seconds=0", "limits.stall_limit_s=0"]


def build_peers(folder):
    """Peers against an optimised SUNDIALS (peers) and against that of Debian (debian); {kind: folder of programs}."""
    prefix = os.path.join(folder, "sundials")
    optimised = []
    if subprocess.run(["bash", os.path.join(PEERS, "sundials.sh"), prefix], check=False).returncode == 0:
        optimised = [f"-DCMAKE_PREFIX_PATH={prefix}"]
    else:
        print("WARNING: the peers use Debian's SUNDIALS, compiled without optimisation: no ratio below is worth quoting")
    found = {}
    for kind, options in (("optimised", optimised), ("debian", [])):
        build = os.path.join(folder, kind)
        if not os.path.exists(os.path.join(build, "build.ninja")):
            subprocess.run(["cmake", "-S", PEERS, "-B", build, "-G", "Ninja", *options], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["ninja", "-C", build, "-j2"], check=True, stdout=subprocess.DEVNULL)
        found[kind] = build
    return found


class Problem:
    """A case with overrides, started from a state developed by the program itself where `develop` says how far."""

    def __init__(self, name, case, overrides, model=None, develop=None, error_species=None, reference_tolerance=1e-12, solver="band"):
        self.name, self.case, self.overrides = name, case, list(overrides)
        self.model, self.develop, self.error_species = model, develop, error_species
        self.reference_tolerance, self.solver = reference_tolerance, solver

    def prepare(self, bench):
        self.folder = os.path.join(bench.out, self.name)
        os.makedirs(self.folder, exist_ok=True)
        if self.develop:
            developed = os.path.join(self.folder, "developed")
            overrides = self.overrides + self.develop + ['method={name="sbdf", relative_tolerance=1e-10}']
            files = sorted(glob.glob(os.path.join(developed, "fields-*.h5")))
            if len(files) < 2:
                bench.stiffront(self.case, overrides, developed)
                files = sorted(glob.glob(os.path.join(developed, "fields-*.h5")))
            self.overrides += [f'initial={{file="{files[-1]}"}}', "time.start=0"]
        # One step leaves the initial state as the program sees it.
        first = os.path.join(self.folder, "start")
        bench.stiffront(self.case, self.overrides + ["limits.max_steps=1", 'method={name="sbdf", initial_step=1e-9}'], first, check=False)
        text = subprocess.run([bench.program, "check", self.case, *self.overrides], check=True, capture_output=True, text=True).stdout
        case = tomllib.loads(text)
        with h5py.File(os.path.join(first, "fields-000000.h5")) as f:
            self.species = [s.decode() if isinstance(s, bytes) else s for s in f.attrs["species"]]
        self.initial = os.path.join(self.folder, "initial.f64")
        read_state(os.path.join(first, "fields-000000.h5"), self.species).tofile(self.initial)
        grid, model = case["grid"], case["model"]
        self.dimension = len(grid["points"])
        boundary = case.get("boundary", {})
        sides = {boundary.get(d + side, "neumann") for d in "xy"[:self.dimension] for side in ("", "_lower", "_upper")}
        if not sides <= {"neumann", "periodic"}:
            raise SystemExit(f"{self.name}: the peers know boundaries without flux and periodic ones")
        periodic = [int(boundary.get(d, "neumann") == "periodic") for d in "xy"[:self.dimension]]
        self.arguments = [
            "model=" + (self.model or model["name"]),
            "diffusion=" + ",".join(repr(float(model["diffusion"][s])) for s in self.species),
            *(f"{k}=" + ",".join(map(repr, grid[k])) for k in ("points", "lower", "upper")),
            "periodic=" + ",".join(map(str, periodic)),
            f"start={case['time'].get('start', 0.0)!r}", f"end={case['time']['end']!r}", f"initial={self.initial}",
            *(f"parameters.{k}={v!r}" for k, v in model.get("parameters", {}).items())]
        self.reference = self.make_reference(bench)

    def make_reference(self, bench):
        """CVODE by hand at a tight tolerance: nothing of the program is in it."""
        with open(self.initial, "rb") as f:
            key = hashlib.sha256(f.read() + repr((self.arguments, self.reference_tolerance)).encode()).hexdigest()[:12]
        path = os.path.join(self.folder, f"reference-{key}.f64")
        if not os.path.exists(path):
            solver = "band" if self.dimension == 1 and self.solver == "band" else "gmres"
            result = bench.peer("optimised", "cvode_peer", self, self.reference_tolerance, [f"linear_solver={solver}"], 3600, path + ".tmp")
            if result is None:
                raise SystemExit(f"{self.name}: no reference")
            os.replace(path + ".tmp", path)
        return np.fromfile(path).reshape(len(self.species), -1)

    def error(self, state):
        """Root mean square over the points divided by the largest modulus: of one species, or of the worst."""
        state = state.reshape(self.reference.shape)
        if not np.all(np.isfinite(state)):
            return math.inf
        errors = np.sqrt(np.mean((state - self.reference) ** 2, axis=1)) / np.max(np.abs(self.reference), axis=1)
        return float(errors[self.error_species] if self.error_species is not None else errors.max())


def read_state(path, species):
    with h5py.File(path) as f:
        return np.concatenate([np.asarray(f[s]).ravel() for s in species])


class Bench:
    def __init__(self, program, out, peers):
        self.program, self.out, self.peers = os.path.abspath(program), os.path.abspath(out), peers
        os.makedirs(self.out, exist_ok=True)

    def stiffront(self, case, overrides, folder, check=True, timeout=3600):
        return subprocess.run([self.program, "run", case, "-o", folder, "--quiet", "--force", *QUIET, *overrides], check=check,
                              timeout=timeout, stderr=None if check else subprocess.DEVNULL)

    def ours(self, problem, method, timeout):
        """One run of the program: what summary.json says of its time loop, and the error. None: failed or took too long."""
        folder = os.path.join(problem.folder, "run")
        try:
            if self.stiffront(problem.case, problem.overrides + method, folder, check=False, timeout=timeout).returncode != 0:
                return None
        except subprocess.TimeoutExpired:
            return None
        with open(os.path.join(folder, "summary.json")) as f:
            summary = json.load(f)
        last = sorted(glob.glob(os.path.join(folder, "fields-*.h5")))[-1]
        return {"seconds": summary["wall_seconds"]["total"], "steps": summary["steps"]["accepted"], "rejected": summary["steps"]["rejected"],
                "error": problem.error(read_state(last, problem.species)), "method": summary.get("choice", "")}

    def peer(self, kind, program, problem, tolerance, options, timeout, final=None):
        path = os.path.join(self.peers[kind], program)
        out = final or os.path.join(problem.folder, "final.f64")
        try:
            done = subprocess.run([path, *problem.arguments, f"relative_tolerance={tolerance!r}", f"absolute_tolerance={tolerance / 100!r}",
                                   f"final={out}", *options], capture_output=True, text=True, timeout=timeout)
        except subprocess.TimeoutExpired:
            return None
        if done.returncode != 0:
            return None
        result = json.loads(done.stdout.strip().splitlines()[-1])
        result["error"] = problem.error(np.fromfile(out)) if final is None else 0.0
        return result


def front(points):
    """(error, seconds) pairs that no other pair beats in both, the loosest first."""
    best, kept = math.inf, []
    for error, seconds in sorted(p for p in points if p[0] > 0 and math.isfinite(p[0])):
        if seconds < best:
            kept.append((error, seconds))
            best = seconds
    return kept[::-1]


def seconds_at(points, error):
    """Seconds for this error, interpolated in logarithms; those of the cheapest run if it is more accurate; None if never reached."""
    kept = front(points)
    if not kept or error < kept[-1][0]:
        return None
    if error >= kept[0][0]:
        return kept[0][1]
    for (e0, s0), (e1, s1) in zip(kept, kept[1:]):
        if e1 <= error <= e0:
            w = math.log(error / e0) / math.log(e1 / e0)
            return s0 * (s1 / s0) ** w
    return None
