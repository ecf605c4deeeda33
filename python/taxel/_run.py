"""Networks compared on the same folds: runs, and their reports."""

from __future__ import annotations

import html
import json
import os
import tempfile
from typing import Any, Iterable, Mapping

import numpy as np

from . import _taxel
from ._config import Networks, file_name, toml
from ._dataset import Dataset, of, read
from ._model import Model, load
from ._network import Graph
from ._settings import seed_of, text


class Run:
    """A run folder: what was trained and tested on folds. `taxel report`, `fit` and `choose` take it too."""

    def __init__(self, path: str | os.PathLike[str], data: Dataset | None = None) -> None:
        self.path = os.fspath(path)
        self._data = data
        self._temporary: Any = None
        self._markdown, table, self._text = _taxel.table(self.path)
        #: The table as a dictionary: what `taxel run --format json` prints.
        self.table: dict[str, Any] = json.loads(table)

    @property
    def results(self) -> dict[str, Any]:
        """`results.json`: scores of every network and baseline, fold by fold, with mean, SD, intervals, confusions."""
        with open(os.path.join(self.path, "results.json"), encoding="utf-8") as file:
            return json.load(file)

    @property
    def predictions(self) -> dict[str, np.ndarray]:
        """`predictions.npz`: what was said of every test sample, by network."""
        with np.load(os.path.join(self.path, "predictions.npz")) as file:
            return dict(file)

    def scores(self) -> dict[str, dict[str, float]]:
        """Mean scores of each row in %: accuracy, precision, recall, f1; of values mae, rmse in their unit, r2 and others."""
        return {own["network"]: own["mean"] for own in self.results["networks"]}

    def models(self) -> dict[str, Model]:
        """The model of every fold, by `<network>.r<repetition>.f<fold>` as its file is called."""
        folder = os.path.join(self.path, "models")
        files = sorted(own for own in os.listdir(folder) if own.endswith(".safetensors"))
        return {os.path.splitext(own)[0]: load(os.path.join(folder, own)) for own in files}

    def report(self, **options: Any) -> Report:
        """As :func:`taxel.report`."""
        return report(self, **options)

    def __str__(self) -> str:
        return self._text

    def _repr_markdown_(self) -> str:
        return self._markdown

    def __repr__(self) -> str:
        return f"<taxel.Run {self.path}>"


