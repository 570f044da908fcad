#!/usr/bin/env python3
"""Looks for displacements inside the trained range at which a model is wrong, after the model was made: at the nodes
with the largest bounds, climbs from random displacements to larger errors (docs/decisions/error-bounds.md).

Usage: worst_probes.py PHYNNESS MODEL_DIR DATABASE.h5 [--nodes N] [--starts N] [--steps N] [--seed N]
Every error is measured against a finite element solve. Needs numpy and h5py.
"""
import argparse
import json
import subprocess
import tempfile

import h5py
import numpy as np


class Bodies:
    """Answers of the model and of the finite elements at a displacement."""

    def __init__(self, phynness, model, database):
        self.command, self.model, self.database, self.solves = phynness, model, database, 0

    def ask(self, *arguments):
        done = subprocess.run([self.command, *arguments, "--json", "-"], capture_output=True, text=True)
        return json.loads(done.stdout) if done.returncode == 0 else None

    def at(self, node, d):
        """(error [N], bound [N]); None outside of the trained range or without an equilibrium."""
        place = ["--node", str(node), "--displacement", ",".join("%.17g" % x for x in d)]
        said = self.ask("eval", self.model, *place)
        if said is None or said["bound_N"] is None:
            return None
        self.solves += 1
        true = self.ask("solve", self.database, *place)
        if true is None:
            return None
        force = [np.array(answer["tools"][0]["force"]) for answer in (said, true)]
        return np.linalg.norm(force[0] - force[1]), said["bound_N"]


def turned(d, random, range_m):
    """A direction up to 15 degrees away, a depth up to a fifth larger or smaller."""
    size = np.linalg.norm(d)
    across = np.cross(d, random.normal(size=3))
    new = d / size + np.tan(np.radians(15)) * random.random() * across / np.linalg.norm(across)
    return new / np.linalg.norm(new) * min(range_m, size * (0.8 + 0.4 * random.random()))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("phynness")
    parser.add_argument("model")
    parser.add_argument("database")
    parser.add_argument("--nodes", type=int, default=12)
    parser.add_argument("--starts", type=int, default=8)
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with h5py.File(options.database) as h:
        active, range_m = h["sets/active"][:], h["magnitudes"][-1]
        force = np.linalg.norm(h["responses/force"][:], axis=-1)
        largest = np.where(h["responses/status"][:] == 0, force, 0).max(axis=(1, 2))
    random = np.random.default_rng(options.seed)
    bodies = Bodies(options.phynness, options.model, options.database)
    # The mean bound over the largest force, at random displacements of every node, needs no solve.
    rows = []
    for node in active:
        e = random.normal(size=(20, 3))
        d = e / np.linalg.norm(e, axis=1)[:, None] * (range_m * random.random(20))[:, None]
        rows += ["%d,%.17g,%.17g,%.17g" % (node, *x) for x in d]
    with tempfile.NamedTemporaryFile("w", suffix=".csv") as queries:
        queries.write("node,ux_m,uy_m,uz_m\n" + "\n".join(rows) + "\n")
        queries.flush()
        answer = subprocess.run([options.phynness, "eval", options.model, "--queries", queries.name],
                                capture_output=True, text=True, check=True)
    bound = np.genfromtxt(answer.stdout.splitlines(), delimiter=",", names=True)["bound_N"].reshape(len(active), 20)
    worst = np.argsort(-np.nanmean(bound, axis=1) / largest)[:options.nodes]

    starts, ends = [], []  # error and bound over the largest force
    for place in worst:
        node, scale = int(active[place]), largest[place]
        found = []
        while len(found) < options.starts:
            e = random.normal(size=3)
            d = e / np.linalg.norm(e) * range_m * random.random()
            now = bodies.at(node, d)
            if now is not None:
                found.append((now[0] / scale, now[1] / scale, d))
        starts += [x[:2] for x in found]
        best = max(found, key=lambda x: x[0])
        for _ in range(options.steps):
            d = turned(best[2], random, range_m)
            now = bodies.at(node, d)
            if now is not None and now[0] / scale > best[0]:
                best = (now[0] / scale, now[1] / scale, d)
        ends.append(best[:2])
        print("node %4d: random %.2f %% in the mean, worst %.2f %%; climbed to %.2f %%, its bound %.2f %%, at %s mm"
              % (node, 100 * np.mean([x[0] for x in found]), 100 * max(x[0] for x in found), 100 * best[0],
                 100 * best[1], " ".join("%.2f" % x for x in 1e3 * best[2])), flush=True)
    for name, values in (("random displacements of these nodes", starts), ("after climbing", ends)):
        error, bound = np.array(values).T
        print("%s: %d, error mean %.2f %%, largest %.2f %%; below the bound %.0f %%; largest error over bound %.1f"
              % (name, len(error), 100 * error.mean(), 100 * error.max(), 100 * np.mean(error <= bound),
                 np.max(error / bound)))
    print("%d solves" % bodies.solves)


main()
