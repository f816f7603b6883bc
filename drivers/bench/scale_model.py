#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The cost of a step on many ranks, from the kernel rates of one run and its counted messages (docs/scaling.md).

    drivers/bench/scale_model.py ONE_RANK/summary.json [TWO_RANKS/summary.json ...]
                                 [--latency 1.5e-6] [--overhead 0.4e-6] [--bandwidth 10e9] [--balanced 1.05]

The first run gives seconds per point and step of each phase and the numbers of stages, exchanges and reductions per step; runs on more ranks are
predicted with the machine's own latency (--here) and compared. Then follow the tables: fixed points per rank, and fixed total.
"""
import argparse
import json
import math

DEPTHS = range(1, 9)


def read(path):
    with open(path, encoding="utf-8") as f:
        return json.load(f)


class Rates:
    """What one step does, and what a point of it costs."""

    def __init__(self, run):
        work, steps = run["work"], run["steps"]["accepted"] + run["steps"]["rejected"]
        points = math.prod(run["grid"]["points"])
        rank = run["rank_work"][0]
        self.dimension = len(run["grid"]["points"])
        self.species = 3
        self.stages = work["diffusion_stages"] / steps  # of all states
        self.exchanges = work["halo_exchanges"] / steps
        self.reductions = work["allreduces"] / steps
        self.stage = rank["diffusion_seconds"] / work["diffusion_stages"] / points
        self.reaction = rank["reaction_seconds"] / steps / points
        other = run["wall_seconds"]["total"] - rank["diffusion_seconds"] - rank["reaction_seconds"]
        self.other = other / steps / points
        self.states = self.stages / self.exchanges  # advanced together, on average


def step_seconds(rates, points_per_rank, ranks, net, imbalance, depth=None):
    """Seconds of a step: (total, diffusion, halos, reductions, reaction, depth)."""
    side = points_per_rank ** (1.0 / rates.dimension)
    sides = min(ranks - 1, 2 * rates.dimension if ranks > 3 else 1)
    corners = 4 if rates.dimension == 2 and ranks > 8 else 0

    def stages_with(d):
        exchanges = rates.exchanges / d
        width = sides / 2.0  # halo layers per unit of depth, in sides of the box
        face = side ** (rates.dimension - 1)
        bytes_sent = 8 * rates.species * rates.states * sides * face * (2 * d - 1)
        messages = sides + (corners if d > 1 else 0)
        interior = rates.stage * rates.states * points_per_rank
        flight = net.latency + bytes_sent / net.bandwidth
        halos = exchanges * (2 * messages * net.overhead + max(0.0, flight - interior))
        redundant = sum((side + 2 * width / rates.dimension * k) ** rates.dimension - points_per_rank for k in range(d)) / d
        return rates.stages * rates.stage * (points_per_rank + redundant), halos

    if ranks == 1:
        best = (rates.stages * rates.stage * points_per_rank, 0.0, 1)
    else:
        best = min((stages_with(d) + (d,) for d in (DEPTHS if depth is None else [depth])), key=lambda x: x[0] + x[1])
    diffusion, halos, d = best
    rounds = math.ceil(math.log2(ranks)) if ranks > 1 else 0
    reductions = rates.reductions * rounds * (net.latency + 2 * net.overhead)
    reaction = rates.reaction * points_per_rank * imbalance
    if ranks > 1:
        # Four calls of the reaction in a step, each with a message there and back and a gather nobody waits for.
        reaction += 4 * (2 * (net.latency + 2 * net.overhead) + min(ranks, 1024).bit_length() * net.overhead)
    other = rates.other * points_per_rank
    return diffusion + halos + reductions + reaction + other, diffusion, halos, reductions, reaction, d


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+")
    parser.add_argument("--latency", type=float, default=1.5e-6)
    parser.add_argument("--overhead", type=float, default=0.4e-6)
    parser.add_argument("--bandwidth", type=float, default=10e9)
    parser.add_argument("--here", type=float, nargs=3, default=[0.4e-6, 0.3e-6, 5e9], help="latency, overhead, bandwidth of this machine")
    parser.add_argument("--balanced", type=float, default=1.05)
    parser.add_argument("--unbalanced", type=float, default=2.2)
    options = parser.parse_args()

    class Net:
        def __init__(self, latency, overhead, bandwidth):
            self.latency, self.overhead, self.bandwidth = latency, overhead, bandwidth

    one = read(options.runs[0])
    rates = Rates(one)
    print(f"per step: {rates.stages:.1f} stages, {rates.exchanges:.1f} exchanges at depth 1, {rates.reductions:.2f} reductions; per point "
          f"{rates.stage * 1e9:.2f} ns a stage, {rates.reaction * 1e9:.1f} ns a step in the reaction, {rates.other * 1e9:.1f} ns elsewhere")
    for path in options.runs[1:]:
        run = read(path)
        steps = run["steps"]["accepted"] + run["steps"]["rejected"]
        points = math.prod(run["grid"]["points"]) / run["ranks"]
        after = run.get("balance", {}).get("imbalance_after", run["imbalance"])
        predicted = step_seconds(rates, points, run["ranks"], Net(*options.here), after)[0]
        measured = run["wall_seconds"]["total"] / steps
        print(f"{run['ranks']} ranks: predicted {predicted * 1e6:.1f} us a step, measured {measured * 1e6:.1f} ({predicted / measured:.2f})")
    net = Net(options.latency, options.overhead, options.bandwidth)
    for title, sizes in (("fixed points per rank", (64**2, 256**2)), ("fixed total", (4096**2, 16384**2))):
        for size in sizes:
            print(f"\n{title}: {round(size**0.5)}^2 points\n| ranks | us/step | diffusion | halos | depth | reductions | reaction | efficiency | unbalanced |")
            print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
            for ranks in (1, 64, 1024, 16384, 100000):
                points = size if title == "fixed points per rank" else size / ranks
                total, diffusion, halos, reductions, reaction, depth = step_seconds(rates, points, ranks, net, options.balanced if ranks > 1 else 1)
                alone = step_seconds(rates, points, 1, net, 1)[0]
                worse = step_seconds(rates, points, ranks, net, options.unbalanced if ranks > 1 else 1)[0]
                print(f"| {ranks} | {total * 1e6:.0f} | {diffusion * 1e6:.0f} | {halos * 1e6:.0f} | {depth} | {reductions * 1e6:.0f} | "
                      f"{reaction * 1e6:.0f} | {alone / total:.2f} | {alone / worse:.2f} |")


main()
