"""Settings and seeds as the library takes them."""

from __future__ import annotations

import json
import numbers
import os
from typing import Any, Mapping

import numpy as np


def seed_of(random_state: Any) -> int:
    """A seed: a whole number, or 0 where nobody says one."""
    if random_state is None:
        return 0
    if hasattr(random_state, "randint"):
        return int(random_state.randint(2**31 - 1))
    if isinstance(random_state, bool) or not isinstance(random_state, numbers.Integral):
        raise TypeError(f"a seed is a whole number, not {random_state!r}")
    seed = int(random_state)
    if not 0 <= seed < 2**63:
        raise ValueError(f"seed = {seed}: must be in 0..={2**63 - 1}")
    return seed


def text(config: Mapping[str, Any]) -> str:
    """Settings as JSON; NumPy's numbers are numbers."""
    try:
        return json.dumps(config, allow_nan=False, default=_plain)
    except ValueError as error:
        raise ValueError(f"a setting is NaN or infinite: {error}") from None


def _plain(value: Any) -> Any:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{value!r} is no value of a setting: numbers, texts, lists and dictionaries are")
