"""Estimators: scikit-learn's manners, labels of any kind, layouts, refusals."""

import pickle
import subprocess
import sys

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import GridSearchCV, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer
from sklearn.utils import estimator_checks

import taxel

QUICK = {"epochs": 2}


def sines(n=24, channels=2, length=20, seed=0):
    """Series of two classes: slow and fast."""
    rng = np.random.default_rng(seed)
    t = np.arange(length) / length
    x = np.stack([np.sin(2 * np.pi * (1 + 3 * (i % 2)) * t)[None] + 0.1 * rng.normal(size=(channels, length)) for i in range(n)])
    return x.astype(np.float32), np.arange(n) % 2


def test_parameters_and_clones():
    own = taxel.Classifier("mlp", recipe=QUICK, random_state=5)
    assert own.get_params()["network"] == "mlp" and own.get_params()["recipe"] is QUICK
    twin = clone(own.set_params(n_jobs=1))
    assert twin.get_params() == own.get_params() and twin is not own
    assert "mlp" in repr(own)
    net = taxel.Network("own")
    graph = net.finish(net.input("signal", (2, 20)).flatten().linear("fc", 2))
    assert clone(taxel.Classifier(graph)).network is graph


@pytest.mark.parametrize(
    "labels",
    [
        ["soft", "hard"], [1, 0], [10, 9], [-1, 1], [True, False], [2.0, 10.0],
        ["10", "9"], np.array(["b", "a"], dtype=object), ["é", "e"],
    ],
    ids=str,
)
def test_labels_of_any_kind(labels):
    x, y = sines()
    y = np.asarray(labels)[y]
    own = taxel.MiniRocket(84).fit(x, y)
    assert (own.classes_ == np.unique(y)).all() and own.classes_.dtype == np.unique(y).dtype
    assert (own.predict(x) == y).all()
    assert own.score(x, y) == 1
    probabilities = own.predict_proba(x)
    assert (own.classes_[probabilities.argmax(axis=1)] == y).all()


def test_selection_pipelines_and_pickles(grasps):
    x, y = sines(40)
    assert cross_val_score(taxel.MiniRocket(84), x, y, cv=3).min() > 0.9
    pipe = make_pipeline(FunctionTransformer(lambda x: x[:, :, ::2]), taxel.MiniRocket(84)).fit(x, y)
    assert pipe.score(x, y) == 1 and pipe[-1].model_.shape == (2, 10)
    grid = GridSearchCV(taxel.Classifier("mlp", n_jobs=1), {"recipe": [{"epochs": 1}, {"epochs": 2}]}, cv=2, n_jobs=2)
    assert grid.fit(x, y).best_estimator_.predict(x).shape == (40,)
    own = taxel.Classifier("mlp", recipe=QUICK).fit(grasps.x, grasps.y)
    back = pickle.loads(pickle.dumps(own))
    assert (back.predict_proba(grasps.x) == own.predict_proba(grasps.x)).all()
    assert back.get_params() == own.get_params() and (back.classes_ == own.classes_).all()


def test_equal_seeds_give_equal_models_on_any_number_of_threads():
    x, y = sines()
    fit = lambda **own: taxel.Classifier("resnet8-lite-1d", recipe=QUICK, **own).fit(x, y).model_.to_bytes()
    assert fit() == fit(n_jobs=1)
    assert fit() != fit(random_state=1)
    own = taxel.Classifier("mlp", recipe={"epochs": np.int64(2), "optimizer": {"lr": np.float32(0.5)}}, random_state=np.int32(1))
    assert own.fit(x, y).model_.card["estimator"]["recipe"]["optimizer"]["lr"] == 0.5


