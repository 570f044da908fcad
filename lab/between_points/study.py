#!/usr/bin/env python3
"""How to answer for a round tool between probed nodes (docs/decisions/between-points.md): interpolations of the
responses of nodes, against finite element solves with the tool at the point itself.

Usage: study.py solve PHYNNESS DATABASE.h5 TRUTH.npz [--points N] [--each N] [--seed N]
       study.py compare PHYNNESS MODEL_DIR DATABASE.h5 TRUTH.npz [--spacing METRES ...]
       study.py product PHYNNESS TRUTH.npz MODEL_DIR ...
       study.py pairs PHYNNESS MODEL_DIR DATABASE.h5 TRUTH.npz --radius METRES [--pairs N] [--seed N]
Points are random by area in triangles with three active corners, or with --model in those that this model answers;
directions are random, depths to the trained range. `product` compares models with a truth, `compare` also methods. Errors
are |f - f_FE| over the larger of |f_FE| and a twentieth of the largest |f_FE|. Pairs: two tools to half of the trained
range, by classes of distance, half of the pairs at nodes; |f - f_FE| of the worse tool over the larger |f_FE|. TRUTH.npz is solved if it is
missing. Needs numpy, scipy and h5py.
"""
import argparse
import json
import os
import subprocess
import tempfile

import h5py
import numpy as np
from scipy.spatial import Delaunay

DISTANCES = ((0, 1), (1, 2), (2, 3.5), (3.5, 99))  # of two tools, in radii
LINEAR = 1e-3  # of a displacement, at which a solve gives the linear response


class Body:
    """Mesh, active nodes and trained depths of a database; lengths in m."""

    def __init__(self, database):
        with h5py.File(database) as h:
            self.nodes, self.surface, self.active = h["mesh/nodes"][:], h["mesh/surface"][:], h["sets/active"][:]
            self.output, self.directions = h["sets/output"][:], h["directions"][:]
            self.depth = np.where(h["responses/status"][:] == 0, h["magnitudes"][:], 0).max(axis=2)
        corners = self.nodes[self.surface]
        self.area_normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        self.touchable = self.surface[np.isin(self.surface, self.active).all(axis=1)]

    def reach(self, node, d):
        """Trained depth of a node in the nearest trained direction."""
        return self.depth[np.searchsorted(self.active, node), np.argmax(self.directions @ d)]


def ask(command, *arguments, field=False):
    """JSON of a command, with the field of its CSV if wanted; None if there is no solution."""
    with tempfile.TemporaryDirectory() as folder:
        out, csv = os.path.join(folder, "a.json"), os.path.join(folder, "u.csv")
        more = ["--deformation", csv] if field else []
        done = subprocess.run([*command, *arguments, "--json", out, *more], capture_output=True, text=True)
        if done.returncode != 0:
            return None
        with open(out) as f:
            said = json.load(f)
        if field:
            table = np.genfromtxt(csv, delimiter=",", names=True)
            said["field"] = np.stack([table[k] for k in table.dtype.names[4:7]], axis=1)
        return said


def numbers(x):
    return ",".join("%.17g" % k for k in x)


def at(x, d):
    return ["--point", numbers(x), "--displacement", numbers(d)]


def answered(body, folder):
    """Triangles whose corners the model answers."""
    with open(os.path.join(folder, "model.txt")) as f:
        lines = f.read().split("\n")
    start = next((i for i, line in enumerate(lines) if line.startswith("covered ")), None)
    rows = lines[start + 1:start + 1 + int(lines[start].split()[1])] if start else []
    known = [int(row.split()[0]) for row in rows] or body.active
    return body.surface[np.isin(body.surface, known).all(axis=1)]


