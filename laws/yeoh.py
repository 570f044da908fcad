"""Yeoh 1993, doi 10.5254/1.3538343, with isochoric invariants:

W = C10 (I1bar - 3) + C20 (I1bar - 3)^2 + C30 (I1bar - 3)^3 + K/2 (J - 1)^2,   I1bar = J^(-2/3) I1.
"""

from law import BULK, Quantity, det, exp, ln, modulus, tr

name = "yeoh"
parameters = (
    modulus("c10", "c10_Pa", "C10"),
    # C20 may be negative: rubbers that first soften and then stiffen have C20 < 0.
    Quantity("c20", "c20_Pa", "C20", low=-1e12, meaning="any sign; C20 in Pa"),
    Quantity("c30", "c30_Pa", "C30", low=-1e12, meaning="any sign; C30 in Pa"),
    BULK,
)
kappa = "K"
formulas = {"shape": "C10 (I1bar - 3) + C20 (I1bar - 3)^2 + C30 (I1bar - 3)^3", "volumetric": "J - 1", "equation": "Yeoh 1993"}


def shear_modulus(c10):
    return 2 * c10


def bulk_modulus(K):
    return K


def example(K):
    return {"c10": 0.5, "c20": -0.05, "c30": 0.02, "K": K}


def shape(F, c10, c20, c30):
    # For J <= 0 the logarithm gives NaN.
    x = exp(-2 / 3 * ln(det(F))) * tr(F.T * F) - 3
    return c10 * x + c20 * x**2 + c30 * x**3


def volumetric(F):
    return det(F) - 1
