"""Networks: of the zoo, written down in Python, or PyTorch's."""

from __future__ import annotations

import io
import json
import os
import warnings
from typing import Any, Iterable, Mapping

from . import _taxel
from ._settings import text
from ._taxel import Flow

__all__ = ["Flow", "Graph", "Network", "cost", "from_torch", "zoo"]


def zoo() -> list[dict[str, Any]]:
    """Every network of the zoo: name, family, paper, inputs (name, shape), parameters, bytes, macs, flops.

    >>> import taxel
    >>> next(own for own in taxel.zoo() if own["name"] == "resnet8-lite-1d")["parameters"]
    13923
    """
    return json.loads(_taxel.zoo())


def cost(network: str | Graph | os.PathLike[str], **settings: Any) -> dict[str, Any]:
    """What a network costs for one sample, layer by layer (`layers`) and in `total`: parameters, bytes, macs, flops,
    activation_bytes.

    `network` is a name of the zoo with its `settings` (`classes=28`), a :class:`Graph`, or a file (`.onnx`,
    `.safetensors`).
    """
    if isinstance(network, (str, os.PathLike)):
        name = os.fspath(network)
        if name.endswith((".onnx", ".safetensors")):
            if settings:
                raise TypeError("settings are for networks of the zoo; a file has none")
            network = Graph.open(name)
        else:
            network = Graph.zoo(name, **settings)
    elif settings:
        raise TypeError("settings are for networks of the zoo; a Graph has none")
    return network.cost()


class Graph:
    """A network as a value: what :meth:`Network.finish`, :func:`from_torch` and :meth:`Graph.open` give and
    :class:`taxel.Classifier` trains. It does not change once it is made."""

    def __init__(self, native: Any) -> None:
        self._native = native

    @classmethod
    def zoo(cls, name: str, **settings: Any) -> Graph:
        """A network of the zoo; `settings` in place of the paper's (`classes=28, length=100`)."""
        return cls(_taxel.Graph.zoo(name, text(settings)))

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Graph:
        """A network from an `.onnx`, or from a `.safetensors` that :meth:`save`, `taxel import` or a training wrote."""
        return cls(_taxel.Graph.open(os.fspath(path)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes network and weights (fresh ones where it has none) as a `.safetensors`, which a config names by
        `[[networks]] file = ".."`."""
        self._native.save(os.fspath(path))

    @property
    def name(self) -> str:
        """Name in tables and cards."""
        return self._native.name

    @property
    def inputs(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the inputs by name, batch axis left out: `signal`, `image` or `tensor`."""
        return {name: tuple(shape) for name, shape in self._native.inputs}

    @property
    def outputs(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the outputs by name."""
        return {name: tuple(shape) for name, shape in self._native.outputs}

    @property
    def has_weights(self) -> bool:
        """Whether it has weights that training starts from."""
        return self._native.has_weights

    @property
    def notes(self) -> list[str]:
        """What :func:`from_torch` left out or renamed; nothing is told of a network that was opened."""
        return self._native.notes

    def cost(self) -> dict[str, Any]:
        """As :func:`taxel.cost`."""
        return json.loads(self._native.costs())

    def _to_bytes(self) -> bytes:
        return self._native.to_bytes()

    @classmethod
    def _from_bytes(cls, data: bytes, weights: bool) -> Graph:
        return cls(_taxel.Graph.from_bytes(data, weights))

    def __reduce__(self) -> tuple[Any, tuple[bytes, bool]]:
        return (Graph._from_bytes, (self._to_bytes(), self.has_weights))

    def __copy__(self) -> Graph:
        return self

    def __deepcopy__(self, memo: Any) -> Graph:
        return self

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Graph):
            return NotImplemented
        return self.has_weights == other.has_weights and self._to_bytes() == other._to_bytes()

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return repr(self._native)


class Network:
    """A network under construction; a step that does not fit is a `ValueError` that names it.

    >>> import taxel
    >>> net = taxel.Network("own")
    >>> x = net.input("signal", (5, 50)).conv_bn_relu("stem", 32, 5, padding="same").max_pool(2)
    >>> x.shape
    [32, 25]
    >>> net.finish(x.global_average_pool().linear("fc", 3))
    <taxel.Graph own: signal: channels 5 × length 50, 995 parameters>

    Axes are PyTorch's, batch left out: `signal` [channels, length], `image` [channels, rows, columns], `tensor`
    [channels, rows, columns, frames]. The last layer gets as many outputs as there are classes when it is trained.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self._native = _taxel.Builder(name)

    def input(self, name: str, shape: Iterable[int]) -> Flow:
        """An input: `signal`, `image` or `tensor`, and the shape of one sample of it."""
        return self._native.input(name, list(shape))

    def concat(self, name: str, flows: Iterable[Flow]) -> Flow:
        """Flows joined along channels (or features)."""
        return self._native.concat(name, list(flows))

    def finish(self, outputs: Flow | Mapping[str, Flow]) -> Graph:
        """The network that has these outputs: one, called `logits`, or several by name."""
        named = {"logits": outputs} if isinstance(outputs, Flow) else outputs
        if not isinstance(named, Mapping):
            raise TypeError(f"outputs are a Flow, or flows by name, not {type(outputs).__name__}")
        return Graph(self._native.finish(list(named.items())))


def from_torch(module: Any, example: Any, name: str | None = None) -> Graph:
    """A PyTorch module, by way of ONNX: its network and its weights, to train on, judge and ship.

    `example` is one batch of what the module reads, such as `torch.zeros(1, 5, 50)`: [1, channels, length] becomes
    `signal`, [1, channels, rows, columns] `image`. An operation that taxel does not have is refused by its node. Needs
    torch.
    """
    import torch

    example = tuple(example) if isinstance(example, (tuple, list)) else (example,)
    training, file = module.training, io.BytesIO()
    module.eval()
    try:
        with torch.no_grad(), warnings.catch_warnings():
            # The older exporter needs nothing beside torch; it says that there is a newer one.
            warnings.simplefilter("ignore", DeprecationWarning)
            # PRESERVE keeps batch norms that EVAL folds into the layer before: they are to be trained.
            preserve = torch.onnx.TrainingMode.PRESERVE
            torch.onnx.export(module, example, file, dynamo=False, training=preserve, do_constant_folding=False)
    finally:
        module.train(training)
    return Graph(_taxel.Graph.from_onnx(file.getvalue(), name or type(module).__name__.lower()))
