#!/usr/bin/python3
"""Compares `phynness solve` with CalculiX (ccx) for the same nodes, cells, law and prescribed displacement.

Usage: lab/study calculix [WORD ...]     only cases whose row contains every word, e.g. P1 mooney-rivlin 200
Environment: PHYNNESS=path   the program to check instead of build/release/phynness
Exit status: 0 every case within its tolerance, 1 otherwise, 2 CalculiX or the program is missing.

Both programs use the same mesh: `phynness mesh` writes it, and this script converts it for CalculiX. One surface node is
displaced by 1 mm and 12 mm into the body, and by 12 mm sideways with an outward component. The force at this node and
the displacements of all free nodes are compared.
"""

import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "laws" / "tables"))
sys.dont_write_bytecode = True
from law import Law, every_law  # noqa: E402

# Millimetres, millinewtons and therefore kilopascals keep CalculiX's numbers near 1 for soft tissue.
MM, MILLINEWTON, KPA = 1e-3, 1e-3, 1e3

MU = 500.0  # Pa

# CalculiX's order of the mid-edge nodes of a C3D10.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))

FIXED = "{ box = { min_fraction = [0, 0, 0], max_fraction = [0.25, 1, 1] }, surface_only = true }"
PART = "{ box = { min_fraction = [0.5, 0, 0], max_fraction = [1, 1, 1] } }"



def hooke(mu, lmbda):
    """With NLGEOM, CalculiX's second Piola-Kirchhoff stress is linear in the Green-Lagrange strain: St.
    Venant-Kirchhoff.
    """
    return "*ELASTIC", (mu * (3 * lmbda + 2 * mu) / (lmbda + mu), lmbda / (2 * (lmbda + mu)))


# Card and numbers of CalculiX's material, moduli in the same unit. CalculiX has (J - 1)^2 / D1, so that D1 = 2 / K, and for
# Yeoh also (J - 1)^4 / D2 + (J - 1)^6 / D3: a term is omitted by a large D; with D = 0 CalculiX does not omit it, and
# forces are wrong by up to 14 %.
CARDS = {
    "linear": hooke,
    "st-venant-kirchhoff": hooke,
    "mooney-rivlin": lambda c10, c01, K: ("*HYPERELASTIC, MOONEY-RIVLIN", (c10, c01, 2 / K)),
    "yeoh": lambda c10, c20, c30, K: ("*HYPERELASTIC, YEOH", (c10, c20, c30, 2 / K, 1e12, 1e12)),
}


@dataclass(frozen=True)
class Case:
    """A material of shear modulus MU in the syntax of both programs."""

    law: Law
    bulk_over_mu: float
    changed: tuple = ()  # (symbol, value over MU) of the parameters that are not those of the law's example
    part: float = 1.0  # moduli of the cells with x in the upper half of the bounding box, over those of the others

    def _parameters(self, factor=1.0):
        values = {**self.law.example(self.bulk_over_mu), **dict(self.changed)}
        return {p: values[p.symbol] * (MU * factor if p.is_modulus else 1) for p in self.law.parameters}

    def _lines(self, factor=1.0):
        return "".join(f"{p.key} = {value!r}\n" for p, value in self._parameters(factor).items())

    @property
    def scene(self):
        region = f'[[region]]\nname = "part"\ncells = {PART}\n' + self._lines(self.part) if self.part != 1 else ""
        return f'law = "{self.law.name}"\n' + self._lines() + region

    def calculix(self, factor):
        values = {p.symbol: value / (KPA if p.is_modulus else 1) for p, value in self._parameters(factor).items()}
        card, numbers = CARDS[self.law.name](**values)
        return card + "\n" + ", ".join(f"{x:.12e}" for x in numbers)

    @property
    def label(self):
        texts = {p.symbol: p.text for p in self.law.parameters}
        part = f" {self.part:g}x" if self.part != 1 else ""
        return self.law.name + "".join(f" {texts[s]}={x * MU:g} Pa" for s, x in self.changed if x and texts[s] != "C10") + part


# If both integrate exactly (P1: constant gradient; linear law on P2: degree 2), only the rounding of CalculiX's seven
# printed digits remains.
EXACT_QUADRATURE = 2e-6
# C3D10 has four points, exact to degree 2; phynness integrates P2 to degree 4. The tolerances are bounds of this difference,
# by depth in mm; docs/calculix.md shows that there are no other differences.
OTHER_QUADRATURE = {1.0: 2e-3, 12.0: 6e-2}

