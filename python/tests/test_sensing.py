"""Simulated worlds, recordings, faults, fields, networks and their costs."""

import numpy as np
import pytest

import taxel


def test_simulated_worlds():
    own = taxel.simulate("fingertip", 12, seed=3, without=["noise", "placement"], shore=[0, 20])
    assert own.x.shape == (12, 5, 50) and own.x.dtype == np.float32
    assert set(own.y) == {"shore-00", "shore-20"} and own.groups.shape == (12,)
    assert all(values.shape == (12,) for values in own.truth.values()) and own.truth
    assert (taxel.simulate("fingertip", 30, seed=3).x[:12] == taxel.simulate("fingertip", 12, seed=3).x).all()
    assert "fingertip" in taxel.scenes() and any(own["removable"] for own in taxel.effects("fingertip"))
    for words, arguments in [
        ("fingertips", ("fingertips", 3)), ("samples", ("fingertip", 0)), ("fit into memory", ("fingertip", 10**13)),
    ]:
        with pytest.raises(ValueError, match=words):
            taxel.simulate(*arguments)
    with pytest.raises(ValueError, match="nois"):
        taxel.simulate("fingertip", 3, without="nois")
    with pytest.raises(ValueError, match="shores"):
        taxel.simulate("fingertip", 3, shores=[0])
    with pytest.raises(OverflowError):
        taxel.simulate("fingertip", -1)


def test_data_sets_come_back_equal(tmp_path, grasps):
    own = taxel.Dataset(
        grasps.x, grasps.y, groups=grasps.groups, unit="N", rate=100, full_scale=1023, name="own"
    )
    own.save(tmp_path / "own.npz")
    back = taxel.read(tmp_path / "own.npz")
    assert back.digest == own.digest and back.reading == own.reading and back.source == own.source
    assert (back.x == own.x).all() and (back.y == own.y).all() and (back.groups == own.groups).all()
    assert len(back.select(back.y == "shore-10")) == 20 and back.select([3, 1]).origins == ["x[3]", "x[1]"]
    with pytest.raises(IndexError):
        back.select([60])
    with pytest.raises(FileNotFoundError):
        taxel.read(tmp_path / "missing.npz")
    with pytest.raises(ValueError, match="chanels"):
        taxel.read(tmp_path / "own.npz", chanels=[0])
    with pytest.raises(ValueError, match="rate"):
        taxel.Dataset(grasps.x, grasps.y, rate=0)
    with pytest.raises(ValueError, match="groups"):
        taxel.Dataset(grasps.x, grasps.y, groups=[0])


def test_faults_are_those_of_the_command_line(command, grasps, tmp_path):
    command(
        "simulate", "fingertip", "--samples", 20, "--fault", "dead", "--severity", 4, "--output", "own.npz", cwd=tmp_path
    )
    own = taxel.simulate("fingertip", 20)
    assert (np.load(tmp_path / "own.npz")["x"] == taxel.faults.apply(own, "dead", 4)).all()
    assert (taxel.faults.apply(grasps.x, "noise", 2, seed=1) != grasps.x).any()
    assert taxel.faults.names()[:2] == ["noise", "quantisation"] and len(taxel.faults.names()) == 16
    assert len(taxel.faults.table()[0]["severities"]) == 5
    before = grasps.x.copy()
    taxel.faults.apply(grasps.x, "stuck", 5)
    assert (grasps.x == before).all()
    with pytest.raises(ValueError, match="there is no fault `ded`; did you mean `dead`"):
        taxel.faults.apply(grasps.x, "ded")
    with pytest.raises(ValueError, match="no meaning"):
        taxel.faults.apply(grasps.x, "shift")
    for severity in (0, 6, 900):
        with pytest.raises(ValueError, match="severity"):
            taxel.faults.apply(grasps.x, "dead", severity)
    with pytest.raises(TypeError, match="severity"):
        taxel.faults.apply(grasps.x, "dead", 2.5)


