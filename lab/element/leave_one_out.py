"""How well a finer solution is known at a point from its stiffness at rest there and from the rays of other points.

Usage: leave_one_out.py SCENE [--points 10] [--seed 1] [--reference taylor-hood] [-o FILE]

At active nodes of a scene of round tools, which are far from each other, six random directions are solved to half and all of the
largest displacement, with the element of the scene (F, stiffness at rest K) and with the reference on the same mesh (G, L).
Predictions of G = L d + (G - L d):
  element         F
  stiffness       L d + (F - K d)
  one factor      L d + s (F - K d), s by least squares over the other points
  nearest         L d + s (F - K d), s of the nearest other point
  product         L inv(K) F
  product, factor L d + s (L inv(K) F - L d), s by least squares over the other points
Printed are errors over |G|, mean / p95 / max in %, for each depth, and the mean at each point. -o keeps all forces as JSON.
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
    rest = F - np.einsum("pij,dj->pdi", K, d)
    product = np.einsum("pij,pjk,pdk->pdi", L, np.linalg.inv(K), F)

    def factor(part, of):
        a, b = part[of], (G - linear)[of]
        # Relative errors are printed, so that each state counts by its own size.
        weight = 1 / np.linalg.norm(G[of], axis=-1, keepdims=True) ** 2
        return np.nansum(weight * a * b) / np.nansum(weight * a * a + 0 * b)

    n = np.arange(len(x))
    away = np.linalg.norm(x[:, None] - x, axis=2) + np.diag(np.full(len(x), np.inf))

    def scaled(part, others):
        return linear + np.array([factor(part, others(i)) for i in n])[:, None, None] * part

    return {"element": F, "stiffness": linear + rest, "one factor": scaled(rest, lambda i: n != i),
            "nearest": scaled(rest, lambda i: [away[i].argmin()]), "product": product,
            "product, factor": scaled(product - linear, lambda i: n != i)}


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--points", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--reference", default="taylor-hood")
    parser.add_argument("-o", type=pathlib.Path)
    asked = parser.parse_args()
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
    if asked.o:
        asked.o.write_text(json.dumps({"places": places[nodes].tolist(), "d": d.tolist(), "K": K.tolist(), "F": F.tolist(),
                                       "L": L.tolist(), "G": G.tolist()}))
    size = np.linalg.norm(G, axis=2)
    print(f"{len(nodes)} points, {np.isfinite(size).sum()} of {size.size} states, {asked.reference}; errors in %, mean / p95 / max")
    for name, predicted in predictions(places[nodes], d, K, F, L, G).items():
        error = 100 * np.linalg.norm(predicted - G, axis=2) / size
        shown = [e[np.isfinite(e)] for e in (error[:, :6], error[:, 6:])]
        at = " ".join(f"{e:.1f}" for e in np.nanmean(error, axis=1))
        print(f"{name:16}", *(f"{e.mean():6.2f} / {np.percentile(e, 95):5.2f} / {e.max():5.2f}" for e in shown), "   ", at)


main()
