#!/usr/bin/env python3
"""Kills a training at random moments, resumes it, and compares every byte with a run that was not killed.

    python3 scripts/kill_resume.py [--taxel target/release/taxel] [--kills 20] [--seed 0]

Five networks (1D, 2D, recurrent, 3D-free hybrids with dropout-free and batch-norm layers) and two baselines on the
simulated fingertip, two folds. Each network's run is killed (SIGKILL) at random moments of its length until
the kills are used up, and resumed each time. Exit code 0: all bytes are equal; 1: some differ. Wall times
(timings.jsonl, environment.json, folds/*.timing.json) are not results and not compared.
"""

import argparse
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

NETWORKS = ["mlp", "lstm", "resnet8-lite-1d", "vgg6-lite-2d", "hybrid-resvgg"]

CONFIG = """
name = "killed"
seed = 11
baselines = ["k-nn", "mini-rocket"]
[data]
scene = "fingertip"
samples = 120
[encoding]
image = {{ kind = "gadf", size = 50 }}
[protocol]
folds = 2
[train]
epochs = {epochs}
batch_size = 16
optimizer = {{ name = "adam", lr = 1e-3 }}
schedule = {{ kind = "cosine" }}
early_stopping = {{ patience = 4 }}
[choose]
grid = {{ "optimizer.lr" = [1e-2, 1e-3] }}
[[networks]]
name = "{network}"
"""
EPOCHS = {"mlp": 150, "lstm": 10, "resnet8-lite-1d": 40, "vgg6-lite-2d": 4, "hybrid-resvgg": 4}


def contents(folder):
    skipped = ("timings.jsonl", "environment.json", ".lock")
    files = (p for p in sorted(folder.rglob("*")) if p.is_file())
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in files
        if p.name not in skipped and not p.name.endswith(".timing.json")
    }


def command(args, config, out, resume):
    base = [args.taxel, "run", str(config), "--output", str(out), "--threads", "1", "--save-every", "0"]
    return base + (["--resume"] if resume else [])


def one(args, network, kills, dice, folder):
    config = folder / f"{network}.toml"
    config.write_text(CONFIG.format(network=network, epochs=EPOCHS[network]))
    whole, parts = folder / "whole", folder / "parts"
    start = time.monotonic()
    subprocess.run(command(args, config, whole, False), check=True, capture_output=True)
    length = time.monotonic() - start
    done = mid_fold = 0
    while done < kills:
        # Resuming repeats little, so moments are drawn over what is left at most.
        wait = dice.uniform(0.0, 1.2 * length / kills)
        process = subprocess.Popen(command(args, config, parts, parts.exists()), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        try:
            process.wait(wait)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            done += 1
            mid_fold += any((parts / "folds").glob("*.session.safetensors"))
            continue
        if process.returncode:
            sys.exit(f"{network}: {process.stderr.read().decode()}")
        # It was through before the kill: start over.
        shutil.rmtree(parts)
    resume = parts.exists()
    subprocess.run(command(args, config, parts, resume), check=True, capture_output=True)
    a, b = contents(whole), contents(parts)
    differ = sorted(set(a) ^ set(b)) + sorted(name for name in set(a) & set(b) if a[name] != b[name])
    print(f"{network}: {done} kills ({mid_fold} within a saved fold) in a run of {length:.1f} s, {len(a)} files: {'equal' if not differ else differ}")
    shutil.rmtree(whole)
    shutil.rmtree(parts)
    return not differ


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taxel", default="target/release/taxel")
    parser.add_argument("--kills", type=int, default=20, help="of all networks together")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    dice = random.Random(args.seed)
    shares = [args.kills // len(NETWORKS) + (i < args.kills % len(NETWORKS)) for i in range(len(NETWORKS))]
    with tempfile.TemporaryDirectory() as folder:
        equal = [one(args, network, kills, dice, pathlib.Path(folder)) for network, kills in zip(NETWORKS, shares)]
    sys.exit(0 if all(equal) else 1)


if __name__ == "__main__":
    main()
