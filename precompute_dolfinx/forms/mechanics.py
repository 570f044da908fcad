"""Kinematics of the paper, and the one way from a strain energy density to the forms of every element.

A law file (law.py) states two functions of the deformation gradient F = I + grad u (equation (3)):

    shape(F)        energy density without its volumetric part
    volumetric(F)   g(F), so that the energy density is  W = shape + kappa/2 g^2

and the coefficient kappa. From these follow, for every element of element_table.py, in this order,

    energy      Pi(w)                 stored energy; stationary at equilibrium without loads
    residual    dPi(w; v)             the weak form (5): assembled, it is the nodal force that holds the state
    tangent     d2Pi(w; v, dw)        its derivative, symmetric
    von_mises   int sigma_v           of the Cauchy stress sigma = P F^T / J, P = dW/dF at fixed p
    stored      int W                 the energy cell by cell (mixed elements: see mixed())
    jacobian    J = det F             at the quadrature points of the forms; -1 where a law says that it ends

Displacement elements: w = u, Pi = int W. Mixed elements: w = (u, p), perturbed Lagrangian

    Pi = int shape + p g - p^2 / (2 kappa)

whose p is kappa g at the solution, where Pi has the value of int W with g weakly averaged; a law may give another
coupling of F and p with the same stationary point and value (laws/neo_hookean.py says why). Equal order (p1-p1) adds
the stabilization of Klaas, Maniatty & Shephard (1999), doi 10.1016/S0045-7825(99)00059-6:

    - alpha h^2 / (2 mu) |F^-T grad p|^2,   h the cell diameter.

All lengths and moduli arrive without dimension (see scaling.hpp).
"""

import basix
from element_table import SOLIDS
from elements import displacement_space, domain, mixed_space
from ufl import (
    CellDiameter, Coefficient, Identity, Jacobian, TestFunction, TrialFunction, conditional, cross, derivative, det, dev, diff, dot,
    dx, grad, gt, inner, split, sqrt, sym, variable,
)

I = Identity(3)


def space_of(element):
    """Of a tetrahedron's row in element_table.py."""
    if element.pressure_degree is None:
        return displacement_space(element.displacement_degree)
    return mixed_space(element.displacement_degree, element.pressure_degree)


def _points(degree):
    return basix.make_quadrature(basix.CellType.tetrahedron, degree)[0]


def _chain(energy, w, space):
    residual = derivative(energy, w, TestFunction(space))
    return energy, residual, derivative(residual, w, TrialFunction(space))


def von_mises(density, F, finite):
    """Von Mises stress, sqrt(3/2) |dev sigma|. Small strains (not `finite`): sigma = dW/de, and P is that."""
    F = variable(F)
    P = diff(density(F), F)
    s = dev(P * F.T / det(F) if finite else sym(P))
    return sqrt(3 / 2 * inner(s, s))


def _jacobian(F, inside):
    return det(F) if inside is None else conditional(gt(inside(F), 0), det(F), -1)


def displacement(element, shape, volumetric, kappa, finite=True, inside=None):
    """Forms of a displacement element: (energy, residual, tangent, von_mises, stored, (jacobian, points))."""
    degree = element.quadrature_degree
    space = space_of(element)
    u = Coefficient(space)
    F = I + grad(u)
    density = lambda F: shape(F) + kappa / 2 * volumetric(F) ** 2
    measure = dx(metadata={"quadrature_degree": degree})
    stress = von_mises(density, F, finite) * measure
    # Two objects: ffcx knows names by them.
    energy, stored = density(F) * measure, density(F) * measure
    return (*_chain(energy, u, space), stress, stored, (_jacobian(F, inside), _points(degree)))


def quadratic(volumetric, kappa):
    """Coupling of displacement and pressure where the volumetric energy is kappa/2 g^2."""
    return lambda F, p: p * volumetric(F) - p**2 / (2 * kappa)


def mixed(element, shape, coupling, kappa, stabilization, finite=True, inside=None):
    """Forms of a displacement-pressure element. `coupling(F, p)` and `stabilization(F, p)` are energy densities.

    Equal order is linear: F is constant in a cell, and all but -p^2 / (2 kappa) is linear in p, or nearly so where p is
    small beside kappa (a coupling of its own; the difference is of second order in the cell's size). So one point is
    enough, with the exact integral of p^2: its value at the middle and the variance of p in the cell.
    (Two quadrature degrees in one form are not an alternative: ffcx 0.5 then takes p of the one for the other.)

    The integrand e of the energy is a density for its stationary point only: where p and kappa g differ, which they do in
    every cell, it may well be negative. `stored` is e - p de/dp, for a quadratic coupling shape + p^2 / (2 kappa). As
    p de/dp integrates to nothing at equilibrium (it is the pressure equations times p), both have the same integral.
    """
    degree = element.quadrature_degree
    space = space_of(element)
    w = Coefficient(space)
    u, p = split(w)
    F = I + grad(u)
    density = shape(F) + coupling(F, p)
    q = variable(p)
    stored = density - p * diff(coupling(F, q), q)
    if element.stabilized:
        # Quadratic in p: p d/dp is twice the function.
        of_element = stabilization(F, p) + variance(p) / (2 * kappa)
        density -= of_element
        stored += of_element
    measure = dx(metadata={"quadrature_degree": degree})
    # The stabilization belongs to the element and not to the material: it is no part of the stress.
    stress = von_mises(lambda F: shape(F) + coupling(F, p), F, finite) * measure
    return (*_chain(density * measure, w, space), stress, stored * measure, (_jacobian(F, inside), _points(degree)))


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


def every_element(shape, volumetric, kappa, stabilization, coupling=None, finite=True, inside=None):
    """What ffcx compiles, by name: {p1,p2,...}_{energy,residual,tangent,von_mises,stored,jacobian}, and lists of them.

    `finite` is False for the theory of small strains, whose stress knows one configuration only. `inside(F)` is positive
    where the law is defined.
    """
    coupling = coupling or quadratic(volumetric, kappa)
    quantities = ("energy", "residual", "tangent", "von_mises", "stored", "jacobian")
    names = {}
    for element in SOLIDS:
        if element.pressure_degree is None:
            built = displacement(element, shape, volumetric, kappa, finite, inside)
        else:
            built = mixed(element, shape, coupling, kappa, stabilization, finite, inside)
        names |= {f"{element.identifier}_{q}": value for q, value in zip(quantities, built)}
    names["forms"] = [v for n, v in names.items() if not n.endswith("_jacobian")]
    names["expressions"] = [v for n, v in names.items() if n.endswith("_jacobian")]
    return names
