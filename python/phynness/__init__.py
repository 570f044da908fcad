"""Forces and deformations of trained soft bodies: models and organs, and the command phynness for solving and training.

Units are SI. A force is the force that must be applied to hold a displacement; a haptic device renders its negative. Nodes have
the numbers of the mesh. Arguments called d are displacements, one of shape (3,) or n of shape (n, 3), float64 in C order without
a copy. Every function may be called by several threads; one call at a time is evaluated.
"""
from ._phynness import (
    Error, Held, IncompleteWarning, Model, NearWarning, Organ, OutsideWarning, RelaxationWarning, StatusWarning, SurfacePoint,
    Touched, UnsettledWarning, __version__,
)
from .command import Page, Solution, precompute, save, show, solve, train, validate

__all__ = [
    "Error", "Held", "IncompleteWarning", "Model", "NearWarning", "Organ", "OutsideWarning", "Page",
    "RelaxationWarning", "Solution", "StatusWarning", "SurfacePoint", "Touched", "UnsettledWarning", "precompute", "show", "solve",
    "train", "validate",
]

setattr(Model, "show", show)
setattr(Model, "save", save)


def __dir__():
    return sorted(__all__)
