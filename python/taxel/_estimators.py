"""Networks and MiniRocket as estimators of scikit-learn."""

from __future__ import annotations

import numbers
import os
from typing import Any, Mapping

import numpy as np

from . import _taxel
from ._arrays import matched, order, readings, weights_of
from ._base import BaseEstimator, ClassifierMixin, NotFittedError, RegressorMixin
from ._config import Networks
from ._dataset import Dataset, of
from ._model import Model
from ._network import Graph
from ._settings import seed_of, text


class _Fitted(BaseEstimator):
    """What all estimators have in common: fitting by a config, answering by a model."""

    #: What the targets are: `classes` or `values`.
    _task = ""

    def fit(self, X: Any, y: Any = None, sample_weight: Any = None, *, groups: Any = None) -> Any:
        """Trains on raw readings `X` [samples, ..] with one target each, or on a :class:`taxel.Dataset`.

        `y` are classes for classifiers: whole numbers or texts. For regressors they are numbers [samples], or [samples,
        quantities]. Nothing has to be scaled or encoded before. `groups` [samples] are kept together where samples are held
        back for early stopping. `sample_weight` [samples] says how much each counts in the loss of a network, or in the ridge of
        MiniRocket: one of weight 2 as much as two, one of weight 0 not at all. Only ratios matter. Ctrl-C ends the training with a
        KeyboardInterrupt.
        """
        facts = {"task": self._task, "layout": self.layout, "full_scale": self.full_scale, "groups": groups, "name": self.name}
        data = of(X, y, facts)
        weights = weights_of(sample_weight, len(data))
        self._refuse(data)
        native = data._native if weights is None else data._native.with_weights(weights)
        with Networks() as networks:
            config, name = self._config(networks)
            config.update(name="fit", seed=seed_of(self.random_state), data={"path": data.name})
            if data.groups is not None:
                config["protocol"] = {"split": "group"}
            self.model_ = Model(
                _taxel.fit(
                    text(config),
                    f"taxel.{type(self).__name__}",
                    native,
                    name,
                    self._threads(),
                    self.verbose,
                )
            )
        self.n_features_in_ = data.shape[0]
        if len(data.channels) == self.n_features_in_:
            self.feature_names_in_ = np.array(data.channels, dtype=object)
        elif hasattr(self, "feature_names_in_"):
            del self.feature_names_in_
        self._learned(data)
        return self

    def _refuse(self, data: Dataset) -> None:
        """Refuses samples that cannot be learned from."""

    def _learned(self, data: Dataset) -> None:
        """Keeps what answers need of the samples."""

    def _config(self, networks: Networks) -> tuple[dict[str, Any], str]:
        raise NotImplementedError

    def _read(self, X: Any) -> np.ndarray:
        """Returns raw readings as the model takes them; refuses other features, and an estimator that is not fitted."""
        if not hasattr(self, "model_"):
            raise NotFittedError(f"This {type(self).__name__} instance is not fitted yet; call fit before it answers")
        X = self._by_name(X)
        self._refuse_other_features(X)
        return X

    def _by_name(self, X: Any) -> np.ndarray:
        """Readings with the columns of a data frame, or the channels of a data set, in the order of `feature_names_in_`."""
        wanted = list(getattr(self, "feature_names_in_", []))
        if not isinstance(X, Dataset):
            return readings(matched(X, wanted, strict=True))
        if not wanted or not X.channels or X.channels == wanted:
            return X.x
        missing = [name for name in wanted if name not in X.channels]
        if missing:
            raise ValueError(f"the data set has no channel {missing[0]!r}; it has {', '.join(X.channels)}")
        return X.x[:, [X.channels.index(name) for name in wanted]]

    def _threads(self) -> int | None:
        """All cores for -1, as scikit-learn has it."""
        return self.n_jobs if self.n_jobs is not None and self.n_jobs > 0 else None

    def _refuse_other_features(self, X: np.ndarray) -> None:
        shape = self.model_.shape
        if X.ndim == len(shape):
            raise ValueError(
                f"samples are [n, ..]; Reshape your data: one sample of shape {shape} is x.reshape(1, ..), these have "
                f"shape {X.shape}"
            )
        if X.ndim == len(shape) + 1 and X.shape[1] != self.n_features_in_:
            name = type(self).__name__
            if X.ndim == 3 and X.shape[1:] == shape[::-1]:
                raise ValueError(
                    f"X has shape {X.shape}, but {name} is expecting [n, {shape[0]}, {shape[1]}]: channels, then time; "
                    "pass X.transpose(0, 2, 1)"
                )
            raise ValueError(f"X has {X.shape[1]} features, but {name} is expecting {self.n_features_in_} features as input")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the model as one `.safetensors` that `taxel predict` and :func:`taxel.load` read."""
        if not hasattr(self, "model_"):
            raise NotFittedError(f"This {type(self).__name__} instance is not fitted yet; call fit before it is saved")
        self.model_.save(path)

    def novelty(self, X: Any) -> np.ndarray:
        """How unlike each sample is what was learned [samples], 0..0.99: see :meth:`Model.novelty`."""
        X = self._read(X)
        return self.model_.novelty(X, threads=self._threads())

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.two_d_array = True
        tags.input_tags.three_d_array = True
        return tags


class _Classes(ClassifierMixin, _Fitted):
    """Estimators of classes."""

    _task = "classes"

    def _learned(self, data: Dataset) -> None:
        self.classes_ = data.classes
        self._order = order(self.classes_, self.model_.classes)

    def predict(self, X: Any) -> np.ndarray:
        """The class of each sample [samples], of raw readings `X` [samples, ..]."""
        probabilities = self.predict_proba(X)
        return self.classes_[probabilities.argmax(axis=1)]

    def predict_proba(self, X: Any) -> np.ndarray:
        """Probabilities [samples, classes], float32, in the order of `classes_`."""
        X = self._read(X)
        return self.model_.predict_proba(X, threads=self._threads())[:, self._order]

    def predict_set(self, X: Any, share: float = 0.9) -> np.ndarray:
        """Which classes are in the set of each sample [samples, classes], bool: see :meth:`Model.predict_set`."""
        X = self._read(X)
        return self.model_.predict_set(X, share, threads=self._threads())[:, self._order]

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.classifier_tags.multi_label = False
        return tags


class _Values(RegressorMixin, _Fitted):
    """Estimators of values."""

    _task = "values"

    def _refuse(self, data: Dataset) -> None:
        if len(data) < 2:
            raise ValueError("n_samples = 1: values are learned from 2 samples or more")

    def predict(self, X: Any) -> np.ndarray:
        """The value of each sample [samples], or its values [samples, quantities], float32, of raw readings `X` [samples, ..]."""
        X = self._read(X)
        return self.model_.predict(X, threads=self._threads())

    def predict_interval(self, X: Any, share: float = 0.9) -> np.ndarray:
        """The ends of the interval of each value [samples, 2], or [samples, quantities, 2]: see :meth:`Model.predict_interval`."""
        X = self._read(X)
        return self.model_.predict_interval(X, share, threads=self._threads())

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags


class _Network(_Fitted):
    """Estimators that train a network."""

    def __init__(
        self,
        network: str | Graph = "resnet8-lite-1d",
        *,
        recipe: Mapping[str, Any] | None = None,
        encoding: Mapping[str, Any] | None = None,
        settings: Mapping[str, Any] | None = None,
        layout: str | None = None,
        full_scale: float | None = None,
        random_state: int | None = 0,
        n_jobs: int | None = None,
        verbose: bool | None = None,
        name: str = "recordings",
    ) -> None:
        self.network = network
        self.recipe = recipe
        self.encoding = encoding
        self.settings = settings
        self.layout = layout
        self.full_scale = full_scale
        self.random_state = random_state
        self.n_jobs = n_jobs
        self.verbose = verbose
        self.name = name

    def _config(self, networks: Networks) -> tuple[dict[str, Any], str]:
        own = networks.entry(self.network, self.settings, None)
        config: dict[str, Any] = {"networks": [own], "train": dict(self.recipe or {}), "encoding": self.encoding, "baselines": []}
        return config, own.get("label", own["name"])


class _Rocket(_Fitted):
    """Estimators on MiniRocket's features."""

    def __init__(
        self,
        features: int = 10_000,
        *,
        encoding: Mapping[str, Any] | None = None,
        layout: str | None = None,
        full_scale: float | None = None,
        random_state: int | None = 0,
        n_jobs: int | None = None,
        verbose: bool | None = None,
        name: str = "recordings",
    ) -> None:
        self.features = features
        self.encoding = encoding
        self.layout = layout
        self.full_scale = full_scale
        self.random_state = random_state
        self.n_jobs = n_jobs
        self.verbose = verbose
        self.name = name

    def _entry(self) -> dict[str, Any]:
        if isinstance(self.features, bool) or not isinstance(self.features, numbers.Integral):
            raise TypeError(f"features is a whole number, not {self.features!r}")
        return {"name": "mini-rocket", "features": int(self.features)}

    def _config(self, networks: Networks) -> tuple[dict[str, Any], str]:
        return {"networks": [], "baselines": [self._entry()], "encoding": self.encoding or {}}, "mini-rocket"


