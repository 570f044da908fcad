"""Linear elasticity (Case 1): W = lambda/2 (tr e)^2 + mu tr(e^2), e = sym(grad u)."""

from mechanics import *

mu, lmbda, alpha = Constant(domain), Constant(domain), Constant(domain)


def strain(F):
    return sym(F) - I


def shape(F):
    return mu * inner(strain(F), strain(F))


def volumetric(F):
    return tr(strain(F))


globals().update(every_element(shape, volumetric, lmbda, klaas(alpha, mu, finite=False), finite=False))
