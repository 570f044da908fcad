"""Function spaces of all elements for the installed version of UFL.

Since UFL 2023.2 (dolfinx 0.7) elements are defined by basix, before by UFL. dolfinx_api.hpp builds the same spaces.
"""

from ufl import FunctionSpace, Mesh, tetrahedron

try:
    from basix.ufl import element as _element, mixed_element as _mixed
except ImportError:
    from ufl import FiniteElement, MixedElement as _MixedElement, TensorElement, VectorElement

    def _scalar(degree):
        return FiniteElement("Lagrange", tetrahedron, degree)

    def _vector(degree):
        return VectorElement("Lagrange", tetrahedron, degree)

    def _mixed(elements):
        return _MixedElement(*elements)

    _tensor = TensorElement("DG", tetrahedron, 0)
else:

    def _scalar(degree):
        return _element("Lagrange", "tetrahedron", degree)

    def _vector(degree):
        return _element("Lagrange", "tetrahedron", degree, shape=(3,))

    _tensor = _element("DG", "tetrahedron", 0, shape=(3, 3))


# Affine tetrahedra.
domain = Mesh(_vector(1))


def displacement_space(degree):
    return FunctionSpace(domain, _vector(degree))


def mixed_space(displacement_degree, pressure_degree):
    return FunctionSpace(domain, _mixed([_vector(displacement_degree), _scalar(pressure_degree)]))


def gradient_space():
    """Constant 3 x 3 tensors, row by row."""
    return FunctionSpace(domain, _tensor)
