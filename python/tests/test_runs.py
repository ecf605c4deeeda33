"""Runs and reports."""

import json

import numpy as np
import pytest

import taxel


@pytest.fixture(scope="module")
def run(grasps):
    rocket = taxel.MiniRocket(84)
    own = taxel.Classifier("mlp", recipe={"epochs": 2})
    return taxel.cross_validate([own, rocket], grasps.x, grasps.y, protocol=2, baselines=["majority"], full_scale=1023)


def test_a_run_holds_what_a_run_folder_holds(run, grasps):
    assert [own["network"] for own in run.results["networks"]] == ["mlp", "majority", "mini-rocket"]
    assert run.results["data_digest"] == grasps_digest(grasps)
    assert all(len(own["folds"]) == 2 for own in run.results["networks"])
    assert run.scores()["majority"]["accuracy"] == pytest.approx(100 / 3, abs=5)
    assert "mlp" in str(run) and "| mlp |" in run._repr_markdown_().replace("`", "")
    assert any(values.shape[-1] == 3 for values in run.predictions.values())
    assert {own.split(".r")[0] for own in run.models()} == {"mlp", "majority", "mini-rocket"}


def grasps_digest(grasps):
    return taxel.Dataset(grasps.x, grasps.y).digest


def test_the_report_shows_itself(run):
    report = run.report(samples=20, threads=1)
    assert report.page.endswith("report.html") and "<html" in report.html
    assert report._repr_html_().startswith("<iframe srcdoc=")
    assert len(report.networks) == 3 and report.words and "mlp" in str(report)
    assert taxel.report(run, samples=20).networks == report.networks, "measured once"
    # The folder has the samples beside it.
    assert taxel.report(run.path, stress=False).chosen == report.chosen


def test_groups_are_kept_together(grasps):
    own = taxel.cross_validate("mlp", grasps.x, grasps.y, groups=grasps.groups, recipe={"epochs": 1}, protocol=2, baselines=[])
    assert own.results["protocol"]["split"] == "group"
    with pytest.raises(ValueError, match="group"):
        taxel.cross_validate("mlp", grasps.x, grasps.y, recipe={"epochs": 1}, protocol={"kind": "leave-group-out"}, baselines=[])


def test_scenes_and_files_are_named_in_the_config(grasps, tmp_path):
    settings = {"recipe": {"epochs": 1}, "protocol": 2, "baselines": []}
    own = taxel.cross_validate("mlp", grasps, out=tmp_path / "scene", **settings)
    assert 'scene = "fingertip"' in (tmp_path / "scene/config.toml").read_text()
    assert own.results["source"] == "simulated: fingertip"
    other = taxel.cross_validate("mlp", grasps, seed=1, out=tmp_path / "kept", **settings)
    assert (tmp_path / "kept/fingertip.npz").is_file() and other.results["source"] == "simulated: fingertip"
    grasps.save(tmp_path / "own.npz")
    read = taxel.cross_validate("mlp", tmp_path / "own.npz", **settings)
    assert read.results["networks"][0]["folds"] == own.results["networks"][0]["folds"]


def test_own_networks_and_resuming(grasps, tmp_path):
    net = taxel.Network("own")
    graph = net.finish(net.input("signal", (5, 50)).flatten().linear("fc", 3))
    settings = {"recipe": {"epochs": 1}, "protocol": 2, "baselines": [], "out": tmp_path / "run"}
    own = taxel.cross_validate([graph, "mlp"], grasps.x, grasps.y, **settings)
    assert list(own.scores()) == ["own", "mlp"]
    with pytest.raises(ValueError, match="not empty"):
        taxel.cross_validate([graph, "mlp"], grasps.x, grasps.y, **settings)
    again = taxel.cross_validate([graph, "mlp"], grasps.x, grasps.y, resume=True, **settings)
    assert again.scores() == own.scores()
    with pytest.raises(ValueError, match="other settings"):
        taxel.cross_validate([graph, "mlp"], grasps.x, grasps.y, resume=True, **{**settings, "recipe": {"epochs": 2}})


def test_a_config_file(tmp_path):
    (tmp_path / "own.toml").write_text(
        'name = "own"\nbaselines = ["majority"]\n[data]\nscene = "fingertip"\nsamples = 30\n'
        '[protocol]\nfolds = 2\n[[networks]]\nname = "mlp"\n'
    )
    own = taxel.run(tmp_path / "own.toml", set={"train.epochs": 1, "train.optimizer": {"name": "adam", "lr": 0.01}}, out=tmp_path / "run")
    assert list(own.scores()) == ["mlp", "majority"]
    assert 'name = "adam"' in (tmp_path / "run/config.toml").read_text()
    assert json.loads(json.dumps(own.table))
    with pytest.raises(ValueError, match="train.epochs = 0"):
        taxel.run(tmp_path / "own.toml", set={"train.epochs": 0}, out=tmp_path / "no")
    with pytest.raises(FileNotFoundError, match="missing.toml"):
        taxel.run(tmp_path / "missing.toml")
    with pytest.raises(ValueError, match="no run folder"):
        taxel.report(tmp_path)


