"""Writes responses of CalculiX: quadratic hexahedra, which phynness does not have, with Ogden's law, which it does not have.

Usage: python3 calculix.py FILE.h5 [ROWS]         ROWS of each of two nodes, 80 if not given; needs ccx in the path

One deck for each node has a static step for each displacement, of which ccx prints the reactions (positive: what holds the
node) and the displacements of the upper face. Its energies are left out: phynness import refuses them, because they are not
those of the forces (after the first step 0.76 force . displacement, later more). Millimetres, millinewtons and kilopascals.
"""
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

CELLS, SIZE = (4, 4, 2), (50.0, 50.0, 24.0)  # of the block [mm]
OGDEN = "1.0, 6.0, 0.4"  # mu [kPa], alpha, D [1/kPa]

# Corners, then middles of edges, of C3D20 in half cells.
PLACES = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2), (1, 0, 0), (2, 1, 0), (1, 2, 0),
          (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2), (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]


def block():
    """Nodes in half cells -> number from 1, in the order of use; cells; triangles between corners and middles of the upper face."""
    number, cells, triangles = {}, [], []
    for cell in np.ndindex(*CELLS):
        nodes = [number.setdefault(tuple(2 * c + p for c, p in zip(cell, place)), len(number) + 1) for place in PLACES]
        cells.append(nodes)
        if cell[2] == CELLS[2] - 1:
            a, b, c, d, ab, bc, cd, da = (nodes[i] for i in (4, 5, 6, 7, 12, 13, 14, 15))
            triangles += [(a, ab, da), (ab, b, bc), (bc, c, cd), (cd, d, da), (ab, bc, cd), (ab, cd, da)]
    return number, cells, triangles


def deck(number, cells, node, displacements):
    half = np.array(SIZE) / (2 * np.array(CELLS))
    lines = ["*NODE, NSET=ALL"] + [f"{n}, " + ", ".join(map(str, half * place)) for place, n in number.items()]
    lines.append("*ELEMENT, TYPE=C3D20R, ELSET=BODY")
    for i, nodes in enumerate(cells, 1):
        words = [str(i)] + [str(n) for n in nodes]
        lines += [", ".join(words[:11]) + ",", ", ".join(words[11:])]
    top = [n for place, n in number.items() if place[2] == 2 * CELLS[2]]
    lines += ["*NSET, NSET=FIXED"] + [f"{n}," for place, n in number.items() if place[2] == 0]
    lines += ["*NSET, NSET=TOP"] + [f"{n}," for n in top] + ["*NSET, NSET=TOUCHED", f"{node},"]
    lines += ["*MATERIAL, NAME=SOFT", "*HYPERELASTIC, OGDEN, N=1", OGDEN, "*SOLID SECTION, ELSET=BODY, MATERIAL=SOFT"]
    lines += ["*BOUNDARY", "FIXED, 1, 3"]
    for d in displacements:
        lines += ["*STEP, NLGEOM, INC=200", "*STATIC", "0.5, 1.", "*BOUNDARY"]
        lines += [f"TOUCHED, {k + 1}, {k + 1}, {d[k]:.9e}" for k in range(3)]
        lines += ["*NODE PRINT, NSET=TOUCHED, FREQUENCY=200", "RF", "*NODE PRINT, NSET=TOP, FREQUENCY=200", "U"]
        lines.append("*END STEP")
    return "\n".join(lines) + "\n", top


def numbers_after(heading, text):
    """Rows of numbers of each block with this heading."""
    blocks = re.split(r"\n (?=\w)", text)
    return [np.array([line.split() for line in block.splitlines()[1:] if line.strip()], float)
            for block in blocks if block.startswith(heading)]


def main(path, n_rows):
    number, cells, triangles = block()
    rows = {name: [] for name in ("touched", "displacements", "forces", "output_displacements")}
    random = np.random.default_rng(5)
    for place in ((4, 4, 4), (6, 4, 4)):
        node = number[place]
        d = random.normal(size=(n_rows, 3))
        d *= 6 * random.random((n_rows, 1)) ** (1 / 3) / np.linalg.norm(d, axis=1)[:, None]
        text, top = deck(number, cells, node, d)
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "block.inp").write_text(text)
            done = subprocess.run(["ccx", "block"], cwd=folder, capture_output=True, text=True)
            said = Path(folder, "block.dat").read_text()
        forces, moved = numbers_after("forces", said), numbers_after("displacements", said)
        if not len(forces) == len(moved) == n_rows:
            sys.exit(f"calculix.py: ccx finished {len(forces)} of {n_rows} steps\n{done.stdout[-1000:]}")
        rows["touched"] += [node - 1] * n_rows
        rows["displacements"] += list(1e-3 * d)
        rows["forces"] += [1e-3 * f[0, 1:] for f in forces]
        rows["output_displacements"] += [1e-3 * u[:, 1:] for u in moved]
    points = np.array(list(number)) * np.array(SIZE) / (2 * np.array(CELLS)) * 1e-3
    with h5py.File(path, "w") as file:
        file.attrs["title"] = "Ogden by CalculiX"
        file["points"], file["triangles"], file["output"] = points, np.array(triangles) - 1, np.array(top) - 1
        file["fixed"] = [n - 1 for place, n in number.items() if place[2] == 0]
        for name, values in rows.items():
            file[name] = np.array(values)


main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 80)
