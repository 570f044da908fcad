#!/usr/bin/env python3
"""A reduced body, the nonlinear finite elements in a basis of solved fields, against finite element solves of two tools
and of one between nodes (docs/decisions/reduced-body.md).

Usage: study.py DATABASE.h5 --radius METRES [--pairs PAIRS.npz] [--points POINTS.npz] [--modes N ...] [--cells N ...]
                [--path PATH.bin]     the last of --modes and --cells on a path of two tools, for phynness_follow_path
DATABASE.h5 has the element p1-p1 or es-p1-p1, a neo-Hookean law, round tools and output = "free"; PAIRS.npz and POINTS.npz
are those of `lab/study between-points`. Errors are those of that study, in %. First the energies of stored fields, and the
means of their displacements under the tools, are compared with the database: elements and tools are written again here.
Needs numpy and h5py.

The state is q, with displacements u = Phi q at the nodes. Energy: sum over the points c of a cubature, which are cells and
edges with the element's volumes S_c of shear and V_c of the pressure (0 at edges), and weights w_c,
w_c S_c [mu/2 (I1 - 3) - mu ln J] + b . C^-1 b / 2,  b = sum_c w_c V_c psi_c (J_c - 1). The rows of psi are pressure modes
in the middle of the cell, and C is their matrix of 1/lambda and of the stabilization at rest. Phi are the leading proper
orthogonal modes of the fields of single tools; cells and weights are the nonnegative least squares solution for forces
and changes of volume of solved states (Farhat, Chapman & Avery 2015, doi 10.1002/nme.4820). A tool prescribes the mean
displacement under it; its force is the multiplier.
"""
import argparse
import time
import tomllib

import h5py
import numpy as np

DISTANCES = ((0, 99), (0, 1), (1, 2), (2, 3.5), (3.5, 99))  # of two tools, in radii
ALPHA, SMOOTHED_ALPHA, CELL_SHARE = 0.05, 0.1, 0.1  # of the elements (formats/include/phynness/formats/law.hpp)
STEPS = 4  # to the displacement of a state
CUTBACKS, ITERATIONS = 6, 25
TOLERANCE = 1e-6  # of the residual, over the forces of the tools


