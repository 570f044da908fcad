"""Definitions for the law files in the folder above, and functions that read them. Needs Python's standard library only.

A law is a file laws/IDENTIFIER.py. It defines

    name                name of the law in a scene
    parameters          constants of the energy (Quantity), in the order of the physics hash
    kappa               symbol of the parameter that multiplies the volumetric energy; K: the law is isochoric
    formulas            shape, volumetric and equation in the form of docs/theory.md
    shape(F)            energy density without its volumetric part, F = I + grad u
    volumetric(F)       g(F); the energy density is  W = shape + kappa/2 g^2
    shear_modulus()     mu at rest, the solver's unit of moduli
    bulk_modulus()      K at rest
    example(K)          {symbol: value} of a material with mu = 1 in which every term contributes, for the tests

and optionally

    finite = False      small strains: one configuration, force proportional to displacement, J is not checked
    accepted            sets of keys that a scene may give (Accepted); default: all parameters by their own keys
    derived             functions of the parameters that become dimensionless constants of the forms
    coupling(F, p)      coupling of displacement and pressure in mixed elements; default: p g - p^2 / (2 kappa)
    of_pressure(F)      what a small pressure multiplies in the coupling, its d/dp at p = 0; default: volumetric(F)
    inside(F)           positive where the energy is defined, in addition to J > 0; other states count as J <= 0
    plane_stress(metric)        energy density of a shell's layer with S^33 condensed (precompute_dolfinx/forms/shell.py)
    squared_thickness(metric)   for laws that are defined for J <= 0: positive unless the wall is turned inside out
    shell_from = 2      smallest K/mu at which plane_stress is accurate enough; default: 0

The parameter names of a function determine its arguments: shape(F, mu) is called with F and mu. Formulas consist of
+ - * /, comparisons, powers with positive integers, F.T (the transpose), identity(F) and the functions det, exp, inner,
ln, sinh, sqrt, sym and tr, which work on objects of UFL and on formulas of tables.py, which become C++. Another power
is written with exp and ln: J^(-2/3) is exp(-2 / 3 * ln(J)).

A key has one meaning in all laws. hooke.py has the quantities MU, LAMBDA, YOUNG and POISSON, and what laws with these
parameters share; BULK is below.
"""

from __future__ import annotations

import importlib.util
import inspect
import sys
import traceback
from dataclasses import dataclass, field
from pathlib import Path

LAWS = Path(__file__).resolve().parent.parent


def _function(name):
    def apply(*arguments):
        for argument in arguments:
            if hasattr(type(argument), "apply_function"):
                return argument.apply_function(name, arguments)
        import ufl

        return getattr(ufl, name)(*arguments)

    apply.__name__ = name
    return apply


det, exp, inner, ln, sinh, sqrt, sym, tr = map(_function, ("det", "exp", "inner", "ln", "sinh", "sqrt", "sym", "tr"))


def identity(tensor):
    """The unit tensor of the same type as `tensor`."""
    if hasattr(type(tensor), "apply_function"):
        return tensor.apply_function("identity", (tensor,))
    import ufl

    return ufl.Identity(3)


@dataclass(frozen=True)
class Quantity:
    """A number of [material] between low and high, where an end is excluded if it is open."""

    symbol: str  # name in functions, and name of the constant in the forms
    key: str  # key in a scene; ends with _Pa or _per_Pa if it has a unit
    text: str  # symbol in the documentation
    low: float = 0.0
    high: float = 1e12
    low_open: bool = False
    high_open: bool = False
    meaning: str = ""  # documentation of the range, if the numbers do not describe it

    @property
    def is_modulus(self):
        return self.key.endswith("_Pa") and not self.key.endswith("_per_Pa")


def modulus(symbol, key, text, **rest):
    """A modulus, positive by default."""
    return Quantity(symbol, key, text, **{"low_open": True, **rest})


@dataclass(frozen=True)
class Bound:
    """A bound of one given number that depends on the other given numbers."""

    symbol: str
    greater: bool
    value: object  # function of the given symbols
    what: str  # follows "[material] KEY" in the message
    remedy: str  # precedes "it must be greater than ..." in the message


@dataclass(frozen=True)
class Accepted:
    """A set of numbers that determines a material, and functions that compute further symbols in turn."""

    given: tuple
    gives: dict = field(default_factory=dict)
    bounds: tuple = ()


