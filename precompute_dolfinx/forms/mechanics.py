"""The forms of all tetrahedra from a law's shape(F), volumetric(F) = g(F) and kappa: W = shape + kappa/2 g^2, F = I + grad u.

Equations (b), (c) and (z) of docs/theory.md, Elements. For every element of element_table.py, in this order:

    energy      Pi(w)                 stored energy; stationary at equilibrium without loads; w = u, or (u, p)
    residual    dPi(w; v)             the weak form (5); assembled, it is the nodal force that holds the state
    tangent     d2Pi(w; v, dw)        its derivative, symmetric
    von_mises   int sigma_v           of the Cauchy stress sigma = P F^T / J, P = dW/dF at fixed p
    stored      int W                 the energy of each cell (mixed elements: see mixed())
    jacobian    J = det F             at the quadrature points of the forms; -1 where the law is not defined

The forms of the edges of the edge-smoothed element, edge_energy and so on, are functions of F_e; src/edge_patches.hpp
sums them. All lengths and moduli are dimensionless (see scaling.hpp).
"""

import basix
from element_table import FIELDS, JACOBIANS, SOLIDS
from elements import displacement_space, domain, gradient_space, mixed_space
from ufl import (
    CellDiameter, Coefficient, Identity, Jacobian, TestFunction, TrialFunction, conditional, cross, derivative, det, dev, diff, dot,
    dx, grad, gt, inner, split, sqrt, sym, variable,
)

I = Identity(3)


def space_of(element):
    """The function space of a tetrahedron's row in element_table.py."""
    if element.pressure_degree is None:
        return displacement_space(element.displacement_degree)
    return mixed_space(element.displacement_degree, element.pressure_degree)


def _points(degree):
    return basix.make_quadrature(basix.CellType.tetrahedron, degree)[0]


def _chain(energy, w, space):
    residual = derivative(energy, w, TestFunction(space))
    return energy, residual, derivative(residual, w, TrialFunction(space))


def von_mises(density, F, finite):
    """Von Mises stress, sqrt(3/2) |dev sigma|. For small strains (not `finite`) sigma = P = dW/de."""
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
    # Two separate objects, because ffcx distinguishes names by the identity of their objects.
    energy, stored = density(F) * measure, density(F) * measure
    return (*_chain(energy, u, space), stress, stored, (_jacobian(F, inside), _points(degree)))


def quadratic(volumetric, kappa):
    """The coupling of displacement and pressure for the volumetric energy kappa/2 g^2."""
    return lambda F, p: p * volumetric(F) - p**2 / (2 * kappa)


def mixed(element, shape, coupling, kappa, stabilization, finite=True, inside=None, cell_share=None):
    """Forms of a displacement-pressure element. `coupling(F, p)` and `stabilization(F, p)` are energy densities.

    In the equal-order element F is constant in a cell, and all terms except -p^2 / (2 kappa) are linear in p. With
    another coupling they are nearly linear if p is small compared to kappa; the difference is of second order in the
    cell size. Therefore one quadrature point suffices if p^2 is integrated exactly, by its value at the middle plus the
    variance of p in the cell. (Two quadrature degrees in one form are not possible: ffcx 0.5 then uses p of one for the
    other.)

    The integrand e of the energy is an energy density only at its stationary point. Where p and kappa g differ, which
    they do in every cell, it may be negative. `stored` is e - p de/dp, which for a quadratic coupling is shape + p^2 /
    (2 kappa). At equilibrium the integral of p de/dp is zero (it is the pressure equations times p), so that both have
    the same integral.
    """
    degree = element.quadrature_degree
    space = space_of(element)
    w = Coefficient(space)
    u, p = split(w)
    F = I + grad(u)
    density = (cell_share * shape(F) if element.edge_smoothed else shape(F)) + coupling(F, p)
    q = variable(p)
    stored = density - p * diff(coupling(F, q), q)
    if element.stabilized:
        # This function is quadratic in p, so that p d/dp gives twice the function.
        of_element = stabilization(F, p) + variance(p) / (2 * kappa)
        density -= of_element
        stored += of_element
    measure = dx(metadata={"quadrature_degree": degree})
    # The stabilization belongs to the element, not to the material, and does not contribute to the stress.
    stress = von_mises(lambda F: shape(F) + coupling(F, p), F, finite) * measure
    return (*_chain(density * measure, w, space), stress, stored * measure, (_jacobian(F, inside), _points(degree)))


