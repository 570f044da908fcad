#!/usr/bin/env python3
"""Calibrates error bounds on the random rays of some nodes and tests them on those of other nodes, for random choices
of the nodes (docs/decisions/error-bounds.md).

Usage: calibrated_bounds.py PHYNNESS MODEL_DIR DATABASE.h5 RAYS.csv ... [--nodes N] [--repeats N]
RAYS.csv come from phynness_random_rays; they must not share rays. Needs numpy and h5py.
"""
import argparse
import pathlib
import subprocess
import tempfile

import h5py
import numpy as np

COVERAGE, SHRINKAGE, DEPTH_POWER, SMALLEST = 0.95, 0.8, 0.5, 1e-5


def read_database(file):
    with h5py.File(file) as h:
        responses = h["responses"]
        good = responses["status"][:] == 0
        force = np.linalg.norm(responses["force"][:], axis=-1)
        least = np.where(good, responses["min_jacobian"][:], 1e-4)
        depth = h["magnitudes"][:]
        ends = np.where(good.all(2), good.shape[2], (~good).argmax(2))
        return {"directions": h["directions"][:], "depths": depth, "active": h["sets/active"][:],
                "crush": np.log(-np.log(np.clip(least, 1e-4, 1 - 1e-4))),
                "largest": np.nanmax(np.where(good, force, 0), axis=(1, 2)),
                "trained": np.concatenate([[0], depth])[ends]}


def read_rays(files):
    tables = []
    for number, file in enumerate(files):
        table = np.genfromtxt(file, delimiter=",", names=True)
        table["ray"] += 1e6 * number
        tables.append(table[table["status"] == 0])
    return np.concatenate(tables)


def forces(phynness, model, rays):
    with tempfile.TemporaryDirectory() as folder:
        queries = pathlib.Path(folder) / "queries.csv"
        with open(queries, "w") as out:
            out.write("node,ux_m,uy_m,uz_m\n")
            for r in rays:
                d = [r["depth_m"] * r[k] for k in ("ex", "ey", "ez")]
                out.write("%d,%.17g,%.17g,%.17g\n" % (r["node"], *d))
        answer = subprocess.run([phynness, "eval", model, "--queries", queries], capture_output=True, text=True, check=True)
    table = np.genfromtxt(answer.stdout.splitlines(), delimiter=",", names=True)
    return np.stack([table[k] for k in ("fx_N", "fy_N", "fz_N")], 1), table["trained_depth_m"]


def at(data, table, node, direction, depth, falls):
    """Values of a table at states: in the nearest direction, linear in the depth; falls: 0 at rest."""
    rows = table[node, (direction @ data["directions"].T).argmax(1)]
    rows = np.concatenate([0 * rows[:, :1] if falls else rows[:, :1], rows], 1)
    knots = np.concatenate([[0], data["depths"]])
    i = np.clip(np.searchsorted(knots, depth, side="right") - 1, 0, len(knots) - 2)
    f = np.clip((depth - knots[i]) / (knots[i + 1] - knots[i]), 0, 1)
    each = np.arange(len(rows))
    return rows[each, i] * (1 - f) + rows[each, i + 1] * f


def calibrated(data, node, direction, depth, error):
    scale, largest = data["depths"][-1], data["largest"]
    terms = np.stack([np.ones(len(node)), np.log(largest[node]), at(data, data["crush"], node, direction, depth, False),
                      np.log(depth / scale)], 1)
    c = SHRINKAGE * np.linalg.lstsq(terms, np.log(error + SMALLEST * largest[node]), rcond=None)[0]
    c[3] += SHRINKAGE * DEPTH_POWER
    table = np.exp(c[0] + c[1] * np.log(largest)[:, None, None] + c[2] * data["crush"]
                   + c[3] * np.log(data["depths"] / scale))
    scores = np.sort(error / at(data, table, node, direction, depth, True))
    level = COVERAGE * (1 + 1 / len(np.unique(node)))
    return table * scores[min(len(scores), int(np.ceil(level * len(scores)))) - 1]


def figures(data, table, node, direction, depth, error):
    bound, largest = at(data, table, node, direction, depth, True), data["largest"][node]
    holds = error <= bound
    constant = lambda e: np.sort(e)[int(np.ceil(holds.mean() * len(e))) - 1]
    third = np.minimum((3 * depth / data["depths"][-1]).astype(int), 2)
    nodes = np.unique(node)
    order = nodes[np.argsort((table.mean((1, 2)) / data["largest"])[nodes])]
    of_node = np.array([holds[node == n].mean() for n in nodes])
    out = {"coverage": holds.mean(), "width in N": bound.mean() / constant(error),
           "width over the largest force": (bound / largest).mean() / constant(error / largest)}
    out.update({"third %d of the depth" % (k + 1): holds[third == k].mean() for k in range(3)})
    out.update({"quarter %d of the nodes" % (k + 1): holds[np.isin(node, part)].mean()
                for k, part in enumerate(np.array_split(order, 4))})
    out.update({"worst node": of_node.min(), "nodes below 90 %": (of_node < 0.9).mean()})
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("phynness", "model", "database"):
        parser.add_argument(name)
    parser.add_argument("rays", nargs="+")
    parser.add_argument("--nodes", type=int, default=88, help="of the calibration")
    parser.add_argument("--rays-per-node", type=int, default=12)
    parser.add_argument("--repeats", type=int, default=60)
    given = parser.parse_args()
    data, rays = read_database(given.database), read_rays(given.rays)
    said, range_m = forces(given.phynness, given.model, rays)
    error = np.linalg.norm(said - np.stack([rays[k] for k in ("fx", "fy", "fz")], 1), axis=1)
    direction = np.stack([rays[k] for k in ("ex", "ey", "ez")], 1)
    inside = rays["depth_m"] <= range_m * (1 + 1e-9)
    node = np.searchsorted(data["active"], rays["node"])
    states = [v[inside] for v in (node, direction, rays["depth_m"], error)]
    ray = (rays["node"] + 1e7 * rays["ray"])[inside]
    nodes = np.unique(states[0])
    print("%d states inside the range, %d rays, %d nodes" % (len(ray), len(np.unique(ray)), len(nodes)))
    results = []
    for repeat in range(given.repeats):
        random = np.random.default_rng(repeat)
        chosen = random.choice(nodes, given.nodes, replace=False)
        keep = np.zeros(len(ray), bool)
        for n in chosen:
            own = np.unique(ray[states[0] == n])
            for r in random.choice(own, min(len(own), given.rays_per_node), replace=False):
                i = np.nonzero(ray == r)[0]
                keep[random.choice(i, min(3, len(i)), replace=False)] = True
        other = ~np.isin(states[0], chosen)
        table = calibrated(data, *(v[keep] for v in states))
        results.append(figures(data, table, *(v[other] for v in states)))
    for key in results[0]:
        values = np.array([r[key] for r in results])
        print("%-30s mean %.3f, 5 %% %.3f, 95 %% %.3f" % (key, values.mean(), *np.quantile(values, [0.05, 0.95])))


if __name__ == "__main__":
    main()
