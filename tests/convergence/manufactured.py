"""A manufactured solution for the neo-Hookean law (8): its load, and errors with respect to it.

The load is the weak form of the exact stress, L(v) = int P(I + grad u*) : grad v. For test functions that vanish on the
boundary this is the work of the body force -Div P, so that the divergence need not be written.

Near the plane z = 1/2 the gradient of the solution is H, or H + a e_z^T in a region above the plane: with the jump a of
layers.hpp both sides have the same traction there.
"""

from element_table import SOLIDS
from mechanics import I, domain, space_of
from ufl import (
    Coefficient, Constant, SpatialCoordinate, TestFunction, TestFunctions, as_matrix, as_vector, cos, det, dx, grad, inner, inv, ln, sin, split,
)

mu, lmbda = Constant(domain), Constant(domain)
a0, a1, a2 = Constant(domain), Constant(domain), Constant(domain)  # zero outside of the region

X = SpatialCoordinate(domain)
s = X[2] - 0.5
H = as_matrix(((0.06, 0.15, -0.10), (0.05, -0.04, 0.12), (0.03, -0.04, 0.02)))  # also in the test
exact = H * X + s * as_vector((a0, a1, a2)) + 0.3 * s**2 * as_vector((
    sin(X[0] + 0.5 * X[1]),
    cos(0.5 * X[0] + X[2]) + 0.5 * X[0] * X[1],
    sin(X[1]) - 0.5 * X[0] ** 2,
))

F_exact = I + grad(exact)
# Stress by hand, so that the residual under test is not compared with itself.
P_exact = mu * (F_exact - inv(F_exact).T) + lmbda * ln(det(F_exact)) * inv(F_exact).T

# Far finer than the elements' own rules, so that only their error is measured.
measure = dx(metadata={"quadrature_degree": 8})


def distance(u):
    e = u - exact
    return inner(e, e) * measure, inner(grad(e), grad(e)) * measure


def load(v):
    return inner(P_exact, grad(v)) * measure


# es-p1-p1 has the space of p1-p1.
P1, P2, TAYLOR_HOOD, P1_P1 = (space_of(e) for e in SOLIDS if not e.edge_smoothed)
p1_L2, p1_H1 = distance(Coefficient(P1))
p2_L2, p2_H1 = distance(Coefficient(P2))
th_L2, th_H1 = distance(split(Coefficient(TAYLOR_HOOD))[0])
p1p1_L2, p1p1_H1 = distance(split(Coefficient(P1_P1))[0])
p1_load, p2_load = load(TestFunction(P1)), load(TestFunction(P2))
th_load, p1p1_load = load(TestFunctions(TAYLOR_HOOD)[0]), load(TestFunctions(P1_P1)[0])

forms = [p1_L2, p1_H1, p1_load, p2_L2, p2_H1, p2_load, th_L2, th_H1, th_load, p1p1_L2, p1p1_H1, p1p1_load]
