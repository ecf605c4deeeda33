#!/usr/bin/env python3
"""Runs five real sets without a config, as a newcomer does, and shows the best method beside that of the committed pages.

    TAXEL_DATA=... python3 scripts/bench_first_run.py --runs runs/first            all five, ten minutes each
    TAXEL_DATA=... python3 scripts/bench_first_run.py --runs runs/first glove      one of them
    python3 scripts/bench_first_run.py --page                                      the page from the table

The page is docs/benchmarks/first-run.md. A set goes into docs/benchmarks/first-run.csv as soon as it has run, and is not run again.
Nothing else may run meanwhile: the budget is one of time.
"""

import argparse
import csv
import json
import os
import pathlib
import re
import shlex
import subprocess
import time

import kept_rows
from program import ROOT, TAXEL

TABLE = ROOT / "docs" / "benchmarks" / "first-run.csv"
PAGE = ROOT / "docs" / "benchmarks" / "first-run.md"
RESULTS = ROOT / "docs" / "results"
BUDGET = "10m"
COLUMNS = ["set", "words", "seconds", "methods", "best", "score", "sd", "metric", "taxel", "processor"]
# Key, set, words after its folder, pages of the same task (of values: the set in values.csv), what differs there.
SETS = [
    ("glove", "fsr-glove28", "--group block --drop contradictory --set data.channels=[30,31,32,33,34]", ["fsr-glove28-block", "fsr-glove28-block-hardened"], ""),
    ("biotac", "biotac-slide20", "--group trial --set data.group_block=10", ["biotac-slide20", "biotac-slide20-hardened"], ""),
    ("gripper", "kinesthetic-gripper36", "--group trial --set data.group_block=12", ["kinesthetic-gripper36-hardened", "kinesthetic-gripper36-few"], "the pages train on at most 20 grasps of each object, this on about 48"),
    ("mattress", "pmd-posture17", "--set data.layout=image", [], "no page; `expect` of the config says 80 % for extra-trees"),
    ("eflesh", "eflesh-normal", "--y force_N --recording group --length window:33,1", ["eflesh-normal"], ""),
]


def best_of_pages(pages, metric):
    """Returns the best row of committed pages: its score and where it stands."""
    found = []
    for page in pages:
        if metric == "mae":
            with (ROOT / "docs" / "benchmarks" / "values.csv").open(newline="") as file:
                found += [(float(row["mae"]), f"`{row['method'].removeprefix('taxel ')}`, [values](values.md)")
                          for row in csv.DictReader(file) if row["set"] == page and row["method"].startswith("taxel ")]
        else:
            for row in re.findall(r"^\| `([^`]+)` \| [\d,]+ \| [\d,]+ \| ([\d.]+)", (RESULTS / f"{page}.md").read_text(), re.M):
                found.append((float(row[1]), f"`{row[0]}`, [{page}](../results/{page}.md)"))
    if not found:
        return None
    return min(found) if metric == "mae" else max(found)


def first_run(key, name, words, folder):
    """Runs one set; returns its row of the table."""
    call = [TAXEL, "run", str(pathlib.Path(os.environ["TAXEL_DATA"]) / name), "--output", str(folder), "--budget", BUDGET, *shlex.split(words)]
    print("$", *call, flush=True)
    start = time.time()
    subprocess.run(call, check=True)
    seconds = time.time() - start
    results = json.loads((folder / "results.json").read_text())
    metric = "accuracy" if "accuracy" in results["networks"][0]["mean"] else "mae"
    rows = sorted(results["networks"], key=lambda row: row["mean"][metric], reverse=metric == "accuracy")
    best = rows[0]
    machine = json.loads((folder / "environment.json").read_text())
    return {
        "set": key, "words": words, "seconds": round(seconds), "methods": len(rows), "best": best["network"],
        "score": round(best["mean"][metric], 3), "sd": round(best["sd"][metric], 3), "metric": metric,
        "taxel": machine["commit"][:9], "processor": machine["cpu"],
    }


def page(rows):
    lines = [
        "# The first run",
        "",
        "`taxel run DATA` without a config, in a budget of ten minutes on two cores, beside the best row of the committed pages of the",
        "same task. Both are of the same recordings and of groups apart; the best row of either was found by its test parts. Real data.",
        "`scripts/bench_first_run.py` ran it and wrote this page from [first-run.csv](first-run.csv).",
        "",
        "| recordings | words after them | s | methods | best of the first run | best of the pages | difference |",
        "|---|---|---:|---:|---|---|---:|",
    ]
    notes = []
    for key, name, _, pages, differs in SETS:
        row = next((row for row in rows if row["set"] == key), None)
        if row is None:
            lines.append(f"| {name} | not run | | | | | |")
            continue
        score, values = float(row["score"]), row["metric"] == "mae"
        digits, unit = (3, " MAE") if values else (1, " %")
        known = best_of_pages(pages, row["metric"])
        other = f"{known[0]:.{digits}f}{unit}, {known[1]}" if known else "–"
        off = f"{score - known[0]:+.{digits}f}" if known else ""
        sd = float(row["sd"])
        lines.append(f"| {name} | `{row['words']}` | {row['seconds']} | {row['methods']} | {score:.{digits}f} ± {sd:.{digits}f}{unit}, `{row['best']}` | {other} | {off} |")
        notes += [f"- {name}: {differs}."] if differs else []
    if notes:
        lines += ["", *notes]
    if rows:
        lines += ["", f"taxel {rows[-1]['taxel']} on {rows[-1]['processor']}."]
    PAGE.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sets", nargs="*", metavar="SET", help="glove, biotac, gripper, mattress, eflesh")
    parser.add_argument("--runs", default=ROOT / "runs" / "first", type=pathlib.Path)
    parser.add_argument("--page", action="store_true", help="write the page from the table alone")
    args = parser.parse_args()
    rows = kept_rows.read(TABLE)
    for key, name, words, *_ in SETS:
        done = any(row["set"] == key for row in rows)
        if args.page or done or args.sets and key not in args.sets:
            continue
        args.runs.mkdir(parents=True, exist_ok=True)
        rows.append(first_run(key, name, words, args.runs / key))
        kept_rows.write(TABLE, COLUMNS, rows)
        page(rows)
    page(rows)


if __name__ == "__main__":
    main()
