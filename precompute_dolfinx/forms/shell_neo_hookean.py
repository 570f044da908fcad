"""Neo-Hookean of neo_hookean.py in plane stress."""

from shell import *

mu, lmbda = Constant(domain), Constant(domain)


def plane_stress(metric):
    """W(q) = mu/2 (I1 - 3 - q) + lambda/8 q^2 at its stationary point, q = ln J^2; I1 = a + b e^q.

    Newton's method from q = 0: two steps, and the third in the energy, W - W'^2 / (2 W'').
    """
    I1, b, _, _ = metric.invariants()
    q = 0
    for _ in range(2):
        q = q - (mu / 2 * (b * exp(q) - 1) + lmbda / 4 * q) / (mu / 2 * b * exp(q) + lmbda / 4)
    slope = mu / 2 * (b * exp(q) - 1) + lmbda / 4 * q
    curvature = mu / 2 * b * exp(q) + lmbda / 4
    return mu / 2 * (I1 + b * (exp(q) - 1) - 3 - q) + lmbda / 8 * q**2 - slope**2 / (2 * curvature)


globals().update(every_form(plane_stress, mu))
