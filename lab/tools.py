"""Forces of several tools on a reduced body, and their bounds, against finite elements in random states.

Usage: lab/study tools DATABASE MODEL BODY [--tools 3] [--states 50] [--seed 1] [--nodes] [--linear]

MODEL is of the same mesh. Tools are between probed points, in a third of the states within 2.5 radii, and each has a
random direction and length up to the scene's depth, as in `phynness calibrate`. With --nodes they are at probed nodes,
each displaced by half of the depth. States of which the body warns are counted and left out. The error of a state is
that of the worst tool, over the largest force; with --linear the linear predictor stands beside it, from displacements
a thousand times smaller.
"""

import argparse
import re

import h5py
import numpy as np
from commands import answer, text, vector


def trained_nodes(body):
    """Those of body.txt between which a tool was probed: kind 2."""
    with open(body) as file:
        for line in file:
            if line.startswith("nodes "):
                rows = [next(file).split()[:2] for _ in range(int(line.split()[1]))]
                return [int(node) for node, kind in rows if kind == "2"]


def random_places(random, nodes, surface, active, n_tools, at_nodes, within_m):
    """n_tools x 3."""
    found = []
    while len(found) < n_tools:
        if at_nodes:
            x = nodes[random.choice(active)]
        else:
            a, b = sorted(random.random(2))
            x = np.array([a, b - a, 1 - b]) @ nodes[surface[random.integers(len(surface))]]
        if not found or 0 < np.linalg.norm(x - found[0]) < within_m:
            found.append(x)
    return np.array(found)


def words(x, d):
    return [w for p, u in zip(x, d) for w in (f"--point={vector(p)}", f"--displacement={vector(u)}")]


def forces(found):
    return found and np.array([tool["force"] for tool in found["tools"]])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("database", "model", "body"):
        parser.add_argument(name)
    parser.add_argument("--tools", type=int, default=3)
    parser.add_argument("--states", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--nodes", action="store_true")
    parser.add_argument("--linear", action="store_true")
    options = parser.parse_args()
    with h5py.File(options.database) as f:
        nodes, surface = f["mesh/nodes"][()], f["mesh/surface"][()]
        active, scene = f["sets/active"][()], text(f["scene"][()])
    radius_m, depth_m = (float(re.search(rf"{key} *= *([0-9.e-]+)", scene).group(1))
                         for key in ("tool_radius_m", "max_displacement_m"))
    surface = surface[np.isin(surface, trained_nodes(options.body)).all(axis=1)]
    random, errors, linear, held = np.random.default_rng(options.seed), [], [], []
    left_out = {"warned of": 0, "without an equilibrium": 0}
    for state in range(options.states):
        within_m = 2.5 * radius_m if not options.nodes and state % 3 == 0 else np.inf
        x = random_places(random, nodes, surface, active, options.tools, options.nodes, within_m)
        d = random.normal(size=x.shape)
        d *= depth_m * (0.5 if options.nodes else random.random((len(x), 1))) / np.linalg.norm(d, axis=1)[:, None]
        said, true = answer("eval", options.model, "--body", options.body, *words(x, d)), None
        if said["status"] == 0:
            true = forces(answer("solve", options.database, *words(x, d)))
        if true is None:
            left_out["warned of" if said["status"] else "without an equilibrium"] += 1
            continue
        off, size = np.linalg.norm(forces(said) - true, axis=1), np.linalg.norm(true, axis=1).max()
        errors.append(100 * off.max() / size)
        if options.linear:
            at_rest = 1000 * forces(answer("solve", options.database, "--increments", 1, *words(x, 1e-3 * d)))
            linear.append(100 * np.linalg.norm(at_rest - true, axis=1).max() / size)
        held += [e <= b for e, b in zip(off, said.get("bounds_N") or []) if b is not None]
    for name, e in (("body", errors), ("linear predictor", linear))[:1 + options.linear]:
        print(f"{options.tools} tools, {len(e)} states, {name}: mean {np.mean(e):.2f}, p95 {np.percentile(e, 95):.1f}, "
              f"max {max(e):.1f} %")
    if held:
        print(f"the bound holds for {100 * np.mean(held):.1f} % of {len(held)} forces")
    print("left out:", ", ".join(f"{n} {reason}" for reason, n in left_out.items()))


if __name__ == "__main__":
    main()
