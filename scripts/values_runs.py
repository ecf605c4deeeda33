#!/usr/bin/env python3
"""Runs the configs of values and of slip that docs/benchmarks/values.md shows.

    TAXEL_DATA=/data python3 scripts/values_runs.py --taxel target/release/taxel --runs runs/values
    ... fsi-tube1d-told baro-tip4-day       those trials alone

Needs numpy. A trial is a config, the rows that are run of it and what is set otherwise; a folder `NAME-SEED` each. Folders of complete
runs are passed over, others are resumed. Some trials need arrays that the sets hold elsewhere; these are written below `RUNS/sets` first:

- `fsi-tube1d-told`: the sensor's fluid (three columns of 0 and 1) and bore (mm) beside its two pressures.
- `fsi-tube1d-direction`, `-told-direction`: the difference of the pressures by their sum, and the logarithm of that, besides.
- `baro-tip4-rest`: the resting pressure of the session as four more channels that stand still.
- `osu-slip`: sessions in five random parts, four draws, as arrays `draw0` to `draw3`.

Nothing is chosen here: rows, seeds and settings are those that were fixed before test parts were seen.
"""

import argparse
import json
import os
import pathlib
import subprocess

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
NETWORK = "layer-norm-mlp"
TREES = "extra-trees"
PLAIN = f"mean,ridge,{TREES},{NETWORK}"
BY_TRIAL = ["protocol.kind=k-fold", "protocol.folds=5", "protocol.split=group"]
# Name, config, rows, seeds, settings; the quick ones first.
TRIALS = [
    ("fsi-tube1d", "fsi-tube1d", f"{PLAIN},{NETWORK}-gain", 3, []),
    ("fsi-tube1d-told", "fsi-tube1d", PLAIN, 3, ["data.path=${SETS}/fsi-tube1d-told"]),
    ("fsi-tube1d-direction", "fsi-tube1d", PLAIN, 1, ["data.path=${SETS}/fsi-tube1d-direction"]),
    ("fsi-tube1d-told-direction", "fsi-tube1d", PLAIN, 1, ["data.path=${SETS}/fsi-tube1d-told-direction"]),
    ("eflesh-location", "eflesh-location", PLAIN, 1, []),
    ("eflesh-location-session", "eflesh-location-session", f"{PLAIN},{NETWORK}-gain", 3, []),
    ("hydrogel-force16", "hydrogel-force16", PLAIN, 1, []),
    ("hydrogel-force16-three", "hydrogel-force16", NETWORK + "," + TREES, 1, ["encoding.signal.lags=[2,8,32]"]),
    ("microfluidic-force", "microfluidic-force", f"{PLAIN},resnet8-lite-1d", 1, []),
    ("microfluidic-force-trials", "microfluidic-force", f"mean,{TREES}", 1, BY_TRIAL),
    ("baro-tip4", "baro-tip4", PLAIN, 1, []),
    ("baro-tip4-day", "baro-tip4", PLAIN, 1, ["data.group=day", "protocol.folds=7"]),
    ("baro-tip4-rest", "baro-tip4", PLAIN, 1, ["data.path=${SETS}/baro-tip4-rest"]),
    ("baro-tip4-rest-day", "baro-tip4", PLAIN, 1, ["data.path=${SETS}/baro-tip4-rest", "data.group=day", "protocol.folds=7"]),
    ("pmd-posture17-weight", "pmd-posture17-weight", f"mean,{TREES}", 1, []),
    *[
        (f"osu-slip-draw{draw}", "osu-slip", f"{TREES},deep-mlp", 1, ["data.path=${SETS}/osu-slip", f"data.group=draw{draw}"])
        for draw in range(4)
    ],
]


def directed(data):
    """Pressures, then their difference by their sum, which a gain leaves alone, and the logarithm of their sum."""
    left, right = data["x"].T
    return dict(data, x=np.stack([left, right, (left - right) / (left + right), np.log(left + right)], 1))


def told(data):
    """Pressures, then what the sensor is filled with and its bore."""
    names = data["group_names"][data["group"]]
    fluid, bore = zip(*(str(name).removesuffix("mm").split("-") for name in names))
    kinds = sorted(set(fluid))
    extra = [[float(own == kind) for kind in kinds] + [float(width)] for own, width in zip(fluid, bore)]
    return dict(data, x=np.concatenate([data["x"], np.asarray(extra, np.float32)], 1))


def at_rest(data):
    """Readings less their rest, then the rest itself."""
    x = data["x"]
    return dict(data, x=np.concatenate([x, np.repeat(data["baseline_kPa"][..., None], x.shape[2], 2)], 1))


def draws(data):
    """Sessions in five random parts of as many sessions, four times."""
    sessions = np.unique(data["group"])
    parts = {}
    for draw in range(4):
        order = np.random.default_rng(draw).permutation(len(sessions))
        parts[f"draw{draw}"] = (order % 5)[np.searchsorted(sessions, data["group"])]
    return dict(data, **parts)


SETS = [
    ("fsi-tube1d", "fsi-tube1d-told", told),
    ("fsi-tube1d", "fsi-tube1d-direction", directed),
    ("fsi-tube1d", "fsi-tube1d-told-direction", lambda data: told(directed(data))),
    ("baro-tip4", "baro-tip4-rest", at_rest),
    ("osu-slip", "osu-slip", draws),
]


def prepare(folder):
    for name, to, make in SETS:
        path = folder / to / "data.npz"
        if not path.exists():
            data = dict(np.load(pathlib.Path(os.environ["TAXEL_DATA"]) / name / "data.npz"))
            path.parent.mkdir(parents=True, exist_ok=True)
            np.savez_compressed(path, **make(data))


def run(taxel, runs, trial, seed):
    name, config, rows, _, settings = trial
    folder = runs / f"{name}-{seed}"
    done = folder / "done"
    if done.exists() and done.read_text() == rows:
        return
    settings = [f"name={name}", *(text.replace("${SETS}", str(runs.resolve() / "sets")) for text in settings)]
    baselines = [row for row in rows.split(",") if row in ("mean", "ridge")]
    trees = {"osu-slip": '{name="extra-trees",min_samples_leaf=20}'}.get(config, '"extra-trees"')
    settings.append(f"baselines=[{','.join([*(json.dumps(row) for row in baselines), trees])}]")
    command = [taxel, "run", ROOT / "configs" / "real" / f"{config}.toml", "--seed", seed, "--only", rows, "--output", folder]
    command += [part for text in settings for part in ("--set", text)] + (["--resume"] if folder.exists() else [])
    print("$", *command, flush=True)
    subprocess.run([str(part) for part in command], check=True)
    done.write_text(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trials", nargs="*", help="names of trials; all where none is named")
    parser.add_argument("--taxel", default=str(ROOT / "target" / "release" / "taxel"))
    parser.add_argument("--runs", type=pathlib.Path, required=True)
    parser.add_argument("--seeds", type=int, help="seeds of each trial in place of its own number")
    arguments = parser.parse_args()
    prepare(arguments.runs / "sets")
    chosen = [trial for trial in TRIALS if not arguments.trials or trial[0] in arguments.trials]
    for trial in chosen:
        for seed in range(arguments.seeds or trial[3]):
            run(arguments.taxel, arguments.runs, trial, seed)


if __name__ == "__main__":
    main()
