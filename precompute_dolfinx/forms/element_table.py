"""The elements: one row each, in the order in which ffcx compiles their forms. Python's standard library reads this.

A tetrahedron's row says all about its forms (mechanics.py) and spaces (elements.py, dolfinx_api.hpp). The shell's forms
and spaces are its own (shell.py, shell_elements.py).
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
    # P1 has a constant gradient, and so has p1-p1 (mixed() of mechanics.py). The quadratic elements have non-polynomial
    # integrands; degree 4 integrates p (J - 1) of Taylor-Hood exactly.
    quadrature_degree: int
    stabilized: bool = False  # equal order of displacement and pressure
    is_shell: bool = False
    locks_above: float = inf  # K/mu from which on it is too stiff
    locks_severely: bool = False  # several times; otherwise noticeably, and a few times at worst


ELEMENTS = (
    Element("p1", "P1", 1, None, 1, locks_above=20, locks_severely=True),
    # Later than P1, not never: at K/mu = 200 and few cells it is up to a few times too stiff.
    Element("p2", "P2", 2, None, 4, locks_above=100),
    Element("th", "taylor-hood", 2, 1, 4),
    Element("p1p1", "p1-p1", 1, 1, 1, stabilized=True),
    Element("shell", "shell", 2, None, 2, is_shell=True),
)
SOLIDS = tuple(e for e in ELEMENTS if not e.is_shell)