class Body:
    """Mesh and finite element quantities of p1-p1 in units of m and Pa."""

    def __init__(self, database, radius):
        with h5py.File(database) as h:
            self.nodes, cells, self.surface = h["mesh/nodes"][:], h["mesh/cells"][:], h["mesh/surface"][:]
            self.fixed, self.active, self.output = h["sets/fixed"][:], h["sets/active"][:], h["sets/output"][:]
            scene = tomllib.loads(h["scene"][()].decode())
            solved = h["responses/status"][:] == 0
            self.fields = h["responses/displacement"][:][solved].astype(float)
            self.energies = h["responses/energy"][:][solved]
            self.places, along, step = np.nonzero(solved)
            self.moved = h["directions"][:][along] * h["magnitudes"][:][step][:, None]
        material = scene["material"]
        self.radius, self.depth, self.mu = radius, scene["probe"]["max_displacement_m"], 2 * material["c10_Pa"]
        self.kappa = material["bulk_modulus_Pa"] - 2 / 3 * self.mu
        n = len(self.nodes)
        self.free = np.setdiff1d(np.arange(n), self.fixed)
        assert np.array_equal(np.sort(self.output), self.free), 'the database needs output = "free"'
        x = self.nodes[cells]
        edges = x[:, 1:] - x[:, :1]
        self.cells, self.volume = cells, np.abs(np.linalg.det(edges)) / 6
        smoothed = scene.get("solver", {}).get("element", "es-p1-p1") == "es-p1-p1"
        self.points, self.shear = self.points_of(smoothed)
        self.volumetric = np.concatenate([self.volume, np.zeros(len(self.shear) - len(cells))])
        slopes = np.linalg.inv(edges).transpose(0, 2, 1)
        self.slopes = np.concatenate([-slopes.sum(axis=1, keepdims=True), slopes], axis=1)  # of the hat functions
        size2 = np.max([((x[:, a] - x[:, b]) ** 2).sum(axis=1) for a in range(4) for b in range(a)], axis=0)
        alpha = SMOOTHED_ALPHA if smoothed else ALPHA
        self.laplace, self.compressibility = np.zeros((n, n)), np.zeros((n, n))
        for a in range(4):
            for b in range(4):
                slope = self.volume * np.einsum("cj,cj->c", self.slopes[:, a], self.slopes[:, b])
                np.add.at(self.laplace, (cells[:, a], cells[:, b]), slope)
                np.add.at(self.compressibility, (cells[:, a], cells[:, b]),
                          self.volume * (1 + (a == b)) / 20 / self.kappa + alpha * size2 / self.mu * slope)
        corners = self.nodes[self.surface]
        self.normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        self.node_normal = np.zeros((n, 3))
        np.add.at(self.node_normal, self.surface.ravel(), np.repeat(self.normal, 3, axis=0))

    def points_of(self, smoothed):
        """Shares (points, cells) of the cells in the gradients of the points, and the points' volumes of shear."""
        if not smoothed:
            return np.eye(len(self.cells)), self.volume
        pairs = np.sort(self.cells[:, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]].reshape(-1, 2), axis=1)
        _, edge = np.unique(pairs, axis=0, return_inverse=True)
        share = np.zeros((edge.max() + 1, len(self.cells)))
        np.add.at(share, (edge.ravel(), np.repeat(np.arange(len(self.cells)), 6)), np.repeat(self.volume / 6, 6))
        size = share.sum(axis=1)
        return (np.concatenate([np.eye(len(self.cells)), share / size[:, None]]),
                np.concatenate([CELL_SHARE * self.volume, (1 - CELL_SHARE) * size]))

    def gradients(self, fields):
        """grad u of fields (nodes, 3, columns) in cells: (cells, 3, 3, columns)."""
        return sum(np.einsum("cj,cim->cijm", self.slopes[:, a], fields[self.cells[:, a]]) for a in range(4))

    def pressures(self, u):
        """Pressure at the nodes for displacements (nodes, 3)."""
        J = np.linalg.det(self.gradients(u[:, :, None])[..., 0] + np.eye(3))
        b = np.zeros(len(self.nodes))
        for a in range(4):
            np.add.at(b, self.cells[:, a], self.volume / 4 * (J - 1))
        return np.linalg.solve(self.compressibility, b)

    def tool(self, point, divisions=12):
        """Weights (nodes,) of the mean under a round tool at a point of the surface: its pressure is uniform within the
        radius, over what faces it (formats/src/tool.cpp)."""
        corners = self.nodes[self.surface]
        s = np.array([(i + k / 3, j + k / 3) for i in range(divisions) for j in range(divisions - i)
                      for k in ((1, 2) if i + j < divisions - 1 else (1,))]) / divisions
        bary = np.stack([1 - s.sum(axis=1), s[:, 0], s[:, 1]], axis=1)
        inside = (np.einsum("qk,tkd->tqd", bary, corners - point) ** 2).sum(axis=2) < self.radius ** 2
        at = self.triangle(point)
        unit = self.node_normal / np.maximum(np.linalg.norm(self.node_normal, axis=1, keepdims=True), 1e-300)
        weights, normal = at[1], (at[1] @ unit[self.surface[at[0]]])
        normal /= np.linalg.norm(normal)
        reached = {t for t in range(len(self.surface))
                   if set(self.surface[at[0]][weights > 1e-9]) <= set(self.surface[t])}
        todo = list(reached)
        while todo:
            shared = np.isin(self.surface, self.surface[todo.pop()]).sum(axis=1) == 2
            for t in np.flatnonzero(shared & inside.any(axis=1)):
                if t not in reached:
                    reached.add(t)
                    todo.append(t)
        mean = np.zeros(len(self.nodes))
        for t in reached:
            facing = normal @ self.normal[t]
            if facing > 0:
                np.add.at(mean, self.surface[t], facing * (inside[t][:, None] * bary).sum(axis=0))
        mean[self.fixed] = 0
        return mean / mean.sum()

    def nearest(self, point):
        """The nearest place of the surface."""
        t, weights = self.triangle(point)
        return weights @ self.nodes[self.surface[t]]

    def triangle(self, point):
        """The triangle of the surface at a point, and its barycentric weights."""
        corners = self.nodes[self.surface]
        a, b, c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], point - corners[:, 0]
        aa, ab, bb = (np.einsum("ti,ti->t", *p) for p in ((a, a), (a, b), (b, b)))
        ac, bc = np.einsum("ti,ti->t", a, c), np.einsum("ti,ti->t", b, c)
        bary = np.stack([bb * ac - ab * bc, aa * bc - ab * ac], axis=1) / (aa * bb - ab ** 2)[:, None]
        bary = np.concatenate([1 - bary.sum(axis=1, keepdims=True), bary], axis=1)
        held = np.clip(bary, 0, None)  # the nearest point, but for triangles with obtuse angles
        held /= held.sum(axis=1, keepdims=True)
        t = np.argmin(np.linalg.norm(np.einsum("tk,tkd->td", held, corners) - point, axis=1))
        return t, np.where(held[t] > 1e-7, held[t], 0)


