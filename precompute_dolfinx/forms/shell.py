"""The forms of the shell from a plane-stress energy density: equations (w) and (y) of docs/theory.md, Shells.

The component g_33 = x of the metric is not computed from the director but from the condition that the stress across the
shell vanishes, which the law condenses (plane_stress of the files in ../laws). The invariants are linear in x:

    I1 = A + x,     I2 = P + A x,     x = s + r J^2,

where A = G^ab g_ab, s is the part of the shear strains, and r = det G / det g_ab.

The exchange of the integrals of the midsurface is a partial selective reduced integration: Arnold & Brezzi 1997, doi
10.1090/S0025-5718-97-00785-0; measurements: docs/decisions/shell.md.

`src/form_set.cpp` sets these constants for each pass over the forms:
    zeta, thickness    height, t
    layer              weight of a layer: half the thickness for each of two Gauss points
    swap               t in the pass that replaces the midsurface's integral, else 0
    shear              in that pass the fraction of the shear strains that takes part, else 1
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
# In the displacement dofs: 1 at middles of edges and 0 at vertices (see CENTRE). In the director dofs: directors at
# rest.
rest = Coefficient(space)

# The constant c of alpha (docs/decisions/shell.md).
c_reduced = 20
# Penalty stiffness of a director's length over the shear modulus.
c_gauge = 1

# Three points of degree 2 and the middle of the triangle in a single rule, so that one kernel computes both integrals.
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
# 1 at the middle of the triangle and 0 at the three points, where the quadratic function of the marks is 4/3 and 1.
CENTRE = 3 * (marks[0] - 1)

_tangents = [Jacobian(domain)[:, 0], Jacobian(domain)[:, 1]]


def _along(f, a):
    return dot(grad(f), a)


# Base vectors at rest, and their changes.
G = [a + zeta * _along(D, a) for a in _tangents]
change = [_along(u, a) + zeta * _along(turn, a) for a in _tangents]


class Metric:
    """Metric of the deformed shell, and its invariants as functions of x = g_33. Without `finite`: for small strains.

    With N instead of D as the third base vector G_a3 = 0, and the energies of stretching and shear are separate, so
    that the energy remains positive if a fraction of the shear is removed (`shear`). With D, whose angle to N is h / R,
    thin shells were unstable at rest.
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
        # Volume of a layer relative to the area of the triangle.
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
    """The same for a density that depends on the state only through the five strains. It is derived in two steps: first
    stress dW/dg and moduli d2W/dg2, which do not contain test functions, then the derivatives of the strains.

    In one step ffcx would generate five times as many operations for the tangent.
    """
    stress = diff(density, metric.variables)
    along = derivative(metric.strains, state, TestFunction(space))
    change = derivative(metric.strains, state, TrialFunction(space))
    tangent = dot(dot(diff(stress, metric.variables), change), along) + dot(stress, derivative(along, state, TrialFunction(space)))
    return density * measure, dot(stress, along) * measure, tangent * measure


def every_form(plane_stress, mu, finite=True, squared_thickness=None):
    """The objects that ffcx compiles: energy, residual, tangent, gauge_energy, gauge_residual, gauge_tangent,
    orientation, and lists of them.

    plane_stress(metric) is the energy density with S^33 = 0. squared_thickness(metric), for laws that are defined for
    J <= 0, is positive unless the wall is turned inside out.
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
    # This is the J of a shell: it is negative where bending has inverted a layer. The law itself ensures a positive
    # thickness.
    names["orientation"] = dot(cross(*g), D + turn) / dot(cross(*G), D)
    if squared_thickness is not None:
        names["orientation"] *= conditional(gt(squared_thickness(metric), 0), 1, -1)
    names["expressions"] = [(names["orientation"], RULE["quadrature_points"])]
    return names
