#!/usr/bin/env python3
"""Which interpolation answers for a round tool between nodes, in a linear body (docs/decisions/between-points.md): the
stiffness and the field of the tool at random points of the surface, against those of the tools at nodes. P1 elements
with a Poisson ratio of 0.45, where every method can be compared at thousands of states in seconds.

Usage: linear.py MESH.msh RADIUS [--fixed AXIS FRACTION] [--from AXIS FRACTION] [--points N] [--spacing PART ...]
MESH.msh is that of `phynness mesh`. Nodes of the surface whose coordinate is at most a fraction of the bounding box are
fixed; those beyond another fraction are touched. A spacing is a part of the radius; without it, all nodes have tools.
Errors are relative, in random directions. Needs numpy and scipy.
"""
import argparse

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu
from scipy.spatial import Delaunay

NU = 0.45
RIDGE = 0.03  # as `across` in runtime/src/tools/round_tool.cpp
_N = 12
_GRID = [((3 * i + s) / (3 * _N), (3 * j + s) / (3 * _N)) for s in (1, 2) for i in range(_N) for j in range(_N - i - s + 1)]
SAMPLES = np.array([(a, b, 1 - a - b) for a, b in _GRID])  # equal parts of a triangle


def read_mesh(path):
    """Nodes and tetrahedra of a text file of MSH 4.1."""
    with open(path) as f:
        lines = f.read().split("\n")
    at = lines.index("$Nodes") + 1
    blocks, n = (int(k) for k in lines[at].split()[:2])
    x, at = np.zeros((n, 3)), at + 1
    for _ in range(blocks):
        m = int(lines[at].split()[3])
        for k in range(m):
            x[int(lines[at + 1 + k]) - 1] = [float(v) for v in lines[at + 1 + m + k].split()[:3]]
        at += 1 + 2 * m
    at, cells = lines.index("$Elements") + 1, []
    blocks, at = int(lines[at].split()[0]), at + 1
    for _ in range(blocks):
        kind, m = (int(k) for k in lines[at].split()[2:])
        cells += [[int(v) - 1 for v in line.split()[1:]] for line in lines[at + 1:at + 1 + m] if kind == 4]
        at += 1 + m
    return x, np.array(cells)


def boundary(x, cells):
    """Triangles of the surface, normals outward."""
    faces = np.concatenate([cells[:, c] for c in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1])])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    first = first[count == 1]
    triangles, beyond = faces[first], cells.T.ravel()[first]
    c = x[triangles]
    inward = np.einsum("ij,ij->i", np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), x[beyond] - c[:, 0]) > 0
    triangles[inward] = triangles[inward][:, [0, 2, 1]]
    return triangles


def factorized(x, cells, free):
    """The stiffness matrix of a body with Young's modulus 1, of the degrees of freedom `free`."""
    lame, mu = NU / ((1 + NU) * (1 - 2 * NU)), 1 / (2 * (1 + NU))
    edges = np.stack([x[cells[:, k]] - x[cells[:, 0]] for k in (1, 2, 3)], axis=2)
    inverse = np.linalg.inv(edges)
    g = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
    local = (lame * np.einsum("eai,ebj->eaibj", g, g) + mu * np.einsum("eaj,ebi->eaibj", g, g)
             + mu * np.einsum("eak,ebk,ij->eaibj", g, g, np.eye(3)))
    local *= np.abs(np.linalg.det(edges))[:, None, None, None, None] / 6
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 12)
    rows, columns = np.repeat(dofs, 12, axis=1).ravel(), np.tile(dofs, 12).ravel()
    matrix = coo_matrix((local.ravel(), (rows, columns))).tocsr()
    return splu(matrix[free][:, free].tocsc())


def unit(v):
    return v / max(np.linalg.norm(v), 1e-300)


def turn(a, b):
    """The smallest rotation that takes the unit vector a to b."""
    c, v = a @ b, np.cross(a, b)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + k + k @ k / (1 + c)


def of_eigenvalues(function, matrix):
    values, vectors = np.linalg.eigh(matrix)
    return (vectors * function(values)) @ vectors.T