class Reduced:
    """The reduced body with points and weights of a cubature, or with all points."""

    def __init__(self, body, modes, pressures, points=None, weights=1.0):
        points = np.arange(len(body.shear)) if points is None else points
        self.modes, self.mu = modes, body.mu
        self.shear, self.volume = weights * body.shear[points], weights * body.volumetric[points]
        cells = body.gradients(modes).reshape(len(body.cells), -1)
        self.G = (body.points[points] @ cells).reshape(9 * len(points), -1)
        self.psi = body.points[points] @ pressures[body.cells].mean(axis=1)
        self.soft = np.linalg.inv(pressures.T @ body.compressibility @ pressures)
        self.iterations, self.solves = 0, 0

    def state(self, q):
        """(F, J, F^-T, parts of the volume, stress) at the points."""
        F = (self.G @ q).reshape(-1, 3, 3) + np.eye(3)
        J = np.linalg.det(F)
        C = np.linalg.inv(F).transpose(0, 2, 1)
        parts = self.psi * (self.volume * (J - 1))[:, None]
        pV = (self.psi @ (self.soft @ parts.sum(axis=0))) * self.volume * J
        stress = (self.mu * self.shear)[:, None, None] * F + (pV - self.mu * self.shear)[:, None, None] * C
        return F, J, C, parts, pV, stress

    def forces(self, q):
        """(energy, gradient, Hessian) at q; None where a point is turned inside out."""
        F, J, C, parts, pV, stress = self.state(q)
        if not (J > 0).all():
            return None
        b = parts.sum(axis=0)
        energy = self.mu * self.shear @ (((F ** 2).sum(axis=(1, 2)) - 3) / 2 - np.log(J)) + b @ self.soft @ b / 2
        A = np.einsum("c,cil,ckj->cijkl", self.mu * self.shear - pV, C, C) + np.einsum("c,cij,ckl->cijkl", pV, C, C)
        A = A.reshape(-1, 9, 9) + (self.mu * self.shear)[:, None, None] * np.eye(9)
        G = self.G.reshape(len(J), 9, -1)
        changes = self.psi.T @ np.einsum("c,ck,ckm->cm", self.volume * J, C.reshape(-1, 9), G)
        return energy, self.G.T @ stress.ravel(), self.G.T @ (A @ G).reshape(self.G.shape) + changes.T @ self.soft @ changes

    def equilibrium(self, q, rows, d):
        """(q, force) with rows q = d, by Newton from q; None if it does not converge."""
        n, here = len(q), self.forces(q)
        for _ in range(ITERATIONS):
            if here is None:
                return None
            _, gradient, hessian = here
            system = np.block([[hessian, rows.T], [rows, np.zeros((len(d),) * 2)]])
            step = np.linalg.solve(system, np.concatenate([-gradient, d - rows @ q]))
            self.iterations += 1
            part, force = 1.0, -step[n:]
            while (here := self.forces(q + part * step[:n])) is None and part > 1 / 64:
                part /= 2
            if here is None:
                return None
            q = q + part * step[:n]
            left = np.linalg.norm(here[1] - rows.T @ force)
            if part == 1 and left <= TOLERANCE * np.linalg.norm(rows.T @ force):
                return q, force
        return None

    def press(self, tools, d):
        """Forces (tools, 3) for mean displacements (tools, 3) under tools (tools, nodes); None if there are none."""
        mean = np.einsum("tn,nim->tim", tools, self.modes).reshape(3 * len(tools), -1)
        q, before, at, step, cutbacks = np.zeros(mean.shape[1]), None, 0.0, 1 / STEPS, 0
        force = None
        while at < 1 - 1e-12:
            start = q if before is None else q + (q - before[0]) * step / (at - before[1])
            found = self.equilibrium(start, mean, (at + step) * d.ravel()) or self.equilibrium(q, mean, (at + step) * d.ravel())
            if found is None:
                step, cutbacks = step / 2, cutbacks + 1
                if cutbacks > CUTBACKS:
                    return None
                continue
            before, (q, force), at = (q, at), found, at + step
            self.solves += 1
        return force.reshape(-1, 3)


