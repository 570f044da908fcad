"""How well a finer solution is known at a point from its stiffness at rest there and from the rays of other points.

Usage: leave_one_out.py SCENE [--points 10] [--seed 1] [--reference taylor-hood] [-o FILE] | --of FILE

At active nodes of a scene of round tools, which are far from each other, six random directions are solved to half and all of the
largest displacement, with the element of the scene (F, stiffness at rest K) and with the reference on the same mesh (G, L).
Predictions of G = L d + (G - L d):
  element         F
  stiffness       L d + (F - K d)
  product         L inv(K) F
  one factor      L d + s (F - K d), s by least squares over all other points
  product, factor L d + s (L inv(K) F - L d), in the same way
  nearest, direction, own rays, own ray      s of the nearest other point, of the same direction at all others, of the other
                  directions of the point itself, and of the direction itself (which nobody knows)
Printed are errors over |G|, mean / p95 / max in %, for each depth, and the mean at each point. -o keeps all forces as JSON, from
which --of prints them again.
"""
import argparse
import json
import pathlib
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from commands import answer, changed, run, vector  # noqa: E402


def spread(points, n):
    """Numbers of n points, each the farthest from those before."""
    chosen = [int(np.argmax(np.linalg.norm(points - points.mean(0), axis=1)))]
    while len(chosen) < min(n, len(points)):
        chosen.append(int(np.argmax(np.linalg.norm(points[:, None] - points[chosen], axis=2).min(1))))
    return chosen


def responses(scene, nodes, d, folder):
    """Stiffness at rest (nodes, 3, 3) and forces (nodes, displacements, 3); NaN where there is no equilibrium."""
    stiffness = np.array([answer("solve", scene, "--node", n, "--displacement", "0,0,0", "--tangent")["tangent_N_per_m"] for n in nodes])
    queries, table = folder / "queries.csv", folder / "solved.csv"
    queries.write_text("node,ux_m,uy_m,uz_m\n" + "".join(f"{n},{vector(x)}\n" for n in nodes for x in d))
    table.unlink(missing_ok=True)
    run("solve", scene, "--queries", queries, "-o", table)
    found = np.genfromtxt(table, delimiter=",", names=True, usecols=range(9), filling_values=np.nan)
    return stiffness.reshape(len(nodes), 3, 3), np.column_stack([found[k] for k in ("fx_N", "fy_N", "fz_N")]).reshape(len(nodes), len(d), 3)


def predictions(x, d, K, F, L, G):
    """{name: (points, displacements, 3)}, from the points' places x."""
    linear = np.einsum("pij,dj->pdi", L, d)
    rest, product = F - np.einsum("pij,dj->pdi", K, d), np.einsum("pij,pjk,pdk->pdi", L, np.linalg.inv(K), F) - linear
    # Errors are relative, so that each state counts by its own size.
    weight = np.nan_to_num(1 / np.linalg.norm(G, axis=-1, keepdims=True) ** 2)
    n, half = np.arange(len(x)), len(d) // 2
    away = np.linalg.norm(x[:, None] - x, axis=2) + np.diag(np.full(len(x), np.inf))
    points, directions = np.indices(G.shape[:2]) % [[[len(x)]], [[half]]]

    def scaled(part, of):
        """With the factor of the states for which of(point, direction) is true."""
        predicted = np.array(linear)
        for i in n:
            for j in range(len(d)):
                w = weight * of(i, j % half)[..., None]
                predicted[i, j] += np.nansum(w * part * (G - linear)) / np.sum(w * part * part) * part[i, j]
        return predicted

    return {"element": F, "stiffness": linear + rest, "product": linear + product,
            "one factor": scaled(rest, lambda i, j: points != i), "product, factor": scaled(product, lambda i, j: points != i),
            "nearest": scaled(rest, lambda i, j: points == away[i].argmin()),
            "direction": scaled(rest, lambda i, j: (points != i) & (directions == j)),
            "own rays": scaled(rest, lambda i, j: (points == i) & (directions != j)),
            "own ray": scaled(rest, lambda i, j: (points == i) & (directions == j))}


def solved(asked):
    """{places, d, K, F, L, G}."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run("mesh", asked.scene, "-o", folder / "mesh.msh")
        text = asked.scene.read_text()
        # The rays of one increment in three directions leave the places of the points and the mesh in a database.
        (folder / "own.toml").write_text(text)
        (folder / "finer.toml").write_text(changed(text, {("solver", "element"): f'"{asked.reference}"'}))
        one = changed(text, {("probe", "directions"): "3", ("probe", "increments"): "1", ("probe", "max_displacement_m"): "1e-5"})
        (folder / "points.toml").write_text(one)
        run("precompute", folder / "points.toml", "-o", folder / "points.h5")
        with h5py.File(folder / "points.h5") as f:
            places, active = f["mesh/nodes"][()], f["sets/active"][()]
        nodes = active[spread(places[active], asked.points)]
        R = float(next(line.split("=")[1].split("#")[0] for line in text.splitlines() if line.startswith("max_displacement_m")))
        random = np.random.default_rng(asked.seed).normal(size=(6, 3))
        random /= np.linalg.norm(random, axis=1)[:, None]
        d = np.concatenate([R / 2 * random, R * random])
        K, F = responses(folder / "own.toml", nodes, d, folder)
        L, G = responses(folder / "finer.toml", nodes, d, folder)
    return {"places": places[nodes], "d": d, "K": K, "F": F, "L": L, "G": G}


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("scene", type=pathlib.Path, nargs="?")
    parser.add_argument("--of", type=pathlib.Path)
    parser.add_argument("--points", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--reference", default="taylor-hood")
    parser.add_argument("-o", type=pathlib.Path)
    asked = parser.parse_args()
    if asked.of:
        found = {name: np.array(values, float) for name, values in json.loads(asked.of.read_text()).items()}
    else:
        found = solved(asked)
    if asked.o:
        asked.o.write_text(json.dumps({name: values.tolist() for name, values in found.items()}))
    x, d, K, F, L, G = found.values()
    size = np.linalg.norm(G, axis=2)
    print(f"{len(x)} points, {np.isfinite(size).sum()} of {size.size} states, {asked.reference}; errors in %, mean / p95 / max")
    for name, predicted in predictions(x, d, K, F, L, G).items():
        error = 100 * np.linalg.norm(predicted - G, axis=2) / size
        shown = [e[np.isfinite(e)] for e in (error[:, : len(d) // 2], error[:, len(d) // 2 :])]
        at = " ".join(f"{e:.1f}" for e in np.nanmean(error, axis=1))
        print(f"{name:16}", *(f"{e.mean():6.2f} / {np.percentile(e, 95):5.2f} / {e.max():5.2f}" for e in shown), "   ", at)


main()
