"""A model on a stream of readings."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import taxel

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def test_windows_have_the_answers_of_predict(mlp, grasps):
    stream = taxel.Stream(mlp, hop=10)
    assert (stream.values, stream.window, stream.hop) == (5, 50, 10)
    readings = np.concatenate(grasps.x[:4], axis=1).T
    decisions = list(stream.feed(readings))
    assert [own.reading for own in decisions] == list(range(49, 200, 10))
    for own in decisions:
        window = readings[own.reading - 49 : own.reading + 1].T[None]
        assert (own.probabilities == mlp.model_.predict_proba(window)[0]).all()
        assert own.answer == mlp.model_.predict(window)[0] and not own.early
    stream.begin()
    assert [own.reading for own in stream.feed(readings[:60])] == [49, 59]


def test_early_decisions_and_broken_channels(mlp, grasps):
    sure = taxel.Stream(mlp, early=0.01, least=5, hop=50)
    first = next(sure.feed(grasps.x[0].T))
    assert first.early and first.known == 5
    readings = np.concatenate(grasps.x[:3], axis=1).T.copy()
    readings[:, 2] = 1023
    assert 2 in list(taxel.Stream(mlp, full_scale=1023).feed(readings))[-1].stuck


def test_what_a_stream_refuses(mlp):
    stream = taxel.Stream(mlp)
    with pytest.raises(ValueError, match="a reading has 5 values; this one has 4"):
        stream.push([1, 2, 3, 4])
    with pytest.raises(ValueError, match="not finite"):
        stream.push([1, 2, 3, 4, np.nan])
    with pytest.raises(ValueError, match="hop"):
        taxel.Stream(mlp, hop=0)
    with pytest.raises(ValueError, match="early"):
        taxel.Stream(mlp, early=2)
    with pytest.raises(TypeError, match="Model"):
        taxel.Stream("model.safetensors")


def test_the_example_node(mlp, grasps, tmp_path):
    mlp.save(tmp_path / "own.safetensors")
    lines = "\n".join(",".join(map(str, row)) for row in np.concatenate(grasps.x[:3], axis=1).T)
    done = subprocess.run(
        [sys.executable, EXAMPLES / "node.py", tmp_path / "own.safetensors", "--hop", "50"],
        input=lines, capture_output=True, text=True,
    )
    assert done.returncode == 0, done.stderr
    answers = [line.split()[1] for line in done.stdout.splitlines()]
    assert answers == list(mlp.model_.predict(grasps.x[:3]))