class Classifier(_Classes, _Network):
    """A network of the zoo, or of your own, trained by taxel's engine on the CPU to tell classes.

    Parameters
    ----------
    network : str or taxel.Graph
        A name of :func:`taxel.zoo`, sized by the data; or what :meth:`taxel.Network.finish`, :func:`taxel.from_torch` and
        :meth:`taxel.Graph.open` give. Weights that it has are the start of the training.
    recipe : dict, optional
        The table `[train]` of a config: `{"epochs": 60, "batch_size": 64, "optimizer": {"name": "adam", "lr": 0.001}}`.
        What is left out is that of Kaewrakmuk and Srinonchat 2026: 100 epochs, batches of 64, SGD with momentum.
    encoding : dict, optional
        The table `[encoding]` of a config: `{"signal": {"kind": "quantile-code"}}`. By default z-scores of a signal; for
        networks that read images the Gramian difference field of series, the pixels of images, the peak frame of
        sequences. `{"guard": True}` puts a guard before it that replaces broken channels.
    settings : dict, optional
        Settings of a network of the zoo other than its sizes.
    layout : str, optional
        What the axes of a sample are, where their number does not say it: `image`, `colour`, `fingers`.
    full_scale : float, optional
        The largest possible reading, such as 1023.
    random_state : int
        Seed of every random choice; equal seeds give equal models.
    n_jobs : int, optional
        Threads; by default all cores. The model does not depend on it.
    verbose : bool, optional
        By default a progress bar on a terminal; True prints lines elsewhere too, False nothing.
    name : str
        Name of the data set on the model's card.

    Attributes
    ----------
    classes_ : array of the labels that were met, sorted
    model_ : taxel.Model
    n_features_in_ : length of the first axis of a sample
    feature_names_in_ : names of the channels or features, where the samples had some. A data frame is matched by them when
        it is predicted, in whatever order its columns are.
    """


