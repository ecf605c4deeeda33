"""What goes wrong with tactile sensors: graded faults on raw readings."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from . import _taxel
from ._dataset import Dataset

__all__ = ["apply", "names", "table"]


def table() -> list[dict[str, Any]]:
    """Every fault: name, what happens, its five severities and their unit."""
    return json.loads(_taxel.faults())


def names() -> list[str]:
    """Names of the faults."""
    return [own["name"] for own in table()]


def apply(
    x: Any,
    fault: str,
    severity: int = 3,
    *,
    seed: int = 0,
    layout: str | None = None,
    full_scale: float | None = None,
    rest: Any = None,
) -> np.ndarray:
    """A copy of `x` [samples, ..] with every sample broken by one fault, as `taxel stress` breaks it.

    `severity` is 1 to 5 (:func:`table` has the units). What is broken depends on seed, fault and sample alone; severity 3
    breaks the channels that 2 breaks, and more. `full_scale` is the largest possible reading, `rest` what is read
    without contact; what nobody says is taken from `x`. `x` may be a :class:`taxel.Dataset`, which knows both.

    >>> import numpy, taxel
    >>> broken = taxel.faults.apply(numpy.full((1, 4, 6), 9, "float32"), "saturation", 5, full_scale=10, rest=0)
    >>> float(broken.max())
    3.0
    """
    if isinstance(x, Dataset):
        own = x
        if layout is not None or full_scale is not None or rest is not None:
            raise TypeError("a Dataset knows layout, full_scale and rest already; leave them out")
    else:
        x = np.asarray(x)
        # Faults ask for no labels.
        own = Dataset(x, np.zeros(len(x) if x.ndim else 0, int), layout=layout, full_scale=full_scale, rest=rest)
    if isinstance(severity, bool) or not isinstance(severity, (int, np.integer)):
        raise TypeError(f"severity is a whole number from 1 to 5, not {severity!r}")
    if not 0 <= severity <= 255:
        raise ValueError(f"severity = {severity}: must be in 1..=5")
    return _taxel.break_samples(own._native, fault, int(severity), seed)