def solve(options):
    body = Body(options.database)
    if options.model:
        body.touchable = answered(body, options.model)
    random = np.random.default_rng(options.seed)
    corners = body.nodes[body.touchable]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rows = {k: [] for k in ("point", "corners", "weights", "d", "force", "linear", "u", "u_linear")}
    for _ in range(options.points):
        t = random.choice(len(area), p=area / area.sum())
        s, q = np.sqrt(random.random()), random.random()
        weights = np.array([1 - s, s * (1 - q), s * q])
        x = weights @ corners[t]
        for _ in range(options.each):
            e = random.normal(size=3)
            e /= np.linalg.norm(e)
            known = [n for n in body.touchable[t] if n in body.active]
            known = known or [min(body.active, key=lambda n: np.linalg.norm(body.nodes[n] - x))]
            d = e * random.random() * min(body.reach(n, e) for n in known)
            command = [options.phynness, "solve", options.database]
            true, small = ask(command, *at(x, d), field=True), ask(command, *at(x, LINEAR * d), field=True)
            if true is None or small is None:
                print("no solution at", x, d, flush=True)
                continue
            for key, value in (("point", x), ("corners", body.touchable[t]), ("weights", weights), ("d", d),
                               ("force", true["tools"][0]["force"]), ("u", true["field"]),
                               ("linear", np.array(small["tools"][0]["force"]) / LINEAR),
                               ("u_linear", small["field"] / LINEAR)):
                rows[key].append(value)
        np.savez(options.truth, **{k: np.array(v) for k, v in rows.items()})


def place(body, random, share, at_node):
    """A point of a touchable triangle, and the nodes that answer for it. @param share of the triangles"""
    corners = random.choice(body.touchable, p=share / share.sum())
    if at_node:
        return body.nodes[corners[0]], corners[:1]
    s, q = np.sqrt(random.random()), random.random()
    return np.array([1 - s, s * (1 - q), s * q]) @ body.nodes[corners], corners


