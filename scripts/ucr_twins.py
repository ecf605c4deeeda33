#!/usr/bin/env python3
"""Compares light 1D networks on the UCR and UEA sets with PyTorch twins of the same recipe: docs/results/ucr-twins.md.

    TAXEL_DATA=... python3 scripts/ucr_twins.py [--seeds 0,1,2] [--threads 1]

Needs a built target/release/taxel (or TAXEL=...), and torch and numpy, without which the twins' accuracies of the page are
kept: they do not depend on the program. Every config configs/real/ucr-*.toml is run
once per seed by `taxel run` and its networks are trained again by scripts/twin/train.py on the same official
split. Nothing is shared but recordings, recipe and split, so a single seed of so few test series may differ by
several points. The mean over seeds counts, over ten seeds if there are fewer than a hundred test series. The baselines'
accuracies stand beside them; they hardly depend on a seed.
"""

import argparse
import importlib.util
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

from results_table import commit, remarks_line

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "results" / "ucr-twins.md"
TORCH = importlib.util.find_spec("torch") is not None
TAXEL = os.environ.get("TAXEL", ROOT / "target" / "release" / "taxel")
# What MiniRocket with ridge should reach on these splits, in %, give or take one.
EXPECTED = {"ucr-gunpoint": 99.3, "ucr-italy-power-demand": 96.5, "ucr-coffee": 100.0, "ucr-basic-motions": 100.0}


def run(config, seed, threads, folder):
    out = folder / f"{config.stem}-{seed}"
    subprocess.run([TAXEL, "run", config, "--output", out, "--seed", str(seed), "--threads", str(threads)], check=True, stdout=subprocess.DEVNULL)
    results = json.loads((out / "results.json").read_text())
    environment = json.loads((out / "environment.json").read_text())
    return results, environment, twins(out, seed, threads)


def twins(out, seed, threads):
    """Accuracy of each network's twin with this seed; None without PyTorch."""
    if not TORCH:
        return None
    twin = ROOT / "scripts" / "twin" / "train.py"
    done = subprocess.run([sys.executable, twin, out, "--seed", str(seed), "--threads", str(threads)], check=True, capture_output=True, text=True)
    return {line["network"]: line["twin"] for line in map(json.loads, done.stdout.splitlines())}


def kept():
    """The twins' accuracies of the page as it is, in the mean and seed after seed, by set and network."""
    rows = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in PAGE.read_text().splitlines() if "/" in line and line.startswith("|")]
    return {(row[0], row[2]): (float(row[4]), [float(pair.split("/")[1]) for pair in row[-1].split(", ")]) for row in rows if len(row) == 7 and row[1].isdigit()}


def accuracies(results):
    return {own["network"]: own["mean"]["accuracy"] for own in results["networks"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", default="0,1,2")
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    usual = [int(seed) for seed in args.seeds.split(",")]
    before = {} if TORCH else kept()
    if not TORCH and args.seeds != parser.get_default("seeds"):
        sys.exit(f"without torch the twins of {PAGE.name} stand, whose seeds are {parser.get_default('seeds')}: leave --seeds out")
    rows, baselines = [], []
    with tempfile.TemporaryDirectory() as folder:
        configs = (ROOT / "configs" / "real").glob("ucr-*.toml")
        for config in sorted(path for path in configs if not path.stem.endswith("-hardened")):
            runs = [run(config, usual[0], args.threads, pathlib.Path(folder))]
            results, environment, first = runs[0]
            tested = results["networks"][0]["folds"][0]["test_samples"]
            seeds = usual if tested >= 100 else list(range(usual[0], usual[0] + 10))
            runs += [run(config, seed, args.threads, pathlib.Path(folder)) for seed in seeds[1:]]
            for name in first if TORCH else [own for stem, own in before if stem == config.stem]:
                ours = [accuracies(results)[name] for results, _, _ in runs]
                if TORCH:
                    theirs = [own[name] for _, _, own in runs]
                    mean = statistics.mean(theirs)
                else:
                    mean, theirs = before[config.stem, name]
                if len(ours) != len(theirs):
                    sys.exit(f"{PAGE.name} has {len(theirs)} twins of {config.stem} {name}, and {len(ours)} seeds were run: install torch")
                each = ", ".join(f"{a:.1f}/{b:.1f}" for a, b in zip(ours, theirs))
                own = statistics.mean(ours)
                rows.append(f"| {config.stem} | {tested} | `{name}` | {own:.2f} | {mean:.2f} | {own - mean:+.2f} | {each} |")
                print(rows[-1], flush=True)
            scores = accuracies(results)
            known = [f"{scores[name]:.2f}" if name in scores else "–" for name in ("mini-rocket", "svm-linear", "svm-rbf", "k-nn", "majority")]
            baselines.append(f"| {config.stem} | " + " | ".join(known) + f" | {EXPECTED.get(config.stem, float('nan')):.1f} |")
    command = "python3 scripts/ucr_twins.py" + ("" if args.seeds == parser.get_default("seeds") else f" --seeds {args.seeds}")
    text = f"""# Light 1D networks on the UCR and UEA sets

Generated by `scripts/ucr_twins.py`: real series, no touch, on the archives' official splits; seeds {', '.join(map(str, usual))},
ten where there are fewer than a hundred test series; accuracy in %. taxel {environment['taxel']} at {commit(environment)}, {environment['cpu']}.

Made again by:

```sh
{command}
```

{remarks_line("ucr-twins")}

| set | test series | network | taxel | PyTorch twin | difference | each seed, taxel/twin |
|---|---:|---|---:|---:|---:|---|
{chr(10).join(rows)}

Baselines on the same splits; the last column is what MiniRocket with ridge should reach, give or take one.

| set | mini-rocket | svm-linear | svm-rbf | k-nn | majority | *expected* |
|---|---:|---:|---:|---:|---:|---:|
{chr(10).join(baselines)}
"""
    part = PAGE.with_suffix(".part")
    part.write_text(text)
    part.replace(PAGE)


if __name__ == "__main__":
    main()