def edges(shape, inside, cell_share):
    """Forms of the edges of an edge-smoothed element: (energy, residual, tangent, (jacobian, points)) as functions of
    the mean gradient F of the cells at an edge."""
    space = gradient_space()
    F = Coefficient(space)
    measure = dx(metadata={"quadrature_degree": 0})
    return (*_chain((1 - cell_share) * shape(F) * measure, F, space), (_jacobian(F, inside), _points(0)))


def variance(p):
    """Variance of a linear function in a cell. A tetrahedron with corners 0, e1, e2, e3 has the covariance
    (4 I - 1 1^T) / 80.
    """
    slope = dot(Jacobian(domain).T, grad(p))
    return (4 * inner(slope, slope) - (slope[0] + slope[1] + slope[2]) ** 2) / 80


def klaas(alpha, mu, finite=True):
    """The energy density of the p1-p1 stabilization; in the linear theory F = I."""

    def density(F, p):
        squared = inner(grad(p), grad(p))
        if finite:
            # F^-T = cof(F) / J. Without divisions the code of the tangent is less than half as long as with inv(F).
            a, b, c = F[:, 0], F[:, 1], F[:, 2]
            q, J = grad(p), det(F)
            g = cross(b, c) * q[0] + cross(c, a) * q[1] + cross(a, b) * q[2]
            squared = inner(g, g) / (J * J)
        return alpha * CellDiameter(domain) ** 2 / (2 * mu) * squared

    return density


def every_element(shape, volumetric, kappa, stabilization, cell_share, coupling=None, finite=True, inside=None, in_shape=None):
    """The objects that ffcx compiles: {p1,p2,...}_{energy,residual,tangent,von_mises,stored,jacobian}, and lists of
    them.

    `finite` is False for the theory of small strains, in which all stresses refer to one configuration. `inside(F)` is
    positive where the law is defined. `in_shape`, if given, is the part of kappa that belongs to shape in the edge-smoothed
    element.
    """
    coupling = coupling or quadratic(volumetric, kappa)
    energies = smoothed = (shape, coupling, kappa)
    if in_shape is not None:
        left = 1 - in_shape / kappa  # p remains kappa g
        smoothed = (lambda F: shape(F) + in_shape / 2 * volumetric(F) ** 2, lambda F, p: left * coupling(F, p), kappa / left)
    quantities = ("energy", "residual", "tangent", *FIELDS, "jacobian")
    names = {}
    for element in SOLIDS:
        if element.pressure_degree is None:
            built = displacement(element, shape, volumetric, kappa, finite, inside)
        else:
            built = mixed(element, *(smoothed if element.edge_smoothed else energies), stabilization, finite, inside, cell_share)
        names |= {f"{element.identifier}_{q}": value for q, value in zip(quantities, built, strict=True)}
    built = edges(smoothed[0], inside, cell_share)
    names |= {f"edge_{q}": value for q, value in zip(("energy", "residual", "tangent", "jacobian"), built, strict=True)}
    names["forms"] = [v for n, v in names.items() if not n.endswith("_jacobian")]
    spaces = {(e.displacement_degree, e.pressure_degree): e.identifier for e in reversed(SOLIDS)} | {"edge": "edge"}
    names["expressions"] = [names[f"{spaces[key]}_jacobian"] for key in JACOBIANS]
    return names
