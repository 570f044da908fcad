"""Mooney-Rivlin, equation (9) with the standard sign and isochoric invariants:

W = C10 (I1bar - 3) + C01 (I2bar - 3) + K/2 (J - 1)^2,   I1bar = J^(-2/3) I1,   I2bar = J^(-4/3) I2.
"""

from law import BULK, Quantity, det, exp, inner, ln, modulus, sinh, tr

name = "mooney-rivlin"
parameters = (modulus("c10", "c10_Pa", "C10"), Quantity("c01", "c01_Pa", "C01"), BULK)
kappa = "K"
formulas = {"shape": "C10 (I1bar - 3) + C01 (I2bar - 3)", "volumetric": "J - 1", "equation": "(9), see Errata"}


def shear_modulus(c10, c01):
    return 2 * (c10 + c01)


def bulk_modulus(K):
    return K


def example(K):
    return {"c10": 0.4, "c01": 0.1, "K": K}


def shape(F, c10, c01):
    C, J = F.T * F, det(F)
    first = tr(C)
    second = (first**2 - inner(C, C)) / 2
    # For J <= 0 the logarithm gives NaN, as in (8). A power would do the same, but less visibly.
    log_J = ln(J)
    return c10 * (exp(-2 / 3 * log_J) * first - 3) + c01 * (exp(-4 / 3 * log_J) * second - 3)


def volumetric(F):
    return det(F) - 1


shell_from = 2


def plane_stress(metric, c10, c01, K):
    """W(q) = C10 (I1 e^(-q/3) - 3) + C01 (I2 e^(-2q/3) - 3) + K/2 (e^(q/2) - 1)^2 at its stationary point, q = ln J^2.

    I1 and I2 are linear in e^q, so that all terms except the last are sums of terms a e^(kq). The stationary point is
    found by one Newton step from q = 0; a second step enters the energy as W - W'^2 / (2 W''). The error is of fifth
    order in the volume strain, mu/K.

    e^(q/2) - 1 is computed as 2 e^(q/4) sinh(q/4): the rounding error of the difference, times K, would exceed the
    bending energy of a thin wall.
    """
    I1, dI1, I2, dI2 = metric.invariants()
    terms = ((c10 * (I1 - dI1), -1 / 3), (c10 * dI1, 2 / 3), (c01 * (I2 - dI2), -2 / 3), (c01 * dI2, 1 / 3))
    q = -sum(a * k for a, k in terms) / (sum(a * k**2 for a, k in terms) + K / 4)
    # Exponentials instead of powers of one exponential, because derivatives of powers would be calls of pow().
    s = sinh(q / 4)
    values = [(a * exp(k * q), k) for a, k in terms]
    slope = sum(v * k for v, k in values) + K * exp(3 * q / 4) * s
    curvature = sum(v * k**2 for v, k in values) + K * (exp(q) / 2 - exp(q / 2) / 4)
    shape = sum(v for v, _ in values) - 3 * (c10 + c01)
    return shape + 2 * K * exp(q / 2) * s**2 - slope**2 / (2 * curvature)
