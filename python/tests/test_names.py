"""Names of columns, and arrays whose meaning would be lost."""

import warnings

import numpy as np
import pytest

import taxel


class Frame:
    """As much of a data frame as is needed of pandas, which is no requirement."""

    def __init__(self, columns):
        self.table = dict(columns)
        self.columns = list(self.table)
        self.iloc = None

    def __getitem__(self, names):
        return Frame({name: self.table[name] for name in names})

    def __array__(self, dtype=None, copy=None):
        return np.stack(list(self.table.values()), axis=1).astype(dtype or float)


def table(n=40, seed=0):
    """Features of two classes, the first of which tells them apart."""
    rng = np.random.default_rng(seed)
    y = np.arange(n) % 2
    columns = {"force": y * 2 + 0.1 * rng.normal(size=n), "noise": 5 * rng.normal(size=n), "travel": rng.normal(size=n)}
    return columns, y


def test_columns_are_matched_by_name():
    columns, y = table()
    own = taxel.Classifier("mlp", recipe={"epochs": 20}).fit(Frame(columns), y)
    assert own.feature_names_in_.tolist() == ["force", "noise", "travel"] and own.feature_names_in_.dtype == object
    want = own.predict_proba(Frame(columns))
    turned = Frame({name: columns[name] for name in ["travel", "force", "noise"]})
    assert (own.predict_proba(turned) == want).all()
    assert (own.predict_proba(np.asarray(Frame(columns))) == want).all(), "an array has its place"
    assert own.model_.card["reading"]["channel_names"] == ["force", "noise", "travel"]
    more = Frame({"id": np.arange(40.0), **turned.table})
    assert (own.model_.predict_proba(more) == own.model_.predict_proba(Frame(columns))).all()
    fewer = Frame({name: columns[name] for name in ["travel", "force"]})
    for bad, words in [(more, "unseen at fit time:\n- id"), (fewer, "now missing:\n- noise")]:
        with pytest.raises(ValueError, match=words):
            own.predict(bad)
    with pytest.raises(ValueError, match="now missing:\n- noise"):
        own.model_.predict(fewer)
    own.fit(np.asarray(Frame(columns)), y)
    assert not hasattr(own, "feature_names_in_")


def test_names_go_with_a_data_set(tmp_path):
    columns, y = table()
    own = taxel.Dataset(Frame(columns), y)
    assert own.channels == ["force", "noise", "travel"]
    own.save(tmp_path / "set.npz")
    assert taxel.read(tmp_path / "set.npz").channels == own.channels
    series = taxel.Dataset(np.zeros((4, 2, 8)) + np.arange(4)[:, None, None], [0, 1, 0, 1], channels=["thumb", "index"])
    assert series.channels == ["thumb", "index"]
    with pytest.raises(ValueError, match="channels is 1 name, and samples have 2 channels"):
        taxel.Dataset(np.zeros((4, 2, 8)), [0, 1, 0, 1], channels=["thumb"])
    with pytest.raises(TypeError, match="string names"):
        taxel.Dataset(Frame({"a": columns["force"], 1: columns["noise"]}), y)


def test_masks_and_times_are_refused():
    x, y = np.arange(16.0).reshape(4, 4), [0, 1, 0, 1]
    masked = np.ma.masked_array(x, mask=x == 3)
    for bad in (masked, list(masked)):
        with pytest.raises(ValueError, match="masked array"):
            taxel.Dataset(bad, y)
    assert len(taxel.Dataset(np.ma.masked_array(x), y)) == 4, "nothing is masked"
    times = x.astype("datetime64[ms]")
    for bad in (times, times - times[0, 0]):
        with pytest.raises(TypeError, match="not times"):
            taxel.Dataset(bad, y)
    model = taxel.Classifier("mlp", recipe={"epochs": 1}).fit(x, y)
    with pytest.raises(ValueError, match="masked array"):
        model.predict(masked)


def test_time_before_channels_is_hinted_at():
    x, y = np.random.default_rng(0).normal(size=(8, 100, 3)), [0, 1] * 4
    with pytest.warns(UserWarning, match=r"transpose\(0, 2, 1\)"):
        taxel.Dataset(x, y)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        taxel.Dataset(x, y, layout="series")
        own = taxel.MiniRocket(84).fit(x.transpose(0, 2, 1), y)
    with pytest.raises(ValueError, match=r"transpose\(0, 2, 1\)"):
        own.predict(x)
