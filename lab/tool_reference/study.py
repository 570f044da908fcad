"""Which weight should a round tool have that moves a weighted mean of the surface? A comparison with rigid tips.

Packages (Debian 12): python3-dolfinx-real, python3-petsc4py-real, python3-gmsh, python3-scipy. Run with /usr/bin/python3:

    python3 research/tool_reference/study.py half-space cylinder block liver depth mesh [--liver liver.msh]

`half-space` checks tips and tools against closed forms; `cylinder` (axisymmetric, fine), `block` and `liver` compare the
force of the tools with that of punches pressed without friction; `depth` presses and
pulls until cells are crushed; `mesh` gives the order of the force, its scatter over places, and the signs of the weights.
liver.msh is written by `phynness mesh SCENE -o liver.msh`, where SCENE is scenes/liver_case3.toml with
`target_nodes = 400`. Each section replaces its figures in
results.json beside this file. Set OMP_NUM_THREADS=1.
"""
import argparse
import itertools
import json
import pathlib
import time

import numpy as np
from body import Body, Stopped, boundary, box, fem, mesh, organ
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.spatial import cKDTree

# F / (E* R mean) on a half-space, and the displacement of the center over the mean
STIFFNESS = {"bump": 17325 * np.pi**2 / 131072, "Hertz": 5 / 3, "uniform": 3 * np.pi**2 / 16, "patch": 0.685008}
CENTER = {"bump": STIFFNESS["bump"] / (5 * np.pi / 16), "Hertz": 5 / 4, "uniform": 3 * np.pi / 8, "patch": 1.0}
DEPTHS, EDGES = np.array([0.2, 0.4, 0.8]), (0.4, 0.2, 0.1)  # of the punch, and its rounded edge
SIDE = 16 / 3  # half of the block's 16 cm, and its 8 cm of height, in units of a = 1.5 cm
TOOLS = [(phi, way) for phi in STIFFNESS for way in ("mean", "center") if (phi, way) != ("patch", "center")]


def radius(phi, way):
    """With the force of a flat punch of radius 1 on a half-space at the same displacement of mean or center."""
    return 2 / STIFFNESS[phi] * (CENTER[phi] if way == "center" else 1)


def size(rim, center, growth=0.3, radius=1.7):
    """Edges by point: short at the punch's rim, longer at the tool, longest far away."""
    def of(x):
        at_rim = np.hypot(np.linalg.norm(x[:-1]) - 1, x[-1])
        return min(rim + 0.25 * at_rim, center + growth * max(0, np.linalg.norm(x) - radius))
    return of


def cylinder(height, of_size, radius=None, **options):
    side = radius or height
    return Body(box((0, -height), (side, 0), of_size), lambda x: (x[1] < 1e-6 - height) | ((x[0] > side - 1e-6) & (side > 10)),
                lambda x: x[1] > -1e-9, symmetric=(0,), **options)


def block(low, high, of_size, reach=4, symmetric=(), **options):
    return Body(box(low, high, of_size), lambda x: x[2] < 1e-6 + low[2],
                lambda x: (x[2] > -1e-9) & (np.linalg.norm(x, axis=0) < reach), symmetric=symmetric, **options)


def sneddon(r, depth):
    """F / E* of a rigid punch of radius 1 with an edge rounded by r, without friction, on a half-space."""
    def integral(c, power):
        slope = lambda x: max(x - 1 + r, 0) / np.sqrt(r**2 - max(x - 1 + r, 0) ** 2)
        start = np.arcsin(min(1, (1 - r) / c))
        return quad(lambda t: (c * np.sin(t)) ** power * slope(c * np.sin(t)), start, np.pi / 2, limit=200)[0]
    c = brentq(lambda c: c * integral(c, 0) - depth, 1 - r, 1 - 1e-9)
    return 2 * integral(c, 2)