class Report:
    """The report of a run; in a notebook it shows itself."""

    def __init__(self, said: Mapping[str, Any]) -> None:
        #: Path of the page, which needs no network and nothing beside it.
        self.page: str = said["page"]
        #: The smallest network that suffices; None where none does.
        self.chosen: str | None = said["chosen"]
        #: The recommendation in sentences.
        self.words: list[str] = said["words"]
        #: One dictionary per row of the first table, units in the keys.
        self.networks: list[dict[str, Any]] = said["networks"]
        self._table: str = said["table"]

    @property
    def html(self) -> str:
        """The page."""
        with open(self.page, encoding="utf-8") as file:
            return file.read()

    def _repr_html_(self) -> str:
        page = html.escape(self.html, quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 800px; border: 0"></iframe>'

    def __str__(self) -> str:
        return "\n".join([self._table, *self.words])

    def __repr__(self) -> str:
        return f"<taxel.Report {self.page}: {self.chosen or 'nothing chosen'}>"


def cross_validate(
    networks: Any,
    x: Any,
    y: Any = None,
    *,
    groups: Any = None,
    recipe: Mapping[str, Any] | None = None,
    encoding: Mapping[str, Any] | None = None,
    protocol: int | Mapping[str, Any] | None = None,
    baselines: Iterable[Any] | None = None,
    harden: Mapping[str, Any] | None = None,
    choose: Mapping[str, Any] | None = None,
    seed: int = 0,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    name: str = "cross-validation",
    threads: int | None = None,
    verbose: bool | None = None,
    **facts: Any,
) -> Run:
    """Trains and tests networks and baselines on the same folds.

    Parameters
    ----------
    networks : str, taxel.Graph, dict, an estimator such as taxel.Classifier or taxel.Regressor, or a list of them
        Names of :func:`taxel.zoo`, networks of your own, estimators, or entries of a config's `[[networks]]`. `encoding`,
        `layout` and `full_scale` are those of the estimators where they are not given here; seed, threads and name of the
        data set are not.
    x, y
        Raw readings [samples, ..] with one label each, or its values; or a :class:`taxel.Dataset`; or the path of
        recordings, as :func:`taxel.read` takes it. Where estimators are among the networks, `y` is what they learn.
    groups : array [samples], optional
        Object, session or day of each sample. With groups given here no group is both trained and tested on, unless
        `protocol` says otherwise: accuracy on objects that were also in training flatters. Groups of a Dataset, or of
        recordings, count where `protocol` asks for them, as `{"split": "group"}` does.
    recipe, encoding, harden, choose : dict, optional
        The tables `[train]`, `[encoding]`, `[harden]`, `[choose]` of a config.
    protocol : int or dict, optional
        Number of folds, or the table `[protocol]`. Default stratified 5-fold.
    baselines : list, optional
        Names (`"mini-rocket"`) or tables (`{"name": "k-nn", "k": 3}`); by default all that learn such targets, none
        more where a :class:`taxel.MiniRocket` or :class:`taxel.MiniRocketRegressor` is among the networks. `[]` for none.
    out : path, optional
        The run folder, by default one that lasts as long as what is returned. Samples in memory are kept in it as
        `recordings.npz`, so that the command line can judge and fit from it.
    resume : bool
        Goes on with an interrupted run in `out`, to the same bytes.
    facts
        `task`, `quantities`, `layout`, `unit`, `rate`, `full_scale`, `rest`, `official`, `source` of arrays, as of
        :class:`taxel.Dataset`.

    Returns
    -------
    Run
        What the run folder holds: a table that prints itself, results, predictions, models, and the report.
    """
    networks = _listed(networks)
    encoding = _agreed(networks, "encoding", encoding)
    for key in ("layout", "full_scale"):
        facts[key] = _agreed(networks, key, facts.get(key))
    given = facts.pop("task", None)
    task = _task(networks, given)
    if isinstance(x, (str, os.PathLike)):
        # Whole numbers in a file are classes where nobody asks for values.
        asked = task if task == "values" else given
        x = read(x, **facts, **({} if asked is None else {"task": asked}))
        facts = {}
    data = of(x, y, {**facts, "groups": groups, "task": task})
    temporary = tempfile.TemporaryDirectory(prefix="taxel-run-") if out is None else None
    folder = os.path.abspath(os.path.join(temporary.name, name) if temporary else os.fspath(out))  # type: ignore[arg-type]
    source, kept = _source(data, folder, seed)
    files = Networks(f"{folder}-networks")
    entries, rockets = _entries(networks, files)
    config = {
        "name": name,
        "seed": seed_of(seed),
        "data": source,
        "train": dict(recipe or {}),
        "encoding": encoding,
        "protocol": _protocol(protocol, groups is not None),
        "networks": entries,
        "baselines": None if baselines is None and not rockets else [*(baselines or []), *rockets],
        "harden": harden,
        "choose": choose,
    }
    begun = os.path.join(folder, "config.toml")
    new, done = not os.path.exists(begun), False
    try:
        _taxel.cross_validate(text(config), data._native, folder, resume, threads, verbose)
        done = True
    finally:
        # Also of a run that was stopped: it is gone on with. A folder that was refused belongs to another run.
        ours = done or new and os.path.isfile(begun)
        if kept is not None and ours and not os.path.exists(kept):
            data.save(kept)
    own = Run(folder, data)
    own._temporary = temporary
    return own


def _source(data: Dataset, folder: str, seed: int) -> tuple[dict[str, Any], str | None]:
    """The `[data]` table, and where samples are kept that no table makes again."""
    if data._data is not None and data._seed in (None, seed):
        return data._data, None
    # Read again, samples go by the name of their file.
    kept = os.path.join(folder, f"{file_name(data.name)}.npz")
    reading = data.reading
    facts = {key: reading.get(key) for key in ("layout", "rate", "full_scale")}
    official = {"test": "official"} if data._facts.get("official") else {}
    return {"path": kept, **facts, **official}, kept


def _protocol(protocol: Any, grouped: bool) -> dict[str, Any]:
    own: dict[str, Any] = {"split": "group"} if grouped else {}
    if protocol is None:
        return own
    if isinstance(protocol, Mapping):
        return {**own, **protocol}
    return {**own, "folds": protocol}


def _listed(networks: Any) -> list[Any]:
    """One network as a list of one."""
    from ._estimators import _Fitted

    one = isinstance(networks, (str, Graph, Mapping, _Fitted))
    networks = [networks] if one else list(networks)
    if not networks:
        raise ValueError("networks = []: name at least one network")
    return networks


def _agreed(networks: list[Any], key: str, given: Any) -> Any:
    """What is given, or else what the estimators among the networks agree on."""
    from ._estimators import _Fitted

    if given is not None:
        return given
    told = [getattr(own, key) for own in networks if isinstance(own, _Fitted)]
    told = [own for own in told if own is not None]
    if any(own != told[0] for own in told):
        raise ValueError(f"the estimators want different {key}s; all networks of a run read the same: give {key}=..")
    return told[0] if told else None


def _task(networks: list[Any], given: str | None) -> str | None:
    """Returns what the targets are, as it is given and as the estimators among the networks learn it."""
    from ._estimators import _Fitted

    told = {own._task for own in networks if isinstance(own, _Fitted)} | ({given} - {None})
    if len(told) > 1:
        raise ValueError("a run has classes or values: the estimators, or task, ask for both")
    return next(iter(told), None)


def _entries(networks: list[Any], files: Networks) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Entries of `[[networks]]`, and baselines among the estimators."""
    from ._estimators import _Network, _Rocket

    entries, rockets = [], []
    for own in networks:
        if isinstance(own, _Rocket):
            rockets.append(own._entry())
        elif isinstance(own, _Network):
            entries.append(files.entry(own.network, own.settings, own.recipe))
        elif isinstance(own, Mapping):
            entries.append(dict(own))
        else:
            entries.append(files.entry(own, None, None))
    return entries, rockets


def run(
    config: str | os.PathLike[str],
    *,
    quick: bool = False,
    set: Mapping[str, Any] | None = None,
    data: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    threads: int | None = None,
    verbose: bool | None = None,
) -> Run:
    """Runs an experiment file, as `taxel run` does; `set={"train.epochs": 20}` replaces values by their dotted keys."""
    pairs = [f"{key}={toml(value)}" for key, value in (set or {}).items()]
    path = [None if own is None else os.fspath(own) for own in (data, out)]
    seed = None if seed is None else seed_of(seed)
    return Run(_taxel.run(os.fspath(config), pairs, quick, path[0], seed, path[1], resume, threads, verbose))


def report(
    run: Run | str | os.PathLike[str],
    *,
    stress: bool = True,
    samples: int = 1000,
    again: bool = False,
    threads: int | None = None,
    verbose: bool | None = None,
) -> Report:
    """Judges a run: which network suffices, accuracy against measured speed, where networks break. Writes the page, tables
    and charts into the run folder; in a notebook the page shows itself.

    `stress=False` leaves the faults out, `samples` limits the test samples under faults, `again` measures anew what was
    measured before. Leave the machine alone while networks are timed. Ctrl-C is heard once everything is measured.
    """
    own = run if isinstance(run, Run) else Run(run)
    native = None if own._data is None else own._data._native
    return Report(json.loads(_taxel.report(own.path, native, stress, samples, again, threads, verbose)))
