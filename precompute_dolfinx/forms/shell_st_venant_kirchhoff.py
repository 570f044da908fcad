"""St. Venant-Kirchhoff of st_venant_kirchhoff.py in plane stress."""

from shell import *

mu, lmbda = Constant(domain), Constant(domain)


def plane_stress(metric):
    """W = lambda/2 (tr E)^2 + mu tr(E^2), tr E = (I1 - 3) / 2, tr(E^2) = (I1^2 - 2 I2 - 2 I1 + 3) / 4: quadratic in x."""
    I1, I2 = metric.A + metric.B * metric.rest, metric.P + metric.Q * metric.rest
    density = lmbda / 8 * (I1 - 3) ** 2 + mu / 4 * (I1**2 - 2 * I2 - 2 * I1 + 3)
    slope = lmbda / 4 * (I1 - 3) * metric.B + mu / 2 * (I1 * metric.B - metric.Q - metric.B)
    curvature = (lmbda / 4 + mu / 2) * metric.B**2
    return density - slope**2 / (2 * curvature)


def squared_thickness(metric):
    """x - s: negative where stretching in the plane would take more than all of the thickness."""
    I1, P = metric.A + metric.B * metric.rest, metric.Q
    slope = lmbda / 4 * (I1 - 3) * metric.B + mu / 2 * (I1 * metric.B - P - metric.B)
    return metric.rest - slope / ((lmbda / 4 + mu / 2) * metric.B**2) - metric.s


globals().update(every_form(plane_stress, mu, squared_thickness=squared_thickness))
