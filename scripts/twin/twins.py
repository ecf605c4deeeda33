"""The description of a PyTorch twin, which stands beside the twin itself in `networks.py` or `image_networks.py`."""

from collections.abc import Callable
from dataclasses import dataclass, field

# Axes of an input by the settings that size them, batch left out.
SIGNAL = ("in_channels", "length")
IMAGE = ("in_channels", "height", "width")
TENSOR = ("in_channels", "height", "width", "frames")

# How far float32 may be from float64, relative, where it is more than tests/support/twin.rs allows: rounding
# grows with the depth, and decides which of two close values wins a pool and on which side of a corner one lies.
DEEP = dict(values=1e-4, gradients=1e-2)
DEEPER = dict(values=1e-4, gradients=5e-2)


@dataclass(frozen=True)
class Twin:
    """A network: how it is built, what it reads, and what `scripts/fixtures/network_twins.py` writes of it."""

    # Makes the module of settings; those that size inputs come along.
    make: Callable
    # The published settings.
    published: dict
    # The axes of each input: settings, or numbers.
    inputs: list
    # Settings of each fixture, beside the published ones.
    cases: list = field(default_factory=lambda: [{}])
    # Dropout modules, and taxel's names of their nodes.
    dropouts: dict = field(default_factory=dict)
    # Learning rate of the fixtures' SGDM steps.
    rate: float = 0.01
    # Tolerance by the settings of a case; none is the usual one.
    tolerance: Callable = lambda settings: None
    # Hundreds of tensors: norm and projections of each are enough.
    is_brief: bool = False

    def build(self, settings):
        return self.make(**{**self.published, **settings})

    def input_shapes(self, settings):
        sizes = {**self.published, **settings}
        return [tuple(axis if isinstance(axis, int) else sizes[axis] for axis in axes) for axes in self.inputs]
