"""Which weight should a round tool have that moves a weighted mean of the surface? A comparison with rigid tips.

Packages (Debian 12): python3-dolfinx-real, python3-petsc4py-real, python3-gmsh, python3-scipy. Run with /usr/bin/python3:

    python3 research/tool_reference/study.py half-space block liver oblique mesh depth [--liver liver.msh]

`half-space` checks tips and tools against closed forms; `block` and `liver` print the force of the tips and of the tools
and their differences; `oblique` compares with a glued punch; `mesh` gives the convergence of the force, its scatter over
places and the signs of the weights; `depth` presses, pulls and slides until cells are inside out. liver.msh is written by
`phynness mesh SCENE -o liver.msh` with `target_nodes = 400`. The figures are kept in results.json beside this file, each
section on its own. One core, about 20 minutes in all; OMP_NUM_THREADS=1.

Not concluded: two runs of `liver` differ (place and mesh were being changed), and no choice has been made from the figures.
"""
import argparse
import json
import pathlib
import time

import numpy as np
from body import Body, Stopped, block, fem, gap_of, mesh, refined_organ
from scipy.integrate import quad
from scipy.optimize import brentq

PUNCH, SPHERE = ("punch", 1.0, 0.4), ("sphere", 3.75)  # the sphere has the punch's stiffness F / depth at depth 0.6
# F / (E* R mean) on a half-space, and the displacement of the center over the mean
STIFFNESS = {"bump": 17325 * np.pi**2 / 131072, "Hertz": 5 / 3, "uniform": 3 * np.pi**2 / 16, "patch": 0.685008}
CENTER = {"bump": STIFFNESS["bump"] / (5 * np.pi / 16), "Hertz": 5 / 4, "uniform": 3 * np.pi / 8, "patch": 1.0}
DEPTHS = np.array([0.2, 0.4, 0.8])
Z = np.array([[0, 0, 1.0]])
RADIUS = {(phi, way): 2 / STIFFNESS[phi] * (1 if way == "mean" else CENTER[phi]) for phi in STIFFNESS
          for way in ("mean", "center") if (phi, way) != ("patch", "center")}

MEAN = {tool: R for tool, R in RADIUS.items() if tool[1] == "mean"}


def sneddon(tip, depth):
    """F / E* of a rigid axisymmetric tip, without friction, on a half-space."""
    def slope(r):
        if tip[0] == "sphere":
            return r / np.sqrt(tip[1] ** 2 - r**2)
        s = r - (tip[1] - tip[2])
        return s / np.sqrt(tip[2] ** 2 - s**2) if s > 0 else 0.0

    def integral(c, power):
        return quad(lambda t: (c * np.sin(t)) ** power * slope(c * np.sin(t)), 0, np.pi / 2, limit=200)[0]

    largest = (tip[1] if tip[0] == "sphere" else tip[1]) * (1 - 1e-6)
    c = brentq(lambda c: c * integral(c, 0) - depth, 1e-6, largest)
    return 2 * integral(c, 2)


def press(body, tip, depths=DEPTHS, stiffness=300, linear=False, steps=3):
    """Forces and states of a tip at the depths."""
    depth, k = fem.Constant(body.domain, 0.0), fem.Constant(body.domain, 0.0)
    body.contact(gap_of(body, tip, depth, linear), k)
    forces, states, before, last = [], [], body.w.x.array.copy(), 0.0
    factors = np.geomspace(10, stiffness, 1 + int(np.ceil(np.log10(stiffness / 10) / 0.5)))
    for target in depths:
        for i in range(steps):
            depth.value = last + (target - last) * (i + 1) / steps
            start = body.w.x.array.copy()
            ladders = [factors]  # from a soft penalty to the hard one; first on a straight line through the last states
            if last + i > 0:
                ladders = [[stiffness], factors, np.geomspace(3, stiffness, 12)]
                body.w.x.array[:] += start - before
            for ladder in ladders:
                try:
                    for factor in ladder:
                        k.value = factor * body.Estar
                        force = body.solve(iterations=15 if len(ladder) == 1 else 40)
                    break
                except Stopped:
                    body.w.x.array[:] = start
            else:
                raise Stopped(f"tip at {depth.value}")
            before = start
            print('  tip at', round(float(depth.value), 3), -force @ body.normal, round(time.process_time()), flush=True)
        last = target
        forces.append(float(-force @ body.normal))
        states.append(body.w.x.array.copy())
    return np.array(forces), states