def check(body, which):
    """Prints the largest differences of this file's elements and tools from the database for some stored fields."""
    energy, moved = [], []
    for k in which:
        u = np.zeros_like(body.nodes)
        u[body.output] = body.fields[k]
        here = Reduced(body, u[:, :, None], np.eye(len(body.nodes))).forces(np.ones(1))[0]
        energy.append(abs(here / body.energies[k] - 1))
        mean = body.tool(body.nodes[body.active[body.places[k]]]) @ u
        moved.append(np.linalg.norm(mean - body.moved[k]) / np.linalg.norm(body.moved[k]))
    print("of %d stored fields: energy %.2g %%, displacement under the tool %.2g %% from the database" % (
        len(energy), 100 * max(energy), 100 * max(moved)))


def modes_of(rows, metric, n):
    """Leading proper orthogonal modes (columns) of rows, orthonormal in the metric."""
    factor = np.linalg.cholesky(metric)
    scaled = rows @ factor
    _, vectors = np.linalg.eigh(scaled.T @ scaled)
    return np.linalg.solve(factor.T, vectors[:, ::-1][:, :n])


def cubature(whole, states, body, numbers):
    """{number: (points, weights)}: nonnegative least squares for the forces and changes of volume of reduced states."""
    n = len(body.shear)
    rest = np.linalg.inv(np.linalg.cholesky(whole.forces(np.zeros(whole.G.shape[1]))[2]))
    soft, gram, right = np.linalg.cholesky(whole.soft), np.zeros((n, n)), np.zeros(n)
    G = whole.G.reshape(n, 9, -1)
    for q in states:
        _, J, _, volumes, _, stress = whole.state(q)
        if not (J > 0).all():
            continue
        parts = np.concatenate([np.einsum("ckm,ck->cm", G, stress.reshape(n, 9)) @ rest.T, volumes @ soft], axis=1)
        parts /= np.linalg.norm(np.linalg.solve(rest, q))
        gram += parts @ parts.T
        right += parts @ parts.sum(axis=0)
    for size in (body.shear, body.volumetric):
        share = size / size.sum() * 0.1 * np.sqrt(gram.sum())
        gram += np.outer(share, share)
        right += share * share.sum()
    chosen, weights, found = [], np.zeros(n), {}
    while len(chosen) < max(numbers):
        gradient = right - gram @ weights
        gradient[chosen] = -np.inf
        chosen.append(int(np.argmax(gradient)))
        while True:
            part = gram[np.ix_(chosen, chosen)] + 1e-12 * np.trace(gram) / n * np.eye(len(chosen))
            wanted, had = np.linalg.solve(part, right[chosen]), weights[chosen]
            if (wanted > 0).all():
                weights[chosen] = wanted
                break
            ratios = np.where(wanted <= 0, had / np.maximum(had - wanted, 1e-300), np.inf)
            had += ratios.min() * (wanted - had)
            keep = np.arange(len(chosen)) != np.argmin(ratios)
            weights[:] = 0
            chosen = [c for c, k in zip(chosen, keep) if k]
            weights[chosen] = had[keep]
        if len(chosen) in numbers:
            found[len(chosen)] = np.array(chosen), weights[chosen]
    return found


