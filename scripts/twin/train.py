#!/usr/bin/env python3
"""Trains the PyTorch twins of a run folder's networks: same recordings, recipe and folds.

    python3 scripts/twin/train.py runs/fsr-glove28 [--networks mlp,resnet8-lite-1d] [--seed 0]

Needs torch, numpy, pyts and matplotlib, and TAXEL_DATA as the run had it. Only the folds come from the
run folder (`predictions.npz`); loading, encoding (pyts, matplotlib), networks, training and scoring are
this script's own. Weights and shuffles have their own random numbers, so accuracies agree in the mean
and not sample by sample. Prints one line per network and appends it to RUN/twin.jsonl.
"""

import argparse
import json
import math
import os
import pathlib
import sys
import time
import tomllib

import numpy as np
import torch
from torch.nn import functional as F
from torch.nn.modules.batchnorm import _BatchNorm

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import networks  # noqa: E402


def archive_pair(path):
    """Samples and labels of the UCR and UEA archives: NAME_TRAIN, then NAME_TEST, .ts or .txt."""
    if pathlib.Path(f"{path}_TRAIN.txt").exists():
        table = np.concatenate([np.loadtxt(f"{path}_{part}.txt") for part in ("TRAIN", "TEST")])
        return table[:, None, 1:].astype(np.float32), np.unique(table[:, 0], return_inverse=True)[1].astype(np.int64)
    samples, labels = [], []
    for part in ("TRAIN", "TEST"):
        lines = pathlib.Path(f"{path}_{part}.ts").read_text().splitlines()
        start = next(i for i, line in enumerate(lines) if line.strip().lower() == "@data")
        for line in filter(str.strip, lines[start + 1:]):
            *channels, label = line.strip().split(":")
            samples.append([[float(v) for v in channel.split(",")] for channel in channels])
            labels.append(label)
    return np.array(samples, np.float32), np.unique(labels, return_inverse=True)[1].astype(np.int64)


def load(config):
    """Samples and labels as the config's [data] says."""
    data = config["data"]
    path = pathlib.Path(os.path.expandvars(data["path"]))
    if any(path.parent.glob(path.name + "_TRAIN.*")):
        return archive_pair(path)
    archive = np.load(path / "data.npz" if path.is_dir() else path)
    x, y = archive[data.get("x", "x")], archive[data.get("y", "y")].astype(np.int64)
    keep = np.ones(len(x), bool)
    if "contradictory" in data.get("drop", []):
        labels = {}
        for row, label in zip(x, y):
            labels.setdefault(row.tobytes(), set()).add(label)
        keep = np.array([len(labels[row.tobytes()]) == 1 for row in x])
    if "channels" in data:
        x = x[:, data["channels"]]
    return x[keep].astype(np.float32), y[keep]


def images(x, image, full_scale):
    """What the 2D networks read: [N, colours, rows, columns]."""
    if image["kind"] == "raw":
        x = x / full_scale if image.get("scale", "full-scale") == "full-scale" else x
        return x[:, None] if x.ndim == 3 else x
    import matplotlib
    from pyts.image import GramianAngularField

    flat = x.reshape(len(x), -1)
    size = image.get("size", 50)
    field = GramianAngularField(image_size=size, method={"gadf": "difference", "gasf": "summation"}[image["kind"]])
    varies = flat.reshape(len(x), size, -1).mean(2).std(1) > 0
    fields = np.zeros((len(x), size, size))
    fields[varies] = field.fit_transform(flat[varies].astype(np.float64))
    colours = matplotlib.colormaps[image.get("colormap", "jet")]((fields + 1) / 2)[..., :3]
    return np.ascontiguousarray(colours.transpose(0, 3, 1, 2)).astype(np.float32)


def z_score(x, train):
    mean = x[train].mean((0, 2), keepdims=True)
    sd = x[train].std((0, 2), keepdims=True)
    return (x - mean) / np.where(sd > 0, sd, 1)


def settings_for(name, shapes, classes):
    if name == "mlp":
        return dict(classes=classes, in_features=int(np.prod(shapes["signal"])))
    if name.startswith("hybrid"):
        return dict(classes=classes, in_channels=shapes["signal"][0], image_channels=shapes["image"][0])
    return dict(classes=classes, in_channels=shapes["signal" if name.endswith("1d") else "image"][0])


def population(net, batches):
    """Batch-norm statistics over everything in `batches`, as MATLAB sets them after training."""
    moments, hooks = {}, []
    for module in net.modules():
        if isinstance(module, _BatchNorm):
            total = moments[module] = [0.0, 0.0, 0.0]

            def hook(_module, args, total=total):
                flat = args[0].detach().double().transpose(0, 1).flatten(1)
                total[0] += flat.shape[1]
                total[1] = total[1] + flat.sum(1)
                total[2] = total[2] + (flat * flat).sum(1)

            hooks.append(module.register_forward_pre_hook(hook))
    with torch.no_grad():
        for xs in batches:
            net(*xs)
    for hook in hooks:
        hook.remove()
    for module, (count, total, squares) in moments.items():
        mean = total / count
        module.running_mean.copy_(mean)
        module.running_var.copy_(squares / count - mean * mean)


