"""Arrays as the library takes them: float32 readings, labels by name."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy as np

LAYOUTS = {2: "features", 3: "series", 4: "sequence"}
#: Fewest channels that look like time steps where each has four times fewer values.
LONG = 16


def names_of(x: Any) -> list[str] | None:
    """The names of the columns of a data frame; none of an array, and of a frame whose names are no texts."""
    columns = getattr(x, "columns", None)
    if columns is None or not (hasattr(x, "iloc") or hasattr(x, "select")):
        return None
    names = list(columns)
    texts = [isinstance(name, str) for name in names]
    if any(texts) and not all(texts):
        raise TypeError("Feature names are only supported if all input features have string names; make them all texts")
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"two columns are named {twice!r}; rename one")
    return [str(name) for name in names] if names and all(texts) else None


def matched(x: Any, wanted: list[str], *, strict: bool) -> Any:
    """A data frame with its columns in the order of the `wanted` names, and `x` itself where it has no names.

    Missing names are refused, and where `strict` others too, in scikit-learn's words.
    """
    held = names_of(x)
    if held is None or not wanted or held == wanted:
        return x
    unseen = [name for name in held if name not in wanted] if strict else []
    missing = [name for name in wanted if name not in held]
    if unseen or missing:
        words = "The feature names should match those that were passed during fit.\n"
        for what, names in (("Feature names unseen at fit time", unseen), ("Feature names seen at fit time, yet now missing", missing)):
            if names:
                words += f"{what}:\n" + "".join(f"- {name}\n" for name in names[:5]) + ("- ...\n" if len(names) > 5 else "")
        raise ValueError(words)
    return x[wanted]


def refuse_masked(x: Any) -> None:
    """Refuses arrays whose mask would be dropped."""
    parts = x if isinstance(x, (list, tuple)) else [x]
    if any(np.ma.isMaskedArray(part) and np.ma.getmaskarray(part).any() for part in parts):
        raise ValueError("readings are a masked array, whose mask would be dropped; fill it, x.filled(0), or leave samples out")


def refuse_times(x: np.ndarray) -> None:
    """Refuses time stamps, which would be taken as numbers."""
    if x.dtype.kind in "mM":
        raise TypeError(f"readings are numbers, not times ({x.dtype}): leave the column of time stamps out and say rate")


def readings(x: Any) -> np.ndarray:
    """`x` as float32; an array that is float32 already is not copied."""
    refuse_masked(x)
    if hasattr(x, "toarray") and hasattr(x, "nnz"):
        raise TypeError("sparse readings are not supported; pass a dense array: x.toarray()")
    kinds = [getattr(kind, "kind", "") for kind in getattr(x, "dtypes", [])] if hasattr(x, "iloc") else []
    if "M" in kinds or "m" in kinds:
        raise TypeError("readings are numbers, not times: leave the column of time stamps out and say rate")
    x = np.asarray(x)
    refuse_times(x)
    if np.iscomplexobj(x):
        raise ValueError("Complex data not supported: readings are real numbers")
    try:
        with np.errstate(over="ignore"):
            own = x.astype(np.float32, copy=False)
    except (TypeError, ValueError) as error:
        raise type(error)(f"readings are numbers, in an array of one shape: {error}") from None
    if own.ndim == 0:
        raise ValueError("readings are an array [samples, ..], not one number")
    if own.dtype != x.dtype and not np.isfinite(own).all() and np.isfinite(x.astype(np.float64)).all():
        raise ValueError("a reading is larger than float32 holds, or infinity; bring the readings to another unit")
    return own


def layout_of(x: np.ndarray, layout: str | None) -> str:
    """What the axes of a sample are, where nobody says it: by their number."""
    if layout is not None:
        return layout
    if x.ndim not in LAYOUTS:
        raise ValueError(
            f"samples [n, ..] have 2 axes (features), 3 (series, or layout='image') or 4 (sequence, or "
            f"layout='colour' or 'fingers'), not {x.ndim}: the shape is {x.shape}. Reshape your data: one sample is "
            "x.reshape(1, ..), one channel x[:, None, :]"
        )
    if x.ndim == 3 and x.shape[1] >= LONG and x.shape[1] >= 4 * x.shape[2]:
        warnings.warn(
            f"samples are [n, channels, time]: these have {x.shape[1]} channels of {x.shape[2]} time steps. If they are "
            "[n, time, channels], as Keras has them, pass x.transpose(0, 2, 1); if not, say layout='series'",
            UserWarning,
            3,
        )
    return LAYOUTS[x.ndim]


def refuse_empty(x: np.ndarray) -> None:
    """Refuses no samples, and samples without values, in scikit-learn's words."""
    if 0 in x.shape:
        what = "sample(s)" if len(x) == 0 else "feature(s)"
        raise ValueError(f"Found array with 0 {what} (shape={x.shape}) while a minimum of 1 is required.")