@pytest.mark.parametrize(
    "network, shape, layout",
    [
        ("mlp", (30,), None), ("resnet8-lite-1d", (3, 40), None), ("vgg6-lite-2d", (5, 50), None),
        ("tactnet4", (28, 30), "image"), ("tactnet4", (3, 28, 30), "colour"), ("tactnet4", (4, 28, 30), None),
        ("tactnet-rd", (8, 28, 30), None),
    ],
)
def test_layouts(network, shape, layout):
    names = [own["name"] for own in taxel.zoo()]
    if network not in names:
        network = next(own["name"] for own in taxel.zoo() if own["inputs"][0]["name"] == "tensor")
    x = np.random.default_rng(0).uniform(0, 5, size=(8, *shape))
    own = taxel.Classifier(network, recipe={"epochs": 1}, layout=layout).fit(x, [0, 1] * 4)
    assert own.predict(x).shape == (8,) and own.model_.shape == shape
    rocket = taxel.MiniRocket(84, layout=layout).fit(x, [0, 1] * 4) if shape != (4, 28, 30) and shape != (8, 28, 30) else None
    assert rocket is None or rocket.predict(x).shape == (8,)


def test_own_networks(grasps):
    net = taxel.Network("own")
    x = net.input("signal", (5, 50)).conv_bn_relu("stem", 16, 5, padding="same").max_pool(2)
    y = x.conv("deep", 16, 3, padding=1, bias=False).batch_norm("bn").relu().add(x).dropout(0.1)
    graph = net.finish(y.global_average_pool().linear("fc", 7))
    assert graph.inputs == {"signal": (5, 50)} and graph.cost()["total"]["parameters"] > 0
    own = taxel.Classifier(graph, recipe=QUICK).fit(grasps.x, grasps.y)
    assert own.predict_proba(grasps.x).shape == (60, 3), "the last layer has an output for each class"
    assert pickle.loads(pickle.dumps(graph)) == graph
    with pytest.raises(ValueError, match="own.*signal"):
        own.fit(grasps.x[:, :4], grasps.y)
    with pytest.raises(ValueError, match="stem: kernel 60"):
        taxel.Network("big").input("signal", (5, 50)).conv("stem", 4, 60)
    with pytest.raises(ValueError, match="padding"):
        taxel.Network("edge").input("signal", (5, 50)).conv("stem", 4, 3, padding="reflect")
    with pytest.raises(TypeError):
        taxel.Network("sized").input("signal", (5, 50)).conv("stem", "four", 3)
    one, other = (taxel.Network(name).input("signal", (5, 50)) for name in ("one", "other"))
    with pytest.raises(ValueError, match="another network"):
        one.add(other)
    with pytest.raises(ValueError, match="another network"):
        taxel.Network("third").finish(one)
    with pytest.raises(TypeError, match="outputs"):
        taxel.Network("none").finish(3)
    with pytest.raises((ValueError, OverflowError)):
        taxel.Network("less").input("signal", (5, 50)).conv("stem", -4, 3)


def test_what_fitting_refuses(grasps):
    x, y = grasps.x, grasps.y
    refused = [
        (ValueError, "no network is called `resnet`", taxel.Classifier("resnet"), x, y),
        (TypeError, "network is a name", taxel.Classifier(3), x, y),
        (ValueError, "epochs", taxel.Classifier("mlp", recipe={"epoch": 3}), x, y),
        (ValueError, "train.epochs = 0: must be", taxel.Classifier("mlp", recipe={"epochs": 0}), x, y),
        (ValueError, "encoding", taxel.Classifier("mlp", encoding={"signals": {}}), x, y),
        (ValueError, "x has 60 samples, y 59", taxel.Classifier("mlp"), x, y[:-1]),
        (ValueError, "shore-00", taxel.Classifier("mlp"), x, ["shore-00"] * 60),
        (ValueError, "NaN", taxel.Classifier("mlp"), np.where(np.arange(50) == 3, np.nan, x), y),
        (ValueError, "infinit", taxel.Classifier("mlp"), x.astype(float) * 1e38, y),
        (ValueError, "layout", taxel.Classifier("mlp", layout="pictures"), x, y),
        (ValueError, "colour", taxel.Classifier("mlp", layout="colour"), x, y),
        (ValueError, "target y is None", taxel.Classifier("mlp"), x, None),
        (ValueError, "continuous", taxel.Classifier("mlp"), x, np.linspace(0, 1, 60)),
        (ValueError, "seed", taxel.Classifier("mlp", random_state=-1), x, y),
        (TypeError, "seed", taxel.Classifier("mlp", random_state="one"), x, y),
        (TypeError, "features", taxel.MiniRocket("many"), x, y),
        (ValueError, "mini-rocket", taxel.MiniRocket(84), x[:, :, :3], y),
        (ValueError, "features = 0: must be", taxel.MiniRocket(0), x, y),
        (ValueError, "features = 1000000000000: must be", taxel.MiniRocket(10**12), x, y),
        (ValueError, "NaN or infinite", taxel.Classifier("mlp", recipe={"clip": np.nan}), x, y),
        (TypeError, "no value of a setting", taxel.Classifier("mlp", recipe={"epochs": object()}), x, y),
        (ArithmeticError, "loss is", taxel.Classifier("mlp", recipe={"epochs": 5, "optimizer": {"lr": 1e30}}), x, y),
    ]
    for kind, words, own, samples, labels in refused:
        with pytest.raises(kind, match=words):
            own.fit(samples, labels)
    with pytest.raises(NotFittedError):
        taxel.Classifier("mlp").predict(x)


