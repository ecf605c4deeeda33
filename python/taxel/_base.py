"""What an estimator needs of scikit-learn, or the little of it that does without."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np

try:
    from sklearn.base import BaseEstimator, ClassifierMixin, RegressorMixin
    from sklearn.exceptions import NotFittedError
except ImportError:

    class NotFittedError(ValueError, AttributeError):  # type: ignore[no-redef]
        """An estimator is asked before it was fitted."""

    class BaseEstimator:  # type: ignore[no-redef]
        """Parameters by name, as of scikit-learn's class of that name."""

        def get_params(self, deep: bool = True) -> dict[str, Any]:
            """Parameters by name."""
            return {name: getattr(self, name) for name in list(inspect.signature(type(self)).parameters)}

        def set_params(self, **params: Any) -> Any:
            """Other values of some parameters."""
            known = self.get_params()
            for name, value in params.items():
                if name not in known:
                    raise ValueError(f"Invalid parameter {name!r} for {type(self).__name__}; it has {sorted(known)}")
                setattr(self, name, value)
            return self

        def __repr__(self) -> str:
            defaults = inspect.signature(type(self)).parameters
            own = [f"{k}={v!r}" for k, v in self.get_params().items() if v is not defaults[k].default]
            return f"{type(self).__name__}({', '.join(own)})"

    class ClassifierMixin:  # type: ignore[no-redef]
        """Accuracy as the score, as of scikit-learn's class of that name."""

        def score(self, X: Any, y: Any, sample_weight: Any = None) -> float:
            """Share of the samples that are answered right."""
            return float(np.average(self.predict(X) == np.asarray(y), weights=sample_weight))  # type: ignore[attr-defined]

    class RegressorMixin:  # type: ignore[no-redef]
        """R² as the score, as of scikit-learn's class of that name."""

        def score(self, X: Any, y: Any, sample_weight: Any = None) -> float:
            """R², of several quantities their mean; 1 is right, 0 as good as the mean of `y`."""
            y = np.asarray(y, dtype=np.float64)
            y = y.reshape(len(y), -1)
            missed = y - np.asarray(self.predict(X), dtype=np.float64).reshape(y.shape)  # type: ignore[attr-defined]
            spread = y - np.average(y, axis=0, weights=sample_weight)
            missed, spread = (np.average(own**2, axis=0, weights=sample_weight) for own in (missed, spread))
            # Of equal true values scikit-learn says 1 where they are met, else 0.
            shares = np.where(spread > 0, 1 - missed / np.where(spread > 0, spread, 1), missed == 0)
            return float(shares.mean())


__all__ = ["BaseEstimator", "ClassifierMixin", "NotFittedError", "RegressorMixin"]
