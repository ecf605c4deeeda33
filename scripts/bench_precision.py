#!/usr/bin/env python3
"""Sets accuracy of training in bf16 beside training in f32, seed by seed; writes docs/benchmarks/precision.md.

    python3 scripts/bench_precision.py --taxel target/release/taxel --runs runs/precision              all trials, ten seeds
    python3 scripts/bench_precision.py --taxel target/release/taxel --runs runs/precision glove        one of them
    python3 scripts/bench_precision.py --page                                                          the page from the table

Needs scipy, a processor with AVX512-BF16 and, for real sets, TAXEL_DATA. Both trainings of a seed have the same split, the same first weights
and the same order of samples. A pair goes into docs/benchmarks/precision.csv as soon as it is there, and is not run again. The
interval of the mean difference is that of a paired t test over seeds.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess

from scipy import stats

import kept_rows

ROOT = pathlib.Path(__file__).resolve().parents[1]
TABLE = ROOT / "docs" / "benchmarks" / "precision.csv"
PAGE = ROOT / "docs" / "benchmarks" / "precision.md"
SEEDS = range(10)
# Key, kind of data, config, row, settings.
TRIALS = [
    ("motions", "real", "real/ucr-basic-motions", "resnet8-lite-1d", []),
    ("glove", "real", "real/fsr-glove28", "resnet8-lite-1d", []),
    ("tekscan", "real", "real/tekscan22", "resnet8-lite-2d", []),
    ("fingertip", "simulated", "hardness/hardness", "resnet8-lite-1d", ["data.samples=600", "protocol.repetitions=1"]),
    ("palpation", "simulated", "palpation/palpation-002-table-1", "tactnet3d", ["data.samples=270", "protocol.repetitions=1"]),
]
COLUMNS = ["trial", "seed", "f32", "bf16", "diverged"]


def score(taxel, runs, trial, seed, precision):
    """Accuracy of one training over all its folds, in percent, and how many of them diverged."""
    key, _, config, row, settings = trial
    folder = runs / f"{key}-{seed}-{precision}"
    settings = [*settings, f'train.precision="{precision}"', 'baselines=["majority"]']
    call = [taxel, "run", ROOT / "configs" / f"{config}.toml", "--only", row, "--seed", seed, "--output", folder]
    call += [word for setting in settings for word in ("--set", setting)] + (["--resume"] if folder.exists() else [])
    print("$", *map(str, call), flush=True)
    subprocess.run([str(word) for word in call], check=True, stdout=subprocess.DEVNULL, cwd=ROOT)
    found = next(entry for entry in json.loads((folder / "results.json").read_text())["networks"] if entry["network"] == row)
    return found["mean"]["accuracy"], sum(bool(fold.get("diverged")) for fold in found["folds"])


def page(rows):
    lines = [
        "# Training in bf16 beside f32",
        "",
        "`train.precision = \"bf16\"` multiplies in bf16 and sums in f32. Both trainings of a seed have the same split, the same first",
        "weights and the same order of samples. `scripts/bench_precision.py` runs the trials and writes this page from",
        "[precision.csv](precision.csv).",
    ]
    for kind in ("real", "simulated"):
        lines += ["", f"## {kind.capitalize()} data", ""]
        lines += ["| config | network | seeds | f32 % | bf16 % | bf16 less f32, points | 95 % interval | diverged |", "|---|---|---:|---:|---:|---:|---|---:|"]
        for key, of, config, row, _ in TRIALS:
            pairs = [(float(one["f32"]), float(one["bf16"])) for one in rows if one["trial"] == key]
            if of != kind or len(pairs) < 2:
                continue
            off = [bf16 - f32 for f32, bf16 in pairs]
            mean, half = statistics.mean(off), stats.t.ppf(0.975, len(off) - 1) * statistics.stdev(off) / math.sqrt(len(off))
            f32, bf16 = (statistics.mean(values) for values in zip(*pairs))
            diverged = sum(int(one["diverged"]) for one in rows if one["trial"] == key)
            lines.append(f"| {config} | {row} | {len(off)} | {f32:.2f} | {bf16:.2f} | {mean:+.2f} | {mean - half:+.2f} to {mean + half:+.2f} | {diverged} |")
    PAGE.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("trials", nargs="*", metavar="TRIAL")
    parser.add_argument("--taxel", default=ROOT / "target" / "release" / "taxel", type=pathlib.Path)
    parser.add_argument("--runs", default=ROOT / "runs" / "precision", type=pathlib.Path)
    parser.add_argument("--page", action="store_true", help="write the page from the table alone")
    args = parser.parse_args()
    rows = kept_rows.read(TABLE)
    for seed in [] if args.page else SEEDS:
        for trial in TRIALS:
            if args.trials and trial[0] not in args.trials or any(one["trial"] == trial[0] and one["seed"] == str(seed) for one in rows):
                continue
            (f32, _), (bf16, diverged) = (score(args.taxel.resolve(), args.runs.resolve(), trial, seed, kind) for kind in ("f32", "bf16"))
            rows.append({"trial": trial[0], "seed": str(seed), "f32": f"{f32:.3f}", "bf16": f"{bf16:.3f}", "diverged": diverged})
            kept_rows.write(TABLE, COLUMNS, rows)
    page(rows)


if __name__ == "__main__":
    main()
