#!/usr/bin/python3
"""Prints the tables of docs/robustness.md that solve: what converges at extreme parameters, and why rays fail.

Usage: lab/study robustness [incompressibility|slivers|paper ...] [--nodes N] [--paper-nodes N]
"""

import argparse
import pathlib
import tempfile

import cube
import numpy as np
from commands import changed, print_tally, read_msh, run, shipped, surface_faces, tally

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


def slivers(folder, options):
    cubes(folder, options, "neo-hookean", (200.0,), mesh=cube.with_slivers(folder, 0.02))


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
    sections = {f.__name__: f for f in (incompressibility, slivers, paper)}
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
