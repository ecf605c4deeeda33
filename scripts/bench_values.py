#!/usr/bin/env python3
"""Compares runs on values with scikit-learn and PyTorch on the same samples and folds; writes docs/benchmarks/values.md.

    TAXEL_DATA=/data python3 scripts/values_runs.py --runs runs/values
    python3 scripts/bench_values.py runs/values/*-? [--add] [--without-torch] [--without-sklearn]
    python3 scripts/bench_values.py --add                                      the page from its table

Needs numpy, scikit-learn, TAXEL_DATA and, but for `--without-torch`, torch. Every row goes into docs/benchmarks/values.csv, from which the
page is written; `--add` keeps the rows there that these runs do not have. Folds are those of the run, from its predictions.npz. Features
for trees are those of taxel's extra-trees: last reading, differences to 1 to 32 steps before, mean, SD, least and largest. The networks
are deep-mlp and layer-norm-mlp with the recipe of the run, trained by PyTorch on the first run of each set. Scores are pooled over all
test samples; of several runs of one set (seeds, which change splits and weights) they are mean and sample SD.

A row that is a mean of rows of the run averages their predictions, which were made out of fold. Which rows is fixed here (`FIXED`), as the
specification of values has it; that positions take the network alone was decided after the first results. Runs of events are scored by `event_scores.py`.
"""

import argparse
import json
import os
import pathlib
import statistics
import time
import tomllib

import numpy as np
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.linear_model import RidgeCV

import event_scores
import kept_rows

ROOT = pathlib.Path(__file__).resolve().parents[1]
LAGS = [1, 2, 4, 8, 16, 32]
PAIR = ("layer-norm-mlp", "extra-trees")
# Rows whose mean is the fixed one where it is not that of PAIR; of positions the network alone.
FIXED = {
    "eflesh-location": ("layer-norm-mlp",),
    "eflesh-location-session": ("layer-norm-mlp-gain",),
    "fsi-tube1d": ("layer-norm-mlp-gain", "extra-trees"),
    "microfluidic-force": ("resnet8-lite-1d", "extra-trees"),
    "pmd-posture17-weight": ("resnet8-lite-2d", "extra-trees"),
}
# Sets whose rows are also scored by parts, named by an array.
PARTS = {"eflesh-location": ("group", "session")}
# What the specification of values asks for: set, quantity, metric, most.
GOALS = [
    ("eflesh-normal-authors", "force", "RMSE", 0.17),
    ("eflesh-normal", "force", "RMSE", 0.42),
    ("eflesh-location, session 0", "x", "MAE", 0.28),
    ("eflesh-location, session 1", "x", "MAE", 0.22),
    ("eflesh-location-session", "x", "MAE", 0.36),
    ("hydrogel-force16", "force", "RMSE", 0.55),
    ("hydrogel-force16-three", "force", "RMSE", 0.47),
    ("microfluidic-force", "force", "RMSE", 0.70),
    ("microfluidic-force-trials", "force", "MAE", 0.27),
    ("baro-tip4-rest", "depth", "MAE", 0.82),
    ("baro-tip4-rest-day", "depth", "MAE", 1.15),
    ("fsi-tube1d", "place", "MAE", 6.2),
    ("fsi-tube1d", "force", "MAE", 1.7),
    ("fsi-tube1d-told", "place", "MAE", 3.8),
    ("fsi-tube1d-told", "force", "MAE", 1.0),
    ("fsi-tube1d-told-direction", "place", "MAE", 3.8),
    ("fsi-tube1d-told-direction", "force", "MAE", 1.0),
    ("fsi-tube1d after 10 touches", "place", "MAE", 3.5),
    ("fsi-tube1d after 10 touches", "force", "MAE", 0.7),
    ("fsi-tube1d after 20 touches", "place", "MAE", 2.0),
    ("fsi-tube1d after 20 touches", "force", "MAE", 0.55),
    ("fsi-tube1d-told after 10 touches", "place", "MAE", 3.5),
    ("fsi-tube1d-told after 10 touches", "force", "MAE", 0.7),
    ("fsi-tube1d-told after 20 touches", "place", "MAE", 2.0),
    ("fsi-tube1d-told after 20 touches", "force", "MAE", 0.55),
    ("pmd-posture17-weight", "weight", "MAE", 8.0),
]
TABLE = ROOT / "docs" / "benchmarks" / "values.csv"
COLUMNS = ["set", "quantity", "unit", "method", "mae", "mae_sd", "rmse", "rmse_sd", "r2", "r2_sd", "seconds", "seeds"]


