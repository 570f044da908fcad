"""Forces and deformations of trained soft bodies: models, databases and training.

Units are SI. A force is the force that must be applied to hold a displacement; a haptic device renders its negative. Nodes have
the numbers of the mesh. Arguments called d are displacements, one of shape (3,) or n of shape (n, 3), float64 without a copy in
any layout. Every function may be called by several threads at the same time; large arrays are evaluated without the GIL.
"""
from typing import TYPE_CHECKING, Any

from ._phynness import (
    Coupled, Column, Database, Error, IncompleteWarning, Level, Model, OutsideWarning, Scene, StatusWarning, SurfacePoint,
    UnsettledWarning, __version__, train, train_forces,
)
from .command import Page, Solution, precompute, show, solve, validate

if TYPE_CHECKING:
    from .estimator import ConservativeForce

__all__ = [
    "ConservativeForce", "Coupled", "Column", "Database", "Error", "IncompleteWarning", "Level", "Model", "OutsideWarning", "Page",
    "Scene", "Solution", "StatusWarning", "SurfacePoint", "UnsettledWarning", "__version__", "precompute", "show", "solve",
    "train", "train_forces", "validate",
]

setattr(Model, "show", show)


def __getattr__(name: str) -> Any:
    # Where scikit-learn is installed, its import takes longer than all others.
    if name == "ConservativeForce":
        from .estimator import ConservativeForce

        return ConservativeForce
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
