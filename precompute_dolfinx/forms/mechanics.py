"""Kinematics of the paper, and the one way from a strain energy density to the forms of every element.

A material file states two functions of the deformation gradient F = I + grad u (equation (3)):

    shape(F)        energy density without its volumetric part
    volumetric(F)   g(F), so that the energy density is  W = shape + kappa/2 g^2

and the coefficient kappa. From these follow, for every element, in this order,

    energy      Pi(w)                 stored energy; stationary at equilibrium without loads
    residual    dPi(w; v)             the weak form (5): assembled, it is the nodal force that holds the state
    tangent     d2Pi(w; v, dw)        its derivative, symmetric
    jacobian    J = det F             at the quadrature points of the forms

Displacement elements: w = u, Pi = int W. Mixed elements: w = (u, p), perturbed Lagrangian

    Pi = int shape + p g - p^2 / (2 kappa)

whose p is kappa g at the solution, where Pi has the value of int W with g weakly averaged; a law may give another
coupling of F and p with the same stationary point and value (neo_hookean.py says why). Equal order (p1-p1) adds
the stabilization of Klaas, Maniatty & Shephard (1999), doi 10.1016/S0045-7825(99)00059-6:

    - alpha h^2 / (2 mu) |F^-T grad p|^2,   h the cell diameter.

All lengths and moduli arrive without dimension (see scaling.hpp).
"""

import basix
from elements import displacement_space, domain, mixed_space
from ufl import (
    CellDiameter, Coefficient, Constant, Identity, Jacobian, TestFunction, TrialFunction, cross, derivative, det, dot,
    dx, exp, grad, inner, ln, split, sym, tr,
)

I = Identity(3)

# Quadrature: P1 has a constant gradient, and so has p1-p1 (see mixed()). The quadratic elements have non-polynomial
# integrands; degree 4 integrates p (J - 1) of Taylor-Hood exactly.
P1 = (displacement_space(1), 1)
P2 = (displacement_space(2), 4)
P1_P1 = (mixed_space(1, 1), 1)
TAYLOR_HOOD = (mixed_space(2, 1), 4)


def _points(degree):
    return basix.make_quadrature(basix.CellType.tetrahedron, degree)[0]


def _chain(energy, w, space):
    residual = derivative(energy, w, TestFunction(space))
    return energy, residual, derivative(residual, w, TrialFunction(space))


def displacement(discretization, shape, volumetric, kappa):
    """Forms of a displacement element: (energy, residual, tangent, (jacobian, points))."""
    space, degree = discretization
    u = Coefficient(space)
    F = I + grad(u)
    energy = (shape(F) + kappa / 2 * volumetric(F) ** 2) * dx(metadata={"quadrature_degree": degree})
    return (*_chain(energy, u, space), (det(F), _points(degree)))


def quadratic(volumetric, kappa):
    """Coupling of displacement and pressure where the volumetric energy is kappa/2 g^2."""
    return lambda F, p: p * volumetric(F) - p**2 / (2 * kappa)


def mixed(discretization, shape, coupling, kappa, stabilization=None):
    """Forms of a displacement-pressure element. `coupling(F, p)` and `stabilization(F, p)` are energy densities.

    Equal order is linear: F is constant in a cell, and all but -p^2 / (2 kappa) is linear in p, or nearly so where p is
    small beside kappa (a coupling of its own; the difference is of second order in the cell's size). So one point is
    enough, with the exact integral of p^2: its value at the middle and the variance of p in the cell.
    (Two quadrature degrees in one form are not an alternative: ffcx 0.5 then takes p of the one for the other.)
    """
    space, degree = discretization
    w = Coefficient(space)
    u, p = split(w)
    F = I + grad(u)
    density = shape(F) + coupling(F, p)
    if stabilization is not None:
        density -= stabilization(F, p) + variance(p) / (2 * kappa)
    energy = density * dx(metadata={"quadrature_degree": degree})
    return (*_chain(energy, w, space), (det(F), _points(degree)))


def variance(p):
    """Of a linear function in a cell. A tetrahedron's corners X = 0, e1, e2, e3 have the covariance (4 I - 1 1^T) / 80."""
    slope = dot(Jacobian(domain).T, grad(p))
    return (4 * inner(slope, slope) - (slope[0] + slope[1] + slope[2]) ** 2) / 80


def klaas(alpha, mu, finite=True):
    """Energy density of the p1-p1 stabilization; in the linear theory F = I."""

    def density(F, p):
        squared = inner(grad(p), grad(p))
        if finite:
            # F^-T = cof(F) / J: without divisions the tangent is less than half as long as from inv(F).
            a, b, c = F[:, 0], F[:, 1], F[:, 2]
            q, J = grad(p), det(F)
            g = cross(b, c) * q[0] + cross(c, a) * q[1] + cross(a, b) * q[2]
            squared = inner(g, g) / (J * J)
        return alpha * CellDiameter(domain) ** 2 / (2 * mu) * squared

    return density


def every_element(shape, volumetric, kappa, stabilization, coupling=None):
    """What ffcx compiles, by name: {p1,p2,th,p1p1}_{energy,residual,tangent,jacobian}, `forms` and `expressions`."""
    coupling = coupling or quadratic(volumetric, kappa)
    built = {
        "p1": displacement(P1, shape, volumetric, kappa),
        "p2": displacement(P2, shape, volumetric, kappa),
        "th": mixed(TAYLOR_HOOD, shape, coupling, kappa),
        "p1p1": mixed(P1_P1, shape, coupling, kappa, stabilization),
    }
    quantities = ("energy", "residual", "tangent", "jacobian")
    names = {f"{e}_{q}": value for e, values in built.items() for q, value in zip(quantities, values)}
    names["forms"] = [v for n, v in names.items() if not n.endswith("_jacobian")]
    names["expressions"] = [v for n, v in names.items() if n.endswith("_jacobian")]
    return names
