#!/usr/bin/env python3
"""Kills a sweep at random moments, resumes it, and compares every byte with an undisturbed one; then measures what sweeps cost.

    python3 scripts/kill_sweep.py [--taxel target/release/taxel] [--trials 200] [--kills 10] [--planned 10000]

1. `taxel sweep run --jobs 2` over small trials is killed (SIGKILL) until the kills are used up: as many results as
   trials, none lost, none twice, equal bytes. A kill counts only if the sweep was alive.
2. Twenty trials by one `run-one` (GNU time is needed) against the same twenty configs by one `taxel run`: the overhead of a chunk.
3. Many planned trials, none of them run: seconds and peak memory of plan, emit and collect, and of a tenth.

Exit code 0: all equal after all kills; 1: not.
"""

import argparse
import json
import pathlib
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time

from kill_resume import contents

CONFIG = """
name = "tiny"
baselines = ["majority"]
[data]
scene = "fingertip"
samples = 40
[protocol]
folds = 2
[train]
epochs = {epochs}
batch_size = 8
[[networks]]
name = "mlp"
"""
GRID = """
config = "tiny.toml"
set = {{ train.epochs = {epochs} }}
[grid]
{key} = [{values}]
"""


def sweep(args, *words, check=True):
    done = subprocess.run([args.taxel, "sweep", *map(str, words)], capture_output=True, text=True)
    if check and done.returncode not in (0, 1):
        sys.exit(f"taxel sweep {words}: {done.stderr}")
    return done.stdout


def plan(args, folder, name, key, values, epochs=2):
    """Plans a sweep of `values` of one key; its folder."""
    (folder / "tiny.toml").write_text(CONFIG.format(epochs=epochs))
    study = folder / "study.toml"
    study.write_text(GRID.format(epochs=epochs, key=key, values=", ".join(map(str, values))))
    sweep(args, "plan", study, "--output", folder / name)
    return folder / name


def results(path):
    """Run folders and results, times left out."""
    return {part: contents(path / part) for part in ("runs", "results")}


def compare(alone, other, trials):
    """Whether `other` has every result once, and the same bytes."""
    a, b = results(alone), results(other)
    collected = json.loads((other / "collected.json").read_text())["progress"]
    complete = len(b["results"]) == trials == collected["planned"] == collected["finished"] == len(list((other / "runs").iterdir()))
    print(f"{len(b['results'])} results of {trials} trials, {collected['duplicates']} twice; {len(b['runs'])} files of run folders: {'equal' if a == b else 'NOT EQUAL'}")
    return complete and a == b


def collect(args, path):
    (path / "collected.json").write_text(sweep(args, "collect", path, "--format", "json"))


def kills(args, folder):
    values = range(args.trials)
    alone, killed = (plan(args, folder, name, "seed", values) for name in ("alone", "killed"))
    start = time.monotonic()
    sweep(args, "run", alone, "--jobs", 2, "--quiet")
    length = time.monotonic() - start
    dice, done, within = random.Random(args.seed), 0, 0
    command = [args.taxel, "sweep", "run", killed, "--jobs", "2", "--quiet"]
    while done < args.kills:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            process.wait(dice.uniform(0.05, 1.6) * length / args.kills)
            break
        except subprocess.TimeoutExpired:
            process.kill()
            if process.wait() != -signal.SIGKILL:
                break
            done += 1
            within += any((killed / "work").iterdir()) if (killed / "work").is_dir() else 0
    sweep(args, "run", killed, "--jobs", 2, "--quiet")
    collect(args, killed)
    print(f"run --jobs 2: {done} kills ({within} with trials under way) in a sweep of {length:.1f} s")
    if done < args.kills or within == 0:
        print(f"the sweep was over after {done} of {args.kills} kills, {within} of them with trials under way: give more --trials")
    return compare(alone, killed, args.trials) and done == args.kills and within > 0


def measured(words):
    """Seconds on the clock, seconds of the processor, and peak memory in MB of a command."""
    with tempfile.NamedTemporaryFile("r") as file:
        command = ["/usr/bin/time", "--quiet", "--format=%e %U %S %M", f"--output={file.name}", *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in (0, 1):
            sys.exit(f"{words}: {done.stderr}")
        wall, user, system, memory = map(float, file.read().split())
    return wall, user + system, memory / 1024


def chunk(args, folder):
    """Twenty trials by one run-one, and by one taxel run: alternately, the median of what each pair differs by."""
    configs = []
    for seed in range(20):
        configs.append(folder / f"own-{seed}.toml")
        own = CONFIG.format(epochs=args.epochs)
        configs[-1].write_text(own.replace('name = "tiny"', f'name = "own-{seed}"\nseed = {seed}'))
    ones, runs = [], []
    for attempt in range(args.rounds):
        path = plan(args, folder, f"chunk-{attempt}", "seed", range(20), args.epochs)
        pair = [
            lambda: ones.append(measured([args.taxel, "sweep", "run-one", path, "--index", 0, "--count", 20, "--threads", 1, "--quiet"])),
            lambda: runs.append(measured([args.taxel, "run", *configs, "--output", folder / f"own-{attempt}", "--threads", 1])),
        ]
        for one in pair if attempt % 2 else reversed(pair):
            one()
    for i, what in enumerate(("on the clock", "of the processor")):
        one, run = (statistics.median(times[i] for times in all) for all in (ones, runs))
        over = sorted(100 * (a[i] / b[i] - 1) for a, b in zip(ones, runs))
        print(
            f"a chunk of 20 trials: {one:.2f} s {what}; the same configs by one taxel run: {run:.2f} s; "
            f"overhead {statistics.median(over):.1f} % ({over[0]:.1f} to {over[-1]:.1f} in {args.rounds} pairs)"
        )


def many(args, folder):
    for count in (args.planned // 10, args.planned):
        (folder / "tiny.toml").write_text(CONFIG.format(epochs=2))
        study, path = folder / "many.toml", folder / f"many-{count}"
        study.write_text(GRID.format(epochs=2, key="train.optimizer.lr", values=", ".join(str(1e-6 * (i + 1)) for i in range(count))))
        figures = []
        for name, words in {
            "plan": ["plan", study, "--output", path],
            "emit": ["emit", "slurm", path, "--seconds-per-trial", 5],
            "collect": ["collect", path],
        }.items():
            seconds, _, memory = measured([args.taxel, "sweep", *words])
            figures.append(f"{name} {seconds:.2f} s, {memory:.0f} MB")
        print(f"{count} trials of nothing: " + "; ".join(figures))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taxel", default="target/release/taxel")
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--planned", type=int, default=10000)
    parser.add_argument("--epochs", type=int, default=600, help="of the trials of a chunk")
    parser.add_argument("--rounds", type=int, default=9, help="pairs of a chunk and a run")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--costs", action="store_true", help="no kills: 2 and 3 alone")
    args = parser.parse_args()
    args.taxel = str(pathlib.Path(args.taxel).resolve())
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        equal = args.costs or kills(args, folder)
        chunk(args, folder)
        many(args, folder)
    sys.exit(0 if equal else 1)


if __name__ == "__main__":
    main()