def train_fold(net, inputs, y, train, test, recipe, generator):
    """Trains on labels, or on values with `loss = "mean-squared-error"`; returns the share of right answers, or the values that were said."""
    is_values = recipe.get("loss") == "mean-squared-error"
    loss = F.mse_loss if is_values else F.cross_entropy
    optimizer = recipe.get("optimizer", {})
    schedule = recipe.get("schedule", {"kind": "constant"})
    rate = optimizer.get("lr", 0.01)
    decay = optimizer.get("weight_decay", 0.0)
    if optimizer.get("name", "sgdm") == "adam":
        steps = torch.optim.Adam(net.parameters(), rate, weight_decay=decay)
    else:
        steps = torch.optim.SGD(net.parameters(), rate, optimizer.get("momentum", 0.9), weight_decay=decay)
    epochs, size = recipe.get("epochs", 100), recipe.get("batch_size", 64)
    train = torch.as_tensor(train)

    def batches():
        order = train[torch.randperm(len(train), generator=generator)]
        return order.split(size)

    net.train()
    for epoch in range(epochs):
        if schedule["kind"] == "steps":
            passed = sum(epoch >= at * epochs for at in schedule["at"])
            steps.param_groups[0]["lr"] = rate * schedule.get("factor", 0.1) ** passed
        elif schedule["kind"] == "cosine":
            low = schedule.get("floor", 0.0) * rate
            steps.param_groups[0]["lr"] = low + (rate - low) * (1 + math.cos(math.pi * epoch / epochs)) / 2
        for rows in batches():
            steps.zero_grad()
            loss(net(*[x[rows] for x in inputs]), y[rows]).backward()
            steps.step()
    if recipe.get("batch_norm", "population") == "population":
        population(net, ([x[rows] for x in inputs] for rows in batches()))
    net.eval()
    with torch.no_grad():
        answers = torch.cat([net(*[x[rows] for x in inputs]) for rows in torch.as_tensor(test).split(256)])
    return answers if is_values else float((answers.argmax(1) == y[test]).float().mean())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=pathlib.Path)
    parser.add_argument("--networks", help="comma-separated; default all of the run")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    config = tomllib.loads((args.run / "config.toml").read_text())
    results = json.loads((args.run / "results.json").read_text())
    predictions = np.load(args.run / "predictions.npz")
    x, y = load(config)
    encoding = config["encoding"]
    image = torch.as_tensor(images(x, encoding["image"], config["data"].get("full_scale", 1.0))) if "image" in encoding else None
    labels = torch.as_tensor(y)
    classes = int(y.max()) + 1
    ours = {n["network"]: n["mean"] for n in results["networks"]}
    # All networks of a run share their folds; the first one is the first to have them all.
    first = config["networks"][0]["name"]
    index, fold, repetition = (predictions[f"{first}.{key}"] for key in ("index", "fold", "repetition"))
    for entry in config["networks"]:
        name = entry["name"]
        if args.networks and name not in args.networks.split(","):
            continue
        recipe = {**config.get("train", {}), **entry.get("train", {})}
        accuracies, started = [], time.time()
        for key in sorted(set(zip(repetition.tolist(), fold.tolist()))):
            test = np.sort(index[(repetition == key[0]) & (fold == key[1])]).astype(np.int64)
            train = np.setdiff1d(np.arange(len(x)), test)
            signal = torch.as_tensor(z_score(x, train)) if x.ndim == 3 and not name.endswith("2d") else None
            shapes = {"signal": x.shape[1:], "image": tuple(image.shape[1:]) if image is not None else None}
            torch.manual_seed(1000 * args.seed + key[0] * 100 + key[1])
            net = networks.build(name, **settings_for(name, shapes, classes))
            inputs = [signal, image] if name.startswith("hybrid") else [image if name.endswith("2d") else signal]
            generator = torch.Generator().manual_seed(7 + 1000 * args.seed + key[0] * 100 + key[1])
            accuracies.append(100 * train_fold(net, inputs, labels, train, test, recipe, generator))
        mean = float(np.mean(accuracies))
        taxel = ours[name]["accuracy"] if ours[name] else None
        gap = round(taxel - mean, 3) if taxel is not None else None
        line = dict(network=name, seed=args.seed, twin=round(mean, 3), taxel=taxel, gap=gap, twin_folds=[round(a, 2) for a in accuracies], seconds=round(time.time() - started, 1), torch=torch.__version__)
        print(json.dumps(line), flush=True)
        with open(args.run / "twin.jsonl", "a") as file:
            file.write(json.dumps(line) + "\n")


if __name__ == "__main__":
    main()
