"""Gent 1996, doi 10.5254/1.3538357, with the isochoric invariant. Its chains of finite length are taut at I1bar - 3 =
J_m.

W = -mu J_m/2 ln(1 - (I1bar - 3) / J_m) + K/2 (J - 1)^2,   I1bar = J^(-2/3) I1.
"""

from law import BULK, Quantity, det, exp, ln, modulus, tr

name = "gent"
LARGEST = 1e6  # far beyond any rubber or tissue: the law is then neo-Hookean
parameters = (
    modulus("mu", "shear_modulus_Pa", "mu"),
    Quantity("j_m", "j_m", "J_m", high=LARGEST, low_open=True,
             meaning=f"> 0 and at most {LARGEST:,.0f}; J_m, the limit of I1bar - 3, no unit"),
    BULK,
)
kappa = "K"
formulas = {"shape": "-mu J_m/2 ln(1 - (I1bar - 3) / J_m)", "volumetric": "J - 1", "equation": "Gent 1996"}


def shear_modulus(mu):
    return mu


def bulk_modulus(K):
    return K


def example(K):
    return {"mu": 1.0, "j_m": 20.0, "K": K}


def inside(F, j_m):
    """The remaining extensibility of the chains. For J <= 0 the logarithm of J gives NaN."""
    return 1 - (exp(-2 / 3 * ln(det(F))) * tr(F.T * F) - 3) / j_m


def shape(F, mu, j_m):
    return -mu * j_m / 2 * ln(inside(F, j_m))


def volumetric(F):
    return det(F) - 1