def move(body, phi, R, depths=DEPTHS, direction=None, steps=1, frame=np.eye(3), degree=24):
    """Forces on the tool, displacements of the center and states, with the mean at the depths along the direction.
    frame, m x 3: the components of the mean that are prescribed; without a state the rest is NaN."""
    direction = -body.normal if direction is None else np.array(direction, float)
    body.contact(None)
    frame = np.eye(3) if phi == "patch" else np.array(frame, float)
    keys = {"patch": body.patch(R)} if phi == "patch" else {"rows": frame @ body.mean_rows(phi, R, degree)[0]}
    body.multipliers = np.zeros(len(frame))
    forces, centers, states, last = [], [], [], 0.0
    for target in depths:
        for k in range(steps):
            try:
                force = body.solve(d=frame @ direction * (last + (target - last) * (k + 1) / steps), **keys)
            except Stopped:
                force = np.full(len(frame), np.nan)
                body.w.x.array[:] = np.nan
                break
        last = target
        forces.append(frame.T @ force)
        centers.append(body.displacement())
        states.append(body.w.x.array.copy())
    return np.array(forces), np.array(centers), states


def at_depths(x, values, depths):
    """Values at the depths, by the parabola through the three nearest of the origin and the points x."""
    x, values, out = np.concatenate([[0], x]), np.concatenate([0 * values[:1], values]), []
    for t in depths:
        if not t < 1.02 * np.nanmax(x):
            out.append(np.nan * values[0])
            continue
        near = np.argsort(np.abs(np.nan_to_num(x, nan=99) - t))[:3]
        out.append(sum(values[i] * np.prod([(t - x[j]) / (x[i] - x[j]) for j in near if j != i]) for i in near))
    return np.array(out)


def compare(body, depths=DEPTHS, tools=RADIUS, steps=2):
    """Tips against tools: relative differences of force and of the surface, by depth."""
    out = {"cells": int(body.domain.topology.index_map(3).size_local), "depths": list(depths)}
    tips = {}
    for tip in (PUNCH, SPHERE):
        tips[tip[0]] = press(body, tip, depths)
        out[tip[0]] = {"F": tips[tip[0]][0].round(4).tolist(), "least_stretch": round(body.least_stretch(), 3)}
        print(tip, out[tip[0]], flush=True)
    for (phi, way), R in tools.items():
        name = f"{phi}, {way}"
        imposed = depths if way == "mean" else np.array([0.15, 0.3, 0.5, 0.8])
        forces, centers, states = move(body, phi, R, imposed, steps=steps, frame=body.normal[None])
        F, c = -forces @ body.normal, -centers @ body.normal
        row = {"R": round(R, 3), "mean": imposed.round(4).tolist(), "F": F.round(4).tolist(), "center": c.round(4).tolist(),
               "least_stretch": round(body.least_stretch(), 3)}
        if way == "center":
            F, states = at_depths(c, F, depths), at_depths(c, np.array(states), depths)
            row["F_at_center"] = F.round(4).tolist()
        for tip, (reference, fields) in tips.items():
            difference = F / reference - 1
            row[tip] = {"force_percent": (100 * difference).round(1).tolist(), "surface_percent": [
                round(100 * body.surface_difference(s, f), 1) for s, f in zip(states, fields)]}
        out[name] = row
        print(name, row, flush=True)
    for tip in tips:  # the radius that agrees best in the mean over the depths, and what remains
        for phi in STIFFNESS:
            a, b = out.get(f"{phi}, mean", {}), out.get(f"{phi}, center", {})
            for row in (r for r in (a, b) if r):
                logs = np.log1p(np.array(row[tip]["force_percent"]) / 100)
                row[tip]["best_R"] = round(row["R"] * np.exp(-logs.mean()), 3)  # F grows about like R
                row[tip]["spread_percent"] = round(100 * float(np.std(logs)), 1)
    return out


def half_space(_):
    out = {"depths": DEPTHS.tolist(), "closed_forms": {phi: {"F/(E* R mean)": STIFFNESS[phi], "center/mean": CENTER[phi]} for phi in STIFFNESS}}
    for size, edge in ((50, 0.4), (100, 0.4), (100, 0.2)):
        domain = block((0, 0, -size), (size, size, 0), edge, 1.7, 0.25)
        body = Body(domain, lambda x: (x[0] > size - 1e-6) | (x[1] > size - 1e-6) | (x[2] < 1e-6 - size), law="linear",
                    symmetric=(0, 1))
        row = {"cells": int(domain.topology.index_map(3).size_local)}
        for (phi, way), R in RADIUS.items():
            if way == "mean":
                forces, centers, _ = move(body, phi, R, [0.3], frame=Z)
                row[phi] = {"force over theory": round(-forces[0][2] / (body.Estar * R * 0.3) / STIFFNESS[phi], 4),
                            "center/mean over theory": round(-centers[0][2] / 0.3 / CENTER[phi], 4)}
        for tip in (PUNCH, SPHERE):
            for stiffness in (100, 300, 1000):
                if stiffness != 300 and (size, edge) != (100, 0.4):
                    continue
                F, _ = press(body, tip, DEPTHS, stiffness, linear=True)
                exact = np.array([sneddon(tip, d) for d in DEPTHS]) * body.Estar
                row[f"{tip[0]}, penalty {stiffness}"] = (F / exact).round(4).tolist()
        out[f"side {size}, edge {edge}"] = row
        print(size, edge, row, flush=True)
    return out


