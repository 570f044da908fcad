#!/usr/bin/python3
"""Prints the tables of docs/robustness.md that solve: what converges at extreme parameters, and why rays fail.

Usage: lab/study robustness [incompressibility|compression|slivers|units|paper ...] [--nodes N] [--paper-nodes N]
"""

import argparse
import pathlib
import tempfile

import cube
import numpy as np
from commands import changed, print_tally, read_msh, run, shipped, solve, surface_faces, tally

ELEMENTS = ("P1", "p1-p1", "taylor-hood", "P2")
TO_3_H = {"radius_m": 0, "depth_m": 3 * cube.H_M, "increments": 9}


def follow(what, scene, increments):
    database = scene.with_suffix(".h5")
    database.unlink(missing_ok=True)
    run("precompute", scene, "-o", database)
    print_tally(what, tally(database), increments)


def cubes(folder, options, law, ratios, **more):
    nodes = cube.drawn(folder, options.nodes)
    for element in ELEMENTS:
        for ratio in ratios:
            scene = cube.write(folder, element, ratio, law=law, active=nodes, **TO_3_H, **more)
            follow(f"{law} K/mu {ratio:g} {element}", scene, (2, 5, 8))


def incompressibility(folder, options):
    cubes(folder, options, "neo-hookean", (10.0, 200.0, 2000.0, 23000.0))
    cubes(folder, options, "mooney-rivlin", (23000.0,))


def compression(folder, options):
    cubes(folder, options, "st-venant-kirchhoff", (1.0, 10.0, 200.0), directions='"hemisphere"')


def slivers(folder, options):
    cubes(folder, options, "neo-hookean", (200.0,), mesh=cube.with_slivers(folder, 0.02))


def units(folder, options):
    """Largest difference of a dimensionless force from that of 0.1 m and 500 Pa, relative."""
    x, cells, fixed = cube.meshed(folder)
    nodes = np.random.default_rng(1).choice(np.setdiff1d(surface_faces(cells), fixed), options.nodes, replace=False)

    def found(law, element, edge_m, shear_Pa):
        scene = cube.write(folder, element, 200.0, law=law, edge_m=edge_m, shear_Pa=shear_Pa, active='"free-surface"', radius_m=0,
                           depth_m=0.6 * edge_m)
        d = 0.7 * edge_m / 5 * np.array([[0.6, 0, -0.8], [0, 0.8, 0.6]])
        return np.array([solve(scene, n, e, 2)[0] for n in nodes for e in d]) / (shear_Pa * edge_m**2)

    for law in ("neo-hookean", "st-venant-kirchhoff", "mooney-rivlin", "linear"):
        for element in ELEMENTS:
            here = found(law, element, 0.1, 500.0)
            for edge_m, shear_Pa in ((1e-3, 1.0), (1e-3, 1e9), (1.0, 1.0), (1.0, 1e9)):
                off = np.linalg.norm(found(law, element, edge_m, shear_Pa) - here, axis=1).max()
                print(f"{law} {element}, {edge_m:g} m, {shear_Pa:g} Pa: {off / np.linalg.norm(here, axis=1).max():.1e}", flush=True)


def paper(folder, options):
    for name, element, n in (("liver_case1", "P1", 10 * options.paper_nodes), ("liver_case3", "P1", options.paper_nodes),
                             ("liver_case3", "p1-p1", options.paper_nodes), ("liver_case2", "P1", options.paper_nodes),
                             ("liver_case3", "taylor-hood", (options.paper_nodes + 5) // 6)):
        scene = folder / "liver.toml"
        scene.write_text(shipped(name + ".toml", {("solver", "element"): f'"{element}"'}))
        run("mesh", scene, "-o", folder / "liver.msh")
        _, cells, fixed = read_msh(folder / "liver.msh")
        free = np.setdiff1d(surface_faces(cells), fixed)
        nodes = np.sort(np.random.default_rng(1).choice(free, n, replace=False)).tolist()
        scene.write_text(changed(scene.read_text(), {("nodes", "active"): f"{{ nodes = {nodes} }}"}))
        follow(f"{name} {element}", scene, (0,) if name == "liver_case1" else (1, 3, 5))


def main():
    sections = {f.__name__: f for f in (incompressibility, compression, slivers, units, paper)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", choices=[[], *sections], metavar="SECTION")
    parser.add_argument("--nodes", type=int, default=4, help="probed nodes of the cube")
    parser.add_argument("--paper-nodes", type=int, default=12, help="probed nodes of the liver; Case 1 has ten times as many")
    options = parser.parse_args()
    for name in options.sections or sections:
        print(f"\n== {name}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            sections[name](pathlib.Path(folder), options)


if __name__ == "__main__":
    main()