class Regressor(_Values, _Network):
    """A network of the zoo, or of your own, trained by taxel's engine on the CPU to answer values, such as a force.

    Parameters
    ----------
    network, encoding, settings, layout, full_scale, random_state, n_jobs, verbose, name
        As of :class:`Classifier`; the network is `deep-mlp` by default.
    recipe : dict, optional
        The table `[train]` of a config. Its `loss` is `"huber"` by default, `"mean-squared-error"`, or one by which the
        network says how far off it may be: `"gaussian-likelihood"`, `"quantiles"`. Values are scaled for the training.

    Attributes
    ----------
    model_, n_features_in_, feature_names_in_
        As of :class:`Classifier`. `model_.quantities` and `model_.units` say what the values are: name them with
        `taxel.Dataset(x, y, quantities=[("force", "N")])`, which `fit` takes.

    `predict_interval` needs held-out predictions. A network has them when it is fitted from a run folder, as by `taxel fit
    RUN` on the folder of :func:`taxel.cross_validate`; :class:`MiniRocketRegressor` has them when it is fitted.
    """

    def __init__(
        self,
        network: str | Graph = "deep-mlp",
        *,
        recipe: Mapping[str, Any] | None = None,
        encoding: Mapping[str, Any] | None = None,
        settings: Mapping[str, Any] | None = None,
        layout: str | None = None,
        full_scale: float | None = None,
        random_state: int | None = 0,
        n_jobs: int | None = None,
        verbose: bool | None = None,
        name: str = "recordings",
    ) -> None:
        super().__init__(
            network,
            recipe=recipe,
            encoding=encoding,
            settings=settings,
            layout=layout,
            full_scale=full_scale,
            random_state=random_state,
            n_jobs=n_jobs,
            verbose=verbose,
            name=name,
        )


class MiniRocket(_Classes, _Rocket):
    """MiniRocket's features and a ridge classifier (Dempster, Schmidt and Webb 2021): often what is recommended.

    Parameters
    ----------
    features : int
        About that many features.
    layout, full_scale, random_state, n_jobs, verbose, name
        As of :class:`Classifier`. Images and sequences are read as channels over rows or time.
    encoding : dict, optional
        `{"guard": True}` and `{"baseline": 10}` act before the features.

    Attributes
    ----------
    classes_, model_, n_features_in_, feature_names_in_
        As of :class:`Classifier`.
    """


class MiniRocketRegressor(_Values, _Rocket):
    """MiniRocket's features, the level of each channel, and ridge regression: values without a network.

    Parameters
    ----------
    features, encoding, layout, full_scale, random_state, n_jobs, verbose, name
        As of :class:`MiniRocket`.

    Attributes
    ----------
    model_, n_features_in_, feature_names_in_
        As of :class:`Regressor`. From 30 samples on it has intervals, without a run folder: the regression says what it would
        answer to each sample had it not learned it.
    """
