"""St. Venant-Kirchhoff, equation (7): W = lambda/2 (tr E)^2 + mu tr(E^2), E the Green-Lagrange strain (4)."""

from hooke import accepted, bulk_modulus, example, parameters, plane_stress, shear_modulus
from law import identity, inner, tr

name = "st-venant-kirchhoff"
kappa = "lmbda"
formulas = {"shape": "mu E : E", "volumetric": "tr E", "equation": "(7)"}


def E(F):
    return (F.T * F - identity(F)) / 2


def shape(F, mu):
    return mu * inner(E(F), E(F))


def volumetric(F):
    return tr(E(F))


def squared_thickness(metric, mu, lmbda):
    """x - s; negative where in-plane stretching would give a negative thickness."""
    return 1 - lmbda / (lmbda + 2 * mu) * (metric.A - 2) - metric.s