PUSHES = ((1.0, "push"), (12.0, "push"), (12.0, "side"))
_LAWS = {law.name: law for law in every_law()}
_MOONEY, _HOOKE, _GREEN = (_LAWS[name] for name in ("mooney-rivlin", "linear", "st-venant-kirchhoff"))
_NO_C01, _MUCH_C01 = (("c10", 0.5), ("c01", 0.0)), (("c10", 0.3), ("c01", 0.2))
SERIES = (
    (Case(_MOONEY, 10, _NO_C01), "P1", PUSHES),
    (Case(_MOONEY, 200, _NO_C01), "P1", PUSHES),
    (Case(_MOONEY, 10, _MUCH_C01), "P1", PUSHES),
    (Case(_GREEN, 10), "P1", PUSHES),
    (Case(_HOOKE, 10), "P1", PUSHES[1:]),
    (Case(_HOOKE, 10), "P2", PUSHES[1:]),
    (Case(_MOONEY, 10, _NO_C01), "P2", PUSHES),
    *((Case(_MOONEY, 10, _NO_C01, part=ratio), "P1", PUSHES) for ratio in (0.1, 8, 1000)),
    (Case(_HOOKE, 10, part=8), "P2", PUSHES[1:]),
    # Every other law that CalculiX has.
    *((Case(law, 10), "P1", PUSHES) for law in _LAWS.values() if law.name in CARDS and law not in (_MOONEY, _HOOKE, _GREEN)),
)


class Body:
    """Nodes [mm], cells, fixed nodes, and the parts of the surface that the selection of probes needs."""

    def __init__(self, msh):
        blocks = dict(re.findall(r"^\$(\w+)\n(.*?)^\$End", msh, re.M | re.S))
        groups = {n: int(i) for d, i, n in re.findall(r'^(\d) (\d+) "(.*)"', blocks["PhysicalNames"], re.M) if d == "0"}
        entities = [line.split() for line in blocks["Entities"].splitlines()]
        fixed_points = {e[0] for e in entities[1 : 1 + int(entities[0][0])] if int(e[5]) == groups["phynness_fixed"]}

        self.nodes, number = [], {}
        lines = iter(blocks["Nodes"].splitlines()[1:])
        for head in lines:
            count = int(head.split()[3])
            tags = [next(lines) for _ in range(count)]
            for tag in tags:
                number[tag] = len(self.nodes)
                self.nodes.append([float(x) / MM for x in next(lines).split()])
        self.cells, self.fixed = [], set()
        lines = iter(blocks["Elements"].splitlines()[1:])
        for head in lines:
            dim, entity, kind, count = head.split()
            for _ in range(int(count)):
                nodes = [number[tag] for tag in next(lines).split()[1:]]
                if kind == "4":
                    self.cells.append(nodes)
                elif dim == "0" and entity in fixed_points:
                    self.fixed.add(nodes[0])

        # Boundary triangles belong to one cell. The order makes their normals point outwards of a positive cell.
        faces = [(c[a], c[b], c[d]) for c in self.cells for a, b, d in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))]
        seen = Counter(frozenset(f) for f in faces)
        self.surface = [f for f in faces if seen[frozenset(f)] == 1]
        self.edges = sorted({(min(c[a], c[b]), max(c[a], c[b])) for c in self.cells for a, b in EDGES})
        low, high = (f(x[0] for x in self.nodes) for f in (min, max))
        self.part = {i for i, c in enumerate(self.cells) if sum(self.nodes[n][0] for n in c) / 4 > (low + high) / 2}
        self.surface_edges = {frozenset(p) for f in self.surface for p in zip(f, f[1:] + f[:1])}

    def probes(self):
        """Free surface nodes at 5, 50 and 90 percent of the order by distance from the fixed ones."""
        free = sorted({n for f in self.surface for n in f} - self.fixed)
        free.sort(key=lambda n: min(math.dist(self.nodes[n], self.nodes[m]) for m in self.fixed))
        return [free[int(share * len(free))] for share in (0.05, 0.5, 0.9)]

    def direction(self, node, move):
        normal = [0.0] * 3
        for face in self.surface:
            if node in face:
                a, b, c = (self.nodes[n] for n in face)
                normal = _add(normal, _cross(_add(b, a, -1), _add(c, a, -1)))
        normal = _unit(normal)
        if move == "push":
            return _add([0.0] * 3, normal, -1)
        sideways = _unit(_cross(normal, (0.3, 0.5, 0.8)))  # skew to every axis
        return _unit(_add(sideways, normal, 0.4))


def _add(a, b, factor=1.0):
    return [x + factor * y for x, y in zip(a, b)]


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _unit(a):
    return [x / math.hypot(*a) for x in a]


