"""From arguments to the tables of a config."""

from __future__ import annotations

import json
import os
import tempfile
from typing import Any, Mapping

import numpy as np

from ._network import Graph


class Networks:
    """Entries of `[[networks]]`; a network that is a value becomes a file in `folder`, or in one that is gone after it."""

    def __init__(self, folder: str | None = None) -> None:
        self._folder = folder
        self._temporary: tempfile.TemporaryDirectory[str] | None = None

    def __enter__(self) -> Networks:
        return self

    def __exit__(self, *error: Any) -> None:
        if self._temporary is not None:
            self._temporary.cleanup()

    def entry(self, network: Any, settings: Mapping[str, Any] | None, recipe: Mapping[str, Any] | None) -> dict[str, Any]:
        """A network of the zoo by name, or one that is a value."""
        train = {} if recipe is None else {"train": dict(recipe)}
        if isinstance(network, str):
            return {"name": network, "set": dict(settings or {}), **train}
        if not isinstance(network, Graph):
            raise TypeError(f"network is a name of taxel.zoo() or a taxel.Graph, not {type(network).__name__}")
        if settings:
            raise TypeError("settings are for networks of the zoo; a Graph has none")
        path = os.path.join(self._place(), f"{file_name(network.name)}.safetensors")
        if not os.path.exists(path):
            network.save(path)
        elif not _holds(path, network):
            # Another run may read it, also one that was moved since.
            raise ValueError(f"{path}: holds another network of that name; give another folder or name, or remove it")
        return {"file": path, "name": network.name, "label": network.name, "fresh": not network.has_weights, **train}

    def _place(self) -> str:
        if self._folder is not None:
            os.makedirs(self._folder, exist_ok=True)
            return self._folder
        if self._temporary is None:
            self._temporary = tempfile.TemporaryDirectory(prefix="taxel-")
        return self._temporary.name


def _holds(path: str, network: Graph) -> bool:
    with open(path, "rb") as file:
        return file.read() == network._to_bytes()


def file_name(name: str) -> str:
    """A name as part of a file's."""
    return "".join(c if c.isascii() and c.isalnum() or c in "._-" else "-" for c in name)


def toml(value: Any) -> str:
    """A value as TOML writes it inside a line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(own)}" for key, own in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, (np.generic, np.ndarray)):
        return toml(value.tolist())
    if isinstance(value, (bool, str, int, float)):
        return json.dumps(value, ensure_ascii=False)
    raise TypeError(f"{value!r} is no value of a config: numbers, texts, lists and dictionaries are")
