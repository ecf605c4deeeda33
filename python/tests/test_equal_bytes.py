"""Python and the command line: the same bytes, both ways."""

import json

import numpy as np
import pytest

import taxel

CONFIG = """
name = "own"
seed = {seed}
baselines = ["mini-rocket"]
[data]
path = "recordings.npz"
[train]
epochs = 4
batch_size = 16
[[networks]]
name = "{network}"
{encoding}
"""
GADF = '[encoding]\nimage = { kind = "gadf" }'


@pytest.mark.parametrize("network, encoding", [("resnet8-lite-1d", ""), ("mlp", ""), ("vgg6-lite-2d", GADF)])
def test_fit(network, encoding, grasps, command, tmp_path):
    labels = grasps._native.y()
    if encoding:
        grasps, labels = grasps.select(range(20)), labels[:20]
    np.savez(tmp_path / "recordings.npz", x=grasps.x, y=labels)
    (tmp_path / "own.toml").write_text(CONFIG.format(seed=3, network=network, encoding=encoding))
    command("fit", "own.toml", "--network", network, "--output", "cli.safetensors", "--threads", 1, cwd=tmp_path)
    own = taxel.Classifier(network, recipe={"epochs": 4, "batch_size": 16}, random_state=3)
    own.fit(grasps.x, labels).save(tmp_path / "python.safetensors")
    assert (tmp_path / "python.safetensors").read_bytes() == (tmp_path / "cli.safetensors").read_bytes()


def test_fit_of_mini_rocket(grasps, command, tmp_path):
    grasps.save(tmp_path / "recordings.npz")
    # Python keeps groups apart where there are some.
    by_group = '[protocol]\nsplit = "group"'
    (tmp_path / "own.toml").write_text(CONFIG.format(seed=0, network="mlp", encoding=by_group))
    command("fit", "own.toml", "--network", "mini-rocket", "--output", "cli.safetensors", cwd=tmp_path)
    data = taxel.read(tmp_path / "recordings.npz")
    assert data.digest == taxel.Dataset(grasps.x, grasps.y, groups=grasps.groups).digest
    taxel.MiniRocket().fit(data).save(tmp_path / "python.safetensors")
    assert (tmp_path / "python.safetensors").read_bytes() == (tmp_path / "cli.safetensors").read_bytes()


def test_predict_of_a_model_from_python(mlp, grasps, command, tmp_path):
    mlp.save(tmp_path / "own.safetensors")
    np.savez(tmp_path / "new.npz", x=grasps.x)
    command("predict", "own.safetensors", "new.npz", "--format", "npz", "--output", "said.npz", cwd=tmp_path)
    said = np.load(tmp_path / "said.npz")
    numbers, probabilities = mlp.model_.answer(grasps.x)
    assert (said["probabilities"] == probabilities).all() and said["probabilities"].dtype == probabilities.dtype
    assert (said["predicted"] == numbers).all()
    assert json.loads(command("inspect", tmp_path / "own.safetensors", "--format", "json")) == mlp.model_.card


def test_a_run_from_python_goes_on_in_the_command_line(grasps, command, tmp_path):
    out = tmp_path / "run"
    own = taxel.cross_validate(
        "mlp", grasps.x, grasps.y, recipe={"epochs": 2}, protocol=2, baselines=["k-nn"], out=out, name="mine"
    )
    config = (out / "config.toml").read_text()
    again = tmp_path / "again"
    (tmp_path / "own.toml").write_text(config)
    command("run", tmp_path / "own.toml", "--output", again)
    for name in ("results.json", "metrics.jsonl", "predictions.npz"):
        assert (again / name).read_bytes() == (out / name).read_bytes(), name
    models = sorted(own.name for own in (out / "models").iterdir())
    assert models and models == sorted(own.name for own in (again / "models").iterdir())
    for name in models:
        assert (again / "models" / name).read_bytes() == (out / "models" / name).read_bytes(), name
    command("fit", out, "--network", "mlp", "--output", tmp_path / "mlp.safetensors")
    assert taxel.load(tmp_path / "mlp.safetensors").card["score"]["folds"] == 2
    assert own.scores()["mlp"]["accuracy"] >= 0