class Body:
    def __init__(self, path, radius, is_fixed):
        self.x, cells = read_mesh(path)
        self.triangles, self.radius = boundary(self.x, cells), radius
        self.surface = np.unique(self.triangles)
        low, high = self.x.min(axis=0), self.x.max(axis=0)
        self.fraction = (self.x - low) / (high - low)
        self.fixed = np.zeros(len(self.x), bool)
        self.fixed[self.surface[is_fixed(self.fraction[self.surface])]] = True
        self.free = (3 * np.flatnonzero(~self.fixed)[:, None] + np.arange(3)).ravel()
        self.matrix = factorized(self.x, cells, self.free)
        c = self.x[self.triangles]
        self.area_normal = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) / 2
        self.middle, self.edge = c.mean(axis=1), np.mean(np.linalg.norm(c[:, 1] - c[:, 0], axis=1))
        self.normal = np.zeros_like(self.x)
        for k in range(3):
            np.add.at(self.normal, self.triangles[:, k], self.area_normal)
        self.normal /= np.maximum(np.linalg.norm(self.normal, axis=1), 1e-300)[:, None]

    def tool(self, x, normal):
        """Weights of an even pressure within the radius, on this side of the body."""
        w, area = np.zeros(len(self.x)), np.linalg.norm(self.area_normal, axis=1)
        near = np.linalg.norm(self.middle - x, axis=1) < self.radius + 2 * self.edge
        for t in np.flatnonzero(near & (self.area_normal @ normal > -0.3 * area)):
            inside = ((SAMPLES @ self.x[self.triangles[t]] - x) ** 2).sum(axis=1) < self.radius ** 2
            np.add.at(w, self.triangles[t], area[t] * SAMPLES[inside].sum(axis=0))
        w[self.fixed] = 0
        return w / w.sum()

    def response(self, w):
        """Stiffness of the mean (3 x 3) and the fields of unit means (3 N x 3)."""
        load, u = np.zeros((3 * len(self.x), 3)), np.zeros((3 * len(self.x), 3))
        for k in range(3):
            load[k::3, k] = w
        u[self.free] = self.matrix.solve(load[self.free])
        stiffness = np.linalg.inv(mean_of(u, w))
        return (stiffness + stiffness.T) / 2, u @ stiffness


def mean_of(u, w):
    return np.stack([w @ u[k::3] for k in range(3)])


def plane(normal):
    a = unit(np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))]))
    return np.array([a, np.cross(normal, a)])


def spread(x, nodes, spacing, random):
    """Nodes that are about as far from each other as the spacing: the farthest one is added again and again."""
    kept = [random.integers(len(nodes))]
    away = np.linalg.norm(x[nodes] - x[nodes[kept[0]]], axis=1)
    while away.max() > 0.65 * spacing:
        kept.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(x[nodes] - x[nodes[kept[-1]]], axis=1))
    return nodes[kept]


class Between:
    """Answers at a point from the tools at nodes."""

    def __init__(self, body, tools, kept, spacing):
        self.body, self.tools, self.kept, self.spacing = body, tools, kept, spacing

    def corners(self, x, normal, mesh_corners):
        """[(node, weight)]: of the mesh's triangle, or of the Delaunay triangle of kept nodes in the plane there."""
        if not self.spacing:
            return mesh_corners
        near = [k for k in self.kept if self.body.normal[k] @ normal > 0.2]
        near = [k for k in near if np.linalg.norm(self.body.x[k] - x) < 5 * self.body.radius]
        if len(near) < 4:
            return None
        mesh = Delaunay((self.body.x[near] - x) @ plane(normal).T)
        t = mesh.find_simplex(np.zeros(2))
        if t < 0:
            return None
        two = mesh.transform[t, :2] @ -mesh.transform[t, 2]
        return list(zip([near[i] for i in mesh.simplices[t]], [*two, 1 - two.sum()]))

    def corrected(self, corners, x):
        """Weights of equation (x) of the theory."""
        body, total = self.body, {}
        for k, w in corners:
            total[k] = total.get(k, 0) + w
            around = body.triangles[(body.triangles == k).any(axis=1)].ravel()
            around = [m for m in around if m != k and m in self.tools]
            e = body.x[around] - body.x[k]
            moment = e.T @ e
            half = w / 2 * np.linalg.solve(moment + RIDGE * np.trace(moment) * np.eye(3), x - body.x[k])
            for m, part in zip(around, e @ half):
                total[m] = total.get(m, 0) + part
                total[k] -= part
        return list(total.items())

    def stiffnesses(self, corners, x):
        k = {n: self.tools[n][1] for n, _ in corners}
        normal = unit(sum(w * self.body.normal[n] for n, w in corners))
        turns = {n: turn(normal, self.body.normal[n]) for n, _ in corners}
        said = {
            "energies": sum(w * k[n] for n, w in corners),
            "logarithm": of_eigenvalues(np.exp, sum(w * of_eigenvalues(np.log, k[n]) for n, w in corners)),
            "compliances": np.linalg.inv(sum(w * np.linalg.inv(k[n]) for n, w in corners)),
            "turned": sum(w * turns[n].T @ k[n] @ turns[n] for n, w in corners),
            "nearest": k[max(corners, key=lambda c: c[1])[0]],
            "superposed": self.body.response(self.wide(corners))[0]}
        if not self.spacing:
            said["corrected"] = sum(w * self.tools[n][1] for n, w in self.corrected(corners, x))
        return said

    def wide(self, corners):
        """Weights of the tool that superposition makes."""
        return sum(w * self.tools[n][0] for n, w in corners)

    def fields(self, corners, weights):
        mean, wide = sum(w * self.tools[n][2] for n, w in corners), self.wide(corners)
        return {"mean": mean, "scaled by nodes": mean @ np.linalg.inv(mean_of(mean, wide)),
                "scaled by tool": mean @ np.linalg.inv(mean_of(mean, weights)),
                "superposed": self.body.response(wide)[1]}