def test_what_a_comparison_refuses(grasps):
    x, y = grasps.x, grasps.y
    with pytest.raises(ValueError, match="name at least one network"):
        taxel.cross_validate([], x, y)
    with pytest.raises(ValueError, match="no network is called `mpl`"):
        taxel.cross_validate("mpl", x, y)
    with pytest.raises(ValueError, match="folds = 1"):
        taxel.cross_validate("mlp", x, y, protocol=1)
    with pytest.raises(ValueError, match="no baseline is called `knn`"):
        taxel.cross_validate("mlp", x, y, baselines=["knn"])
    with pytest.raises(TypeError, match="leave y out"):
        taxel.cross_validate("mlp", grasps, y)
    with pytest.raises(ValueError, match="different encodings"):
        taxel.cross_validate([taxel.Classifier("mlp", encoding={"guard": own}) for own in (True, False)], x, y)
    with pytest.raises(TypeError):
        taxel.cross_validate("mlp", x, y, unit_of="N")
    assert np.isfinite(x).all()


def one_layer(name="own", hidden=None):
    """A network of one layer, or of two."""
    net = taxel.Network(name)
    x = net.input("signal", (5, 50)).flatten()
    return net.finish((x if hidden is None else x.linear("hidden", hidden).relu()).linear("fc", 3))


def contents(folder):
    """Every file below `folder`, by its path."""
    return {own: own.read_bytes() for own in sorted(folder.rglob("*")) if own.is_file()}


def test_a_refused_comparison_changes_no_file_of_another_run(grasps, tmp_path):
    settings = {"recipe": {"epochs": 1}, "protocol": 2, "baselines": []}
    taxel.cross_validate(one_layer(), grasps.x, grasps.y, out=tmp_path / "run", **settings)
    taxel.cross_validate("mlp", grasps, out=tmp_path / "scene", **settings)
    np.savez(tmp_path / "recordings.npz", x=grasps.x, y=grasps.groups)
    before = contents(tmp_path)
    other = grasps.x + 1
    with pytest.raises(ValueError, match="not empty"):
        taxel.cross_validate("mlp", other, grasps.y, out=tmp_path / "run", **settings)
    for name in ("run", "scene"):
        with pytest.raises(ValueError, match="other settings|other data"):
            taxel.cross_validate("mlp", other, grasps.y, out=tmp_path / name, resume=True, **settings)
    with pytest.raises(ValueError, match="not empty"):
        taxel.cross_validate("mlp", other, grasps.y, out=tmp_path, **settings)
    with pytest.raises(ValueError, match="data"):
        taxel.cross_validate(one_layer(), other, grasps.y, out=tmp_path / "run", resume=True, **settings)
    for resume in (False, True):
        with pytest.raises(ValueError, match="another network of that name"):
            taxel.cross_validate(one_layer(hidden=4), grasps.x, grasps.y, out=tmp_path / "run", resume=resume, **settings)
    assert contents(tmp_path) == before


def test_what_a_stopped_run_was_given_is_kept(grasps, tmp_path):
    with pytest.raises(ArithmeticError):
        recipe = {"epochs": 5, "optimizer": {"lr": 1e30}}
        taxel.cross_validate("mlp", grasps.x, grasps.y, recipe=recipe, protocol=2, baselines=[], out=tmp_path / "run")
    assert (taxel.read(tmp_path / "run/recordings.npz").x == grasps.x).all()


def test_mini_rocket_alone_is_compared_alone(grasps):
    own = taxel.cross_validate(taxel.MiniRocket(84), grasps.x, grasps.y, protocol=2)
    assert list(own.scores()) == ["mini-rocket"]
    assert len(own.report(samples=20, threads=1).networks) == 1


def test_what_estimators_say_of_the_samples_counts(grasps, tmp_path):
    settings = {"protocol": 2, "baselines": []}
    rocket = taxel.MiniRocket(84, encoding={"guard": True}, layout="image", full_scale=1023)
    own = taxel.cross_validate(rocket, grasps.x, grasps.y, out=tmp_path / "run", **settings)
    assert all(model.card["reading"]["layout"] == "image" for model in own.models().values())
    assert all(model.card["reading"]["full_scale"] == 1023 for model in own.models().values())
    assert "guard = true" in (tmp_path / "run/config.toml").read_text()
    grasps.save(tmp_path / "own.npz")
    read = taxel.cross_validate(rocket, tmp_path / "own.npz", layout="series", **settings)
    assert all(model.card["reading"]["layout"] == "series" for model in read.models().values())
    for words, others in [
        ("encodings", {"encoding": {"guard": False}}), ("layouts", {"layout": "series"}), ("full_scales", {"full_scale": 5}),
    ]:
        other = taxel.MiniRocket(84, **{"encoding": {"guard": True}, "layout": "image", "full_scale": 1023, **others})
        with pytest.raises(ValueError, match=f"different {words}"):
            taxel.cross_validate([rocket, other], grasps.x, grasps.y, **settings)
    with pytest.raises(TypeError, match="knows full_scale, layout already"):
        taxel.cross_validate(rocket, grasps, **settings)
    with pytest.raises(TypeError, match="features is a whole number"):
        taxel.cross_validate(taxel.MiniRocket("many"), grasps.x, grasps.y, **settings)
    pair = [taxel.Classifier("mlp", recipe={"epochs": 1}, encoding={"guard": own}) for own in (True, False)]
    with pytest.raises(ValueError, match="two networks go by this name"):
        taxel.cross_validate(pair, grasps.x, grasps.y, encoding={"guard": True}, **settings)