def solve_pairs(options, body):
    random = np.random.default_rng(options.seed)
    corners = body.nodes[body.touchable]
    area, middle = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1), corners.mean(axis=1)
    rows = {k: [] for k in ("points", "d", "force", "linear", "at_node")}
    for pair in range(options.pairs):
        here, share = [], area
        low, high = DISTANCES[pair // 2 % len(DISTANCES)]
        for _ in range(2):
            here.append(place(body, random, share, pair % 2 == 0))
            away = np.linalg.norm(middle - here[0][0], axis=1) / options.radius
            share = area * ((away >= low) & (away < high))
            if not share.any():
                break
        if len(here) < 2 or np.array_equal(here[0][0], here[1][0]):
            continue
        points, d = [x for x, _ in here], []
        for _, nodes in here:
            e = Interpolations.unit(random.normal(size=3))
            d.append(e * 0.5 * random.random() * min(body.reach(n, e) for n in nodes))
        command = [options.phynness, "solve", options.database]
        true, small = (ask(command, *at(points[0], f * d[0]), *at(points[1], f * d[1])) for f in (1, LINEAR))
        if true is None or small is None:
            print("no solution at", points, d, flush=True)
            continue
        for key, value in (("points", points), ("d", d), ("at_node", pair % 2 == 0),
                           ("force", [t["force"] for t in true["tools"]]),
                           ("linear", [np.array(t["force"]) / LINEAR for t in small["tools"]])):
            rows[key].append(value)
        np.savez(options.truth, **{k: np.array(v) for k, v in rows.items()})


def pairs(options):
    if not os.path.exists(options.truth):
        solve_pairs(options, Body(options.database))
    truth = dict(np.load(options.truth))
    size = np.linalg.norm(truth["force"], axis=2).max(axis=1)
    said = [ask([options.phynness, "eval", options.model], *at(x[0], d[0]), *at(x[1], d[1]))
            for x, d in zip(truth["points"], truth["d"])]
    flagged = np.array([s["status"] & 5 != 0 for s in said])  # outside, unsettled
    own = np.array([[t["force"] for t in s["tools"]] for s in said])
    errors = {n: np.linalg.norm(f - truth["force"], axis=2).max(axis=1) / size for n, f in (("product", own), ("linear", truth["linear"]))}
    away = np.linalg.norm(truth["points"][:, 0] - truth["points"][:, 1], axis=1) / options.radius
    print("%-26s %4s  %6s %6s %6s   [%%]; %d are flagged" % ("", "n", "mean", "p95", "max", flagged.sum()))
    for low, high in ((0, 99), *DISTANCES):
        for kind, of in (("", True), (" quiet", ~flagged), (" at nodes", truth["at_node"]), (" between", ~truth["at_node"])):
            for name, e in errors.items():
                if (some := (away >= low) & (away < high) & of).any():
                    print_row("%s, %g to %g R%s" % (name, low, high, kind), e[some])


class Nodes:
    """Force and energy of the model at nodes. What is asked is collected first, because a process answers many rows."""

    def __init__(self):
        self.wanted, self.answers = {}, None

    def __call__(self, node, d):
        key = (int(node), *(float("%.12g" % x) for x in d))
        if self.answers is None:
            self.wanted[key] = None
            return np.ones(3), 1.0
        return self.answers[key]

    def answer(self, command):
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as queries:
            queries.write("node,ux_m,uy_m,uz_m\n" + "".join("%d,%.12g,%.12g,%.12g\n" % k for k in self.wanted))
            queries.flush()
            done = subprocess.run([*command, "--queries", queries.name], capture_output=True, text=True, check=True)
        table = np.genfromtxt(done.stdout.splitlines(), delimiter=",", names=True)
        force = np.stack([table[k] for k in ("fx_N", "fy_N", "fz_N")], axis=1)
        self.answers = dict(zip(self.wanted, zip(force, table["energy_J"])))


def turn(a, b):
    """The smallest rotation that takes the unit vector a to b."""
    c, v = a @ b, np.cross(a, b)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + k + k @ k / (1 + c)


class Interpolations:
    """Forces at a point from responses of nodes; `kept` are the nodes that may be used."""

    def __init__(self, body, nodes, kept, radius):
        self.body, self.nodes, self.kept, self.radius = body, nodes, kept, radius
        middle = body.nodes[body.surface].mean(axis=1)
        self.normals = {}
        for n in range(len(body.nodes)):
            near = (np.linalg.norm(middle - body.nodes[n], axis=1) < radius / 2) | (body.surface == n).any(axis=1)
            self.normals[n] = self.unit(body.area_normal[near].sum(axis=0))
        self.rings, self.ridge = {}, 0.03

    @staticmethod
    def unit(v):
        return v / max(np.linalg.norm(v), 1e-300)

    def plane(self, x, normal):
        """Two axes of the plane."""
        a = self.unit(np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))]))
        return np.array([a, np.cross(normal, a)])

    def near(self, x, normal, reach):
        """Kept nodes around x that are on the same side of the body, nearest first."""
        away = np.linalg.norm(self.body.nodes[self.kept] - x, axis=1)
        ok = [(w, n) for w, n in zip(away, self.kept) if w < reach and self.normals[n] @ normal > 0.3]
        return [n for _, n in sorted(ok)]

    def mix(self, weights, d, power=1, turned=None):
        """Power mean of energies, and its gradient; `turned` is the normal to which d belongs."""
        force, energy, parts = np.zeros(3), 0.0, []
        for n, w in weights:
            r = np.eye(3) if turned is None else turn(turned, self.normals[n])
            f, e = self.nodes(n, r @ d)
            parts.append((w, r.T @ f, e))
        if power == 1:
            return sum(w * f for w, f, _ in parts)
        energy = (np.exp(sum(w * np.log(e) for w, _, e in parts)) if power == 0 else
                  sum(w * e ** power for w, _, e in parts) ** (1 / power))
        return sum(w * f * (energy / e) ** (1 - power) for w, f, e in parts)

    def gradient_weights(self, n):
        """Least squares gradient of a function at a node from differences to its neighbours: [(node, vector)]."""
        if n not in self.rings:
            around = [m for m in self.neighbours(n) if m != n]
            e = self.body.nodes[around] - self.body.nodes[n]
            moment = e.T @ e
            moment += self.ridge * np.trace(moment) * np.eye(3)
            self.rings[n] = [(m, np.linalg.solve(moment, e[i])) for i, m in enumerate(around)] if around else []
        return self.rings[n]

    def neighbours(self, n):
        triangles = self.body.surface[(self.body.surface == n).any(axis=1)]
        return [m for m in triangles.ravel() if m in self.kept_set]  # an edge of two triangles counts twice

    @property
    def kept_set(self):
        return set(int(k) for k in self.kept)

    def corrected(self, weights, x, part):
        """sum lambda_k [E_k + part g_k . (x - x_k)]; exact for quadratic functions with part = 1/2."""
        total = {}
        for n, w in weights:
            total[n] = total.get(n, 0) + w
            for m, g in self.gradient_weights(n):
                share = part * w * (g @ (x - self.body.nodes[n]))
                total[m] = total.get(m, 0) + share
                total[n] = total.get(n, 0) - share
        return list(total.items())

    def moving(self, x, normal, reach, degree):
        """Moving least squares over kept nodes within reach, weights (1 - s^2)^2."""
        around = self.near(x, normal, reach)
        axes = self.plane(x, normal)
        y = np.array([axes @ (self.body.nodes[m] - x) for m in around]) / reach
        bump = (1 - (y ** 2).sum(axis=1).clip(0, 1)) ** 2 + 1e-9
        columns = [np.ones(len(y)), y[:, 0], y[:, 1]]
        if degree == 2:
            columns += [y[:, 0] ** 2, y[:, 0] * y[:, 1], y[:, 1] ** 2]
        p = np.stack(columns, axis=1)
        if len(y) < p.shape[1] + 1:
            return None
        moment = p.T @ (bump[:, None] * p)
        if np.linalg.cond(moment) > 1e8:
            return None
        return list(zip(around, bump * (p @ np.linalg.solve(moment, np.eye(len(moment))[0]))))

    def triangle(self, x, normal):
        """The Delaunay triangle of kept nodes around x, in the plane of the surface there: [(node, weight)]."""
        around = self.near(x, normal, 6 * self.radius)[:40]
        axes = self.plane(x, normal)
        y = np.array([axes @ (self.body.nodes[m] - x) for m in around])
        if len(y) < 4:
            return None
        mesh = Delaunay(y)
        t = mesh.find_simplex(np.zeros(2))
        if t < 0:
            return None
        two = mesh.transform[t, :2] @ (0 - mesh.transform[t, 2])
        return list(zip([around[i] for i in mesh.simplices[t]], [*two, 1 - two.sum()]))


