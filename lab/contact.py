"""Compares the forces of two spheres that slide over a body with finite elements, which hold the same places.

Usage: lab/study contact DATABASE BODY RADIUS [MOTION] [options of haptic_loop, as --friction 0.5 --at X,Y,Z]
DATABASE and BODY are those of one scene. MOTION is same (the default), opposed or pinch. The program is
build/release/tests/loop/example/haptic_loop, or $HAPTIC_LOOP.

Every hundredth cycle is solved from rest. Errors are those of all components of the force of the worse sphere, over the
larger force; beside them stands linear theory, from displacements a thousand times smaller. Left out are spheres nearer
than half of the tool's radius: between them are springs, which finite elements do not have
(docs/decisions/near-tools.md).
The last line has the largest change of a force between two settled cycles, over the largest force of all, and that of
the finite elements between the same states.
"""

import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from commands import SOURCE, answer, vector


def rows(body, radius, options):
    """Table of the CSV, n_cycles x n_tools."""
    motion, options = (options[0], options[1:]) if options and options[0][0] != "-" else ("same", options)
    program = os.environ.get("HAPTIC_LOOP", str(SOURCE / "build/release/tests/loop/example/haptic_loop"))
    with tempfile.NamedTemporaryFile(suffix=".csv") as file:
        words = ["-", motion, "--body", body, "--sphere", radius, *options, "--csv", file.name]
        subprocess.run([program, *words], check=True)
        table = np.genfromtxt(file.name, delimiter=",", names=True)
    return table.reshape(-1, int(table["tool"].max()) + 1)


def columns(row, *names):
    return np.array([row[name] for name in names])


def solved(database, points, displacements):
    """Forces [N]; None without an equilibrium."""
    words = [w for p, d in zip(points, displacements) for w in (f"--point={vector(p)}", f"--displacement={vector(d)}")]
    found = answer("solve", database, *words)
    return found and np.array([tool["force"] for tool in found["tools"]])


def held_by(cycle, nodes):
    """The spheres in contact, their points, displacements and forces."""
    held = [row for row in cycle if row["node0"] >= 0]
    points = [columns(r, "weight0", "weight1", "weight2") @ nodes[columns(r, "node0", "node1", "node2").astype(int)]
              for r in held]
    displacements = np.array([columns(r, "ux_m", "uy_m", "uz_m") for r in held])
    return held, points, displacements, np.array([columns(r, "fx_N", "fy_N", "fz_N") for r in held])


def largest_change(cycles, nodes, database):
    """Of the forces of contact and of the finite elements [%]; NaN without an equilibrium."""
    given = np.stack([cycles["fx_N"], cycles["fy_N"], cycles["fz_N"]], axis=-1)
    sizes = np.linalg.norm(np.diff(given, axis=0), axis=2).max(axis=1)
    settled = (cycles["status"][:, 0].astype(int) & 4) == 0
    at = np.argmax(np.where(settled[1:] & settled[:-1], sizes, 0))
    both = np.zeros((2,) + given.shape[1:])
    for i, cycle in enumerate(cycles[at : at + 2]):
        held, points, displacements, _ = held_by(cycle, nodes)
        forces = solved(database, points, displacements) if held else []
        both[i, [int(r["tool"]) for r in held]] = np.nan if forces is None else forces
    changes = sizes[at], np.linalg.norm(both[1] - both[0], axis=1).max()
    return [100 * change / np.linalg.norm(given, axis=2).max() for change in changes]


def main(database, body, radius, *options):
    with h5py.File(database) as file:
        nodes = file["mesh/nodes"][()]
    errors, left_out = {1: [], 2: []}, {"near": 0, "unsettled": 0, "without an equilibrium": 0}
    cycles = rows(body, radius, options)
    for cycle in cycles[::100]:
        held, points, displacements, given = held_by(cycle, nodes)
        if not held:
            continue
        forces = None
        if int(held[0]["status"]) & 4:
            reason = "unsettled"
        elif int(held[0]["status"]) & 8:
            reason = "near"
        else:
            reason, forces = "without an equilibrium", solved(database, points, displacements)
        if forces is None:
            left_out[reason] += 1
            continue
        linear = 1000 * solved(database, points, displacements / 1000)
        size = np.linalg.norm(forces, axis=1).max()
        errors[len(held)].append([100 * np.linalg.norm(f - forces, axis=1).max() / size for f in (given, linear)])
    for n_spheres, found in errors.items():
        for name, e in zip(("contact", "linear theory"), np.transpose(found)):
            print(f"{n_spheres} in contact, {len(e)} states, {name}: mean {e.mean():.2f}, p95 {np.percentile(e, 95):.2f}, "
                  f"max {e.max():.2f} %")
    print("left out:", ", ".join(f"{n} {reason}" for reason, n in left_out.items()))
    print("largest settled change: contact {:.1f} %, finite elements {:.1f} %".format(*largest_change(cycles, nodes, database)))


if __name__ == "__main__":
    if len(sys.argv) < 4:
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