def press(body, edge, depths=DEPTHS, step=0.05, stiffness=300):
    """Forces, states and least stretches of a punch at the depths."""
    depth, k = fem.Constant(body.domain, 0.0), fem.Constant(body.domain, 0.0)
    body.release(body.punch(edge, depth, k))
    w, forces, states, stretches = body.w.x.array, [], [], []
    body.states = states
    before, last, ladder = w.copy(), 0.0, np.geomspace(10, stiffness, 4)
    for target in depths:
        while last < target - 1e-9:
            start, reach = w.copy(), min(step, target - last)
            for way in ("line", "ladder", "ladder", "ladder"):  # along the last states, or by softer penalties, or shorter
                if way == "line":
                    w[:] += (start - before) * (last > 0)
                depth.value = last + reach
                try:
                    for factor in ladder if way == "ladder" or last == 0 else (stiffness,):
                        k.value = factor * body.Estar
                        force = body.solve(iterations=40)
                    break
                except Stopped:
                    w[:] = start
                    reach /= 1 if way == "line" else 2
            else:
                return tuple(np.pad(np.array(a, float), (0, len(depths) - len(a)), constant_values=np.nan) for a in (forces, stretches))
            before, last = start, last + reach
        forces.append(-force @ body.normal)
        states.append(w.copy())
        stretches.append(body.least_stretch())
    return np.array(forces), np.array(stretches)


def move(body, phi, R, means, frame=None):
    """Forces, displacements of the center, states and least stretches with the mean at each of `means` along the first
    row of the frame (the inward normal), and at 0 along the others; NaN where no state was found."""
    body.release()
    frame = -body.normal[None] if frame is None else np.array(frame, float)
    F, center, stretch = np.full((3, len(means)), np.nan)
    body.states = [np.full(len(body.w.x.array), np.nan)] * len(means)
    tool = {"patch": body.patch(R)} if phi == "patch" else {"rows": body.rows(body.weights(phi, R), frame)}
    for i, mean in enumerate(means):
        try:
            force = body.solve(**tool, d=mean * (frame[0] if phi == "patch" else np.eye(len(frame))[0]))
        except Stopped:
            break
        F[i] = force @ frame[0] if phi == "patch" else force[0]
        center[i] = body.w.x.array[body.dofs[body.center]] @ frame[0]
        stretch[i] = body.least_stretch()
        body.states[i] = body.w.x.array.copy()
    return F, center, stretch


def compare(body, step, edges=EDGES, fitted=False, tools=TOOLS):
    """Punches against tools of the half-space's radius, and of the radius that fits the body at the smallest depth."""
    out, tips, fields = {"cells": int(body.domain.topology.index_map(body.dim).size_local)}, {}, None
    for edge in edges:
        tips[edge], stretch = press(body, edge, step=min(step, 0.1))
        fields = body.states
        out[f"punch, edge {edge}"] = {"F": tips[edge].round(3).tolist(), "least_stretch": stretch.round(2).tolist()}
        print(edge, out[f"punch, edge {edge}"], flush=True)
    means = np.arange(1, round(0.8 / step) + 1) * step

    def at_depths(phi, way, R, means=means):
        F, center, stretch = move(body, phi, R, means)
        place = center if way == "center" else means
        valid = ~np.isnan(F)
        place, values = np.append(0, place[valid]), np.array([np.append(start, a[valid]) for start, a in ((0, F), (0, center / means), (1, stretch))])
        return np.array([np.interp(DEPTHS, place, v, right=np.nan) for v in values]), place[-1]

    for phi, way in tools:
        R = radius(phi, way)
        for kind in ("half-space", "body") if fitted else ("half-space",):
            if kind == "body":
                for _ in range(3):  # F grows about like R
                    R *= tips[edges[-1]][0] / at_depths(phi, way, R, means[means < 0.2 + 1e-9])[0][0, 0]
            (F, center, stretch), last = at_depths(phi, way, R)
            row = {"R": round(R, 3), "F": F.round(3).tolist(), "center/mean": center.round(2).tolist(),
                   "least_stretch": stretch.round(2).tolist(), "deepest": round(float(last), 2)}
            row["percent_of_edges"] = {str(e): (100 * (F / tips[e] - 1)).round(1).tolist() for e in edges}
            if way == "mean":
                at = [int(round(d / step)) - 1 for d in DEPTHS]
                row["surface_percent"] = [round(100 * body.surface_difference(body.states[i], f), 1) for i, f in zip(at, fields)]
            out[f"{phi}, {way}, R of {kind}"] = row
            print(phi, way, kind, row, flush=True)
    return out