CHECKS = [
    "check_no_attributes_set_in_init", "check_parameters_default_constructible", "check_get_params_invariance",
    "check_set_params", "check_estimators_unfitted",
    "check_estimator_tags_renamed", "check_estimator_cloneable", "check_estimator_repr",
    "check_do_not_raise_errors_in_init_or_set_params", "check_dont_overwrite_parameters", "check_valid_tag_types",
    "check_estimators_fit_returns_self", "check_classifier_data_not_an_array",
    "check_fit2d_1feature", "check_fit2d_1sample", "check_classifiers_train", "check_mixin_order",
    "check_dict_unchanged", "check_fit_score_takes_y",
    "check_estimators_dtypes", "check_dtype_object", "check_complex_data", "check_estimators_empty_data_messages",
    "check_pipeline_consistency", "check_estimators_nan_inf", "check_estimators_overwrite_params",
    "check_estimators_pickle", "check_estimator_sparse_tag", "check_estimator_sparse_array",
    "check_estimator_sparse_matrix", "check_f_contiguous_array_estimator", "check_fit1d", "check_fit2d_predict1d",
    "check_methods_subset_invariance", "check_methods_sample_order_invariance", "check_n_features_in",
    "check_n_features_in_after_fitting", "check_fit_check_is_fitted", "check_fit_idempotent", "check_requires_y_none",
    "check_supervised_y_no_nan", "check_supervised_y_2d", "check_classifiers_classes", "check_classifiers_one_label",
    "check_classifiers_regression_target", "check_readonly_memmap_input",
]


# Other versions of scikit-learn name some of them otherwise.
KNOWN = [check for check in CHECKS if hasattr(estimator_checks, check)]


def test_there_are_checks():
    assert len(KNOWN) >= 35


@pytest.mark.parametrize("check", KNOWN)
def test_scikit_learns_own_checks(check):
    check = getattr(estimator_checks, check)
    own = taxel.Classifier("mlp", recipe={"epochs": 40, "batch_size": 8, "optimizer": {"name": "adam", "lr": 0.01}})
    check("Classifier", own)


def test_estimators_without_scikit_learn(tmp_path):
    """The same in an interpreter that has none."""
    code = """
import sys
sys.modules["sklearn"] = sys.modules["sklearn.base"] = None
import numpy as np, pickle, taxel
x = np.random.default_rng(0).normal(size=(12, 1, 20)); y = ["a", "b"] * 6
own = taxel.MiniRocket(84).fit(x, y)
assert own.get_params()["features"] == 84 and own.set_params(features=168).features == 168
assert 0 <= own.score(x, y) <= 1 and "MiniRocket(features=168)" == repr(own)
assert (pickle.loads(pickle.dumps(own)).predict(x) == own.predict(x)).all()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
