#!/usr/bin/env python3
"""Measures on real recordings how far models may be believed; writes docs/benchmarks/certainty.md.

    python3 scripts/bench_certainty.py --taxel target/release/taxel --runs runs/certainty
    python3 scripts/bench_certainty.py --taxel target/release/taxel --runs runs/certainty fsr biotac      those trials alone
    python3 scripts/bench_certainty.py --page                                                             the page from the table

Needs TAXEL_DATA. A trial is one row of a config with one seed: `taxel run` (with [unknown]), `taxel fit`, `taxel report`. Its figures go
into docs/benchmarks/certainty.csv as soon as they are there, and what stands there is not run again. Everything is of samples whose
groups nobody trained.
"""

import argparse
import json
import pathlib
import statistics
import subprocess

import kept_rows

ROOT = pathlib.Path(__file__).resolve().parents[1]
TABLE = ROOT / "docs" / "benchmarks" / "certainty.csv"
PAGE = ROOT / "docs" / "benchmarks" / "certainty.md"
SEEDS = [0, 1, 2]
# Set, config, what is run of it, rows; the quick ones first.
TRIALS = [
    ("fsr-glove28, blocks", "fsr-glove28-block-code", "mini-rocket", ["mini-rocket"]),
    ("biotac-slide20, blocks", "biotac-slide20", "mini-rocket", ["mini-rocket"]),
    ("kinesthetic-gripper36, blocks", "kinesthetic-gripper36-hardened", "dilated-resnet-1d.hardened.n15", ["dilated-resnet-1d.hardened.n15"]),
    ("tekscan22 images", "tekscan22-hardened", "resnet8-lite-2d.hardened", ["resnet8-lite-2d.hardened"]),
    ("kinesthetic-gripper36, blocks", "kinesthetic-gripper36-hardened", "mini-rocket.n15", ["mini-rocket.n15"]),
    ("pmd-posture17, subjects", "pmd-posture17", "resnet8-lite-2d.hardened", ["resnet8-lite-2d.hardened"]),
    ("fsr-glove28, blocks", "fsr-glove28-block-hardened", "dilated-resnet-1d.hardened", ["dilated-resnet-1d.hardened"]),
]
FIGURES = [
    "samples", "accuracy", "ece_plain", "ece", "ece_floor", "auroc", "auroc_softmax", "refused", "false_alarms", "covered", "worst_group", "set_size",
    "early_decided", "early_right", "early_seen", "sure", "sure_right", "sure_right_broken", "sure_broken",
]
COLUMNS = ["set", "config", "row", "seed", *FIGURES]


def call(arguments, taxel):
    print("$", "taxel", *arguments, flush=True)
    return subprocess.run([taxel, *map(str, arguments)], check=True, stdout=subprocess.PIPE, text=True, cwd=ROOT).stdout


def percent(value):
    return "" if value is None else f"{100 * value:.2f}"


def run(taxel, runs, config, only, seed):
    """Runs the rows of a trial, tries them without some classes and judges them; the run folder."""
    folder = runs / f"{config}-{only}-{seed}"
    path = ROOT / "configs" / "real" / f"{config}.toml"
    without = [] if "[unknown]" in path.read_text() else ["--set", "unknown.hold_out=0.25", "--set", "unknown.draws=3"]
    call(["run", path, "--only", only, "--seed", seed, *without, "--output", folder, *(["--resume"] if folder.exists() else [])], taxel)
    call(["report", folder], taxel)
    return folder


def figures(taxel, folder, row):
    """Figures of one row of a run; shares in percent."""
    model = folder / f"{row}.safetensors"
    call(["fit", folder, "--network", row, "--output", model], taxel)
    card = json.loads(call(["inspect", model, "--format", "json"], taxel))
    certainty = card["certainty"]
    judged = json.loads((folder / "judgement.json").read_text())
    tried = next(entry["draws"] for entry in json.loads((folder / "unknown.json").read_text()) if entry["network"] == row)
    unknown = {key: statistics.mean(draw[key] for draw in tried) for key in ("auroc", "auroc_softmax", "refused", "false_alarms")}
    results = json.loads((folder / "results.json").read_text())
    answers = next(kept for kept in certainty["sets"] if kept["share"] == 0.9)
    early = next((kept for kept in certainty.get("early", []) if kept["confidence"] == 0.9), {})
    network = next(entry for entry in judged["stress"]["networks"] if entry["network"] == row)
    clean, broken = network["sure"] or {}, certainty.get("under_faults") or {}
    error = certainty["calibration_error"]
    score = next(entry for entry in results["networks"] if entry["network"] == row)
    return {
        "samples": certainty["fitted_on"]["samples"],
        "accuracy": f"{score['mean']['accuracy']:.2f}",
        "ece_plain": percent(error["before"]), "ece": percent(error["after"]), "ece_floor": percent(error["floor"]),
        "auroc": percent(unknown.get("auroc")), "auroc_softmax": percent(unknown.get("auroc_softmax")),
        "refused": percent(unknown.get("refused")), "false_alarms": percent(unknown.get("false_alarms")),
        "covered": percent(answers["covered"]), "worst_group": percent(answers.get("worst_group")), "set_size": f"{answers['size']:.3f}",
        "early_decided": percent(early["decided"] / early["of"]) if early else "",
        "early_right": percent(early.get("right")), "early_seen": percent(early.get("seen")),
        "sure": percent(clean.get("share")), "sure_right": percent(clean.get("right")),
        "sure_broken": percent(broken.get("share")), "sure_right_broken": percent(broken.get("right")),
    }