def test_fields_are_those_of_the_command_line(command, grasps, tmp_path):
    np.save(tmp_path / "own.npy", grasps.x)
    command("encode", "hardness-image", "--input", "own.npy", "--output", "fields.npy", cwd=tmp_path)
    assert (np.load(tmp_path / "fields.npy") == taxel.gadf(grasps.x)).all()
    assert taxel.gadf(grasps.x, 20, range=(0, 1023), colormap="grey", summation=True).shape == (60, 1, 20, 20)
    with pytest.raises(ValueError, match="sample 0"):
        taxel.gadf(np.zeros((1, 5, 50)))
    assert taxel.gadf(np.zeros((1, 5, 50)), constant="zero").std(axis=(2, 3)).max() < 1e-6
    for words, arguments in [("colormap", {"colormap": "red"}), ("low", {"range": (3, 1)}), ("size", {"size": 1}), ("size", {"size": 10**9})]:
        with pytest.raises(ValueError, match=words):
            taxel.gadf(grasps.x, **arguments)
    with pytest.raises(ValueError, match="series"):
        taxel.gadf(grasps.x[0])


def test_the_zoo_and_its_costs(tmp_path):
    names = [own["name"] for own in taxel.zoo()]
    assert "resnet8-lite-1d" in names and len(names) == len(set(names))
    own = taxel.cost("resnet8-lite-1d")
    assert (own["total"]["parameters"], own["total"]["macs"]) == (13_923, 204_928)
    assert taxel.cost("resnet8-lite-1d", classes=28)["total"]["parameters"] > 13_923
    taxel.Graph.zoo("mlp").save(tmp_path / "mlp.safetensors")
    assert taxel.cost(tmp_path / "mlp.safetensors")["layers"] == taxel.cost("mlp")["layers"]
    with pytest.raises(ValueError, match="did you mean"):
        taxel.cost("resnet8-lite-1")
    with pytest.raises(ValueError, match="clases"):
        taxel.cost("mlp", clases=3)
    with pytest.raises(FileNotFoundError):
        taxel.cost(tmp_path / "missing.onnx")


def test_a_data_set_does_not_change_with_the_arrays_it_was_made_of():
    x, y = np.arange(24, dtype=np.float32).reshape(4, 2, 3), np.array([0, 1, 0, 1])
    own = taxel.Dataset(x, y)
    x[0], y[0] = 99, 1
    assert (own.x == np.arange(24).reshape(4, 2, 3)).all() and own.y.tolist() == [0, 1, 0, 1]
    assert own.digest == taxel.Dataset(own.x, own.y).digest


@pytest.mark.parametrize("classes", [["10", "9"], [9, 10], ["b", "a"]], ids=str)
def test_a_selection_has_the_labels_of_its_samples(classes):
    y = np.array(classes)[[0, 1, 1, 0, 1]]
    own = taxel.Dataset(np.zeros((5, 1, 3)), y).select([4, 0, 2])
    assert own.y.tolist() == y[[4, 0, 2]].tolist() and own.y.dtype == y.dtype
    assert own.select([1]).y.tolist() == [y[0]]


def test_numbers_of_numpy_are_numbers(grasps, tmp_path):
    assert taxel.cost("mlp", classes=np.int64(7)) == taxel.cost("mlp", classes=7)
    assert (taxel.gadf(grasps.x, np.int64(20)) == taxel.gadf(grasps.x, 20)).all()
    own = taxel.simulate("fingertip", np.int32(6), np.int64(2), shore=np.array([0, 20]))
    assert own.digest == taxel.simulate("fingertip", 6, 2, shore=[0, 20]).digest
    grasps.save(tmp_path / "own.npz")
    read = taxel.read(tmp_path / "own.npz", channels=np.arange(3), full_scale=np.float32(1023))
    assert read.x.shape == (60, 3, 50) and read.reading["full_scale"] == 1023
    for seed in (1.7, True, "1"):
        with pytest.raises(TypeError, match="a seed is a whole number"):
            taxel.simulate("fingertip", 6, seed)


def test_a_data_set_has_one_label_for_each_sample(tmp_path):
    y = np.array([[0, 0], [1, 1], [0, 2], [1, 0], [0, 1], [1, 2]])
    np.savez(tmp_path / "own.npz", x=np.arange(36, dtype=np.float32).reshape(6, 2, 3), y=y)
    assert taxel.read(tmp_path / "own.npz", attribute=1).y.tolist() == ["0", "1", "2"] * 2
    with pytest.raises(ValueError, match="one label for each sample"):
        taxel.read(tmp_path / "own.npz", attributes=["hardness", "height"])