def samples(data, config, encoding):
    """Samples [n, channels, time] and targets [n, quantities] of a data set as the run reads them."""
    arrays = np.load(data / "data.npz", allow_pickle=True)
    names = config.get("y", "y")
    y = np.stack([arrays[name] for name in (names if isinstance(names, list) else names.split(","))], -1) if names != "y" else arrays["y"]
    x, y = arrays["x"].astype(np.float32), np.asarray(y, np.float32).reshape(len(y), -1)
    if "tare" in config:
        tare = config["tare"]["array"] if isinstance(config["tare"], dict) else config["tare"].removeprefix("array:")
        x = x - arrays[tare].astype(np.float32)[..., None]
    recording, length = config.get("recording"), config.get("length")
    if recording:
        parts, to = arrays[recording], length["to"]
        windows, ends = [], []
        for part in dict.fromkeys(parts.tolist()):
            rows = np.flatnonzero(parts == part)
            for start in range(0, len(rows) - to + 1, length["hop"]):
                window = rows[start : start + to]
                windows.append(x[window].T)
                ends.append(window[-1])
        return np.stack(windows), y[ends]
    is_series = x.ndim == 3 and "image" not in encoding
    return x.reshape(len(x), *(x.shape[1:] if is_series else (1, -1))), y


def history(x, lags):
    last = x[:, :, -1]
    return np.concatenate([last, *[last - x[:, :, -1 - lag] for lag in lags if lag < x.shape[2]]], 1)


def summary(x):
    if x.shape[2] == 1 or x.shape[1] == 1 and x.shape[2] < 64:
        return x.reshape(len(x), -1)
    return np.concatenate([history(x, LAGS), x.mean(2), x.std(2), x.min(2), x.max(2)], 1)


class Ridge:
    name = "scikit-learn RidgeCV, readings"

    def __call__(self, train, y, test, _config):
        flat = [part.reshape(len(part), -1) for part in (train, test)]
        mean, sd = flat[0].mean(0), flat[0].std(0)
        sd[sd == 0] = 1
        return RidgeCV(np.logspace(-3, 3, 10)).fit((flat[0] - mean) / sd, y).predict((flat[1] - mean) / sd)


class Trees:
    name = "scikit-learn ExtraTreesRegressor, features"

    def __call__(self, train, y, test, _config):
        trees = ExtraTreesRegressor(100, min_samples_leaf=2, random_state=0, n_jobs=2)
        return trees.fit(summary(train), y if y.shape[1] > 1 else y[:, 0]).predict(summary(test))


class Mlp:
    """One of the two networks that were made for values."""

    def __init__(self, network):
        self.network = network
        self.name = f"PyTorch {network}"

    def __call__(self, train, y, test, config):
        import torch

        torch.manual_seed(0)
        torch.set_num_threads(2)
        signal = config.get("encoding", {}).get("signal", {})
        features = (lambda x: history(x, signal.get("lags", LAGS))) if signal.get("kind") == "history" else (lambda x: x)
        inputs = [features(part) for part in (train, test)]
        axes = 0 if signal.get("kind") == "history" else (0, 2)
        mean, sd = inputs[0].mean(axes, keepdims=True), inputs[0].std(axes, keepdims=True)
        inputs = [torch.tensor(((part - mean) / np.where(sd == 0, 1, sd)).reshape(len(part), -1)) for part in inputs]
        middle, scale = y.mean(0), y.std(0, ddof=1)
        targets = torch.tensor((y - middle) / scale)
        layers, width = [], inputs[0].shape[1]
        hidden = next(network for network in config["networks"] if network["name"] == self.network).get("set", {}).get("hidden", 128)
        norm = torch.nn.BatchNorm1d if self.network == "deep-mlp" else torch.nn.LayerNorm
        for _ in range(3):
            layers += [torch.nn.Linear(width, hidden), norm(hidden), torch.nn.ReLU()]
            width = hidden
        net = torch.nn.Sequential(*layers, torch.nn.Linear(width, y.shape[1]))
        recipe = config["train"]
        matrices = [p for p in net.parameters() if p.ndim > 1]
        others = [p for p in net.parameters() if p.ndim == 1]
        decay = recipe["optimizer"]["weight_decay"]
        optimizer = torch.optim.AdamW([{"params": matrices, "weight_decay": decay}, {"params": others, "weight_decay": 0}], lr=recipe["optimizer"]["lr"])
        epochs, rising = recipe["epochs"], int(np.ceil(recipe["warm_up"] * recipe["epochs"]))
        rate = lambda epoch: (epoch + 1) / rising if epoch < rising else 0.5 * (1 + np.cos(np.pi * (epoch - rising) / max(epochs - rising, 1)))  # noqa: E731
        schedule = torch.optim.lr_scheduler.LambdaLR(optimizer, rate)
        for _ in range(epochs):
            net.train()
            for rows in torch.randperm(len(targets)).split(recipe["batch_size"]):
                if len(rows) < 2:
                    continue
                optimizer.zero_grad()
                torch.nn.functional.huber_loss(net(inputs[0][rows]), targets[rows]).backward()
                optimizer.step()
            schedule.step()
        if recipe["batch_norm"] == "population":
            for norm in (layer for layer in net if isinstance(layer, torch.nn.BatchNorm1d)):
                norm.reset_running_stats()
                norm.momentum = None
            with torch.no_grad():
                for rows in torch.randperm(len(targets)).split(recipe["batch_size"]):
                    net(inputs[0][rows]) if len(rows) > 1 else None
        net.eval()
        with torch.no_grad():
            return net(inputs[1]).numpy() * scale + middle