SIDE = 16 / 3  # half of the block's 16 cm, and its 8 cm of height, in units of a = 1.5 cm


def quarter(edge, **options):
    domain = block((0, 0, -SIDE), (SIDE, SIDE, 0), edge, 1.7, 0.35)
    return Body(domain, lambda x: x[2] < 1e-6 - SIDE, symmetric=(0, 1), **options)


def on_block(_):
    out = {"P2, K/mu 10": compare(quarter(0.35))}
    body = quarter(0.35)
    for stiffness in (100, 1000):
        out[f"punch, penalty {stiffness}"] = press(body, PUNCH, stiffness=stiffness)[0].round(4).tolist()
    fine = quarter(0.22)
    for tip in (PUNCH, SPHERE):
        out[f"{tip[0]}, edge 0.22"] = press(fine, tip)[0].round(4).tolist()
    for phi in ("bump", "Hertz", "uniform"):
        out[f"{phi}, mean, edge 0.22"] = (-move(fine, phi, RADIUS[phi, "mean"], frame=Z)[0][:, 2]).round(4).tolist()
    print(out, flush=True)
    out["Taylor-Hood, K/mu 200"] = compare(quarter(0.45, K=200.0, element="taylor-hood"), tools=MEAN)
    return out


def on_liver(path):
    domain, normal = refined_organ(path, 0.012, np.array([0.5, 0.5, 1.0]), (2.6, 1.7))
    low, high = domain.geometry.x.min(0), domain.geometry.x.max(0)
    out = {}
    for name, held in (("end held", lambda x: x[0] < low[0] + 0.2 * (high - low)[0]),
                       ("back held", lambda x: x[2] < low[2] + 0.25 * (high - low)[2])):
        out[name] = compare(Body(domain, held, normal=normal, reach=3.5), tools=RADIUS if name == "back held" else MEAN)
    return out


def oblique(_):
    domain = block((-SIDE, 0, -SIDE), (SIDE, SIDE, 0), 0.4, 1.6, 0.45)
    body, out = Body(domain, lambda x: x[2] < 1e-6 - SIDE, symmetric=(1,)), {}
    for sense, z in (("push", -1), ("pull", 1)):
        direction = np.array([0.5, 0, z * np.sqrt(0.75)])
        d = fem.Constant(domain, np.zeros(3))
        body.glue(1.0, d, 1000 * body.Estar)
        reference, fields, depths = [], [], [0.3, 0.6]
        for depth in depths:
            d.value = depth * direction
            reference.append(body.solve())
            fields.append(body.w.x.array.copy())
        reference = np.array(reference)
        reference[:, 1] = 0
        out[f"glued, {sense}"] = reference[:, [0, 2]].round(3).tolist()
        for (phi, way), R in RADIUS.items():
            scale = CENTER[phi] if way == "center" else 1.0
            F, centers, states = move(body, phi, R, np.array(depths) / scale, direction, frame=[[1, 0, 0], [0, 0, 1]])
            F[:, 1] = 0
            size = np.linalg.norm(reference, axis=1)
            out[f"{phi}, {way}, {sense}"] = {
                "force_percent": (100 * np.linalg.norm(F - reference, axis=1) / size).round(1).tolist(),
                "size_percent": (100 * (np.linalg.norm(F, axis=1) / size - 1)).round(1).tolist(),
                "center": centers[:, [0, 2]].round(3).tolist(),
                "surface_percent": [round(100 * body.surface_difference(s, f), 1) for s, f in zip(states, fields)]}
        print({k: v for k, v in out.items() if sense in k}, flush=True)
    return out


