#!/usr/bin/env python3
"""Asks whether a new class can be added to a trained network without training it again, and writes the answer as a page.

    TAXEL_DATA=... python3 scripts/add_class_experiment.py [--seeds 1]

A network learns all classes of a set but one. The class that was left out gets a head on frozen features, from a few of its
recordings: prototypes (means of the features by class) in several ways. Beside it stands the network that is trained again on
everything with the same few recordings. Both are tested on the same recordings of all classes, in groups that neither has
seen where the set has groups. The best of the heads is taken by the test part, which flatters it.

Needs Python 3 with numpy, onnx and onnxruntime, and taxel (target/release/taxel, or TAXEL=/path/to/taxel). The page is
docs/benchmarks/add-class.md.
"""

import argparse
import json
import os
import pathlib
import tempfile

import numpy as np
import onnx
import onnxruntime

from program import ROOT, taxel

PAGE = ROOT / "docs" / "benchmarks" / "add-class.md"
NETWORK = "resnet8-lite-1d"
SHOTS = (10,)
# How the network is trained again: the class weights of its loss. The first is what all others are compared with.
AGAIN = {"trained again, classes balanced": "balanced", "trained again": "none"}
# Classes that are left out, one at a time, spread over the list of classes.
LEFT_OUT = 3
CONFIG = """name = "run"
seed = {seed}
baselines = []
[data]
path = "set.npz"
test = "held"
[protocol]
kind = "official"
[train]
epochs = 30
batch_size = 64
optimizer = {{ name = "adamw", lr = 3e-3, weight_decay = 0.02, decay = "matrices" }}
warm_up = 0.1
schedule = {{ kind = "cosine" }}
least_steps = 400
batch_norm = "population"
label_smoothing = 0.1
class_weights = "{weights}"
[[networks]]
name = "{network}"
"""


def sets():
    """Name, samples, classes and marks of the test part of each set."""
    with tempfile.TemporaryDirectory() as folder:
        taxel(folder, "simulate", "fingertip", "--samples", "900", "--set", "shore=[0,10,20,30,40,50]", "--set", "sessions=10",
              "--output", "set.npz")
        data = np.load(pathlib.Path(folder) / "set.npz")
        yield "simulated: fingertip, six hardnesses", data["x"], data["y"], data["group"] >= 8
    root = os.environ.get("TAXEL_DATA")
    if root:
        data = np.load(pathlib.Path(root) / "fsr-glove28" / "data.npz")
        yield "fsr-glove28", data["x"][:, 30:35], data["y"], data["block"] == data["block"].max()


def trained(x, y, held, seed, weights="none"):
    """Features of all samples of `x`, the logits and the names of their classes, by a network that learned those with held == 0.

    `held` is 0 for training, 1 for testing, 2 for samples that are not shown to it at all.
    """
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        shown = held < 2
        names = np.unique(y[shown])
        labels = np.searchsorted(names, y[shown]).astype(np.int64)
        np.savez(folder / "set.npz", x=x[shown].astype(np.float32), y=labels, held=(held[shown] == 1).astype(np.int64))
        (folder / "config.toml").write_text(CONFIG.format(seed=seed, network=NETWORK, weights=weights))
        taxel(folder, "run", "config.toml", "--output", "run", "--threads", "1", "--quiet")
        [model] = (folder / "run" / "models").glob("*.safetensors")
        taxel(folder, "export", str(model), "--output", "model.onnx")
        graph = onnx.load(str(folder / "model.onnx"))
        kinds = {node.op_type for node in graph.graph.node}
        last = [node for node in graph.graph.node if node.op_type in ("Gemm", "MatMul")][-1]
        graph.graph.output.append(onnx.helper.make_empty_tensor_value_info(last.input[0]))
        session = onnxruntime.InferenceSession(graph.SerializeToString(), providers=["CPUExecutionProvider"])
        outputs = [output.name for output in session.get_outputs()]
        found = dict(zip(outputs, session.run(None, {session.get_inputs()[0].name: x.astype(np.float32)})))
        features, logits = found[last.input[0]].reshape(len(x), -1), found["logits"]
        assert len(kinds) > 1 and logits.shape[1] == len(names)
        # The file says what taxel says: its score on the test part is that of the run.
        results = json.loads((folder / "run" / "results.json").read_text())
        own = 100 * np.mean(names[logits.argmax(1)][held == 1] == y[held == 1])
        assert abs(own - results["networks"][0]["mean"]["accuracy"]) < 0.2, (own, results["networks"][0]["mean"])
        return features, logits, names


