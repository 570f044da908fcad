"""Neo-Hookean, equation (8): W = mu/2 (I_c - 3) - mu ln J + lambda/2 (ln J)^2."""

from hooke import accepted as accepted_of_hooke
from hooke import bulk_modulus, example, lame_lambda, parameters, shear_modulus
from law import BULK, Accepted, det, exp, inner, ln, modulus

name = "neo-hookean"
kappa = "lmbda"
formulas = {"shape": "mu/2 (I1 - 3) - mu ln J", "volumetric": "ln J", "equation": "(8)"}

C10 = modulus("c10", "c10_Pa", "C10")
accepted = (*accepted_of_hooke, Accepted((C10, BULK), {"mu": lambda c10: 2 * c10, "lmbda": lame_lambda}))


def couples_J(mu, lmbda):
    """Whether the coupling uses the exponential form; see coupling()."""
    return lmbda >= 2 * mu


derived = (couples_J,)


def shape(F, mu):
    return mu / 2 * (inner(F, F) - 3) - mu * ln(det(F))


def volumetric(F):
    return ln(det(F))


def coupling(F, p, lmbda, couples_J):
    """p e^(-p/lambda) J - p + p^2 / (2 lambda), which is stationary at p = lambda ln J with the value lambda/2 (ln J)^2.

    p ln J - p^2 / (2 lambda) has the same stationary point and value, but under tension Taylor-Hood and p1-p1 are then
    unstable from p = 2 mu on (docs/decisions/pressure-multiplies-J.md). The exponential coupling is limited to J < e,
    where it is concave in p; the logarithmic one is stable up to J = e^(2 mu / lambda), more for lambda < 2 mu.
    """
    with_J = p * exp(-p / lmbda) * det(F) - p + p**2 / (2 * lmbda)
    with_ln_J = p * ln(det(F)) - p**2 / (2 * lmbda)
    return couples_J * with_J + (1 - couples_J) * with_ln_J


def of_pressure(F, couples_J):
    return couples_J * (det(F) - 1) + (1 - couples_J) * ln(det(F))


shell_from = 1


def plane_stress(metric, mu, lmbda):
    """W(q) = mu/2 (I1 - 3 - q) + lambda/8 q^2 at its stationary point, q = ln J^2; I1 = a + b e^q.

    The stationary point is found by two Newton steps from q = 0; a third step enters the energy as W - W'^2 / (2 W'').
    """
    I1, b, _, _ = metric.invariants()
    q = 0
    for _ in range(2):
        q = q - (mu / 2 * (b * exp(q) - 1) + lmbda / 4 * q) / (mu / 2 * b * exp(q) + lmbda / 4)
    slope = mu / 2 * (b * exp(q) - 1) + lmbda / 4 * q
    curvature = mu / 2 * b * exp(q) + lmbda / 4
    return mu / 2 * (I1 + b * (exp(q) - 1) - 3 - q) + lmbda / 8 * q**2 - slope**2 / (2 * curvature)
