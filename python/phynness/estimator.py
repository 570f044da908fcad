"""An estimator in the conventions of scikit-learn, which need not be installed."""
from __future__ import annotations

import inspect
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._phynness import Model, train_forces

try:
    from sklearn.base import BaseEstimator, RegressorMixin  # type: ignore[import]
except ImportError:

    class BaseEstimator:  # type: ignore[no-redef]
        """What of scikit-learn is needed without it."""

        def get_params(self, deep: bool = True) -> dict[str, Any]:
            return {name: getattr(self, name) for name in inspect.signature(type(self)).parameters}

        def set_params(self, **params: Any) -> BaseEstimator:
            for name, value in params.items():
                if name not in self.get_params():
                    raise ValueError(f"{type(self).__name__} has no parameter {name}")
                setattr(self, name, value)
            return self

    class RegressorMixin:  # type: ignore[no-redef]
        pass


class ConservativeForce(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Forces of one place as the gradient of a stored energy (train_forces).

    centers: largest number of centers, at most half of the displacements. model_: the trained Model.

    >>> d = np.random.default_rng(1).normal(size=(60, 3)) * 0.003
    >>> fitted = phynness.ConservativeForce(centers=20).fit(d, 30 * d)
    >>> bool(np.allclose(fitted.predict([[0, 0, 0.001]]), [[0, 0, 0.03]], atol=1e-5))
    True
    """

    model_: Model

    def __init__(self, centers: int = 80, title: str = "") -> None:
        self.centers = centers
        self.title = title

    def fit(self, displacements: ArrayLike, forces: ArrayLike, energies: ArrayLike | None = None) -> ConservativeForce:
        """displacements, forces: (n, 3) [m], [N]; energies: (n,) [J] or None."""
        self.model_ = train_forces(displacements, forces, energies, centers=self.centers, title=self.title)
        return self

    def predict(self, displacements: ArrayLike) -> NDArray[np.float64]:
        """Forces (n, 3) [N]."""
        return self.model_.force(0, displacements)

    def save(self, path: str | PathLike[str]) -> None:
        """Writes a model.txt."""
        self.model_.save(path)