def on_meshes(_):
    out = {}
    for element, law, levels in (("P2", "linear", 3), ("P1", "neo-hookean", 4)):
        domain, forces = block((0, 0, -3), (4, 4, 0), 1.0, 1.5, 0.4), {}
        for level in range(levels):
            if level:
                domain.topology.create_entities(1)
                domain = mesh.refine(domain, redistribute=False)
            body = Body(domain, lambda x: x[2] < 1e-6 - 3, symmetric=(0, 1), law=law, element=element, reach=1.2)
            for phi in STIFFNESS:
                F = -move(body, phi, 1.0, [0.3], steps=1 if law == "linear" else 2, frame=Z)[0][0][2]
                forces.setdefault(phi, []).append(round(float(F), 5))
        for phi, F in forces.items():
            steps = np.abs(np.diff(F))
            out[f"{element}, {law}, {phi}"] = {"F": F, "orders": np.log2(steps[:-1] / steps[1:]).round(2).tolist(),
                                               "first_over_last": round(F[0] / F[-1], 4)}
        print({k: v for k, v in out.items() if element in k}, flush=True)
    domain = block((-4, -4, -3), (4, 4, 0), 0.42, 1.6, 0.6)
    places = np.random.default_rng(1).uniform(-0.4, 0.4, (12, 2))
    for element, degree in (("P1", 24), ("P1", 6), ("P2", 24)):
        body = Body(domain, lambda x: x[2] < 1e-6 - 3, law="linear", element=element, reach=2.5)
        for phi in STIFFNESS:
            forces, negative, least = [], [], []
            for place in places if (element, phi) != ("P2", "patch") else places[:6]:
                body.at.value[:2] = place
                if phi != "patch":
                    weights = body.mean_rows(phi, 1.0, degree)[1]
                    used = weights[np.abs(weights) > 1e-12]
                    negative.append((used < 0).mean())
                    least.append(-used[used < 0].sum())
                forces.append(-move(body, phi, 1.0, [0.1], degree=degree)[0][0][2])
            out[f"scatter, {element}, quadrature {degree}, {phi}"] = {
                "mean": round(float(np.mean(forces)), 5), "std_percent": round(100 * float(np.std(forces) / np.mean(forces)), 2),
                "range_percent": round(100 * float(np.ptp(forces) / np.mean(forces)), 2),
                "negative_weights_percent": round(100 * float(np.mean(negative or [0])), 1),
                "sum_of_negative": round(float(np.mean(least or [0])), 5)}
        print({k: v for k, v in out.items() if f"scatter, {element}, quadrature {degree}" in k}, flush=True)
    return out


def how_deep(_):
    """Force, center, least stretch and negative pivots of the free body's tangent, with R = 1, by depth and mesh."""
    out, depths = {}, np.arange(1, 9) / 10
    for element, edge, K in (("P2", 1 / 2, 10), ("P2", 1 / 3.5, 10), ("P2", 1 / 5, 10), ("P1", 1 / 2.5, 10), ("P1", 1 / 5, 10),
                             ("taylor-hood", 1 / 3, 200)):
        domain = block((0, 0, -3.5), (3.5, 3.5, 0), edge, 1.2, 0.4)
        body = Body(domain, lambda x: x[2] < 1e-6 - 3.5, K=K, element=element, symmetric=(0, 1), reach=2.0)
        for sense in (-1, 1):
            for phi in STIFFNESS:
                rows = {"patch": body.patch(1.0)} if phi == "patch" else {"rows": body.mean_rows(phi, 1.0)[0][[2]]}
                body.contact(None)
                body.multipliers = np.zeros(1)
                F, center, stretch, negative = [], [], [], []
                try:
                    for depth in depths:
                        d = sense * depth * np.array([0, 0, 1.0])
                        F.append(round(float(body.solve(d=d if phi == "patch" else d[2:], **rows)[-1]) * sense, 4))
                        center.append(round(float(sense * body.displacement()[2] / depth), 3))
                        stretch.append(round(body.least_stretch(), 3))
                        negative.append(body.negative_pivots())
                    why = "complete"
                except Stopped as reason:
                    why = str(reason)
                name = f"{element}, K/mu {K}, edge {edge:.2f} R, {'push' if sense < 0 else 'pull'}, {phi}"
                out[name] = {"F": F, "center/mean": center, "least_stretch": stretch, "negative": negative, "end": why}
                print(name, out[name], flush=True)
    return out


def main():
    sections = {"half-space": half_space, "block": on_block, "liver": on_liver, "oblique": oblique, "mesh": on_meshes,
                "depth": how_deep}
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
        path.write_text(json.dumps({**kept, name: result}, indent=None).replace("NaN", "null").replace("}, ", "},\n") + "\n")
        print(name, result["cpu_s"], "s", flush=True)


if __name__ == "__main__":
    main()