def spread(body, spacing, seed):
    """Active nodes farther than spacing from each other, greedily from a random start."""
    x = body.nodes[body.active]
    chosen = [int(np.random.default_rng(seed).integers(len(x)))]
    away = np.linalg.norm(x - x[chosen[0]], axis=1)
    while away.max() > spacing:
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(x - x[chosen[-1]], axis=1))
    return body.active[chosen]


def answers(body, model, truth, k, spacing):
    """All answers for a state, by name."""
    x, d, normal_weights = truth["point"][k], truth["d"][k], zip(truth["corners"][k], truth["weights"][k])
    normal = model.unit(sum(w * model.normals[n] for n, w in normal_weights))
    if spacing:
        corners = model.triangle(x, normal)
        if corners is None:
            return {}
    else:
        corners = list(zip(truth["corners"][k], truth["weights"][k]))
    normal = model.unit(sum(w * model.normals[n] for n, w in corners))
    said = {"energies": model.mix(corners, d), "logarithm": model.mix(corners, d, 0),
            "harmonic": model.mix(corners, d, -1), "turned": model.mix(corners, d, 1, normal),
            "turned logarithm": model.mix(corners, d, 0, normal),
            "nearest": model.mix([(max(corners, key=lambda c: c[1])[0], 1.0)], d)}
    if not spacing:
        said["corrected"] = model.mix(model.corrected(corners, x, 0.5), d)
        said["turned corrected"] = model.mix(model.corrected(corners, x, 0.5), d, 1, normal)
    for degree, reach in ((1, 1.2), (2, 1.5)):
        weights = model.moving(x, normal, reach * max(spacing or 0, 0.7 * model.radius), degree)
        if weights:
            said["moving %d" % degree] = model.mix(weights, d)
    return said


