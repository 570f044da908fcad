"""Kinematics of the shell, and the one way from a plane-stress energy density to its forms.

A point at height zeta over the middle surface, |zeta| <= t/2, is carried from X + zeta D to x + zeta d: x = X + u with
quadratic u, and directors D, d that live at the middles of edges and are linear in a triangle. The spaces are those of
Campello, Pimenta & Wriggers 2003, doi 10.1007/s00466-003-0458-8, who have rotations in the place of directors. With
convected coordinates, G_a = X,a + zeta D,a and g_a likewise, the layer's normal N as third base vector G_3, and g_3 the
vector that becomes of it, D = c N + s^a G_a and d = c g_3 + s^a g_a:

    C = g_ij G^i x G^j,     I1 = G^ij g_ij,     I2 = G_ij cof(g)_ij / det G,     J^2 = det g / det G.

g_33 = x is not what the director says but what makes the stress across the shell vanish, S^33 = 2 dW/dx = 0: the law
condenses it (plane_stress of the files in ../laws), so no thickness locking and any K/mu. The invariants are
linear in it,

    I1 = A + x,     I2 = P + A x,     x = s + r J^2,

A = G^ab g_ab, s what shear alone gives and r = det G / det g_ab. The shear strains g_a3 are scaled by sqrt(5/6), which
gives the usual factor of shear energy.

The middle surface's energy t W(zeta = 0), of stretching and of shear, is integrated with weight alpha at the three
points of the others and with 1 - alpha at one point, alpha = c t^2 / (c t^2 + h^2): without that, a thin flat triangle
cannot bend as part of a curved surface (membrane locking). Half of the shear energy goes that way too, which helps thin
plates; all of it would make a shell under a point force hard to solve. Partial selective reduced integration: Arnold &
Brezzi 1997, doi 10.1090/S0025-5718-97-00785-0; the measurements: docs/decisions/shell.md.

The length of a director has no meaning of its own. A penalty at the middles of edges keeps it: `gauge`.

`src/form_set.cpp` says which constants each pass over these forms gets:
    zeta, thickness    height, t
    layer              weight of a layer: half the thickness for each of two Gauss points
    swap               t in the pass that exchanges the middle surface's integral, else 0
    shear              there the share of shear strains that takes part, else 1
"""

import numpy
from shell_elements import domain, space
from ufl import (
    CellDiameter, Coefficient, Constant, Jacobian, TestFunction, TrialFunction, as_vector, conditional, cross, derivative, diff,
    dot, dx, grad, gt, split, sqrt, variable,
)

zeta, thickness = Constant(domain), Constant(domain)
layer, swap, shear = Constant(domain), Constant(domain), Constant(domain)

state = Coefficient(space)
# In the places of the displacement: 1 at middles of edges and 0 at vertices (see CENTRE); directors at rest.
rest = Coefficient(space)

# Of alpha: docs/decisions/shell.md.
c_reduced = 20
# Stiffness of a director's length over the shear modulus.
c_gauge = 1

# Degree 2, three points, and the middle of the triangle in one rule: one kernel for both integrals.
RULE = {
    "quadrature_rule": "custom", "quadrature_degree": 2,
    "quadrature_points": numpy.array([[1 / 6, 1 / 6], [2 / 3, 1 / 6], [1 / 6, 2 / 3], [1 / 3, 1 / 3]]),
    "quadrature_weights": numpy.array([1 / 6, 1 / 6, 1 / 6, 1 / 2]),
}
MIDDLES = {
    "quadrature_rule": "custom", "quadrature_degree": 2,
    "quadrature_points": numpy.array([[1 / 2, 1 / 2], [0, 1 / 2], [1 / 2, 0]]),
    "quadrature_weights": numpy.array([1 / 6, 1 / 6, 1 / 6]),
}

u, turn = split(state)
marks, D = split(rest)
# 1 at the middle of the triangle, 0 at the three points: the quadratic function of the marks is 4/3 and 1 there.
CENTRE = 3 * (marks[0] - 1)

_tangents = [Jacobian(domain)[:, 0], Jacobian(domain)[:, 1]]


def _along(f, a):
    return dot(grad(f), a)


# Base vectors at rest, and how they change.
G = [a + zeta * _along(D, a) for a in _tangents]
change = [_along(u, a) + zeta * _along(turn, a) for a in _tangents]


