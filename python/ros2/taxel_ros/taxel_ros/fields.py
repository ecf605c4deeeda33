"""The numbers of a message, by the path of a field."""

from __future__ import annotations

import re
from typing import Any, Callable, Iterator

#: Fields that hold no reading, whatever their type.
LEFT_OUT = {"header", "stamp", "layout"}
#: `data`, `data[3]`, `data[0:5]`.
STEP = re.compile(r"([A-Za-z_]\w*)((?:\[\d*(?::\d*)?\])*)$")
PART = re.compile(r"\[(\d*)(:?)(\d*)\]")

Path = list[Callable[[Any], Any]]


class FieldError(ValueError):
    """A message without the numbers that were asked for."""


def path(field: str) -> Path:
    """The steps from a message to a field: `wrench.force`, `effort`, `data[0:5]`. No step for an empty text."""
    steps: Path = []
    for word in field.strip().split(".") if field.strip() else []:
        found = STEP.match(word)
        if not found:
            raise FieldError(f"field {field!r}: {word!r} is no field; write wrench.force, effort or data[0:5]")
        steps.append(named(field, found[1]))
        for low, colon, high in PART.findall(found[2]):
            if not colon and not low:
                raise FieldError(f"field {field!r}: [] holds no place; write data[3] or data[0:5]")
            part: Any = slice(int(low or 0), int(high) if high else None) if colon else int(low)
            steps.append(indexed(field, part))
    return steps


def named(field: str, name: str) -> Callable[[Any], Any]:
    def step(value: Any) -> Any:
        if name not in fields_of(value):
            held = ", ".join(fields_of(value)) or "none"
            raise FieldError(f"field {field!r}: {type(value).__name__} has no field {name!r}; it has {held}")
        return getattr(value, name)

    return step


def indexed(field: str, part: Any) -> Callable[[Any], Any]:
    def step(value: Any) -> Any:
        try:
            return value[part]
        except (IndexError, TypeError) as error:
            raise FieldError(f"field {field!r}: {type(value).__name__} has no [{part}]") from error

    return step


def fields_of(value: Any) -> list[str]:
    """The fields of a message; none of anything else."""
    kinds = getattr(value, "get_fields_and_field_types", None)
    return list(kinds()) if kinds else []


def numbers(message: Any, steps: Path) -> list[float]:
    """All numbers below the field, in the order of the definition."""
    for step in steps:
        message = step(message)
    found = [float(value) for value in flat(message)]
    if not found:
        raise FieldError(f"{type(message).__name__} holds no numbers; name a field that does")
    return found


def flat(value: Any) -> Iterator[float]:
    if isinstance(value, (bool, int, float)):
        yield value
    elif isinstance(value, (str, bytes)):
        return
    elif fields_of(value):
        for name in fields_of(value):
            if name not in LEFT_OUT:
                yield from flat(getattr(value, name))
    elif hasattr(value, "__iter__"):
        for inner in value:
            # Numbers of NumPy know how to become Python's.
            yield from flat(inner.item() if hasattr(inner, "item") else inner)


def joints(message: Any, steps: Path) -> list[str]:
    """The names that stand beside the numbers, as in a JointState: a list `name` as long as they are."""
    for step in steps[:-1]:
        message = step(message)
    return [str(name) for name in getattr(message, "name", [])] if "name" in fields_of(message) else []


def stamp(message: Any) -> float | None:
    """The time of a message in seconds, of one that bears any."""
    time = getattr(getattr(message, "header", None), "stamp", None)
    seconds = None if time is None else time.sec + 1e-9 * time.nanosec
    return seconds or None