def points_and_weights(body, element, node):
    """Positions of all nodes of the element, nodes of each cell, fixed points, and the tool's weights.

    On P2 the tool has the weights of the P1 hat function: midpoints of surface edges have half of the displacement.
    """
    if element == "P1":
        return body.nodes, body.cells, body.fixed, {node: 1.0}
    first = len(body.nodes)
    mid = {frozenset(e): first + i for i, e in enumerate(body.edges)}
    points = body.nodes + [[(x + y) / 2 for x, y in zip(body.nodes[a], body.nodes[b])] for a, b in body.edges]
    cells = [c + [mid[frozenset((c[a], c[b]))] for a, b in EDGES] for c in body.cells]
    fixed = body.fixed | {m for e, m in mid.items() if e <= body.fixed}
    weights = {node: 1.0} | {mid[e]: 0.5 for e in body.surface_edges if node in e}
    return points, cells, fixed, weights


def calculix(ccx, folder, body, case, element, node, displacement):
    """Force [N] at the tool and displacement [m] of the body's nodes, from one ccx run."""
    points, cells, fixed, weights = points_and_weights(body, element, node)
    linear = not case.law.finite
    deck = ["*NODE, NSET=all"]
    # CalculiX reads at most 20 characters of a number.
    deck += [f"{i + 1}, " + ", ".join(f"{x:.12e}" for x in p) for i, p in enumerate(points)]
    deck += [f"*ELEMENT, TYPE={'C3D4' if element == 'P1' else 'C3D10'}, ELSET=body"]
    deck += [f"{i + 1}, " + ", ".join(str(n + 1) for n in cell) for i, cell in enumerate(cells)]
    deck += ["*NSET, NSET=tool"] + [str(n + 1) for n in weights]
    for name, factor, chosen in (("rest", 1, set(range(len(cells))) - body.part), ("part", case.part, body.part)):
        deck += [f"*ELSET, ELSET={name}"] + [str(i + 1) for i in sorted(chosen)]
        deck += [f"*MATERIAL, NAME={name}", case.calculix(factor), f"*SOLID SECTION, ELSET={name}, MATERIAL={name}"]
    deck += ["*BOUNDARY"] + [f"{n + 1}, 1, 3" for n in sorted(fixed)]
    deck += ["*STEP" if linear else "*STEP, NLGEOM, INC=1000", "*STATIC"]
    if not linear:
        # Largest residual below 1e-9 of the mean force, with a sufficient number of iterations.
        deck += ["0.1, 1., 1e-6, 0.1", "*CONTROLS, PARAMETERS=FIELD", "1e-9, 1e-9, , , 1e-9, 1e-12, 1e-9, 1e-12"]
        deck += ["*CONTROLS, PARAMETERS=TIME INCREMENTATION", "20, 24, 25, 40, 30, 4, , 10"]
    deck += ["*BOUNDARY"]
    for n, w in weights.items():
        deck += [f"{n + 1}, {k + 1}, {k + 1}, {w * displacement[k] / MM:.12e}" for k in range(3)]
    # The .dat file has seven digits, the .frd file six.
    for what, where in (("U", "all"), ("RF", "tool")):
        deck += [f"*NODE PRINT, NSET={where}, FREQUENCY=1000", what]
    deck += ["*END STEP", ""]
    (folder / "job.inp").write_text("\n".join(deck))
    (folder / "job.dat").unlink(missing_ok=True)
    run = subprocess.run([ccx, "-i", "job"], cwd=folder, text=True, capture_output=True)
    if run.returncode or "Job finished" not in run.stdout:
        raise RuntimeError("ccx: " + " ".join(run.stdout[-300:].split()))

    values = {}
    for line in (folder / "job.dat").read_text().splitlines():
        if title := re.match(r" (displacements|forces) ", line):
            table = values[title[1]] = {}
        elif row := re.match(r" *(\d+)" + r" +(-?\d\.\d+E[-+]\d+|-?\d\.\d+-\d{3})" * 3, line):
            # Fortran omits the E of three-digit exponents; such a number is negligible.
            table[int(row[1]) - 1] = [float(x) if "E" in x else 0.0 for x in row.groups()[1:]]
    force = [0.0] * 3
    for n, w in weights.items():
        force = _add(force, values["forces"][n], w * MILLINEWTON)
    return force, [[x * MM for x in values["displacements"][n]] for n in range(len(body.nodes))]


def phynness(program, *arguments, folder):
    run = subprocess.run([program, *arguments], cwd=folder, text=True, capture_output=True)
    if run.returncode:
        raise RuntimeError("phynness: " + " ".join(run.stderr[-300:].split()))
    return run.stderr