def row(name, errors):
    if len(errors):
        print("%-40s %4d  %6.2f %6.2f %6.2f" % (name, len(errors), 100 * errors.mean(), 100 * np.percentile(errors, 95),
                                                100 * errors.max()), flush=True)


def compare(name, answer, truths):
    """Rows of errors of answer(kind of truth, state) -> forces; a state without an answer counts as an error of 1."""
    for kind, truth in truths.items():
        said = [answer(kind, k) for k in range(len(truth["d"]))]
        errors = np.array([1.0 if f is None else np.linalg.norm(f - g, axis=1).max() / s
                           for f, g, s in zip(said, truth["force"], truth["size"])])
        label, unanswered = "%s, %s" % (name, kind), sum(f is None for f in said)
        if unanswered:
            label += ", %d unanswered" % unanswered
        for low, high in DISTANCES if kind == "pairs" else DISTANCES[:1]:
            row(label if high - low == 99 else "  %g to %g R" % (low, high), errors[(truth["away"] >= low) & (truth["away"] < high)])


def truth_of(body, file):
    """States of `lab/study between-points`, with the weights of their tools."""
    with np.load(file) as h:
        several = "points" in h
        points = h["points"] if several else h["point"][:, None]
        shape = points.shape
        truth = {k: h[k].reshape(shape) for k in ("d", "force")}
        if several:
            truth["linear"] = h["linear"]
        else:
            truth["linear"] = h["linear"].reshape(shape)
    truth["tools"] = [np.array([body.tool(x) for x in of]) for of in points]
    truth["size"] = np.linalg.norm(truth["force"], axis=2).max(axis=1)
    if not several:
        truth["size"] = np.maximum(truth["size"], truth["size"].max() / 20)
    truth["away"] = np.linalg.norm(points[:, 0] - points[:, -1], axis=1) / body.radius
    return truth


