"""The function space of the shell for the installed version of UFL; dolfinx_api.hpp builds the same space."""

from ufl import FunctionSpace, Mesh

try:
    from basix.ufl import element as _element, mixed_element as _mixed

    _plane = _element("Lagrange", "triangle", 1, shape=(3,))
    _displacement = _element("Lagrange", "triangle", 2, shape=(3,))
    _director = _element("CR", "triangle", 1, shape=(3,))
except ImportError:
    from ufl import Cell, MixedElement, VectorElement

    _triangle = Cell("triangle", geometric_dimension=3)
    _plane = VectorElement("Lagrange", _triangle, 1, dim=3)
    _displacement = VectorElement("Lagrange", _triangle, 2, dim=3)
    _director = VectorElement("CR", _triangle, 1, dim=3)

    def _mixed(elements):
        return MixedElement(*elements)


# Flat triangles in space.
domain = Mesh(_plane)

# Quadratic displacements, and directors at the middles of edges (Crouzeix-Raviart).
space = FunctionSpace(domain, _mixed([_displacement, _director]))
