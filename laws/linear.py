"""Linear elasticity (Case 1): W = lambda/2 (tr e)^2 + mu tr(e^2), e = sym(grad u).

In plane stress the St. Venant-Kirchhoff energy of first-order strains is the energy of the linear theory: with C = 1 +
2 e its invariants give tr e and tr(e^2).
"""

from hooke import accepted, bulk_modulus, example, parameters, plane_stress, shear_modulus
from law import identity, inner, sym, tr

name = "linear"
finite = False
kappa = "lmbda"
formulas = {"shape": "mu e : e", "volumetric": "tr e", "equation": "Case 1"}


def strain(F):
    return sym(F) - identity(F)


def shape(F, mu):
    return mu * inner(strain(F), strain(F))


def volumetric(F):
    return tr(strain(F))