BULK = modulus("K", "bulk_modulus_Pa", "K")
D1 = Quantity("d1", "d1_per_Pa", "D1", low=1e-12, meaning="> 0; D1 in 1/Pa, in place of K: here K = 1/D1")


class LawError(Exception):
    pass


def _place(error, path):
    """FILE:LINE of the last line of a law file that an error came through."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename) == Path(path)]
    return f"{path}:{lines[-1]}" if lines else str(path)


def call(function, *leading, **symbols):
    """Calls a law's function with the symbols that are its parameters."""
    wanted = list(inspect.signature(function).parameters)[len(leading) :]
    try:
        return function(*leading, **{name: symbols[name] for name in wanted})
    except Exception as error:
        place = _place(error, function.__code__.co_filename)
        raise LawError(
            f"{place}: {function.__name__} cannot be evaluated: {error}; laws/tables/law.py lists what formulas consist of"
        ) from error


class Law:
    """The content of a law file with defaults for omitted definitions."""

    def __init__(self, path):
        self.identifier = path.stem
        spec = importlib.util.spec_from_file_location(f"law_{path.stem}", path)
        module = importlib.util.module_from_spec(spec)
        self._path = path
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            raise LawError(f"{_place(error, path)}: {error}; laws/tables/law.py lists what a law file may use") from error
        for word in ("name", "parameters", "kappa", "formulas", "shape", "volumetric", "shear_modulus", "bulk_modulus", "example"):
            if not hasattr(module, word):
                raise self._error(f"a law must define {word}", "it is missing", "see laws/tables/law.py for its meaning")
            setattr(self, word, getattr(module, word))
        self.isochoric = self.kappa == BULK.symbol  # shape does not see changes of volume
        self.finite = getattr(module, "finite", True)
        self.derived = tuple(getattr(module, "derived", ()))
        for word in ("coupling", "of_pressure", "inside", "plane_stress", "squared_thickness"):
            setattr(self, word, getattr(module, word, None))
        self.shell_from = getattr(module, "shell_from", 0)
        given = tuple(getattr(module, "accepted", (Accepted(tuple(self.parameters)),)))
        self.accepted = given + tuple(_by_d1(s) for s in given if BULK in s.given)
        self._check()

    def _error(self, what, value, remedy):
        return LawError(f"{self._path}: {what}: {value}, {remedy}")

    def _check(self):
        symbols = [p.symbol for p in self.parameters]
        if len(set(symbols)) < len(symbols) or self.kappa not in symbols:
            raise self._error("the symbols of parameters must differ and include kappa", symbols, "correct the list")
        for p in self.parameters:
            if p.key.endswith("_per_Pa"):
                raise self._error("a parameter must be a modulus or dimensionless", p.key, "give it in Pa")
        example = call(self.example, 10.0)
        if not any({q.symbol for q in s.given} == set(symbols) for s in self.accepted):
            raise self._error("accepted must contain the set of all parameters", symbols, "add this set to accepted")
        if set(example) != set(symbols):
            raise self._error("example must return the symbols of the parameters", sorted(example), f"return {symbols}")
        shear, bulk = call(self.shear_modulus, **example), call(self.bulk_modulus, **example)
        if abs(shear - 1) > 1e-12 or abs(bulk - 10) > 1e-11:
            raise self._error(
                "example(10) must have mu = 1 and K = 10 at rest",
                f"mu = {shear}, K = {bulk}",
                "correct example or the moduli",
            )


def _by_d1(accepted):
    given = tuple(D1 if q is BULK else q for q in accepted.given)
    return Accepted(given, {"K": lambda d1: 1 / d1, **accepted.gives}, accepted.bounds)


def load(identifier):
    return Law(LAWS / f"{identifier}.py")


def every_law():
    """All laws in the order of their identifiers, which is the order of every table."""
    sys.dont_write_bytecode = True
    laws = [Law(path) for path in sorted(LAWS.glob("*.py"))]
    keys = {}
    for law in laws:
        for quantity in (q for s in law.accepted for q in s.given):
            first, other = keys.setdefault(quantity.key, (quantity, law))
            if quantity != first:
                raise law._error(
                    f"a key of [material] must have the same meaning in every law, and {other.identifier}.py gives another one",
                    f"{quantity} and there {first}",
                    "use the same Quantity in both (see hooke.py), or another key",
                )
    return laws
