#!/usr/bin/env python3
"""Compares what `taxel report --learning-curve` forecasts with what recordings that were held back really bring.

    TAXEL_DATA=... python3 scripts/check_learning_curve.py [--seeds 3] [--networks]

A part of the recordings of each class is a set of its own. Its run and curve say what so many more of each class would bring. Then
they are brought: the same methods run on the larger set. The page docs/benchmarks/learning-curve.md has the forecast with its
interval, and what happened, for each method, set and draw.

Without --networks baselines alone are compared, which takes minutes. Needs Python 3 with numpy, the recordings under TAXEL_DATA
(fsr-glove28, kinesthetic-gripper36, pmd-posture17), and taxel (target/release/taxel, or TAXEL=/path/to/taxel).
"""

import argparse
import json
import os
import pathlib
import tempfile

import numpy as np

from program import ROOT, taxel

PAGE = ROOT / "docs" / "benchmarks" / "learning-curve.md"
BASELINES = ["mini-rocket", "k-nn"]
NETWORKS = ["resnet8-lite-1d"]
FOLDS = 5
# Share of each class that the smaller set has.
SMALLER = 0.45
CONFIG = """name = "run"
baselines = {baselines}
[data]
path = "set.npz"
[protocol]
folds = {folds}
[train]
epochs = 60
batch_size = 64
optimizer = {{ name = "adamw", lr = 3e-3, weight_decay = 0.02, decay = "matrices" }}
schedule = {{ kind = "cosine" }}
batch_norm = "population"
"""


def sets():
    root = pathlib.Path(os.environ["TAXEL_DATA"])
    for name in ("fsr-glove28", "kinesthetic-gripper36", "pmd-posture17"):
        data = np.load(root / name / "data.npz")
        x = data["x"][:, 30:35] if name == "fsr-glove28" else data["x"]
        yield name, x.astype(np.float32), data["y"].astype(np.int64)


def drawn(y, per_class, seed):
    """So many samples of each class; those of a smaller number are among those of a larger one."""
    rng = np.random.default_rng(seed)
    return np.sort(np.concatenate([rng.permutation(np.flatnonzero(y == name))[:per_class] for name in np.unique(y)]))


def variance(accuracy, per_class, y):
    """Of the share of right samples, as if they were independent."""
    return accuracy / 100 * (1 - accuracy / 100) / (per_class * len(np.unique(y)))


def run(x, y, rows, method, with_curve):
    """Mean accuracy over folds, its standard error, and the learning curve where it is asked for."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        np.savez(folder / "set.npz", x=x[rows], y=y[rows])
        text = CONFIG.format(baselines=json.dumps([method] if method in BASELINES else []), folds=FOLDS)
        text += f'[[networks]]\nname = "{method}"\n' if method in NETWORKS else ""
        text = text if method in NETWORKS else text.replace("baselines", "networks = []\nbaselines", 1)
        (folder / "config.toml").write_text(text)
        taxel(folder, "run", "config.toml", "--output", "run", "--quiet")
        results = json.loads((folder / "run" / "results.json").read_text())["networks"][0]
        curve = None
        if with_curve:
            said = taxel(folder, "report", "run", "--no-stress", "--learning-curve", "--format", "json", "--quiet")
            curve = json.loads(said)["learning_curve"]
        return results["mean"]["accuracy"], curve


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="draws of the recordings that are held back")
    parser.add_argument("--networks", action="store_true", help="compare networks too, which takes hours")
    args = parser.parse_args()
    head = ["set", "method", "draw", "recordings of each class", "accuracy %", "forecast with more", "gain forecast, points", "gain that came"]
    lines, held, near, of = [], 0, 0, 0
    for name, x, y in sets():
        least = np.bincount(y)[np.unique(y)].min()
        for method in BASELINES + (NETWORKS if args.networks else []):
            for seed in range(args.seeds):
                few = int(SMALLER * least)
                before, curve = run(x, y, drawn(y, few, seed), method, True)
                if curve["law"] is None:
                    lines.append([name, method, seed, few, f"{before:.1f}", "no law", "–", "–"])
                    continue
                # The most that the set has; a training part is smaller than the set by a fold.
                gains = [(gain, few + round(gain["more"] * FOLDS / (FOLDS - 1))) for gain in curve["law"]["gains"]]
                gain, larger = gains[-1] if gains[-1][1] <= least else gains[0]
                after, _ = run(x, y, drawn(y, larger, seed), method, False)
                low, high = gain["interval"]
                came, noise = after - before, 100 * sum(variance(*part) for part in [(before, few, y), (after, larger, y)]) ** 0.5
                held, near, of = held + (low <= came <= high), near + (low - noise <= came <= high + noise), of + 1
                lines.append([name, f"`{method}`", seed, f"{few}, then {larger}", f"{before:.1f}", f"{gain['more']:g}",
                              f"{gain['gain']:+.1f} [{low:.1f}, {high:.1f}]", f"{came:+.1f} ± {noise:.1f}"])
    rows = "\n".join("| " + " | ".join(map(str, line)) + " |" for line in [head, ["---"] * len(head), *lines])
    PAGE.write_text(f"""# What more recordings were forecast to bring, and brought

Generated by `scripts/check_learning_curve.py`, which says how it measures. The interval is that of the true gain; the gain that came has
noise of its own, since the larger set has other test samples too: beside it stands its standard error, as if all samples were independent.

{rows}

The interval holds {held} of {of} gains, and reaches {near} within one standard error.
""")
    print(PAGE)


if __name__ == "__main__":
    main()