def path_of(body, seconds=2.0, speed=0.05, seed=1):
    """Weights (moments, 2, nodes) and displacements (moments, 6) of two tools in steps of a millisecond. They slide over the
    surface between nodes at random, at both ends 1.5 radii and more apart, and press to a third of the trained depth."""
    random, moments = np.random.default_rng(seed), []
    n = int(1000 * seconds)
    nodes = body.active[np.isin(body.active, body.surface)]
    ends = []
    while len(ends) < 2:
        a = body.nodes[random.choice(nodes, 2, replace=False)]
        if np.linalg.norm(a[0] - a[1]) > 1.5 * body.radius:
            ends.append(a)
    depth, turn = body.depth / 3, 2 * np.pi * random.random((2, 3))
    for k in range(n):
        share = min(1.0, k / 1000 * speed / max(np.linalg.norm(ends[1] - ends[0], axis=1)))
        if k % 10 == 0:  # the weights between are interpolated
            here = [body.tool(body.nearest(x)) for x in ends[0] + share * (ends[1] - ends[0])]
            moments.append(np.array(here))
    weights = np.array([moments[k // 10] * (1 - k % 10 / 10) + moments[min(k // 10 + 1, len(moments) - 1)] * (k % 10 / 10)
                        for k in range(n)])
    t = np.arange(n)[:, None, None] / 1000
    d = depth * np.minimum(1, 5 * t) * np.sin(2 * np.pi * np.array([1.0, 1.7])[None, :, None] * t + turn) / np.sqrt(3)
    return weights, d.reshape(n, 6)


def save_path(file, body, reduced):
    weights, d = path_of(body)
    rows = np.einsum("ktn,nim->ktim", weights, reduced.modes).reshape(len(d), 6, -1)
    with open(file, "wb") as f:
        np.array([len(reduced.shear), rows.shape[2], reduced.psi.shape[1], 6, len(d), reduced.mu]).tofile(f)
        for a in (reduced.G, reduced.shear, reduced.volume, reduced.psi, reduced.soft):
            np.ascontiguousarray(a, float).tofile(f)
        for r, x in zip(rows, d):
            np.ascontiguousarray(r).tofile(f)
            np.ascontiguousarray(x).tofile(f)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("database")
    parser.add_argument("--radius", type=float, required=True)
    parser.add_argument("--pairs")
    parser.add_argument("--points")
    parser.add_argument("--modes", type=int, nargs="+", default=[80, 120, 160])
    parser.add_argument("--cells", type=int, nargs="+", default=[100, 200, 400])
    parser.add_argument("--path")
    parser.add_argument("--not-all", action="store_true", help="leave out the rows of all points, which take most of the time")
    parser.add_argument("--states", type=int, default=300, help="for the cubature")
    options = parser.parse_args()
    body = Body(options.database, options.radius)
    truths = {kind: truth_of(body, file) for kind, file in (("pairs", options.pairs), ("between", options.points)) if file}
    print("%d nodes, %d cells, %d fields\n%-40s    n    mean    p95    max   [%%]" % (len(body.nodes), len(body.cells), len(body.fields), ""))
    check(body, np.random.default_rng(2).permutation(len(body.fields))[:10])
    compare("linear predictor", lambda kind, k: truths[kind]["linear"][k], truths)

    place = np.searchsorted(body.output, body.free)
    fields = body.fields[:, place].reshape(len(body.fields), -1)
    metric = np.kron(body.laplace[np.ix_(body.free, body.free)], np.eye(3))
    some = np.random.default_rng(1).permutation(len(fields))[:options.states]
    full = np.zeros((len(some), *body.nodes.shape))
    full[:, body.free] = fields[some].reshape(len(some), -1, 3)
    solved_pressures = np.array([body.pressures(u) for u in full])
    for n in options.modes:
        basis = modes_of(fields, metric, n)
        modes = np.zeros((len(body.nodes), 3, n))
        modes[body.free] = basis.reshape(-1, 3, n)
        pressures = modes_of(solved_pressures, body.compressibility, n // 4)
        whole = Reduced(body, modes, pressures)
        states = (fields[some] @ metric) @ basis
        found = cubature(whole, states, body, [c for c in options.cells if c < len(body.shear)])
        for size, reduced in [(len(body.shear), whole)] * (not options.not_all) + [(s, Reduced(body, modes, pressures, *f)) for s, f in found.items()]:
            began = time.time()
            compare("%d modes, %d points" % (n, size), lambda kind, k: reduced.press(truths[kind]["tools"][k], truths[kind]["d"][k]), truths)
            last = reduced
            print("  %.1f iterations an increment, %.0f s" % (reduced.iterations / max(reduced.solves, 1), time.time() - began))
    if options.path:
        save_path(options.path, body, last)


if __name__ == "__main__":
    main()
