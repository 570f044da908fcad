#!/usr/bin/python3
"""Prints the tables of docs/extremes.md. Each takes minutes.

Usage: lab/study extremes [incompressibility|displacements|origin|slivers|rest|extrapolation|float32|tools ...]
"""

import argparse
import pathlib
import tempfile

import cube
import h5py
import numpy as np
from commands import answer, forces, run, shipped, solve, tally, vector, write_msh
from cube import ELEMENTS, H_M, TOP

PUSH, PULL, SLIDE = np.array([(0, 0, -1), (0, 0, 1), (1, 0, 0)], float)


def incompressibility(folder):
    """Stiffness felt at h/2, over that of taylor-hood with cells of half the size; rays that reach h."""

    def felt(*body, **options):
        found = solve(cube.write(folder, *body, **options), TOP, H_M / 2 * PUSH)
        return -found[0][2] / (H_M / 2) if found else np.nan

    for law, ratio in [("neo-hookean", r) for r in (10.0, 200.0, 1e3, 1e4, 1e5)] + [("mooney-rivlin", 100e3 / 4.4)]:
        reference = felt("taylor-hood", ratio, law=law, size_m=H_M / 2)
        row = f"{law} K/mu {ratio:g}: {reference:.1f} N/m"
        for element in ELEMENTS:
            row += f"; {element} {felt(element, ratio, law=law) / reference:.2f}"
            if element != "P2" or ratio <= 200:  # else minutes for a ray
                (folder / "d.h5").unlink(missing_ok=True)
                run("precompute", cube.write(folder, element, ratio, law=law), "-o", folder / "d.h5")
                row += f", {100 * tally(folder / 'd.h5')['reached'][-1]:.0f} %"
        print(row, flush=True)


def displacements(folder):
    """|f| / |K d|, K the stiffness at rest; pushed, pulled, slid."""
    for element in ("P1", "p1-p1", "taylor-hood"):
        scene = cube.write(folder, element, 200.0)
        K = np.array(solve(scene, TOP, (0, 0, 0))[1]["tangent_N_per_m"])
        for size in (1e-12, 1e-9, 1e-6, 1e-3, 0.1, 1.0, 2.0, 4.0):
            found = [solve(scene, TOP, size * H_M * way, max(1, int(np.ceil(3 * size)))) for way in (PUSH, PULL, SLIDE)]
            ratios = [np.linalg.norm(f[0]) / np.linalg.norm(K @ (size * H_M * way)) if f else np.nan
                      for f, way in zip(found, (PUSH, PULL, SLIDE))]
            print(element, f"|d| / h = {size:g}:", " ".join("%.9f" % r for r in ratios), flush=True)


def origin(folder):
    """Largest difference of the force from that at the origin, relative: the cube written far away and read."""
    x, cells, fixed = cube.meshed(folder)
    ways = [PUSH, np.array([0.6, 0, -0.8]), np.array([0, 0.8, 0.6])]
    for away_m in (1.0, 1e3, 1e6, 1e9):
        row = f"{away_m:g} m:"
        for element in ELEMENTS:
            found = []
            for by in (0.0, away_m):
                write_msh(folder / "moved.msh", x + [by, -by, by], cells, fixed)
                scene = cube.write(folder, element, 200.0, mesh=folder / "moved.msh", tolerance=1e-11)
                node = np.linalg.norm(x - TOP, axis=1).argmin()
                found.append(np.array([solve(scene, node, H_M / 2 * way)[0] for way in ways]))
            row += f" {element} {(np.linalg.norm(found[1] - found[0], axis=1) / np.linalg.norm(found[0], axis=1)).max():.1e}"
        print(row, flush=True)


def slivers(folder):
    """The force where five cells are flat: difference from that with quality 0.02, relative."""
    first = {}
    for worst in (0.02, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11):
        mesh, row = cube.with_slivers(folder, worst), f"quality {worst:g}:"
        for element in ELEMENTS:
            found = solve(cube.write(folder, element, 200.0, mesh=mesh), TOP, H_M / 2 * PUSH)
            force = found[0][2] if found else np.nan
            row += f" {element} {abs(force / first.setdefault(element, force) - 1):.1e}"
        print(row, flush=True)