def study(options):
    random = np.random.default_rng(options.seed)
    (fixed_axis, fixed_to), (axis, start) = options.fixed, options.touched
    body = Body(options.mesh, options.radius, lambda p: p[:, int(fixed_axis)] <= fixed_to + 1e-9)
    nodes = np.array([n for n in body.surface if not body.fixed[n] and body.fraction[n][int(axis)] > start])
    weights = {n: body.tool(body.x[n], body.normal[n]) for n in nodes}
    tools = {n: (weights[n], *body.response(weights[n])) for n in nodes}
    triangles = body.triangles[np.isin(body.triangles, nodes).all(axis=1)]
    c = body.x[triangles]
    area = np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1)
    points = []
    for _ in range(options.points):
        t = random.choice(len(area), p=area / area.sum())
        s, q = np.sqrt(random.random()), random.random()
        w = np.array([1 - s, s * (1 - q), s * q])
        x, normal = w @ c[t], unit(w @ body.normal[triangles[t]])
        own = body.tool(x, normal)
        points.append((x, normal, list(zip(triangles[t], w)), own, *body.response(own), random.normal(size=(3, 3))))
    print("edge %.2g m, radius %.2f edges, %d nodes" % (body.edge, options.radius / body.edge, len(nodes)))
    for spacing in [None, *options.spacing]:
        kept = nodes if spacing is None else spread(body.x, nodes, spacing * options.radius, random)
        between, errors = Between(body, tools, kept, spacing), {}
        for x, normal, mesh_corners, own, stiffness, field, directions in points:
            corners = between.corners(x, normal, mesh_corners)
            if corners is None:
                continue
            said = {"force, " + k: (v, stiffness) for k, v in between.stiffnesses(corners, x).items()}
            said |= {"field, " + k: (v, field) for k, v in between.fields(corners, own).items()}
            for name, (answer, true) in said.items():
                for d in directions:
                    errors.setdefault(name, []).append(np.linalg.norm((answer - true) @ d) / np.linalg.norm(true @ d))
        print("spacing", "of the mesh" if spacing is None else "%g R" % spacing, "with", len(kept), "nodes")
        for name, e in errors.items():
            print("  %-24s %6.2f %6.2f %6.2f %%" % (name, 100 * np.mean(e), 100 * np.percentile(e, 95), 100 * max(e)))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("mesh")
    parser.add_argument("radius", type=float)
    parser.add_argument("--fixed", type=float, nargs=2, default=(0, 0.2))
    parser.add_argument("--from", dest="touched", type=float, nargs=2, default=(0, 0.35))
    parser.add_argument("--points", type=int, default=60)
    parser.add_argument("--spacing", type=float, nargs="*", default=[])
    parser.add_argument("--seed", type=int, default=1)
    study(parser.parse_args())


if __name__ == "__main__":
    main()
