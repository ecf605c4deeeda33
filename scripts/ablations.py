#!/usr/bin/env python3
"""Measures how each effect of a scene changes the ranking of methods: writes docs/scenes/ablations.md.

    cargo build --release          # or TAXEL=/path/to/taxel
    python3 scripts/ablations.py [fingertip gripper palpation imprint gel hand] [--seeds 0,1,2,3] [--threads 1]

For every removable effect the scene is simulated without it, and `taxel run` trains and tests the same methods
again, on the same protocol and seeds. A row shows how each method changes against the whole scene, in percentage
points, seed by seed, and whether the order of the methods changes. Bold: significant by a paired t-test over seeds
at 5 %, divided by the number of methods. An effect that is significant for no method should be removed from the
scene, or its reason be written where `--explain` prints it. Needs scipy.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import tempfile

from scipy import stats

ROOT = pathlib.Path(__file__).resolve().parents[1]
TAXEL = os.environ.get("TAXEL", ROOT / "target" / "release" / "taxel")

# Config, what is smaller than in it, and the methods: cheap ones, since every effect is a run of its own.
SCENES = {
    "fingertip": (
        "quickstart.toml",
        ["data.samples=600", 'protocol.split="group"', "train.epochs=15", 'networks=[{name="mlp"},{name="resnet8-lite-1d"}]', 'baselines=["k-nn","mini-rocket","svm-linear"]'],
    ),
    "gripper": (
        "strength/strength-004-table-2.toml",
        ["data.samples=400", "protocol.test=0.4", "train.epochs=8", 'networks=[{name="multiscale-cnn"}]', 'baselines=["k-nn","mini-rocket","svm-linear"]'],
    ),
    "palpation": (
        "palpation/palpation-003-fig-6-all.toml",
        ["data.samples=480", "protocol.per_class=[10]", "protocol.repetitions=1", "train.epochs=10", "train.optimizer.lr=0.01", 'networks=[{name="tactnet6"}]', 'baselines=["k-nn","svm-linear"]'],
    ),
    "imprint": (
        "visuotactile/imprint.toml",
        ["data.samples=300", "data.set.elements=32", "train.epochs=10", 'networks=[{name="resnet8-lite-2d"}]', 'baselines=["k-nn","svm-linear"]'],
    ),
    "gel": (
        "visuotactile/gel.toml",
        ["data.samples=576", "train.epochs=15", 'networks=[{name="resnet8-lite-2d"}]', 'baselines=["k-nn","mini-rocket"]'],
    ),
    "hand": (
        "visuotactile/hand.toml",
        ["data.samples=300", "train.epochs=15", 'networks=[{name="resnet8-lite-2d"}]', 'baselines=["k-nn","mini-rocket"]'],
    ),
}


def accuracies(config: str, settings: list[str], seed: int, threads: int) -> dict[str, float]:
    """Mean accuracy of every method, in %."""
    with tempfile.TemporaryDirectory() as folder:
        command = [TAXEL, "run", ROOT / "configs" / config, "--output", pathlib.Path(folder) / "run", "--format", "json"]
        command += ["--seed", str(seed), "--threads", str(threads)]
        for setting in settings:
            command += ["--set", setting]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
    result = json.loads(done.stdout)
    return {n["network"]: n["measured"]["mean"]["accuracy"] for n in result["networks"]}


def effects(scene: str) -> list[str]:
    done = subprocess.run([TAXEL, "simulate", scene, "--explain", "--format", "json"], check=True, capture_output=True, text=True)
    return list(dict.fromkeys(e["name"] for e in json.loads(done.stdout) if e["removable"]))


def order(scores: dict[str, float]) -> list[str]:
    return sorted(scores, key=lambda name: -scores[name])


def change(base: list[float], own: list[float], comparisons: int) -> tuple[str, bool]:
    """Mean change over seeds with its standard error, and whether it is significant (paired t, 5 %, Bonferroni)."""
    differences = [b - a for a, b in zip(base, own)]
    mean, error = statistics.mean(differences), statistics.stdev(differences) / len(differences) ** 0.5
    critical = stats.t.ppf(1 - 0.05 / (2 * comparisons), len(differences) - 1)
    told = abs(mean) > critical * error
    words = f"{mean:+.1f} ± {error:.1f}"
    return (f"**{words}**" if told else words), told


def ablate(scene: str, seeds: list[int], threads: int) -> str:
    config, settings = SCENES[scene]
    runs = lambda extra: [accuracies(config, settings + extra, seed, threads) for seed in seeds]
    whole = runs([])
    names = list(whole[0])
    mean = lambda all_: {name: statistics.mean(one[name] for one in all_) for name in names}
    base = mean(whole)
    lines = [f"## {scene}", "", f"`configs/{config}` with `{' '.join(settings)}`, seeds {', '.join(map(str, seeds))}.", ""]
    lines += ["| scene | " + " | ".join(names) + " | order |", "|---|" + "---:|" * len(names) + "---|"]
    lines.append("| whole, accuracy % | " + " | ".join(f"{base[n]:.1f}" for n in names) + " | " + " > ".join(order(base)) + " |")
    silent = []
    for effect in effects(scene):
        own = runs([f'data.without=["{effect}"]'])
        ranked = order(mean(own))
        changed = "the same" if ranked == order(base) else " > ".join(ranked)
        cells = [change([one[n] for one in whole], [one[n] for one in own], len(names)) for n in names]
        lines.append(f"| without {effect} | " + " | ".join(words for words, _ in cells) + f" | {changed} |")
        if not any(told for _, told in cells):
            silent.append(effect)
        print(lines[-1], flush=True)
    lines += ["", f"Significant for no method: {', '.join(silent)}." if silent else "Every effect changes at least one method."]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help="scenes; all where none is named")
    parser.add_argument("--seeds", default="0,1,2,3")
    parser.add_argument("--threads", type=int, default=1)
    given = parser.parse_args()
    path = ROOT / "docs" / "scenes" / "ablations.md"
    # Other scenes' sections stay.
    sections = {}
    if path.is_file():
        for part in path.read_text().split("\n## ")[1:]:
            sections[part.split("\n", 1)[0]] = "## " + part.strip() + "\n"
    for scene in given.scenes or list(SCENES):
        sections[scene] = ablate(scene, [int(s) for s in given.seeds.split(",")], given.threads)
        head = "<!-- written by scripts/ablations.py -->\n\n# What each effect does to the ranking\n\nAccuracy on *simulated* data. Rows without an effect show the change in percentage points, mean ± standard\nerror over seeds. Bold: significant (paired t-test, 5 % over the methods of a row).\n\n"
        part = path.with_suffix(".part")
        part.write_text(head + "\n".join(sections[s] for s in SCENES if s in sections))
        part.replace(path)


if __name__ == "__main__":
    main()
