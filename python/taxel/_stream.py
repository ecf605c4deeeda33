"""A model on a stream of readings: decisions as they come."""

from __future__ import annotations

from typing import Any, Iterable, Iterator, NamedTuple

import numpy as np

from . import _taxel
from ._arrays import readings
from ._model import Model


class Decision(NamedTuple):
    """What a model says about a window of readings."""

    #: Number of the window's last reading, from 0.
    reading: int
    #: The likeliest class; of several attributes one each. Of a model of values the value, or one per quantity.
    answer: Any
    #: Probabilities [outputs], in the order of `Model.classes`; None of a model of values.
    probabilities: np.ndarray | None
    #: Readings of the window that were there, and of a full one.
    known: int
    ticks: int
    #: Channels (or taxels) by position that are dead, stuck, or were at full scale within the window.
    dead: list[int]
    stuck: list[int]
    saturated: list[int]
    #: How familiar the window is to the model, 0.01..1; None of a model that does not know.
    familiarity: float | None = None
    #: Whether it is at most as familiar as `unknown`: unlike all that the model has learned.
    unknown: bool = False
    #: Of a model of values these, by the names of their quantities; else None.
    values: dict[str, float] | None = None
    #: The ends of their intervals by the same names; None where the stream was asked for none.
    interval: dict[str, tuple[float, float]] | None = None

    @property
    def early(self) -> bool:
        """Whether the window was not full."""
        return self.known < self.ticks


class Stream:
    """Answers the readings of one sensor as they come, window by window.

    Parameters
    ----------
    model : taxel.Model, or a fitted estimator
    hop : int, optional
        Readings from one window to the next; by default a quarter of a window.
    contact : bool
        Whether windows begin with contact.
    before : int, optional
        Readings of a window before contact.
    early : float, optional
        The probability at which a window is decided before it is full, from `least` readings on.
    full_scale : float, optional
        The largest possible reading, by default what the model's card says.
    unknown : float
        The familiarity up to which a window is unknown: of familiar windows such a share is. By default 0, none.
    interval : float, optional
        Share of windows whose intervals are to hold the true values: 0.8, 0.9, 0.95 or 0.99. By default no intervals. Only
        of a model that has them, see :meth:`Model.predict_interval`.
    tare : int, optional
        First readings that are at rest, whose mean is taken off: for a model whose training had resting values taken off. By
        default as many as there, or 10 where these came in an array.

    >>> stream = taxel.Stream(model, early=0.95)        # doctest: +SKIP
    >>> for decision in stream.feed(sensor):            # doctest: +SKIP
    ...     print(decision.reading, decision.answer)
    """

    def __init__(
        self,
        model: Model | Any,
        *,
        hop: int | None = None,
        contact: bool = False,
        before: int | None = None,
        early: float | None = None,
        least: int | None = None,
        full_scale: float | None = None,
        unknown: float = 0.0,
        interval: float | None = None,
        tare: int | None = None,
    ) -> None:
        self.model: Model = getattr(model, "model_", model)
        if not isinstance(self.model, Model):
            raise TypeError(f"a stream asks a taxel.Model or a fitted estimator, not {type(model).__name__}")
        self._native = _taxel.Stream(self.model._native, hop, contact, before, early, least, full_scale, unknown, interval, tare)
        self._names = list(self.model.attributes.values())
        self._quantities = self.model.quantities

    @property
    def values(self) -> int:
        """Values of one reading: channels, or taxels row by row."""
        return self._native.sizes[0]

    @property
    def window(self) -> int:
        """Readings of a full window."""
        return self._native.sizes[1]

    @property
    def hop(self) -> int:
        """Readings from one window to the next."""
        return self._native.sizes[2]

    @property
    def contacts(self) -> int:
        """How often contact began."""
        return self._native.contacts

    def push(self, reading: Any) -> Decision | None:
        """Hears one reading [values]; what is decided with it, if anything is.

        A window that the model's encoding refuses (one in which it finds no contact) is passed over.
        """
        own = readings(reading).reshape(-1)
        said = self._native.push(own)
        if said is None or "refused" in said:
            return None
        probabilities, ends, at = said.pop("probabilities"), said.pop("intervals"), 0
        answers: list[Any] = []
        if self._quantities:
            answers = [float(value) for value in probabilities]
            said["values"] = dict(zip(self._quantities, answers))
            said["interval"] = {name: (low, high) for name, (low, high) in zip(self._quantities, ends)} if ends else None
            probabilities = None
        for names in self._names:
            answers.append(names[int(probabilities[at : at + len(names)].argmax())])
            at += len(names)
        answer = answers[0] if len(answers) == 1 else tuple(answers)
        return Decision(answer=answer, probabilities=probabilities, **said)

    def feed(self, source: Iterable[Any]) -> Iterator[Decision]:
        """Decisions of readings as they come, from anything that can be gone through: an array [readings, values], a queue."""
        for reading in source:
            decision = self.push(reading)
            if decision is not None:
                yield decision

    def begin(self) -> None:
        """Another recording begins: nothing of the last one counts."""
        self._native.begin()

    def anew(self) -> None:
        """Readings are missing: the window begins anew. The level at rest and the history of the channels stay."""
        self._native.anew()

    def tare(self) -> bool:
        """Takes the level at rest anew, from the next readings; until then nothing is decided.

        False for a model that reads what the sensor gives.
        """
        return self._native.tare()
