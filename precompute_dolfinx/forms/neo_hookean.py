"""Neo-Hookean, equation (8): W = mu/2 (I_c - 3) - mu ln J + lambda/2 (ln J)^2."""

from mechanics import *

mu, lmbda, alpha = Constant(domain), Constant(domain), Constant(domain)
# 1 where lambda >= 2 mu, else 0 (src/form_set.cpp); see coupling().
couples_J = Constant(domain)


def shape(F):
    return mu / 2 * (inner(F, F) - 3) - mu * ln(det(F))


def volumetric(F):
    return ln(det(F))


def coupling(F, p):
    """p e^(-p/lambda) J - p + p^2 / (2 lambda): stationary at p = lambda ln J, where it is lambda/2 (ln J)^2.

    So is p ln J - p^2 / (2 lambda), but its second variation holds -p tr((F^-1 dF)^2), which under constant pressure
    is -p (div)^2: from p = 2 mu on, a moderate pull, changes of volume that the pressure space cannot see outweigh
    the shear stiffness, and Taylor-Hood and p1-p1 lose the stability that the body has. The second variation of J
    under constant pressure integrates to nothing. Its own limit is J = e, where it stops being concave in p. Which of
    the two comes later is a matter of lambda = 2 mu: below, ln J holds on to J = e^(2 mu / lambda).
    """
    with_J = p * exp(-p / lmbda) * det(F) - p + p**2 / (2 * lmbda)
    with_ln_J = p * ln(det(F)) - p**2 / (2 * lmbda)
    return couples_J * with_J + (1 - couples_J) * with_ln_J


globals().update(every_element(shape, volumetric, lmbda, klaas(alpha, mu), coupling))
