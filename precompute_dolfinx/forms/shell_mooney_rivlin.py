"""Mooney-Rivlin of mooney_rivlin.py in plane stress."""

from shell import *

c10, c01, bulk = Constant(domain), Constant(domain), Constant(domain)


def plane_stress(metric):
    """W(q) = C10 (I1 e^(-q/3) - 3) + C01 (I2 e^(-2q/3) - 3) + K/2 (e^(q/2) - 1)^2 at its stationary point, q = ln J^2.

    I1 and I2 are linear in e^q, so that all but the last is a sum of terms a e^(kq). One Newton step from q = 0, and a
    second one in the energy, W - W'^2 / (2 W''): what is left out is of fifth order in the volume strain, mu/K.

    e^(q/2) - 1 = 2 e^(q/4) sinh(q/4): as a difference its rounding, times K, is more than what a thin wall bends with.
    """
    I1, dI1, I2, dI2 = metric.invariants()
    terms = ((c10 * (I1 - dI1), -1 / 3), (c10 * dI1, 2 / 3), (c01 * (I2 - dI2), -2 / 3), (c01 * dI2, 1 / 3))
    q = -sum(a * k for a, k in terms) / (sum(a * k**2 for a, k in terms) + bulk / 4)
    # Exponentials and not powers of one: their derivatives are themselves, where those of powers are calls of pow().
    s = sinh(q / 4)
    values = [(a * exp(k * q), k) for a, k in terms]
    slope = sum(v * k for v, k in values) + bulk * exp(3 * q / 4) * s
    curvature = sum(v * k**2 for v, k in values) + bulk * (exp(q) / 2 - exp(q / 2) / 4)
    shape = sum(v for v, _ in values) - 3 * (c10 + c01)
    return shape + 2 * bulk * exp(q / 2) * s**2 - slope**2 / (2 * curvature)


globals().update(every_form(plane_stress, 2 * (c10 + c01)))