def half_space(_):
    out = {"closed_forms": {phi: {"F/(E* R mean)": round(STIFFNESS[phi], 4), "center/mean": round(CENTER[phi], 4)} for phi in STIFFNESS}}
    for side in (50, 100):
        body = cylinder(side, size(0.02, 0.1), law="linear")
        row = {"cells": int(body.domain.topology.index_map(2).size_local)}
        for phi in STIFFNESS:
            R = radius(phi, "mean")
            F, center, _ = move(body, phi, R, [0.3])
            row[phi] = {"force over theory": round(F[0] / (body.Estar * R * 0.3) / STIFFNESS[phi], 4),
                        "center/mean over theory": round(center[0] / 0.3 / CENTER[phi], 4)}
        for edge in EDGES:
            exact = np.array([sneddon(edge, d) for d in DEPTHS]) * body.Estar
            row[f"punch, edge {edge}"] = (press(body, edge)[0] / exact).round(4).tolist()
        out[f"side {side}"] = row
        print(side, row, flush=True)
    return out


def on_cylinder(_):
    out = {}
    for K, rim in ((10.0, 0.02), (50.0, 0.02)):
        out[f"K/mu {K:.0f}"] = compare(cylinder(SIDE, size(rim, 0.08), K=K), 0.025, fitted=True)
    return out


def on_block(_):
    body = block((0, 0, -SIDE), (SIDE, SIDE, 0), size(0.13, 0.35, 0.35), symmetric=(0, 1))
    return compare(body, 0.1, (0.2, 0.1))


def on_liver(path):
    """The place on top, in the middle of the bounding box; the underside is held; cells refined at the tool and its rim."""
    domain, normal = organ(path, 0.012, np.array([0.5, 0.5, 1.0]), (
        lambda x: np.linalg.norm(x, axis=1) < 1.5, lambda x: np.hypot(np.linalg.norm(x[:, :2], axis=1) - 1, x[:, 2]) < 0.4))
    corners, normals = boundary(domain)
    middles, facing = domain.geometry.x[corners].mean(axis=1), normals @ normal / np.linalg.norm(normals, axis=1)
    below = domain.geometry.x[corners[facing < -0.3]]
    tree, under = cKDTree(middles[facing > 0.5]), cKDTree(np.concatenate([below, (below + np.roll(below, 1, 1)) / 2]).reshape(-1, 3))
    body = Body(domain, lambda x: under.query(x.T)[0] < 1e-9, lambda x: (np.linalg.norm(x, axis=0) < 3.5) & (tree.query(x.T)[0] < 1e-9),
                normal=normal)
    return compare(body, 0.2, (0.2,), tools=[tool for tool in TOOLS if tool[1] == "mean"])


def how_deep(_):
    """With R = 1: the mean up to which no cell has a stretch below 0.5, up to which a state was found by steps of 0.025
    (0.05 in three dimensions), the center over the mean at the former, and the force over that of a linear body."""
    out, h = {}, 0.5**0.5
    for (K, element, edge), height in itertools.product(((10, "P2", 0.05), (200, "taylor-hood", 0.1), (200, "p1-p1", 0.1), (200, "p1-p1", 0.35)), (3.5, 1.5)):
        of_size, options = lambda x: edge + 0.5 * max(0, np.linalg.norm(x) - 1.3), {"K": K, "element": element}
        if edge < 0.3:
            body, means = cylinder(height, of_size, 3.5, **options), np.arange(1, 41) * 0.025
            ways = {"push": ((0, -1),), "pull": ((0, 1),)}
        else:
            body, means = block((-3.5, 0, -height), (3.5, 3.5, 0), of_size, symmetric=(1,), **options), np.arange(1, 21) * 0.05
            ways = {"push": ((0, 0, -1), (1, 0, 0)), "pull": ((0, 0, 1), (1, 0, 0)), "slide": ((1, 0, 0), (0, 0, 1)),
                    "push at 45 degrees": ((h, 0, -h), (h, 0, h))}
        for (way, frame), phi in itertools.product(ways.items(), STIFFNESS):
            F, center, stretch = move(body, phi, 1.0, means, frame)
            last = np.append(np.flatnonzero(~(stretch > 0.5)), len(means))[0] - 1
            out[f"{element}, K/mu {K}, edge {edge}, height {height}, {way}, {phi}"] = {
                "good_to": round(means[last], 3), "found_to": round(means[(~np.isnan(F)).sum() - 1], 3),
                "center/mean": round(center[last] / means[last], 2), "F_over_linear": round(F[last] / F[0] / (last + 1), 2)}
            print(*list(out.items())[-1], flush=True)
    return out


