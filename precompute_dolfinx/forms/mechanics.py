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
    CellDiameter, Coefficient, Constant, Identity, TestFunction, TrialFunction, derivative, det, dot, dx, exp, grad,
    inner, inv, ln, split, sym, tr,
)

I = Identity(3)

# Quadrature: P1 has a constant gradient. p1-p1 integrates p^2 exactly. The quadratic elements have non-polynomial
# integrands; degree 4 integrates p (J - 1) of Taylor-Hood exactly.
P1 = (displacement_space(1), 1)
P2 = (displacement_space(2), 4)
P1_P1 = (mixed_space(1, 1), 2)
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


def mixed(discretization, shape, coupling, stabilization=None):
    """Forms of a displacement-pressure element. `coupling(F, p)` and `stabilization(F, p)` are energy densities."""
    space, degree = discretization
    w = Coefficient(space)
    u, p = split(w)
    F = I + grad(u)
    pointwise, constant = coupling(F, p), None
    if stabilization is None:
        pointwise += shape(F)
    else:
        # Equal order is linear: gradients are constant in a cell, and only p wants more than one point.
        constant = shape(F) - stabilization(F, p)
    energy = pointwise * dx(metadata={"quadrature_degree": degree})
    if constant is not None:
        energy += constant * dx(metadata={"quadrature_degree": 1})
    return (*_chain(energy, w, space), (det(F), _points(degree)))


def klaas(alpha, mu, finite=True):
    """Energy density of the p1-p1 stabilization; in the linear theory F = I."""

    def density(F, p):
        g = dot(inv(F).T, grad(p)) if finite else grad(p)
        return alpha * CellDiameter(domain) ** 2 / (2 * mu) * inner(g, g)

    return density


def every_element(shape, volumetric, kappa, stabilization, coupling=None):
    """What ffcx compiles, by name: {p1,p2,th,p1p1}_{energy,residual,tangent,jacobian}, `forms` and `expressions`."""
    coupling = coupling or quadratic(volumetric, kappa)
    built = {
        "p1": displacement(P1, shape, volumetric, kappa),
        "p2": displacement(P2, shape, volumetric, kappa),
        "th": mixed(TAYLOR_HOOD, shape, coupling),
        "p1p1": mixed(P1_P1, shape, coupling, stabilization),
    }
    quantities = ("energy", "residual", "tangent", "jacobian")
    names = {f"{e}_{q}": value for e, values in built.items() for q, value in zip(quantities, values)}
    names["forms"] = [v for n, v in names.items() if not n.endswith("_jacobian")]
    names["expressions"] = [v for n, v in names.items() if n.endswith("_jacobian")]
    return names
