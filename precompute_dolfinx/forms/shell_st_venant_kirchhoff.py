"""St. Venant-Kirchhoff of st_venant_kirchhoff.py in plane stress."""

from shell import *

mu, lmbda = Constant(domain), Constant(domain)


def plane_stress(metric):
    """W = lambda/2 (tr E)^2 + mu tr(E^2), tr E = (I1 - 3) / 2, tr(E^2) = (I1^2 - 2 I2 - 2 I1 + 3) / 4, with E_33 such that
    S_33 = 0: lambda becomes 2 lambda mu / (lambda + 2 mu), E_33 drops out, x = 1.
    """
    I1, I2 = metric.A + 1, metric.P + metric.A
    return lmbda * mu / (lmbda + 2 * mu) * (I1 - 3) ** 2 / 4 + mu / 4 * (I1**2 - 2 * I2 - 2 * I1 + 3)


def squared_thickness(metric):
    """x - s: negative where stretching in the plane would take more than all of the thickness."""
    return 1 - lmbda / (lmbda + 2 * mu) * (metric.A - 2) - metric.s


globals().update(every_form(plane_stress, mu, squared_thickness=squared_thickness))
