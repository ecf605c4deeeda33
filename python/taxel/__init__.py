"""taxel, the tactile model zoo: train, compare and ship networks on recordings of touch.

    import taxel

    grasps = taxel.simulate("fingertip", 300, seed=0)          # or arrays of your own, or taxel.read("recordings.npz")
    model = taxel.Classifier("resnet8-lite-1d").fit(grasps.x, grasps.y)
    model.predict(grasps.x[:3])
    model.save("hardness.safetensors")                         # `taxel predict hardness.safetensors press.csv`
    taxel.load("hardness.safetensors").predict(grasps.x[:3])

Classes have :class:`Classifier` and :class:`MiniRocket`; values, such as a force, :class:`Regressor` and
:class:`MiniRocketRegressor`.

Arrays are `[samples, ..]`, float32 is read where it lies. The axes of a sample are its layout: `features` [values],
`series` [channels, time], `image` [rows, columns], `colour` [3, rows, columns], `sequence` [frames, rows, columns],
`fingers` [fingers, channels, time]. Settings (recipe, encoding, protocol) are dictionaries with the keys of taxel's
config files.

Equal data, settings and seed give equal bytes, from Python and from the command line, on any number of threads.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import faults
from ._dataset import Dataset, effects, read, scenes, simulate
from ._encode import gadf
from ._model import Model, load
from ._network import Flow, Graph, Network, cost, from_torch, zoo
from ._run import Report, Run, cross_validate, report, run
from ._stream import Decision, Stream
from ._taxel import VERSION as __version__

if TYPE_CHECKING:
    from ._estimators import Classifier, MiniRocket, MiniRocketRegressor, Regressor

__all__ = [
    "Classifier",
    "Dataset",
    "Decision",
    "Flow",
    "Graph",
    "MiniRocket",
    "MiniRocketRegressor",
    "Model",
    "Network",
    "Regressor",
    "Report",
    "Run",
    "Stream",
    "__version__",
    "cost",
    "cross_validate",
    "effects",
    "faults",
    "from_torch",
    "gadf",
    "load",
    "read",
    "report",
    "run",
    "scenes",
    "simulate",
    "zoo",
]


def __getattr__(name: str) -> Any:
    # Estimators bring scikit-learn, a second of imports that `load` and `predict` do without.
    if name in ("Classifier", "MiniRocket", "MiniRocketRegressor", "Regressor"):
        from . import _estimators

        return getattr(_estimators, name)
    raise AttributeError(f"module 'taxel' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
