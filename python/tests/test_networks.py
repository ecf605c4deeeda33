"""Networks from elsewhere: ONNX files, PyTorch."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

import taxel

ONNX = Path(__file__).resolve().parents[2] / "crates/onnx/tests/data"


def test_a_network_that_pytorch_exported():
    graph = taxel.Graph.open(ONNX / "cnn1d.script.onnx")
    assert graph.has_weights and graph.name == "cnn1d.script"
    (shape,) = graph.inputs.values()
    x = np.random.default_rng(0).normal(size=(12, *shape))
    own = taxel.Classifier(graph, recipe={"epochs": 1}).fit(x, [0, 1, 2] * 4)
    assert own.predict_proba(x).shape == (12, 3)
    assert json.dumps(graph.cost())
    with pytest.raises(FileNotFoundError, match="missing.onnx"):
        taxel.Graph.open("missing.onnx")
    with pytest.raises(ValueError, match="no ONNX model"):
        taxel._taxel.Graph.from_onnx(b"no", "own")


@pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="needs torch")
def test_a_module_of_pytorch():
    import torch
    from torch import nn

    torch.manual_seed(0)
    module = nn.Sequential(
        nn.Conv1d(5, 8, 3, padding=1), nn.BatchNorm1d(8), nn.ReLU(), nn.AdaptiveAvgPool1d(1), nn.Flatten(), nn.Linear(8, 3)
    )
    module.train()
    graph = taxel.from_torch(module, torch.zeros(1, 5, 50), "own")
    assert module.training and graph.name == "own" and graph.inputs == {"signal": (5, 50)}
    assert graph.cost()["total"]["parameters"] == sum(own.numel() for own in module.parameters())
    x = taxel.simulate("fingertip", 30)
    own = taxel.Classifier(graph, recipe={"epochs": 1}).fit(x)
    assert own.predict_proba(x.x).shape == (30, 3)
    with pytest.raises(ValueError, match="node"):
        taxel.from_torch(nn.Sequential(nn.Flatten(), nn.Linear(250, 4), nn.Softplus()), torch.zeros(1, 5, 50))
