#!/usr/bin/env python3
"""Fits the models of a run on to a few labelled touches of the sensor that each has not seen; adds rows to docs/benchmarks/values.csv.

    TAXEL_DATA=/data python3 scripts/bench_touches.py --taxel target/release/taxel runs/values/fsi-tube1d-0

Needs numpy and scikit-learn. Each fold of the run left one sensor out. Touches are drawn at random from that sensor, `taxel fit --from` goes on
from the fold's model, and all other touches of the sensor are predicted. Scores are pooled over sensors; they are mean and SD over draws.
Beside it: the model as it was, and trees that learn the touches alone. `bench_values.py --add` then writes the page.
"""

import argparse
import json
import os
import pathlib
import subprocess
import tempfile
import time
import tomllib

import numpy as np
from sklearn.ensemble import ExtraTreesRegressor

import bench_values

ROW = "layer-norm-mlp"
TOUCHES = [10, 20]


def save(path, x, y, names):
    np.savez(path, x=x, **{name: y[:, at] for at, name in enumerate(names)})


def call(taxel, *arguments):
    return subprocess.run([taxel, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def predicted(taxel, model, path, quantities):
    answers = json.loads(call(taxel, "predict", model, path, "--format", "json"))["answers"]
    return np.array([[answer["predicted"][name] for name in quantities] for answer in answers])


def draw(arguments, data, quantities, touches, seed, folder):
    """True values and predictions of each method over all sensors."""
    said = np.load(arguments.run / "predictions.npz")
    index, fold = said[f"{ROW}.index"], said[f"{ROW}.fold"]
    names = [f"q{at}_{unit}" for at, (_, unit) in enumerate(quantities)]
    truth, found, spent = [], {"taxel as it was": [], "taxel fit --from": [], "scikit-learn ExtraTreesRegressor, touches alone": []}, 0.0
    for part in np.unique(fold):
        rows = np.random.default_rng([seed, touches, part]).permutation(np.sort(index[fold == part]))
        few, rest = rows[:touches], rows[touches:]
        model = arguments.run / "models" / f"{ROW}.r0.f{part}.safetensors"
        own, asked, tuned = folder / "few.npz", folder / "rest.npz", folder / "tuned.safetensors"
        quantity = ",".join(f"{name}_{unit}" for name, unit in quantities)
        save(own, data["x"][few], data["y"][few], names)
        np.savez(asked, x=data["x"][rest])
        start = time.time()
        flags = ["--y", ",".join(names), "--quantities", quantity, "--seed", seed]
        tuned.unlink(missing_ok=True)
        call(arguments.taxel, "fit", own, "--from", model, "--output", tuned, *flags)
        spent += time.time() - start
        order = [name for name, _ in quantities]
        found["taxel fit --from"].append(predicted(arguments.taxel, tuned, asked, order))
        found["taxel as it was"].append(predicted(arguments.taxel, model, asked, order))
        trees = ExtraTreesRegressor(100, min_samples_leaf=2, random_state=seed).fit(data["x"][few], data["y"][few])
        found["scikit-learn ExtraTreesRegressor, touches alone"].append(trees.predict(data["x"][rest]))
        truth.append(data["y"][rest])
    return np.concatenate(truth), {name: np.concatenate(parts) for name, parts in found.items()}, spent


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=pathlib.Path)
    parser.add_argument("--taxel", required=True)
    parser.add_argument("--draws", type=int, default=3)
    arguments = parser.parse_args()
    results = json.loads((arguments.run / "results.json").read_text())
    path = tomllib.loads((arguments.run / "config.toml").read_text())["data"]["path"]
    data = np.load(pathlib.Path(path.replace("${TAXEL_DATA}", os.environ.get("TAXEL_DATA", ""))) / "data.npz")
    quantities = [(own["name"], own["unit"]) for own in results["quantities"]]
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for touches in TOUCHES:
            runs = {}
            for seed in range(arguments.draws):
                truth, found, spent = draw(arguments, data, quantities, touches, seed, pathlib.Path(folder))
                for name, said in found.items():
                    for at, (quantity, unit) in enumerate(quantities):
                        key = (f"{results['name']} after {touches} touches", quantity, unit, f"{name}, {ROW}" if "taxel" in name else name)
                        own = bench_values.scores(truth[:, at].astype(float), said[:, at].astype(float))
                        runs.setdefault(key, []).append((own, spent if "from" in name else None))
                        print(*key, seed, *(f"{value:.3f}" for value in own), flush=True)
            rows |= {key: bench_values.row_of(key, own) for key, own in runs.items()}
    bench_values.write(bench_values.read() | rows)


if __name__ == "__main__":
    main()
