"""The tables of elements and of the functionals of fields, in the order in which ffcx compiles their forms. Needs Python's standard library only.

The row of a tetrahedron determines its forms (mechanics.py) and spaces (elements.py, dolfinx_api.hpp). The shell has
separate forms and spaces (shell.py, shell_elements.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf


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
    is_shell: bool = False
    locks_above: float = inf  # K/mu above which the element is too stiff
    locks_severely: bool = False  # too stiff by a large factor; otherwise noticeably, at worst by a small factor


ELEMENTS = (
    Element("p1", "P1", 1, None, 1, locks_above=20, locks_severely=True),
    # P2 locks later than P1: at K/mu = 200 with few cells it is too stiff by a factor of a few.
    Element("p2", "P2", 2, None, 4, locks_above=100),
    Element("th", "taylor-hood", 2, 1, 4),
    Element("p1p1", "p1-p1", 1, 1, 1, stabilized=True),
    Element("shell", "shell", 2, None, 2, is_shell=True),
)
SOLIDS = tuple(e for e in ELEMENTS if not e.is_shell)

# The functionals of fields, in the order of formats/include/phynness/formats/fields.hpp: displacement() and mixed() of
# mechanics.py return them behind the tangent. Shells have none.
FIELDS = ("von_mises", "stored")
