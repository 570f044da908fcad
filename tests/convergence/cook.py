"""The law of Cook's membrane in the published computations, W = mu/2 (J^(-2/3) I1 - 3) + kappa/4 (J^2 - 1 - 2 ln J).

It has no form kappa/2 g^2 that is smooth at J = 1, so that all of it is in `shape`.
"""

from element_table import SOLIDS
from mechanics import displacement, domain
from ufl import Constant, det, exp, inner, ln

mu, kappa = Constant(domain), Constant(domain)


def energy_density(F):
    J = det(F)
    return mu / 2 * (exp(-2 / 3 * ln(J)) * inner(F, F) - 3) + kappa / 4 * (J**2 - 1 - 2 * ln(J))


def nothing(F):
    return 0


P1, P2, *_ = SOLIDS
p1_energy, p1_residual, p1_tangent, *_, p1_jacobian = displacement(P1, energy_density, nothing, kappa)
p2_energy, p2_residual, p2_tangent, *_, p2_jacobian = displacement(P2, energy_density, nothing, kappa)
forms = [p1_energy, p1_residual, p1_tangent, p2_energy, p2_residual, p2_tangent]
expressions = [p1_jacobian, p2_jacobian]
