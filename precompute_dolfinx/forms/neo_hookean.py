"""Neo-Hookean, equation (8): W = mu/2 (I_c - 3) - mu ln J + lambda/2 (ln J)^2."""

from mechanics import *

mu, lmbda, alpha = Constant(cell), Constant(cell), Constant(cell)


def shape(F):
    return mu / 2 * (inner(F, F) - 3) - mu * ln(det(F))


def volumetric(F):
    return ln(det(F))


globals().update(every_element(shape, volumetric, lmbda, klaas(alpha, mu)))