def heads(features, y, train):
    """The predicted class of every sample by each kind of prototype, from the features of the samples of `train`."""
    names = np.unique(y[train])
    of = lambda values, name: values[train & (y == name)]
    means = np.stack([of(features, name).mean(0) for name in names])
    unit = features / np.linalg.norm(features, axis=1, keepdims=True).clip(1e-12)
    directions = np.stack([of(unit, name).mean(0) for name in names])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rest = np.concatenate([of(features, name) - mean for name, mean in zip(names, means)])
    covariance = rest.T @ rest / max(1, len(rest) - len(names))
    shrunk = covariance + 0.1 * np.trace(covariance) / len(covariance) * np.eye(len(covariance))
    inverse = np.linalg.inv(shrunk)
    distance = lambda metric: np.stack([np.einsum("nd,de,ne->n", features - mean, metric, features - mean) for mean in means], 1)
    return {
        "nearest mean": names[distance(np.eye(features.shape[1])).argmin(1)],
        "cosine to the mean": names[(unit @ directions.T).argmax(1)],
        "nearest mean, common covariance": names[distance(inverse).argmin(1)],
    }


def one_row(features, logits, old, shots, new):
    """The network's own head with a row for the new class, from the features and logits of `shots` alone: no old recording is needed.

    The row is the mean feature, scaled so that at that mean it has the largest logit of the old classes and a margin as large as
    the spread of their logits.
    """
    mean = features[shots].mean(0)
    at_mean = logits[shots].mean(0)
    wanted = at_mean.max() + at_mean.std()
    row = features @ mean / (mean @ mean) * wanted
    return np.where(row > logits.max(1), new, old[logits.argmax(1)])


def scores(predicted, y, test, new):
    own = predicted[test] == y[test]
    is_new = y[test] == new
    return np.array([100 * own.mean(), 100 * own[~is_new].mean(), 100 * own[is_new].mean()])


def few(y, is_train, new, shots, seed):
    """The samples that are trained on when `shots` of the new class are there."""
    own = np.flatnonzero(is_train & (y == new))
    kept = np.random.default_rng(seed).permutation(own)[:shots]
    train = is_train & (y != new)
    train[kept] = True
    return train


def compared(x, y, test, seeds):
    """Rows by number of recordings and kind of head: mean scores over classes and seeds, and their number."""
    found = {}
    classes = np.unique(y)
    for seed in range(seeds):
        for new in classes[np.linspace(0, len(classes) - 1, LEFT_OUT).round().astype(int)]:
            held = np.where(y == new, 2, test.astype(int))
            features, logits, old = trained(x, y, held, seed)
            for shots in SHOTS:
                train = few(y, ~test, new, shots, seed)
                rows = {}
                for name, weights in AGAIN.items():
                    _, own, names = trained(x, y, np.where(test, 1, np.where(train, 0, 2)), seed, weights)
                    rows[name] = names[own.argmax(1)]
                rows |= heads(features, y, train)
                rows["own head and one row"] = one_row(features, logits, old, train & (y == new), new)
                for name, predicted in rows.items():
                    found.setdefault((shots, name), []).append(scores(predicted, y, test, new))
    return found


def page(all_found, seeds):
    lines = [
        "# A new class without training again", "",
        "Generated by `scripts/add_class_experiment.py`, which says how it measures.", "",
        f"`{NETWORK}` learns all classes but one; {LEFT_OUT} classes are left out, one at a time, with {seeds} seed(s). The class that was "
        f"left out is added by prototypes on frozen features, from {SHOTS[0]} of its recordings. *Trained again* is the same network on "
        "everything with the same recordings, with and without class weights. All prototypes need the mean features of the old classes, which "
        "a model file does not hold; *own head and one row* needs none. Accuracies in %, mean over the classes that were left out; in "
        "brackets the difference to *trained again, classes balanced*, least to most.", ""]
    for name, found in all_found.items():
        lines += [f"## {name}", "", "| recordings | head | all classes | old classes | the new class |", "| ---: | --- | ---: | ---: | ---: |"]
        for (shots, head), rows in found.items():
            rows, against = np.array(rows), np.array(found[(shots, next(iter(AGAIN)))])
            gaps = rows - against
            cells = [f"{mean:.1f}" + ("" if head == next(iter(AGAIN)) else f" ({low:+.1f} to {high:+.1f})")
                     for mean, low, high in zip(rows.mean(0), gaps.min(0), gaps.max(0))]
            lines.append(f"| {shots} | {head} | " + " | ".join(cells) + " |")
        lines.append("")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1, help="trainings of each kind with other seeds")
    args = parser.parse_args()
    found = {name: compared(x, y, test, args.seeds) for name, x, y, test in sets()}
    PAGE.write_text(page(found, args.seeds))
    print(PAGE)


if __name__ == "__main__":
    main()