def scores(truth, predicted):
    error = predicted - truth
    left, whole = (error**2).sum(), ((truth - truth.mean()) ** 2).sum()
    return np.abs(error).mean(), np.sqrt((error**2).mean()), 1 - left / whole


def rows_of(run, with_sklearn, with_torch):
    """Config, quantity, method, scores and seconds of every method of a run and beside it."""
    config = tomllib.loads((run / "config.toml").read_text())
    results = json.loads((run / "results.json").read_text())
    said = np.load(run / "predictions.npz")
    path = config["data"]["path"].replace("${TAXEL_DATA}", os.environ["TAXEL_DATA"])
    x, y = samples(pathlib.Path(path), config["data"], config.get("encoding", {}))
    names = [row["network"] for row in results["networks"] if len(said[f"{row['network']}.index"])]
    index, fold = said[f"{names[0]}.index"], said[f"{names[0]}.fold"]
    true = said[f"{names[0]}.true"].reshape(len(index), -1)
    assert np.array_equal(true, y[index]), f"{run}: the samples are not those of the run"
    train_seconds = {}
    for line in (run / "timings.jsonl").read_text().splitlines():
        line = json.loads(line)
        if "train_seconds" in line:
            train_seconds[line["network"]] = train_seconds.get(line["network"], 0) + line["train_seconds"]
    found = []
    for name in names:
        assert np.array_equal(said[f"{name}.index"], index), f"{run}: {name} is incomplete"
        found.append((f"taxel {name}", said[f"{name}.predicted"].reshape(len(index), -1), train_seconds.get(name)))
    authors = len(set(fold.tolist())) == 1
    of = {name.removeprefix("taxel "): predicted for name, predicted, _ in found}
    fixed = FIXED.get(results["name"], PAIR)
    if len(fixed) > 1 and all(name in of for name in fixed):
        found.append((mean_of(fixed), sum(of[name] for name in fixed) / len(fixed), None))
    has = [network["name"] for network in config["networks"]]
    networks = [Mlp(name) for name in ("deep-mlp", "layer-norm-mlp") if with_torch and name in has]
    for method in (*([Ridge(), Trees()] if with_sklearn else []), *networks):
        predicted, seconds = np.zeros_like(true), 0.0
        for part in sorted(set(fold.tolist())):
            test = index[fold == part]
            train = np.setdiff1d(np.arange(len(x)), test) if authors else index[fold != part]
            start = time.time()
            predicted[fold == part] = np.asarray(method(x[train], y[train], x[test], config)).reshape(len(test), -1)
            seconds += time.time() - start
        found.append((method.name, predicted, seconds))
    parts = [(results["name"], np.full(len(index), True))]
    if results["name"] in PARTS:
        array, word = PARTS[results["name"]]
        of_part = np.load(pathlib.Path(path) / "data.npz", allow_pickle=True)[array][index]
        parts += [(f"{results['name']}, {word} {part}", of_part == part) for part in np.unique(of_part)]
    for part, rows in parts:
        for at, quantity in enumerate(results["quantities"]):
            for name, predicted, seconds in found:
                own = scores(true[rows, at].astype(float), predicted[rows, at].astype(float))
                yield part, quantity["name"], quantity.get("unit", ""), name, own, seconds


def mean_of(names):
    return f"mean of taxel {' and '.join(names)}"


def read():
    """Rows of the table by what names them."""
    return {tuple(row[key] for key in COLUMNS[:4]): row for row in kept_rows.read(TABLE)}


