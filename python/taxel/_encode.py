"""Readings to images."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from . import _taxel
from ._arrays import readings
from ._settings import text


def gadf(
    x: Any,
    size: int = 50,
    *,
    range: tuple[float, float] | None = None,
    colormap: Literal["jet", "viridis", "grey"] = "jet",
    constant: Literal["error", "zero"] = "error",
    summation: bool = False,
) -> np.ndarray:
    """Coloured Gramian angular fields of series.

    Parameters
    ----------
    x : array [samples, channels, time]
        Readings; the channels of a sample are put one behind the other.
    size : int
        Rows and columns of the image.
    range : (low, high), optional
        Readings that become -1 and 1, in the unit of `x`. By default each sample's own: amplitude is lost.
    colormap : str
        `jet` and `viridis` have three colours, `grey` one.
    constant : str
        What a constant sample gives without a `range`: an error, or `zero`.
    summation : bool
        The summation field in place of the difference field.

    Returns
    -------
    float32 [samples, colours, size, size], values 0 to 1: bit for bit what `encoding.image.kind = "gadf"` gives networks.
    """
    x = readings(x)
    if x.ndim != 3:
        raise ValueError(f"series are [samples, channels, time]; these have shape {x.shape}")
    settings: dict[str, Any] = {"size": size, "colormap": colormap, "constant": constant}
    if range is not None:
        low, high = range
        settings["range"] = {"low": float(low), "high": float(high)}
    return _taxel.gadf(x, text(settings), summation)