class Metric:
    """Metric of the deformed shell, and its invariants as functions of x = g_33. Linear: of small strains.

    With N and not D as third base vector G_a3 = 0, and stretching and shear have energies of their own: a share of the shear
    (`shear`) that is taken away then leaves the rest positive. With D, whose angle to N is h / R, thin shells were unstable
    at rest.
    """

    def __init__(self, finite=True):
        g = [a + b for a, b in zip(G, change)]
        d = D + turn

        def product(a, b, da, db):
            return dot(a + da, b + db) if finite else dot(a, b) + dot(a, db) + dot(da, b)

        G11, G12, G22 = dot(G[0], G[0]), dot(G[0], G[1]), dot(G[1], G[1])
        rest_plane = G11 * G22 - G12**2
        D1, D2 = dot(G[0], D), dot(G[1], D)
        s1, s2 = (G22 * D1 - G12 * D2) / rest_plane, (G11 * D2 - G12 * D1) / rest_plane
        normal = cross(*G) / sqrt(rest_plane)
        c = dot(normal, D)
        turned = (turn - s1 * change[0] - s2 * change[1]) / c

        g11, g22 = (product(G[a], G[a], change[a], change[a]) for a in (0, 1))
        g12 = product(G[0], G[1], change[0], change[1])
        g13, g23 = (
            shear * sqrt(5 / 6) * (dot(G[a], turned) + dot(change[a], normal + turned if finite else normal)) for a in (0, 1)
        )

        self.strains = as_vector([g11, g12, g22, g13, g23])
        self.variables = variable(self.strains)
        g11, g12, g22, g13, g23 = (self.variables[i] for i in range(5))
        det_plane = g11 * g22 - g12**2
        self.A = (G22 * g11 + G11 * g22 - 2 * G12 * g12) / rest_plane
        self.P = (det_plane + 2 * G12 * g13 * g23 - G11 * g23**2 - G22 * g13**2) / rest_plane
        self.s = (g22 * g13**2 + g11 * g23**2 - 2 * g12 * g13 * g23) / det_plane
        self.r = rest_plane / det_plane
        # Volume of a layer over the area of the triangle.
        area = sqrt(dot(_tangents[0], _tangents[0]) * dot(_tangents[1], _tangents[1]) - dot(*_tangents) ** 2)
        self.volume = sqrt(rest_plane) * c / area
        self.stretch = dot(d, d) - dot(D, D) if finite else 2 * dot(D, turn)

    def invariants(self):
        """(I1, dI1/dy, I2, dI2/dy) at y = J^2 = 1."""
        return (self.A + self.s + self.r, self.r, self.P + self.A * (self.s + self.r), self.A * self.r)


def _chain(energy):
    residual = derivative(energy, state, TestFunction(space))
    return energy, residual, derivative(residual, state, TrialFunction(space))


def _chain_of_strains(density, metric, measure):
    """The same of a density that depends on the state through the five strains only, in two steps: stress dW/dg and
    moduli d2W/dg2, which no test function enters, and then the strains' own derivatives.

    For ffcx the tangent in one step is five times as many operations.
    """
    stress = diff(density, metric.variables)
    along = derivative(metric.strains, state, TestFunction(space))
    change = derivative(metric.strains, state, TrialFunction(space))
    tangent = dot(dot(diff(stress, metric.variables), change), along) + dot(stress, derivative(along, state, TrialFunction(space)))
    return density * measure, dot(stress, along) * measure, tangent * measure


def every_form(plane_stress, mu, finite=True, squared_thickness=None):
    """What ffcx compiles: {energy,residual,tangent,gauge_energy,gauge_residual,gauge_tangent,orientation}, and lists of them.

    plane_stress(metric) is the energy density with S^33 = 0. squared_thickness(metric), of laws that know no J = 0, is what
    must be positive for the wall not to be turned inside out.
    """
    metric = Metric(finite)
    h = CellDiameter(domain)
    alpha = c_reduced * thickness**2 / (c_reduced * thickness**2 + h**2)
    weight = layer * (1 - CENTRE) + swap * (1 - alpha) * (2 * CENTRE - 1)
    density = weight * metric.volume * plane_stress(metric)
    names = dict(zip(("energy", "residual", "tangent"), _chain_of_strains(density, metric, dx(metadata=RULE))))
    gauge = c_gauge * mu * thickness * metric.stretch**2 / 4
    names |= zip(("gauge_energy", "gauge_residual", "gauge_tangent"), _chain(gauge * dx(metadata=MIDDLES)))
    names["forms"] = list(names.values())
    g = [a + b for a, b in zip(G, change)]
    # A shell's J: how its layers would be turned over if it were bent further. The law has the thickness right by itself.
    names["orientation"] = dot(cross(*g), D + turn) / dot(cross(*G), D)
    if squared_thickness is not None:
        names["orientation"] *= conditional(gt(squared_thickness(metric), 0), 1, -1)
    names["expressions"] = [(names["orientation"], RULE["quadrature_points"])]
    return names
