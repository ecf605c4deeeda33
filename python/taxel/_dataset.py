"""Labelled samples: arrays of your own, recordings on disk, simulated worlds."""

from __future__ import annotations

import json
import os
from typing import Any, Mapping, Sequence

import numpy as np

from . import _taxel
from ._arrays import is_values, labels, layout_of, names_of, quantities_of, readings, refuse_empty, values
from ._settings import seed_of, text


class Dataset:
    """Labelled samples with what is known of them.

    Parameters
    ----------
    x : array [samples, ..]
        Readings in their own unit; nothing is scaled. Copied once, into the data set.
    y : array [samples] or [samples, quantities]
        The class of each sample, or its values, such as a force. Texts, integers, and floats [samples] that are all whole
        numbers are classes. Floats [samples] that are not all whole, and floats [samples, quantities] of two or more, are
        values. `task` and `quantities` say otherwise. Estimators do not guess: classifiers take whole numbers and texts
        as classes and refuse other floats; regressors take all numbers as values.
    task : str, optional
        `"values"` or `"classes"`, where the type of `y` does not say it.
    quantities : sequence of str or of (str, str), optional
        Names of the values, or pairs of name and unit: `[("force", "N")]`. A known unit at the end of a name is taken as its
        unit: `["force_N"]`. `y` that has them is values. By default `y`, of several `y-0`, `y-1`.
    layout : str, optional
        What the axes of a sample are. By their number: `features`, `series`, `sequence`; say `image`, `colour` or
        `fingers`.
    groups : array [samples], optional
        Object, session or day of each sample: what a fair split keeps together.
    official : array of bool [samples], optional
        The samples that the data set's authors test on, for `protocol={"kind": "official"}`.
    channels : sequence of str, optional
        Names of the channels, or of the features. By default those of the columns of a data frame.
    name : str
        Goes on the card of what is trained on it.
    unit, rate, full_scale, rest : optional
        Unit of the readings, readings per second (Hz), the largest possible reading, readings without contact (one
        for all, or one per channel).
    source : str, optional
        `"simulated: .."` or `"real: .."`; by default real, by its name.
    """

    def __init__(
        self,
        x: Any,
        y: Any,
        *,
        task: str | None = None,
        quantities: Sequence[str | tuple[str, str | None]] | None = None,
        layout: str | None = None,
        groups: Any = None,
        official: Any = None,
        channels: Sequence[str] | None = None,
        name: str = "recordings",
        unit: str | None = None,
        rate: float | None = None,
        full_scale: float | None = None,
        rest: Any = None,
        source: str | None = None,
    ) -> None:
        # Before the labels: an array of the wrong axes is the more likely mistake.
        channels = names_of(x) if channels is None else [str(own) for own in channels]
        x = readings(x)
        layout = layout_of(x, layout)
        refuse_empty(x)
        own = values(y, len(x)) if is_values(y, task, quantities) else None
        classes, names = labels(y, len(x)) if own is None else (np.array([], dtype=str), [])
        facts = {
            "name": str(name),
            "layout": layout,
            "labels": names,
            "quantities": [] if own is None else quantities_of(quantities, own.shape[1]),
            "groups": None if groups is None else [str(own) for own in np.asarray(groups).tolist()],
            "official": None if official is None else [bool(own) for own in np.asarray(official).tolist()],
            "channels": channels,
            "unit": unit,
            "rate": rate,
            "full_scale": full_scale,
            "rest": None if rest is None else np.atleast_1d(np.asarray(rest, dtype=np.float32)).tolist(),
            "source": source,
        }
        self._fill(_taxel.Dataset.of_arrays(x, facts, own))
        self.classes: np.ndarray = classes
        if own is None:
            self._y = np.array(y).reshape(len(x))

    def _fill(self, native: Any) -> None:
        self._native = native
        self._x: np.ndarray | None = None
        self._y: np.ndarray | None = None
        #: The `[data]` table that makes these samples again; none of samples in memory.
        self._data: dict[str, Any] | None = None
        self._seed: int | None = None
        self._facts: dict[str, Any] = json.loads(native.facts())
        #: True physical values [samples] by name, of simulated samples.
        self.truth: dict[str, np.ndarray] = {}
        #: The classes, sorted; none of values.
        self.classes = np.array(self._facts["classes"])

    @classmethod
    def _of(cls, native: Any) -> Dataset:
        own = cls.__new__(cls)
        own._fill(native)
        return own

    @property
    def x(self) -> np.ndarray:
        """Readings [samples, ..], float32."""
        if self._x is None:
            self._x = self._native.x()
        return self._x

    @property
    def y(self) -> np.ndarray:
        """The class of each sample [samples]; of values these, float32 [samples], or [samples, quantities]."""
        if self._y is None:
            own = self._native.values()
            if own is None:
                self._y = self.classes[self._native.y()]
            else:
                self._y = own[:, 0] if own.shape[1] == 1 else own
        return self._y

    @property
    def task(self) -> str:
        """What the targets are: `classes` or `values`."""
        return "values" if self._facts["quantities"] else "classes"

    @property
    def quantities(self) -> list[str]:
        """Names of the values; none of classes."""
        return [own["name"] for own in self._facts["quantities"]]

    @property
    def units(self) -> list[str | None]:
        """Units of the values, None where nobody says one; none of classes."""
        return [own.get("unit") for own in self._facts["quantities"]]

    @property
    def groups(self) -> np.ndarray | None:
        """The group of each sample [samples] by its number, if there are groups."""
        return self._native.groups()

    @property
    def origins(self) -> list[str]:
        """Where each sample comes from: its file, `x[17]`, or `fingertip[17]`."""
        return self._native.origins()

    @property
    def name(self) -> str:
        """Name of the data set."""
        return self._facts["name"]

    @property
    def source(self) -> str:
        """`simulated: ..` or `real: ..`: stands beside every score."""
        return self._facts["source"]

    @property
    def digest(self) -> str:
        """BLAKE3 of shape, values, labels and groups."""
        return self._facts["digest"]

    @property
    def reading(self) -> dict[str, Any]:
        """What one sample is: layout, shape, and where it is known unit, rate (Hz), full_scale, rest."""
        return self._facts["reading"]

    @property
    def channels(self) -> list[str]:
        """Names of the channels, in their order; empty where nobody names them."""
        return list(self.reading.get("channel_names", []))

    @property
    def layout(self) -> str:
        """What the axes of a sample are."""
        return self.reading["layout"]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one sample."""
        return tuple(self.reading["shape"])

    def select(self, rows: Any) -> Dataset:
        """The samples `rows` (positions, or a mask), in that order."""
        rows = np.asarray(rows)
        if rows.dtype == bool:
            rows = np.flatnonzero(rows)
        rows = [int(own) for own in rows]
        own = Dataset._of(self._native.select(rows))
        own.classes = self.classes
        # The library may number classes in another order: by value where their names are numbers.
        own._y = self.y[rows]
        own.truth = {name: true[rows] for name, true in self.truth.items()}
        return own

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes an `.npz` (x, y, group) and, beside it, `<name>.classes.json` with what is known: `taxel run --data`
        and :func:`taxel.read` read both, to the same digest."""
        self._native.save(os.fspath(path))

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        shape = "×".join(map(str, self.shape))
        named = [name if unit is None else f"{name} ({unit})" for name, unit in zip(self.quantities, self.units)]
        said = f"values of {', '.join(named)}" if named else f"{len(self.classes)} classes"
        return f"<taxel.Dataset {self.source}: {len(self)} samples, {self.layout} {shape}, {said}>"


