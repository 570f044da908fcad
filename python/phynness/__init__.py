"""Forces and deformations of trained soft bodies: models, bodies and training.

Units are SI. A force is the force that must be applied to hold a displacement; a haptic device renders its negative. Nodes have
the numbers of the mesh. Arguments called d are displacements, one of shape (3,) or n of shape (n, 3), float64 in C order without
a copy. Every function may be called by several threads; one call at a time is evaluated.
"""
from ._phynness import (
    Body, Coupled, Error, IncompleteWarning, Model, NearWarning, OutsideWarning, Pressed, StatusWarning, SurfacePoint,
    UnsettledWarning, __version__, train,
)
from .command import Page, Solution, precompute, show, solve, validate

__all__ = [
    "Body", "Coupled", "Error", "IncompleteWarning", "Model", "NearWarning", "OutsideWarning", "Page",
    "Pressed", "Solution", "StatusWarning", "SurfacePoint", "UnsettledWarning", "__version__", "precompute", "show",
    "solve", "train", "validate",
]

setattr(Model, "show", show)