def labels(y: Any, samples: int) -> tuple[np.ndarray, list[str]]:
    """The classes of labels in sorted order, and the name of each sample's class."""
    if y is None:
        raise ValueError("requires y to be passed, but the target y is None")
    y = np.asarray(y)
    if y.ndim == 2 and y.shape[1] == 1:
        # Scikit-learn's own kind where it is in use.
        known = sys.modules.get("sklearn.exceptions")
        kind = getattr(known, "DataConversionWarning", UserWarning)
        warnings.warn("A column-vector y was passed when a 1d array was expected; its one column is taken", kind, 3)
        y = y[:, 0]
    if y.ndim != 1:
        raise ValueError(f"y should be a 1d array, one label for each sample; it has shape {y.shape}")
    if len(y) != samples:
        raise ValueError(f"x has {samples} samples, y {len(y)} labels; give one label for each sample")
    if np.iscomplexobj(y):
        raise ValueError("Complex data not supported: labels are whole numbers or texts")
    if y.dtype.kind == "f":
        if not np.isfinite(y).all():
            raise ValueError("Input y contains NaN or infinity; give each sample its class")
        if (y != np.round(y)).any():
            raise ValueError("Unknown label type: continuous. Classes are whole numbers or texts; values are for taxel.Regressor")
    try:
        classes = np.unique(y)
    except TypeError:
        raise ValueError("Unknown label type: labels of different kinds cannot be sorted; make them all texts") from None
    names = [_name(own) for own in classes]
    if len(set(names)) < len(names):
        raise ValueError(f"two classes go by one name: {names}; make them all texts")
    by_class = dict(zip(classes.tolist(), names))
    return classes, [by_class[own] for own in y.tolist()]


def is_values(y: Any, task: str | None, quantities: Any) -> bool:
    """Checks whether targets are values, not classes; by their type where nobody says it."""
    if task not in (None, "classes", "values"):
        raise ValueError(f"task is 'classes' or 'values', not {task!r}")
    if quantities is not None and task == "classes":
        raise ValueError("quantities are names of values: leave them out of classes")
    if task is not None or quantities is not None:
        return task != "classes"
    y = np.asarray(y)
    if y.dtype.kind != "f":
        return False
    if y.ndim == 2 and y.shape[1] > 1:
        if len(y) and ((y == 0) | (y == 1)).all() and (y.sum(axis=1) == 1).all():
            raise ValueError("y is one-hot: pass classes, y.argmax(axis=1), or say task='values'")
        return True
    finite = y[np.isfinite(y)]
    return bool((finite != np.round(finite)).any())


def values(y: Any, samples: int) -> np.ndarray:
    """Returns targets that are values, as float32 [samples, quantities]."""
    if y is None:
        raise ValueError("requires y to be passed, but the target y is None")
    if np.ma.isMaskedArray(y) and np.ma.getmaskarray(y).any():
        raise ValueError("y is a masked array, whose mask would be dropped; leave samples without values out")
    y = np.asarray(y)
    if np.iscomplexobj(y):
        raise ValueError("Complex data not supported: values are real numbers")
    if y.dtype.kind not in "biufO":
        raise ValueError(f"Unknown label type: values are numbers, not {y.dtype}; classes are for taxel.Classifier")
    if y.ndim not in (1, 2) or 0 in y.shape[1:]:
        raise ValueError(f"y of values is [samples] or [samples, quantities]; it has shape {y.shape}")
    if len(y) != samples:
        raise ValueError(f"x has {samples} samples, y {len(y)} values; give each sample its own")
    try:
        exact = y.reshape(samples, -1).astype(np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"Unknown label type: values are numbers: {error}") from None
    if not np.isfinite(exact).all():
        raise ValueError("Input y contains NaN or infinity; leave samples without values out")
    with np.errstate(over="ignore"):
        own = exact.astype(np.float32)
    if not np.isfinite(own).all():
        raise ValueError("a value is larger than float32 holds; bring the values to another unit")
    return own


def quantities_of(named: Any, width: int) -> list[tuple[str, str | None]]:
    """Lists name and unit of each of `width` quantities; `y`, or `y-0`, `y-1`, where nobody names them."""
    if named is None:
        return [("y" if width == 1 else f"y-{at}", None) for at in range(width)]
    named = [named] if isinstance(named, str) else list(named)
    pairs: list[tuple[str, str | None]] = []
    for own in named:
        pair = (own, None) if isinstance(own, str) else tuple(own) if isinstance(own, (tuple, list)) else ()
        if len(pair) != 2 or not isinstance(pair[0], str) or not isinstance(pair[1], (str, type(None))):
            raise TypeError(f"a quantity is a name, or a pair of name and unit, not {own!r}")
        pairs.append((pair[0], pair[1]))
    if len(pairs) != width:
        raise ValueError(f"quantities is {len(pairs)} name{'s' * (len(pairs) != 1)}, and y has {width} column{'s' * (width != 1)}")
    return pairs


def weights_of(weights: Any, samples: int) -> list[float] | None:
    """Returns the weights of samples; none of equal ones, which change nothing."""
    if weights is None:
        return None
    own = np.asarray(weights, dtype=np.float64)
    if own.shape not in ((), (samples,)):
        raise ValueError(f"sample_weight is one number for each of {samples} samples; it has shape {own.shape}")
    if not np.isfinite(own).all() or (own < 0).any():
        raise ValueError("sample_weight holds a number that is negative, NaN or infinite")
    if not own.any():
        raise ValueError("sample_weight is zero for every sample")
    if not own.ndim or (own == own[0]).all():
        return None
    # Only ratios count, and float32 has no room for the largest numbers.
    return (own / own.max()).tolist()


def _name(label: Any) -> str:
    whole = isinstance(label, (float, np.floating)) and float(label).is_integer()
    return str(int(label)) if whole else str(label)


def order(classes: np.ndarray, named: list[str]) -> np.ndarray:
    """Where each of `classes` stands among the classes that a model names."""
    at = {name: i for i, name in enumerate(named)}
    return np.array([at[_name(own)] for own in classes])
