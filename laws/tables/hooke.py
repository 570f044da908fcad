"""Common parts of laws that are Hooke's law at rest, with mu and lambda: sets of keys, and Hooke's law in plane stress.
"""

from law import BULK, Accepted, Bound, Quantity, modulus

MU = modulus("mu", "shear_modulus_Pa", "mu")
LAMBDA = Quantity("lmbda", "lame_lambda_Pa", "lambda", low=-1e12, meaning="greater than -2/3 mu; lambda in Pa")
YOUNG = modulus("E", "youngs_modulus_Pa", "E")
POISSON = Quantity("nu", "poisson_ratio", "nu", low=-1.0, high=0.5, low_open=True, high_open=True,
                   meaning="greater than -1 and less than 0.5; nu, no unit")  # fmt: skip

parameters = (MU, LAMBDA)


def shear_modulus(mu):
    return mu


def bulk_modulus(mu, lmbda):
    return lmbda + 2 * mu / 3


def lame_lambda(mu, K):
    return K - 2 * mu / 3


accepted = (
    Accepted((YOUNG, POISSON), {
        "mu": lambda E, nu: E / (2 * (1 + nu)),
        "lmbda": lambda E, nu: E * nu / ((1 + nu) * (1 - 2 * nu)),
        "K": lambda E, nu: E / (3 * (1 - 2 * nu)),
    }),
    Accepted((MU, LAMBDA), bounds=(
        Bound("lmbda", True, lambda mu: -2 * mu / 3, "gives a bulk modulus lambda + 2 mu / 3 that is not positive",
              "with this shear modulus"),
    )),
    Accepted((MU, BULK), {"lmbda": lame_lambda}),
    Accepted((YOUNG, BULK), {"mu": lambda K, E: 3 * K * E / (9 * K - E), "lmbda": lame_lambda}, (
        Bound("E", False, lambda K: 9 * K, "must be less than nine times the bulk modulus", "with this bulk modulus"),
    )),
)  # fmt: skip


def example(K):
    return {"mu": 1.0, "lmbda": K - 2 / 3}


def plane_stress(metric, mu, lmbda):
    """W = lambda/2 (tr E)^2 + mu tr(E^2), tr E = (I1 - 3) / 2, tr(E^2) = (I1^2 - 2 I2 - 2 I1 + 3) / 4, with E_33 such
    that S_33 = 0. Then lambda is replaced by 2 lambda mu / (lambda + 2 mu), E_33 cancels, and x = 1.
    """
    I1, I2 = metric.A + 1, metric.P + metric.A
    return lmbda * mu / (lmbda + 2 * mu) * (I1 - 3) ** 2 / 4 + mu / 4 * (I1**2 - 2 * I2 - 2 * I1 + 3)
