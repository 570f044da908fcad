"""Mooney-Rivlin, equation (9) with the standard sign and isochoric invariants:

W = C10 (I1bar - 3) + C01 (I2bar - 3) + K/2 (J - 1)^2,   I1bar = J^(-2/3) I1,   I2bar = J^(-4/3) I2.
"""

from mechanics import *

c10, c01, bulk, alpha = Constant(domain), Constant(domain), Constant(domain), Constant(domain)


def shape(F):
    C, J = F.T * F, det(F)
    first = tr(C)
    second = (first**2 - inner(C, C)) / 2
    # The logarithm makes J <= 0 a NaN, as in (8); a power would do so too, but less clearly.
    log_J = ln(J)
    return c10 * (exp(-2 / 3 * log_J) * first - 3) + c01 * (exp(-4 / 3 * log_J) * second - 3)


def volumetric(F):
    return det(F) - 1


mu = 2 * (c10 + c01)
globals().update(every_element(shape, volumetric, bulk, klaas(alpha, mu)))
