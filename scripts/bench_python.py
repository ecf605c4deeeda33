#!/usr/bin/env python3
"""Compares the Python package with PyTorch and aeon, interleaved in one process; prints a table, writes JSON with --output.

    python3 scripts/bench_python.py [--rounds 5] [--epochs 5] [--threads N] [--only regressors] [--output bench.json]

Needs TAXEL_DATA and a Python with the wheel of scripts/python, torch, aeon and numpy.

*Programs.* On fsr-glove28 (5 force sensors × 50 time steps, 28 objects; every fifth sample is tested):
`taxel.Classifier("resnet8-lite-1d").fit` with the recipe of configs/real/fsr-glove28.toml, fewer epochs, against the same
recipe in PyTorch (`scripts/twin`: network, z-scores, shuffles, schedule, recomputed batch-norm statistics); `taxel.MiniRocket` against
`aeon`'s MiniRocketClassifier, both with about 10,000 features, `fit` and `predict`. On eflesh-normal (readings of a magnetic skin,
windows of 33 of them, normal force in N; the last of three sessions is tested) the same of values: `taxel.Regressor` and
`taxel.MiniRocketRegressor` against PyTorch with squared errors and `aeon`'s MiniRocketRegressor. Then how much memory
`predict_proba` takes for a float32 array of 512 MiB besides the array.

*Method.* One after the other in one process, in turns, the order reversed from round to round, each after one warm-up.
A time is the median over rounds, of the whole process and all of its threads: CPU time, which other programs disturb less
than wall time, and wall time beside it. CPU time includes threads that wait actively: `--threads 1`
compares work alone.
"""

import argparse
import json
import os
import pathlib
import resource
import statistics
import sys
import time

os.environ.setdefault("CUDA_VISIBLE_DEVICES", "")

import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts" / "twin"))
RECIPE = {
    "batch_size": 64,
    "optimizer": {"name": "sgdm", "lr": 0.01, "momentum": 0.9},
    "schedule": {"kind": "steps", "at": [0.6, 0.85], "factor": 0.1},
    "batch_norm": "population",
}
TARGETS = {
    "fit of resnet8-lite-1d": 2.0,
    "fit of MiniRocket": 1.5,
    "predict of MiniRocket": 1.5,
    "fit of resnet8-lite-1d to newtons": 2.0,
    "fit of MiniRocketRegressor": 1.5,
    "predict of MiniRocketRegressor": 1.5,
}
# Windows of eflesh-normal: every so many readings, of 33 each.
HOP, WINDOW = 4, 33


def timed(work):
    """CPU and wall seconds of some work, and what it gives."""
    wall, cpu = time.perf_counter(), time.process_time()
    given = work()
    return (time.process_time() - cpu, time.perf_counter() - wall), given


def interleaved(rounds, columns):
    """Medians of CPU and wall seconds of each column, and what each gave last."""
    times, given = {name: [] for name in columns}, {}
    for turn in range(-1, rounds):
        for name in list(columns)[:: 1 if turn % 2 else -1]:
            took, given[name] = timed(columns[name])
            if turn >= 0:
                times[name].append(took)
    return {name: [statistics.median(own) for own in zip(*all_)] for name, all_ in times.items()}, given


def networks(taxel, x, y, train, test, args):
    import torch
    import networks as twins
    import train as twin

    torch.set_num_threads(args.threads)
    recipe = {**RECIPE, "epochs": args.epochs}
    classes = int(y.max()) + 1

    def ours():
        own = taxel.Classifier("resnet8-lite-1d", recipe=recipe, n_jobs=args.threads).fit(x[train], y[train])
        return own.score(x[test], y[test])

    def theirs():
        torch.manual_seed(0)
        signal, labels = torch.as_tensor(twin.z_score(x, train)), torch.as_tensor(y)
        net = twins.build("resnet8-lite-1d", classes=classes, in_channels=x.shape[1])
        return twin.train_fold(net, [signal], labels, train, test, recipe, torch.Generator().manual_seed(7))

    times, accuracy = interleaved(args.rounds, {"taxel": ours, "PyTorch": theirs})
    return [("fit of resnet8-lite-1d", "PyTorch", times["taxel"], times["PyTorch"], accuracy["taxel"], accuracy["PyTorch"])]


def rocket_rows(name, ours, theirs, score, x, y, train, test, rounds):
    """Rows of `fit` and `predict` of one of taxel's estimators and one of aeon's; `score` says how good answers are."""
    times, fitted = interleaved(rounds, {"taxel": lambda: ours().fit(x[train], y[train]), "aeon": lambda: theirs().fit(x[train], y[train])})
    asked = {who: (lambda own=own: own.predict(x[test])) for who, own in fitted.items()}
    answers, said = interleaved(3 * rounds, asked)
    scores = [float(score(said[who], y[test])) for who in ("taxel", "aeon")]
    return [
        (f"fit of {name}", "aeon", times["taxel"], times["aeon"], *scores),
        (f"predict of {name}", "aeon", answers["taxel"], answers["aeon"], *scores),
    ]


def rockets(taxel, x, y, train, test, args):
    from aeon.classification.convolution_based import MiniRocketClassifier

    def ours():
        return taxel.MiniRocket(10_000, n_jobs=args.threads)

    def theirs():
        return MiniRocketClassifier(n_kernels=10_000, n_jobs=args.threads, random_state=0)

    return rocket_rows("MiniRocket", ours, theirs, lambda said, true: (said == true).mean(), x, y, train, test, args.rounds)


