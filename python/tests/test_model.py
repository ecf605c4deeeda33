"""Models: answers, card, latency, files, pickles."""

import copy
import pickle

import numpy as np
import pytest

import taxel


def test_answers_and_card(mlp, grasps, tmp_path):
    path = tmp_path / "own.safetensors"
    mlp.save(path)
    model = taxel.load(path)
    probabilities = model.predict_proba(grasps.x)
    assert probabilities.shape == (60, 3) and probabilities.dtype == np.float32
    assert np.allclose(probabilities.sum(axis=1), 1, atol=1e-5)
    assert model.classes == ["shore-00", "shore-10", "shore-20"]
    assert (model.predict(grasps.x) == np.array(model.classes)[probabilities.argmax(axis=1)]).all()
    assert model.card["name"] == "mlp" and model.card["trained_on"]["samples"] == 60
    assert model.shape == (5, 50) and "mlp" in str(model)


def test_answers_do_not_depend_on_how_they_are_asked(mlp, grasps):
    model = mlp.model_
    all_at_once = model.predict_proba(grasps.x)
    one_by_one = np.concatenate([model.predict_proba(grasps.x[i : i + 1], threads=1) for i in range(60)])
    assert (all_at_once == one_by_one).all()
    assert (model.predict_proba(grasps.x.astype(float)) == all_at_once).all()
    turned = np.asfortranarray(grasps.x)
    assert not turned.flags.c_contiguous
    assert (model.predict_proba(turned) == all_at_once).all()
    assert (model.predict_proba(np.repeat(grasps.x, 2, axis=0)[::2]) == all_at_once).all()
    read_only = grasps.x.copy()
    read_only.flags.writeable = False
    assert (model.predict_proba(read_only) == all_at_once).all()


def test_many_samples_are_answered_piece_by_piece(mlp, grasps):
    # More than stand encoded at a time.
    many = np.tile(grasps.x, (400, 1, 1))
    want = np.tile(mlp.model_.predict_proba(grasps.x), (400, 1))
    assert (mlp.model_.predict_proba(many) == want).all()
    many[20_000, 3, 7] = np.nan
    with pytest.raises(ValueError, match="sample 20000"):
        mlp.model_.predict(many)


def test_pickles_and_copies_are_the_model(mlp, grasps):
    model = mlp.model_
    for own in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model)):
        assert own.to_bytes() == model.to_bytes()
        assert (own.predict_proba(grasps.x) == model.predict_proba(grasps.x)).all()


def test_latency(mlp, grasps):
    own = mlp.model_.latency(seconds=0.05)
    assert 0 < own["whole"]["p50_ms"] <= own["whole"]["p95_ms"]
    assert own["samples_per_second"] > 0
    assert mlp.model_.latency(grasps.x, seconds=0.05)["network"]["runs"] >= 5


def test_what_a_model_refuses(mlp, grasps, tmp_path):
    model = mlp.model_
    with pytest.raises(FileNotFoundError, match="missing.safetensors"):
        taxel.load(tmp_path / "missing.safetensors")
    broken = tmp_path / "broken.safetensors"
    broken.write_bytes(model.to_bytes()[:-7])
    with pytest.raises(ValueError, match="broken.safetensors"):
        taxel.load(broken)
    changed = model.to_bytes().replace(b'\\"seed\\":0', b'\\"seed\\":1', 1)
    with pytest.raises(ValueError, match="digests differ"):
        taxel.Model.from_bytes(changed)
    with pytest.raises(ValueError, match=r"mlp reads samples of shape \[5, 50\].*these have \[5, 49\]"):
        model.predict(grasps.x[:, :, :49])
    with pytest.raises(ValueError, match="there are none"):
        model.predict(grasps.x[:0])
    with pytest.raises(ValueError, match="not one number"):
        model.predict(3.0)
    with pytest.raises(ValueError, match="inhomogeneous"):
        model.predict([[[1.0, 2.0], [3.0]]])
    with pytest.raises((TypeError, ValueError), match="readings are numbers"):
        model.predict([["a", "b"]])
    with pytest.raises(ValueError, match="there are none|these have"):
        model.predict(np.zeros((0,), np.float32))
    with pytest.raises(ValueError, match=".safetensors"):
        model.save(tmp_path / "own.bin")
    with pytest.raises(OSError):
        model.save(tmp_path / "nowhere" / "own.safetensors")


def test_models_as_onnx(mlp, tmp_path):
    mlp.model_.export(tmp_path / "own.onnx")
    graph = taxel.Graph.open(tmp_path / "own.onnx")
    assert graph.outputs["logits"] == (3,)
    rocket = taxel.MiniRocket(84).fit(np.random.default_rng(0).normal(size=(12, 1, 20)), [0, 1] * 6)
    rocket.model_.export(tmp_path / "rocket.onnx")
    assert b"taxel.classes" in (tmp_path / "rocket.onnx").read_bytes()