def write(rows):
    """Writes the table in the order of sets, quantities and methods."""
    sets = list(dict.fromkeys(key[0] for key in rows))
    quantities = list(dict.fromkeys(key[1] for key in rows))
    in_order = sorted(rows.items(), key=lambda item: (sets.index(item[0][0]), quantities.index(item[0][1])))
    kept_rows.write(TABLE, COLUMNS, [row for _, row in in_order])


def row_of(key, runs):
    """Mean and sample SD over runs of scores and seconds."""
    row = dict(zip(COLUMNS, key)) | {"seeds": len(runs)}
    for at, name in enumerate(("mae", "rmse", "r2")):
        own = [scores[at] for scores, _ in runs]
        row |= {name: f"{statistics.mean(own):.4f}", f"{name}_sd": f"{statistics.stdev(own):.4f}" if len(own) > 1 else ""}
    spent = [seconds for _, seconds in runs]
    return row | {"seconds": "" if None in spent else f"{statistics.mean(spent):.1f}"}


def cell(row, name):
    """Mean and, of several seeds, sample SD."""
    sd = row[f"{name}_sd"]
    return f"{float(row[name]):.3f}" + (f" ± {float(sd):.3f}" if sd else "")


def goal_rows(rows):
    """The table of goals: the best of taxel's rows by the mean over seeds, and whether it reaches the goal."""
    for name, prefix, metric, goal in GOALS:
        of = {
            row["method"]: float(row[metric.lower()])
            for row in rows.values()
            if row["set"] == name and row["quantity"].startswith(prefix) and "taxel" in row["method"]
        }
        if not of:
            yield f"| {name} | {prefix}, {metric} | {goal:.2f} | not run | | open |"
            continue
        best = min(of, key=of.get)
        rule = FIXED.get(name.split(",")[0], PAIR)
        fixed = of.get(mean_of(rule) if len(rule) > 1 else f"taxel {rule[0]}")
        fixed = "–" if fixed is None else f"{fixed:.3f}"
        # Goals have two decimals.
        verdict = "reached" if round(of[best], 3) <= goal else "missed"
        yield f"| {name} | {prefix}, {metric} | {goal:.2f} | {of[best]:.3f}, {best} | {fixed} | {verdict} |"


PAGE = """# Values beside scikit-learn and PyTorch

Every method sees the same samples and the same folds. Scores are pooled over all test samples, in the unit of the quantity: mean ± SD over
seeds, of splits and of weights. Seconds are those of all trainings of a run on the same two cores: they tell the order of size. All data
are real recordings.

`scripts/bench_values.py` writes this page from run folders. Its table of goals is that of the specification. The best row is shown beside
one whose kind is fixed for all sets: the mean of a network and `extra-trees`, of positions the network alone (a rule that was made after the
first results). A best row of several was found by the test parts, so it flatters a little.
"""


def page(rows):
    lines = [PAGE, "## Goals", "", "| set | quantity | goal | best row | fixed row | best row against goal |", "|---|---|---:|---|---:|---|", *goal_rows(rows), ""]
    lines += event_scores.page()
    lines += ["## All rows", "", "| set | quantity | method | MAE | RMSE | R² | seconds | seeds |", "|---|---|---|---:|---:|---:|---:|---:|"]
    for row in rows.values():
        unit = f" ({row['unit']})" if row["unit"] else ""
        cells = " | ".join(cell(row, name) for name in ("mae", "rmse", "r2"))
        lines.append(f"| {row['set']} | {row['quantity']}{unit} | {row['method']} | {cells} | {row['seconds'] or '–'} | {row['seeds']} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="*", type=pathlib.Path)
    parser.add_argument("--add", action="store_true", help="keep rows of the table that these runs do not have")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs" / "benchmarks" / "values.md")
    parser.add_argument("--without-torch", action="store_true", help="leave out the networks in PyTorch")
    parser.add_argument("--without-sklearn", action="store_true", help="leave out the methods of scikit-learn")
    arguments = parser.parse_args()
    found, seen, events = {}, set(), []
    for run in arguments.runs:
        results = json.loads((run / "results.json").read_text())
        if not results.get("quantities"):
            events.append(run)
            continue
        name = results["name"]
        for *key, values, seconds in rows_of(run, not arguments.without_sklearn, name not in seen and not arguments.without_torch):
            found.setdefault(tuple(key), []).append((values, seconds))
            print(*key, *(f"{value:.3f}" for value in values), flush=True)
        seen.add(name)
    rows = read() if arguments.add else {}
    rows |= {key: row_of(key, runs) for key, runs in found.items()}
    write(rows)
    if events:
        event_scores.write(events)
    arguments.output.write_text(page(read()))


if __name__ == "__main__":
    main()