def read(path: str | os.PathLike[str], **options: Any) -> Dataset:
    """Recordings on disk: `.npz`, `.mat`, `.h5`, a folder with one sub-folder per class, CSV or Parquet tables, UCR
    folders, ROS 2 bags, LeRobot sets.

    `options` are the keys of the table `[data]` of a config file, such as `channels=[0, 1]`,
    `length={"kind": "resample", "to": 300}`, `layout="image"`, `full_scale=1023`; `y=["force_N", "depth_mm"]` and
    `task="values"` for targets that are values.

    >>> import taxel
    >>> taxel.read("missing.npz")
    Traceback (most recent call last):
    ...
    FileNotFoundError: missing.npz: no such file or folder; ...
    """
    if options.get("attributes"):
        raise ValueError("attributes: a Dataset has one label for each sample; attribute=N picks one, taxel.run takes several")
    data = {"path": os.path.abspath(os.fspath(path)), **options}
    config = {"name": "read", "data": {**data, "path": os.fspath(path)}, "networks": []}
    own = Dataset._of(_taxel.Dataset.read(text(config)))
    own._data = data
    return own


def simulate(
    scene: str,
    n: int = 1500,
    seed: int = 0,
    *,
    without: str | Sequence[str] = (),
    **settings: Any,
) -> Dataset:
    """`n` recordings of a simulated world, with true physical values in `.truth`.

    `scene` is one of :func:`taxel.scenes`; `without` leaves effects out (:func:`taxel.effects` lists them); `settings` are
    the scene's own, such as `shore=[0, 10, 20]` of `fingertip`. Sample i is the same however many are asked for.

    >>> import taxel
    >>> taxel.simulate("fingertip", 30, seed=7, without="noise")
    <taxel.Dataset simulated: fingertip without noise: 30 samples, series 5×50, 3 classes>
    """
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)):
        raise TypeError(f"n is a whole number, not {n!r}")
    n, seed = int(n), seed_of(seed)
    without = [without] if isinstance(without, str) else list(without)
    native, truth = _taxel.Dataset.simulate(scene, n, seed, without, text(settings))
    own = Dataset._of(native)
    own.truth = truth
    own._data = {"scene": scene, "samples": n, "without": without, "set": settings}
    own._seed = seed
    return own


def scenes() -> list[str]:
    """Names of the simulated worlds."""
    return _taxel.scenes()


def effects(scene: str) -> list[dict[str, Any]]:
    """Every effect of a simulated world: name, parameter, value, unit, source, why, removable."""
    return json.loads(_taxel.explain(scene))


def of(x: Any, y: Any, facts: Mapping[str, Any]) -> Dataset:
    """`x` itself where it is a data set, or one made of arrays; a task among the facts is what it has to pose."""
    if isinstance(x, Dataset):
        facts = dict(facts)
        task = facts.pop("task", None)
        if task not in (None, x.task):
            words = {
                "classes": f"the targets are values ({', '.join(x.quantities)}), and classes are needed; taxel.Regressor learns values",
                "values": "the targets are classes, and values are needed: taxel.Dataset(x, y, task='values') makes numbers values",
            }
            raise ValueError(words.get(task, f"task is 'classes' or 'values', not {task!r}"))
        if y is not None:
            raise TypeError("a Dataset has its labels already; leave y out")
        given = sorted(key for key, value in facts.items() if value is not None and key != "name")
        if given:
            raise TypeError(f"a Dataset knows {', '.join(given)} already; leave them out")
        return x
    return Dataset(x, y, **facts)