def newtons(taxel):
    """Windows of the magnetic skin [n, channels, 33], their last force, and which are trained on and tested."""
    path = pathlib.Path(os.environ["TAXEL_DATA"]) / "eflesh-normal"
    data = taxel.read(path, y="force_N", recording="group", length={"kind": "window", "to": WINDOW, "hop": HOP})
    last = data.groups == data.groups.max()
    return np.ascontiguousarray(data.x), data.y, np.flatnonzero(~last), np.flatnonzero(last)


def value_networks(taxel, x, y, train, test, args):
    import torch
    import networks as twins
    import train as twin

    torch.set_num_threads(args.threads)
    recipe = {**RECIPE, "epochs": args.epochs, "loss": "mean-squared-error"}
    scaled = (y - y[train].mean()) / y[train].std()

    def ours():
        own = taxel.Regressor("resnet8-lite-1d", recipe=recipe, n_jobs=args.threads).fit(x[train], y[train])
        return float(np.abs(own.predict(x[test]) - y[test]).mean())

    def theirs():
        torch.manual_seed(0)
        net = twins.build("resnet8-lite-1d", classes=1, in_channels=x.shape[1])
        signal, forces = torch.as_tensor(twin.z_score(x, train)), torch.as_tensor(scaled, dtype=torch.float32)[:, None]
        said = twin.train_fold(net, [signal], forces, train, test, recipe, torch.Generator().manual_seed(7))
        return float(np.abs(said.numpy()[:, 0] * y[train].std() + y[train].mean() - y[test]).mean())

    times, off = interleaved(args.rounds, {"taxel": ours, "PyTorch": theirs})
    return [("fit of resnet8-lite-1d to newtons", "PyTorch", times["taxel"], times["PyTorch"], off["taxel"], off["PyTorch"])]


def value_rockets(taxel, x, y, train, test, args):
    from aeon.regression.convolution_based import MiniRocketRegressor

    def ours():
        return taxel.MiniRocketRegressor(10_000, n_jobs=args.threads)

    def theirs():
        return MiniRocketRegressor(n_kernels=10_000, n_jobs=args.threads, random_state=0)

    return rocket_rows("MiniRocketRegressor", ours, theirs, lambda said, true: np.abs(said - true).mean(), x, y, train, test, args.rounds)


def copies(taxel, x, y):
    """Memory that `predict_proba` takes besides a float32 array of 512 MiB, as a share of it."""
    model = taxel.Classifier("mlp", recipe={"epochs": 1}).fit(x[:200], y[:200]).model_
    many = np.resize(x, ((512 << 20) // x[0].nbytes, *x.shape[1:]))
    model.predict_proba(many[:5000])
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    said = model.predict_proba(many)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) << 10
    return {"array_bytes": many.nbytes, "answers_bytes": said.nbytes, "grown_bytes": grown, "share": grown / many.nbytes}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--epochs", type=int, default=5)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--only", choices=["classifiers", "regressors"])
    parser.add_argument("--output", type=pathlib.Path)
    args = parser.parse_args()
    import taxel

    rows, memory, counts = [], None, []
    if args.only != "regressors":
        path = pathlib.Path(os.environ["TAXEL_DATA"]) / "fsr-glove28"
        data = taxel.read(path, channels=[30, 31, 32, 33, 34], drop=["contradictory"])
        x, y = data.x, np.searchsorted(data.classes, data.y).astype(np.int64)
        test = np.arange(0, len(x), 5)
        train = np.setdiff1d(np.arange(len(x)), test)
        memory = copies(taxel, x, y)
        rows += networks(taxel, x, y, train, test, args) + rockets(taxel, x, y, train, test, args)
        counts.append((len(train), len(test)))
    if args.only != "classifiers":
        x, y, train, test = newtons(taxel)
        rows += value_networks(taxel, x, y, train, test, args) + value_rockets(taxel, x, y, train, test, args)
        counts.append((len(train), len(test)))
    for trained, tested in counts:
        print(f"{trained} samples trained on, {tested} tested, {args.threads} threads, load {os.getloadavg()[0]:.1f}")
    print(f"{'':34} {'taxel':>16} {'other':>16} {'times as fast':>14} {'target':>7}  accuracy %, or error in N")
    table = []
    for name, other, ours, theirs, right, wrong in rows:
        ratio = [theirs[i] / ours[i] for i in (0, 1)]
        scale, digits = (1, 3) if "newtons" in name or "Regressor" in name else (100, 2)
        print(
            f"{name:34} {ours[0]:7.3f} / {ours[1]:6.3f} {theirs[0]:7.3f} / {theirs[1]:6.3f} {ratio[0]:6.2f} / {ratio[1]:5.2f} "
            f"{TARGETS[name]:7.1f}  {scale * right:.{digits}f} ({other} {scale * wrong:.{digits}f})"
        )
        table.append(
            dict(what=name, other=other, cpu_s=[ours[0], theirs[0]], wall_s=[ours[1], theirs[1]], ratio=ratio, score=[right, wrong])
        )
    print("seconds and ratios: CPU / wall")
    if memory:
        print(f"predict_proba of {memory['array_bytes'] >> 20} MiB of float32 took {memory['grown_bytes'] / 2**20:.1f} MiB "
              f"({100 * memory['share']:.1f} %) besides, {memory['answers_bytes'] / 2**20:.1f} MiB of them the answers")
    if args.output:
        args.output.write_text(json.dumps({"rows": table, "memory": memory, "arguments": vars(args) | {"output": None}}, indent=1))


if __name__ == "__main__":
    main()
