"""St. Venant-Kirchhoff, equation (7): W = lambda/2 (tr E)^2 + mu tr(E^2), E the Green-Lagrange strain (4)."""

from mechanics import *

mu, lmbda, alpha = Constant(domain), Constant(domain), Constant(domain)


def E(F):
    return (F.T * F - I) / 2


def shape(F):
    return mu * inner(E(F), E(F))


def volumetric(F):
    return tr(E(F))


globals().update(every_element(shape, volumetric, lmbda, klaas(alpha, mu)))