def cell(rows, key, places=1):
    values = [float(row[key]) for row in rows if row[key]]
    if not values:
        return "–"
    middle = f"{statistics.mean(values):.{places}f}"
    return middle if len(values) == 1 else f"{middle} ({min(values):.{places}f} to {max(values):.{places}f})"


def page(rows):
    lines = [
        "# How far models may be believed",
        "",
        "Real recordings; every figure is of samples whose groups the answering model has not trained (of tekscan22, which has no groups,",
        "of other folds). Means over seeds, and the least and the most of them in brackets. `scripts/bench_certainty.py` runs the trials and",
        "writes this page from [certainty.csv](certainty.csv), which has every seed by itself.",
        "",
        "## Probabilities",
        "",
        "ECE: expected calibration error in 15 bins, in points. The floor is what a model reads whose probabilities are right. *Sure* answers",
        "are those of 90 % or more.",
        "",
        "| set | row | seeds | samples | ECE by itself | calibrated | floor | sure answers | right | right under faults |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    groups = {}
    for row in rows:
        groups.setdefault((row["set"], row["row"]), []).append(row)
    for (name, row), own in groups.items():
        cells = [cell(own, key) for key in ("ece_plain", "ece", "ece_floor", "sure", "sure_right", "sure_right_broken")]
        lines.append(f"| {name} | {row} | {len(own)} | {own[0]['samples']} | " + " | ".join(cells) + " |")
    lines += [
        "",
        "## Objects that nobody trained",
        "",
        "A quarter of the classes is left out of training, three times others (of the postures one, five times others). AUROC: how well the",
        "distance tells their samples from known ones; beside it what the highest probability tells. *Refused*: answered `unknown` at 0.05.",
        "",
        "| set | row | AUROC | of the probability | refused | false alarms |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for (name, row), own in groups.items():
        cells = [cell(own, key) for key in ("auroc", "auroc_softmax", "refused", "false_alarms")]
        lines.append(f"| {name} | {row} | " + " | ".join(cells) + " |")
    lines += [
        "",
        "## Sets and early decisions",
        "",
        "Sets at 90 %: how many hold the true class, in all and in the worst group, and how many classes they have. Early decisions at 0.9: how",
        "many samples are decided before their end, how many of these are right, and how much of a sample has been seen on average.",
        "",
        "| set | row | covered | worst group | classes | decided early | right | seen |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for (name, row), own in groups.items():
        cells = [cell(own, "covered"), cell(own, "worst_group"), cell(own, "set_size", 2)]
        cells += [cell(own, key) for key in ("early_decided", "early_right", "early_seen")]
        lines.append(f"| {name} | {row} | " + " | ".join(cells) + " |")
    PAGE.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trials", nargs="*", help="words of the trials to run [default: all]")
    parser.add_argument("--taxel", type=pathlib.Path)
    parser.add_argument("--runs", type=pathlib.Path, help="folder of the runs")
    parser.add_argument("--page", action="store_true", help="writes the page alone")
    arguments = parser.parse_args()
    rows = kept_rows.read(TABLE)
    if not arguments.page:
        if not (arguments.taxel and arguments.runs):
            parser.error("--taxel and --runs are needed to run trials")
        taxel = arguments.taxel.resolve()
        for seed in SEEDS:
            for name, config, only, own in TRIALS:
                is_asked = not arguments.trials or any(word in f"{config} {only} {seed}" for word in arguments.trials)
                is_there = all(any((old["config"], old["row"], old["seed"]) == (config, row, str(seed)) for old in rows) for row in own)
                if is_there or not is_asked:
                    continue
                folder = run(taxel, arguments.runs.resolve(), config, only, seed)
                for row in own:
                    rows.append({"set": name, "config": config, "row": row, "seed": str(seed), **figures(taxel, folder, row)})
                    kept_rows.write(TABLE, COLUMNS, rows)
                    page(rows)
    page(rows)


if __name__ == "__main__":
    main()
