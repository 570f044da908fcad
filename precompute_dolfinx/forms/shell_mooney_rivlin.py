"""Mooney-Rivlin of mooney_rivlin.py in plane stress."""

from shell import *

c10, c01, bulk = Constant(domain), Constant(domain), Constant(domain)


def plane_stress(metric):
    """W(q) = C10 (I1 e^(-q/3) - 3) + C01 (I2 e^(-2q/3) - 3) + K/2 (e^(q/2) - 1)^2 at its stationary point, q = ln J^2.

    I1 and I2 are linear in e^q, so that W is a sum of terms a e^(kq). One Newton step from q = 0, and a second one in the
    energy, W - W'^2 / (2 W''): what is left out is of fifth order in the volume strain, mu/K.
    """
    I1, dI1, I2, dI2 = metric.invariants()
    terms = (
        (c10 * (I1 - dI1), -1 / 3), (c10 * dI1, 2 / 3), (c01 * (I2 - dI2), -2 / 3), (c01 * dI2, 1 / 3), (bulk / 2, 1), (-bulk, 1 / 2),
    )
    q = -sum(a * k for a, k in terms) / sum(a * k**2 for a, k in terms)
    # All exponents are multiples of a sixth.
    z = exp(q / 6)
    values = [(a * z ** round(6 * k), k) for a, k in terms]
    slope, curvature = sum(v * k for v, k in values), sum(v * k**2 for v, k in values)
    return sum(v for v, _ in values) + bulk / 2 - 3 * (c10 + c01) - slope**2 / (2 * curvature)


globals().update(every_form(plane_stress, 2 * (c10 + c01)))
