"""The tables of elements and of the functionals of fields, in the order in which ffcx compiles their forms. Needs Python's standard library only.

The row of a tetrahedron determines its forms (precompute_dolfinx/forms/mechanics.py) and spaces (elements.py, dolfinx_api.hpp). The shell has
separate forms and spaces (shell.py, shell_elements.py).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Element:
    identifier: str  # in the names of compiled forms
    name: str  # in a scene
    displacement_degree: int
    pressure_degree: int | None  # None: no pressure
    # P1 and p1-p1 have a constant gradient (see mixed() of mechanics.py). Integrands of quadratic elements are not
    # polynomials; degree 4 integrates p (J - 1) of Taylor-Hood exactly.
    quadrature_degree: int
    stabilized: bool = False  # equal order of displacement and pressure
    edge_smoothed: bool = False  # the shear energy is a function of mean gradients at edges (edges() of mechanics.py)
    is_shell: bool = False
    # Of an element that locks: rows of K/mu, ascending, and the mean of its force over that of Taylor-Hood on the same
    # mesh in patch probes, and over that of the mixed element that holds the same points in node probes.
    # docs/theory.md, Why P1 locks, says what was measured.
    force_ratios: tuple[tuple[float, float, float], ...] = ()


ELEMENTS = (
    Element("p1", "P1", 1, None, 1, force_ratios=(
        (2, 1.26, 1.07), (10, 1.40, 1.37), (50, 1.79, 1.85), (200, 2.52, 2.5))),
    Element("p2", "P2", 2, None, 4, force_ratios=(
        (2, 1.01, 1.07), (10, 1.03, 1.35), (50, 1.06, 1.75), (200, 1.10, 2.5))),
    Element("th", "taylor-hood", 2, 1, 4),
    Element("p1p1", "p1-p1", 1, 1, 1, stabilized=True),
    Element("esp1p1", "es-p1-p1", 1, 1, 1, stabilized=True, edge_smoothed=True),
    Element("shell", "shell", 2, None, 2, is_shell=True),
)
SOLIDS = tuple(e for e in ELEMENTS if not e.is_shell)
# Solids by their spaces, which determine J. ffcx accepts an expression only once; the last one is of edges.
JACOBIANS = tuple(dict.fromkeys((e.displacement_degree, e.pressure_degree) for e in SOLIDS)) + ("edge",)

# The functionals of fields, in the order of formats/include/phynness/formats/fields.hpp: displacement() and mixed() of
# mechanics.py return them behind the tangent. Shells have none.
FIELDS = ("von_mises", "stored")