def solve(program, folder, node, displacement):
    """Force [N], displacement [m] by node, and whether the state is stable, from `phynness solve`."""
    vector = ",".join(repr(x) for x in displacement)
    phynness(program, "solve", "scene.toml", "--node", str(node), "--displacement", vector,
             "--json", "solve.json", "--deformation", "solve.csv", folder=folder)  # fmt: skip
    result = json.loads((folder / "solve.json").read_text())
    rows = [line.split(",") for line in (folder / "solve.csv").read_text().splitlines()[1:]]
    field = {int(r[0]): [float(x) for x in r[4:]] for r in rows}
    return result["tools"][0]["force"], field, result["negative_pivots"] == 0


def write_scene(folder, mesh, case, element):
    (folder / "scene.toml").write_text(
        f'[mesh]\n{mesh}\n[material]\n{case.scene}\n[solver]\nelement = "{element}"\nrelative_tolerance = 1e-11\n'
        f'[nodes]\nfixed = {FIXED}\noutput = "free"\n[probe]\nmax_displacement_m = 0.02\n'
    )


def compare(program, ccx, folder, body, case, element, node, displacement):
    """Relative difference of the force and of the displacement field, both forces, stability."""
    force, field, stable = solve(program, folder, node, displacement)
    other_force, other_field = calculix(ccx, folder, body, case, element, node, displacement)
    largest = max(math.hypot(*u) for u in field.values())
    field_difference = max(math.dist(u, other_field[n]) for n, u in field.items()) / largest
    return math.dist(force, other_force) / math.hypot(*other_force), field_difference, force, other_force, stable


def main():
    source = Path(__file__).resolve().parent.parent
    program, ccx = os.path.abspath(os.environ.get("PHYNNESS", source / "build/release/phynness")), shutil.which("ccx")
    words = sys.argv[1:]
    missing = "CalculiX (apt-get install calculix-ccx)" if not ccx else "" if shutil.which(program) else program
    if missing:
        print(f"not installed: {missing}", file=sys.stderr)
        return 2
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    meshes = {"liver": 'shape = "liver"\ntarget_nodes = 200'}
    real = source / "../shared/meshes/real/liver_181.msh"
    if real.exists():
        meshes["liver_181"] = f'file = "{real.resolve()}"\nscale_to_m = 0.025'
    else:
        print(f"skipped: the cases of liver_181, because {real} does not exist")

    head = f"{'mesh':9} {'law':24} {'K/mu':>4} el {'node':>4} {'move':4} {'mm':>3}"
    columns = f"{'force of phynness [mN]':^29}  {'force of CalculiX [mN]':^29}  d force d field allowed"
    print(f"{head}  {columns}")
    bad = run = 0
    worst = {True: 0.0, False: 0.0}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for name, mesh in meshes.items():
            write_scene(folder, mesh, SERIES[0][0], "P1")
            phynness(program, "mesh", "scene.toml", "-o", "body.msh", folder=folder)
            body = Body((folder / "body.msh").read_text())
            for case, element, moves in SERIES:
                write_scene(folder, mesh, case, element)
                for node in body.probes():
                    for depth, move in moves:
                        row = f"{name:9} {case.label:24} {case.bulk_over_mu:4} {element} {node:4} {move:4} {depth:3g}"
                        if not all(w in row.split() for w in words):
                            continue
                        run += 1
                        d = [depth * MM * x for x in body.direction(node, move)]
                        exact = element == "P1" or not case.law.finite
                        allowed = EXACT_QUADRATURE if exact else OTHER_QUADRATURE[depth]
                        try:
                            df, du, ours, theirs, stable = compare(program, ccx, folder, body, case, element, node, d)
                        except RuntimeError as error:
                            print(f"{row}  {error}", flush=True)
                            bad += 1
                            continue
                        forces = "  ".join(" ".join(f"{x / MILLINEWTON:9.4f}" for x in f) for f in (ours, theirs))
                        good = max(df, du) <= allowed
                        worst[exact] = max(worst[exact], df, du)
                        bad += not good
                        note = ("" if good else "  too large") + ("" if stable else "  unstable")
                        print(f"{row}  {forces}  {df:7.1e} {du:7.1e} {allowed:7.0e}{note}", flush=True)
    print(f"largest difference: {worst[True]:.1e} if both integrate exactly, {worst[False]:.1e} otherwise")
    print(f"{run} cases, {bad} outside their tolerance")
    return 1 if bad or not run else 0


if __name__ == "__main__":
    sys.exit(main())