def print_row(name, errors):
    e = 100 * np.array(errors)
    print("%-26s %4d  %6.2f %6.2f %6.2f" % (name, len(e), e.mean(), np.percentile(e, 95), e.max()), flush=True)


def product(options):
    """@return the truth, and the size of its forces by which errors are divided"""
    truth = dict(np.load(options.truth))
    force = truth["force"]
    size = np.maximum(np.linalg.norm(force, axis=1), 0.05 * np.linalg.norm(force, axis=1).max())
    field = np.linalg.norm(truth["u"], axis=(1, 2))
    print("%-26s %4s  %6s %6s %6s   [%%]" % ("", "n", "mean", "p95", "max"))
    print_row("linear", np.linalg.norm(truth["linear"] - force, axis=1) / size)
    print_row("linear field", np.linalg.norm(truth["u_linear"] - truth["u"], axis=(1, 2)) / field)
    for model in options.model:
        asked = [ask([options.phynness, "eval", model], *at(x, d), field=True) for x, d in zip(truth["point"], truth["d"])]
        known = [k for k, said in enumerate(asked) if said]
        said = [asked[k] for k in known]
        own = np.array([s["tools"][0]["force"] for s in said])
        print(model, "answers", len(known), "of", len(asked))
        print_row("product", np.linalg.norm(own - force[known], axis=1) / size[known])
        fields = np.array([s["field"] for s in said]) - truth["u"][known]
        print_row("product field", np.linalg.norm(fields, axis=(1, 2)) / field[known])
    return truth, size


def compare(options):
    command = [options.phynness, "eval", options.model]
    options.model = [options.model]
    body, (truth, size) = Body(options.database), product(options)
    force = truth["force"]
    for spacing in [None, *options.spacing]:
        kept = spread(body, spacing, 1) if spacing else body.active
        print("spacing", spacing, "nodes", len(kept))
        nodes = Nodes()
        model = Interpolations(body, nodes, kept, options.radius)
        for k in range(len(force)):
            answers(body, model, truth, k, spacing)
        nodes.answer(command)
        errors = {}
        for k in range(len(force)):
            for name, f in answers(body, model, truth, k, spacing).items():
                errors.setdefault(name, []).append(np.linalg.norm(f - force[k]) / size[k])
        for name, e in errors.items():
            print_row(name, e)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("solve")
    one.set_defaults(run=solve)
    two = commands.add_parser("compare")
    two.set_defaults(run=compare)
    three = commands.add_parser("pairs")
    three.set_defaults(run=pairs)
    four = commands.add_parser("product")
    four.set_defaults(run=product)
    for p in (one, two, three, four):
        p.add_argument("phynness")
    for p in (two, three):
        p.add_argument("model")
    for p in (one, two, three):
        p.add_argument("database")
    for p in (one, two, three, four):
        p.add_argument("truth")
    four.add_argument("model", nargs="+")
    one.add_argument("--model")
    one.add_argument("--points", type=int, default=40)
    one.add_argument("--each", type=int, default=3)
    three.add_argument("--pairs", type=int, default=40)
    for p in (one, three):
        p.add_argument("--seed", type=int, default=1)
    for p in (two, three):
        p.add_argument("--radius", type=float, required=True)
    two.add_argument("--spacing", type=float, nargs="*", default=[])
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