class Sample:
    """The sample's scene, solved; models of families that are trained from it."""

    def __init__(self, folder, depth_m=0.020):
        self.folder, self.scene, self.database = folder, folder / "sample.toml", folder / "sample.h5"
        self.scene.write_text(shipped("../examples/model/scene.toml", {("probe", "max_displacement_m"): depth_m}))
        run("precompute", self.scene, "-o", self.database)
        with h5py.File(self.database) as f:
            self.active, self.nodes, self.surface = f["sets/active"][()], f["mesh/nodes"][()], f["mesh/surface"][()]
            self.largest_N = np.linalg.norm(f["responses/force"][()], axis=-1).max(axis=(1, 2))
        self.probed = self.active[(2 * np.arange(10) + 1) * len(self.active) // 20]

    def train(self, family, values=None, database=None):
        scene = self.folder / f"{family}.toml"
        scene.write_text(changed(pathlib.Path(self.scene).read_text(), values or {}))
        run("train", scene, database or self.database, "-o", self.folder / family, "--family", family)
        return self.folder / family


def rest(folder):
    """Force at rest over the largest trained; |f - K d| / |K d| of small displacements, mean and largest."""
    sample = Sample(folder)
    stiffness = [np.array(solve(sample.scene, n, (0, 0, 0))[1]["tangent_N_per_m"]) for n in sample.probed]
    ways = np.vstack([np.eye(3), -np.eye(3)])
    for family in ("modal", "rbfn"):
        model = sample.train(family)
        at_rest = np.linalg.norm(forces(model, sample.active, np.zeros((len(sample.active), 3)), folder), axis=1) / sample.largest_N
        row = f"{family}: at rest {at_rest.max():.1e}"
        for size in (1e-12, 1e-9, 1e-6, 1e-4, 1e-3):
            f = forces(model, np.repeat(sample.probed, 6), np.tile(size * ways, (len(sample.probed), 1)), folder)
            true = np.concatenate([size * ways @ K.T for K in stiffness])
            error = np.linalg.norm(f - true, axis=1) / np.linalg.norm(true, axis=1)
            row += f"; {size:g} m {error.mean():.2g}, {error.max():.2g}"
        print(row, flush=True)


def extrapolation(folder):
    """Trained to 2 mm, evaluated deeper: errors (17) of the force at each depth, mean / p95 / max in %."""
    R, factors, random = 0.002, (1, 2, 5, 10), np.random.default_rng(1)
    sample = Sample(folder, R)
    ways = random.normal(size=(len(sample.probed), 6, 3))
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    nodes, stiffness = np.repeat(sample.probed, 6), []
    for node in sample.probed:
        stiffness += 6 * [np.array(solve(sample.scene, node, (0, 0, 0))[1]["tangent_N_per_m"])]
    models = {family: sample.train(family) for family in ("modal", "rbfn")}
    for factor in factors:
        d = (factor * R * ways).reshape(-1, 3)
        solved = [solve(sample.scene, n, e, 4 * factor) for n, e in zip(nodes, d)]
        true = np.array([s[0] if s else 3 * [np.nan] for s in solved])
        largest = np.repeat(np.nanmax(np.linalg.norm(true, axis=1).reshape(-1, 6), axis=1), 6)
        said = {family: forces(model, nodes, d, folder) for family, model in models.items()}
        said |= {"linear theory": np.einsum("nij,nj->ni", stiffness, d), "zero": 0 * d}
        for name, f in said.items():
            e = 100 * np.linalg.norm(f - true, axis=1) / largest
            print(f"{factor} R, {name}: {np.nanmean(e):.3g} / {np.nanpercentile(e, 95):.3g} / {np.nanmax(e):.3g}", flush=True)


def float32(folder):
    """Images in float against the runtime's double: largest difference over the largest answer."""
    sample = Sample(folder)
    for spread in (None, 0.2, 0.75, 2.0, 5.0, 20.0):
        spreads = {("training", "deformation_spread"): spread, ("training", "force_spread"): spread} if spread else {}
        model = sample.train("rbfn" if spread else "modal", spreads)
        found = answer("export", model, "-o", folder / "image", "--float", "--golden", 2000)
        print(f"rbfn, both spreads {spread}" if spread else "modal", {k: v for k, v in found.items() if "deviation" in k}, flush=True)


def tools(folder):
    """Two tools nearer than an edge, 5 mm deep: pairs that are unsettled, and errors in % of the summed force, median and largest."""
    sample, random, depth_m = Sample(folder), np.random.default_rng(3), 0.005
    model = sample.train("modal")
    triangles = sample.surface[np.isin(sample.surface, sample.active).all(1)]
    for together in (True, False):
        for apart_m in (1e-6, 1e-4, 1e-3, 0.005, 0.01, 0.02, 0.04):
            unsettled, errors = 0, []
            for _ in range(30):
                corners = sample.nodes[random.choice(triangles)]
                first = random.dirichlet(np.ones(3)) @ corners
                angle, along = 2 * np.pi * random.random(), (corners[1] - corners[0]) / np.linalg.norm(corners[1] - corners[0])
                across = np.cross(np.cross(along, corners[2] - corners[0]), along)
                second = first + apart_m * (np.cos(angle) * along + np.sin(angle) * across / np.linalg.norm(across))
                d = random.normal(size=(2, 3))
                d *= depth_m / np.linalg.norm(d, axis=1, keepdims=True)
                words = [w for p, e in ((first, d[0]), (second, d[0 if together else 1]))
                         for w in ("--point", vector(p), "--displacement", vector(e))]
                said, true = answer("eval", model, *words), answer("solve", sample.scene, *words, "--increments", 4)
                if said is None:
                    continue  # a point beside the active nodes
                unsettled += bool(said["status"] & 4)  # PHN_WARNING_UNSETTLED
                if true is not None:
                    f, g = (np.sum([t["force"] for t in a["tools"]], axis=0) for a in (said, true))
                    errors.append(100 * np.linalg.norm(f - g) / np.linalg.norm(g))
            if errors:
                print("together" if together else "apart", f"{1e3 * apart_m:g} mm: {unsettled} unsettled, {len(errors)} solved, "
                      f"{np.median(errors):.2g}, {max(errors):.2g}", flush=True)


def main():
    sections = {f.__name__: f for f in (incompressibility, displacements, origin, slivers, rest, extrapolation, float32, tools)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", choices=[[], *sections], metavar="SECTION")
    for name in parser.parse_args().sections or sections:
        print(f"\n== {name}: {sections[name].__doc__}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            sections[name](pathlib.Path(folder))


if __name__ == "__main__":
    main()
