"""Trained models that answer."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from . import _taxel
from ._arrays import matched, readings
from ._dataset import Dataset, of


def load(path: str | os.PathLike[str]) -> Model:
    """A model file that `taxel fit`, a run folder or :meth:`Model.save` wrote: one file that needs nothing beside it."""
    return Model(_taxel.Model.open(os.fspath(path)))


class Model:
    """A trained network or baseline, with everything that turns raw readings into answers.

    >>> import taxel
    >>> model = taxel.load("model.safetensors")         # doctest: +SKIP
    >>> model.predict(x)                                # doctest: +SKIP
    array(['shore-00', 'shore-20'], dtype='<U8')
    """

    def __init__(self, native: Any) -> None:
        self._native = native
        self._card: dict[str, Any] | None = None

    @property
    def card(self) -> dict[str, Any]:
        """What the model says about itself: network, reading, inputs, classes, what it was trained on, its score."""
        if self._card is None:
            self._card = json.loads(self._native.card())
        return self._card

    @property
    def name(self) -> str:
        """Name of the network or baseline."""
        return self.card["name"]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one raw sample."""
        return tuple(self.card["reading"]["shape"])

    @property
    def attributes(self) -> dict[str, list[str]]:
        """What it answers, by name: one attribute called `class`, or several."""
        task = self.card["task"]
        if "attributes" in task:
            return {own["name"]: own["classes"] for own in task["attributes"]}
        return {"class": task["classes"]} if "classes" in task else {}

    @property
    def quantities(self) -> list[str]:
        """Names of the values that it answers; none of a model of classes."""
        return [quantity["name"] for quantity in self.card["task"].get("quantities", [])]

    @property
    def units(self) -> list[str | None]:
        """Units of the values that it answers, None where the data set said none; none of a model of classes."""
        return [quantity.get("unit") for quantity in self.card["task"].get("quantities", [])]

    @property
    def classes(self) -> list[str]:
        """Names of the columns of :meth:`predict_proba`; of several attributes `attribute:level`."""
        several = len(self.attributes) > 1
        return [f"{name}:{own}" if several else own for name, classes in self.attributes.items() for own in classes]

    def answer(self, x: Any, *, threads: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the likeliest classes [samples] ([samples, attributes] of several) and probabilities
        [samples, outputs], of raw samples `x` [samples, ..] of the shape that the card states. Of a model of values no
        numbers, and the values [samples, quantities].

        A float32 array is read where it lies; answers depend neither on threads nor on their neighbours. The columns of a
        data frame are found by the names that the model knows; others are left out.
        """
        x = self._readings(x)
        numbers, probabilities = self._native.predict(x, threads)
        several = len(self.attributes)
        return (numbers.reshape(-1, several) if several > 1 else numbers), probabilities

    def predict(self, x: Any, *, threads: int | None = None) -> np.ndarray:
        """Names of the likeliest classes [samples] ([samples, attributes] of several attributes).

        A model of values answers these: [samples], or [samples, quantities].
        """
        numbers, outputs = self.answer(x, threads=threads)
        if self.quantities:
            return outputs[:, 0] if len(self.quantities) == 1 else outputs
        names = [np.array(classes) for classes in self.attributes.values()]
        if len(names) == 1:
            return names[0][numbers]
        return np.stack([own[numbers[:, at]] for at, own in enumerate(names)], axis=1)

    def predict_proba(self, x: Any, *, threads: int | None = None) -> np.ndarray:
        """Probabilities [samples, outputs], float32, in the order of :attr:`classes`; not of a model of values."""
        if self.quantities:
            raise ValueError(f"{self.name} answers values ({', '.join(self.quantities)}), which have no probabilities: use predict")
        return self.answer(x, threads=threads)[1]

    def predict_interval(self, x: Any, share: float = 0.9, *, threads: int | None = None) -> np.ndarray:
        """The ends of an interval around each value [samples, 2], or [samples, quantities, 2], float32.

        The interval holds the true value in `share` of cases: 0.8, 0.9, 0.95 or 0.99. `card["intervals"]` says what it covered
        on held-out samples. A model has intervals if it was fitted from a run folder with 30 held-out predictions or more
        (`taxel fit RUN`); ridge and MiniRocket have them wherever they are fitted.
        """
        ends = self._native.intervals(self._readings(x), float(share), threads)
        return ends[:, 0] if len(self.quantities) == 1 else ends

    def predict_set(self, x: Any, share: float = 0.9, *, threads: int | None = None) -> np.ndarray:
        """Which classes are in the set of each sample [samples, outputs], bool, in the order of :attr:`classes`.

        The set holds the true class in `share` of cases: 0.8, 0.9, 0.95 or 0.99. `card["certainty"]["sets"]` says what it covered
        on held-out samples. Only a calibrated model has sets.
        """
        probabilities = self.predict_proba(x, threads=threads)
        sets = np.zeros(probabilities.shape, dtype=bool)
        for row, outputs in zip(sets, self._native.sets(probabilities, float(share))):
            row[outputs] = True
        return sets

    def novelty(self, x: Any, *, threads: int | None = None) -> np.ndarray:
        """How unlike each sample is what the model has learned [samples], 0..0.99: 1 less its familiarity.

        Of samples like those of the training 5 % are at 0.95 or above. Only a calibrated model of classes knows, and a model of
        values that has intervals.
        """
        x = self._readings(x)
        familiarity = self._native.familiarity(x, threads)
        if familiarity is None:
            raise ValueError(
                f"{self.name} does not know what is familiar: fit it from a run folder (taxel fit RUN), or calibrate it on own recordings"
            )
        return 1 - familiarity

    def calibrated(self, data: Any, y: Any = None, *, groups: Any = None) -> Model:
        """The same model, as sure as it is right on labelled samples that it has not learned from; a model of values has intervals
        that are fitted to them. Nothing is trained.

        `data` is a :class:`taxel.Dataset`, or samples [samples, ..] with labels `y` [samples] of 30 or more, best of other objects,
        sessions or people than those of the training.
        """
        reading = self.card["reading"]
        task = "values" if self.quantities else "classes"
        facts = {"task": task, "groups": groups, "name": "calibration"}
        if not isinstance(data, Dataset):
            quantities = list(zip(self.quantities, self.units)) or None
            facts |= {"quantities": quantities, "layout": reading["layout"], "full_scale": reading.get("full_scale")}
        return Model(self._native.calibrated(of(data, y, facts)._native))

    def _readings(self, x: Any) -> np.ndarray:
        return readings(matched(x, self.card["reading"].get("channel_names", []), strict=False))

    def latency(self, x: Any = None, *, seconds: float = 1.0) -> dict[str, Any]:
        """How long one answer takes on one thread of this machine, measured for about so many `seconds`.

        `encoding`, `network` and `whole` each hold `p50_ms`, `p95_ms` and `runs`; `samples_per_second` is of batches of
        `batch`. `x` [samples, ..] are the samples to ask about, by default a ramp over the whole range.
        """
        if x is None:
            full = self.card["reading"].get("full_scale") or 1.0
            x = np.linspace(0, full, num=int(np.prod(self.shape)), dtype=np.float32).reshape(1, *self.shape)
        return json.loads(self._native.latency(readings(x), float(seconds)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the model as one `.safetensors`, whole or not at all; the command line and :func:`taxel.load` read it."""
        path = os.fspath(path)
        if not path.endswith(".safetensors"):
            raise ValueError(f"{path}: a model is a .safetensors file")
        self._native.save(path)

    def export(self, path: str | os.PathLike[str]) -> None:
        """Writes the model as ONNX, its scaling included; not of baselines."""
        self._native.export(os.fspath(path))

    def to_bytes(self) -> bytes:
        """The bytes of the model's file."""
        return self._native.to_bytes()

    @classmethod
    def from_bytes(cls, data: bytes) -> Model:
        """The model whose file has these bytes."""
        return cls(_taxel.Model.from_bytes(data))

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        return (Model.from_bytes, (self.to_bytes(),))

    def __str__(self) -> str:
        return str(self._native)

    def __repr__(self) -> str:
        shape = "×".join(map(str, self.shape))
        return f"<taxel.Model {self.name}: {self.card['reading']['layout']} {shape}, {len(self.classes or self.quantities)} outputs>"