def on_meshes(_):
    out, top = {}, lambda x: (x[2] > -1e-9) & (np.linalg.norm(x, axis=0) < 2.5)
    domain, forces = box((0, 0, -3), (4, 4, 0), lambda x: 1 + 0.4 * max(0, np.linalg.norm(x) - 1.5)), {phi: [] for phi in STIFFNESS}
    for _ in range(4):  # edges of R to R / 8
        body = Body(domain, lambda x: x[2] < 1e-6 - 3, top, symmetric=(0, 1), element="p1-p1", K=50)
        for phi in STIFFNESS:
            forces[phi].append(move(body, phi, 1.0, [0.1])[0][0])
        domain.topology.create_entities(1)
        domain = mesh.refine(domain, redistribute=False)
    for phi, F in forces.items():
        steps = np.abs(np.diff(F))
        out[f"order, {phi}"] = {"F": np.round(F, 4).tolist(), "orders": np.log2(steps[:-1] / steps[1:]).round(2).tolist()}
    places = np.random.default_rng(1).uniform(-0.4, 0.4, (12, 2))
    for kind, near in (("even 0.42", lambda x: 0.42), ("graded 0.15 to 0.7", lambda x: min(max(0.15, 0.4 + 0.2 * x[0]), 0.7))):
        domain = box((-4, -4, -3), (4, 4, 0), lambda x: near(x) + 0.6 * max(0, np.linalg.norm(x) - 1.6))
        for element in ("p1-p1", "P2"):
            body = Body(domain, lambda x: x[2] < 1e-6 - 3, top, K=50, element=element)
            fem.petsc.assemble_matrix(body.A, body.tangent)
            body.A.assemble()
            body.A.zeroRowsColumns(body.fixed, 1.0)
            column, step = body.A.createVecs()
            for degree, phi in itertools.product((24, 6, 0), ("bump", "Hertz", "uniform")):
                forces, negative, shift = [], [], []
                for body.at.value[:2] in places:  # F per mean at rest
                    w = body.weights(phi, 1.0, degree)
                    negative.append(-w[w < 0].sum())
                    shift.append(np.linalg.norm(w @ body.x - body.at.value))
                    column.array[:] = body.rows(w, [[0, 0, 1]])[0]
                    body.ksp.solve(column, step)
                    forces.append(1 / column.dot(step))
                out[f"scatter, {kind}, {element}, degree {degree}, {phi}"] = {
                    "mean": round(np.mean(forces), 3), "std_percent": round(100 * np.std(forces) / np.mean(forces), 2),
                    "centroid_off": round(np.mean(shift), 4), "sum_of_negative": round(np.mean(negative), 4)}
    return out


def main():
    sections = {"half-space": half_space, "cylinder": on_cylinder, "block": on_block, "liver": on_liver, "depth": how_deep, "mesh": on_meshes}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="+", choices=sections)
    parser.add_argument("--liver", default="liver.msh")
    options = parser.parse_args()
    path = pathlib.Path(__file__).parent / "results.json"
    for name in options.sections:
        start = time.process_time()
        result = sections[name](options.liver)
        result["cpu_s"] = round(time.process_time() - start)
        kept = json.loads(path.read_text()) if path.exists() else {}
        path.write_text(json.dumps({**kept, name: result}).replace("NaN", "null").replace("}, ", "},\n") + "\n")
        print(name, result["cpu_s"], "s", flush=True)


if __name__ == "__main__":
    main()
