#!/usr/bin/env python3
"""Tries shipped models with samples of no object: dead, stuck, saturated and noisy sensors, and other sensors.

    python3 scripts/bench_foreign.py --taxel target/release/taxel glove=runs/glove:glove.npz presses=runs/quickstart:presses.npz

Each argument names a set, its run folder and its raw samples, an .npz with `x` `[n, channels, steps]` or `[n, rows, columns]`; the others
serve as other sensors. Each row of a run is fitted, and asked for 100 samples of each kind. The page docs/benchmarks/foreign.md gets the
share that is answered as unknown, and that of known samples. Needs numpy.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "benchmarks" / "foreign.md"
COUNT = 100
# Rows that name no class by what they see.
LEFT_OUT = {"majority"}


def call(taxel, *arguments):
    run = subprocess.run([taxel, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if run.returncode:
        raise SystemExit(f"taxel {' '.join(map(str, arguments))}: {run.stderr}")
    return run.stdout


def kinds(x, low, high, rng):
    """Samples of no object, of the shape of `x`."""
    shape = x.shape
    mean, spread = x.mean(2, keepdims=True), x.std(2, keepdims=True)
    stuck = np.broadcast_to(x[:, :, :1], shape)
    overall = x.mean((0, 2), keepdims=True), x.std((0, 2), keepdims=True)
    return {
        "zeros": np.zeros(shape),
        "full scale": np.full(shape, high),
        "mid-scale": np.full(shape, (low + high) / 2),
        "stuck at the first step": stuck,
        "uniform noise": rng.uniform(low, high, shape),
        "noise of the set": rng.normal(*overall, shape),
        "noise of the sample": rng.normal(mean, spread, shape),
        "ten times as strong": 10 * x,
        "a tenth as strong": x / 10,
    }


def resampled(other, shape, rng):
    """Samples of another sensor: its channels in turn, its steps thinned or repeated."""
    steps = np.linspace(0, other.shape[2] - 1, shape[2]).astype(int)
    channels = np.arange(shape[1]) % other.shape[1]
    return other[rng.integers(0, len(other), shape[0])][:, channels][:, :, steps]


def share(taxel, model, x, folder):
    """Percent of samples that are unknown to a model; none where its encoding refuses them."""
    path = folder / "samples.npz"
    np.savez(path, x=np.asarray(x, np.float32))
    arguments = [taxel, "predict", model, path, "--format", "json", "--as-is"]
    run = subprocess.run(list(map(str, arguments)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if run.returncode == 2 and "per-sample rescaling has no range" in run.stderr:
        return None
    if run.returncode:
        raise SystemExit(f"{' '.join(map(str, arguments))}: {run.stderr}")
    return 100 * float(np.mean([answer["familiarity"] <= 0.05 for answer in json.loads(run.stdout)["answers"]]))


def table(taxel, name, run, sets, folder):
    rng = np.random.default_rng(0)
    x = sets[name]
    low, high = float(x.min()), float(x.max())
    chosen = x[rng.permutation(len(x))[:COUNT]]
    samples = kinds(chosen, low, high, rng)
    for other in sorted(set(sets) - {name}):
        raw = resampled(sets[other], chosen.shape, rng)
        samples[f"{other}, as it is"] = raw
        lowest, highest = raw.min(), raw.max()
        samples[f"{other}, in this range"] = (raw - lowest) / (highest - lowest) * (high - low) + low
    samples["*known samples*"] = chosen
    results = json.loads((pathlib.Path(run) / "results.json").read_text())
    rows = [row["network"] for row in results["networks"]]
    columns = {}
    for row in (row for row in rows if row not in LEFT_OUT):
        model = folder / "model.safetensors"
        model.unlink(missing_ok=True)
        call(taxel, "fit", run, "--network", row, "--output", model)
        columns[row] = {kind: share(taxel, model, of_kind, folder) for kind, of_kind in samples.items()}
        print(name, row, columns[row], flush=True)
    lines = [f"| {name} | {' | '.join(f'`{row}`' for row in columns)} |", "| --- |" + " ---: |" * len(columns)]
    cell = lambda percent: "error" if percent is None else f"{percent:.0f}"
    lines += [f"| {kind} | {' | '.join(cell(columns[row][kind]) for row in columns)} |" for kind in samples]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--taxel", default=str(ROOT / "target" / "release" / "taxel"))
    parser.add_argument("sets", nargs="+", metavar="NAME=RUN:SAMPLES.npz")
    arguments = parser.parse_args()
    given = [(name, *rest.rsplit(":", 1)) for name, rest in (text.split("=", 1) for text in arguments.sets)]
    sets = {name: np.load(samples)["x"].astype(float) for name, _, samples in given}
    version = call(arguments.taxel, "--version").strip()
    with tempfile.TemporaryDirectory() as folder:
        tables = [table(arguments.taxel, name, run, sets, pathlib.Path(folder)) for name, run, _ in given]
    PAGE.write_text(
        "# Samples of no object\n\n"
        "Percent of samples that a shipped model answers with `unknown`, at a familiarity of 0.05 or below\n"
        f"([certainty](../certainty.md)). {COUNT} samples of each kind; known samples are of the training set. Made by\n"
        f"`scripts/bench_foreign.py`, {version}. Sets that are not named as simulated are real recordings.\n"
        "Error: the encoding refuses such samples, with the reason.\n\n" + "\n\n".join(tables) + "\n"
    )


if __name__ == "__main__":
    main()
