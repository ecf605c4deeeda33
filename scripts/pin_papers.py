#!/usr/bin/env python3
"""Writes tests/papers/pins.json, with which tests/papers.rs compares the small experiment of each paper.

    cargo build --release
    python3 scripts/pin_papers.py            # about five minutes on two cores

Two things are kept of every config in tests/papers:

fixed    networks with their initial weights (a rate of 1e-30 changes none): costs, losses, confusion. They follow
         from scene, encoding, network, initialisation and protocol alone, to the last digits.
trained  the accuracy (%) of ten seeds, whose spread says what one seed may show.

A change that moves `fixed` says so in its commit, and why.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CONFIGS = ROOT / "tests" / "papers"
SEEDS = 10
# As in tests/papers.rs.
FIXED = ["train.optimizer.lr=1e-30", "train.epochs=1"]
CHOICE = 'choose.grid={"optimizer.lr"=[1e-30]}'


def run(binary, config, sets, out):
    """The networks of results.json, each with the loss of its first training."""
    values = [part for one in sets for part in ("--set", one)]
    command = [binary, "run", config, *values, "--output", out, "--threads", "2"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{config.name}: {done.stderr}")
    networks = json.loads((out / "results.json").read_text())["networks"]
    for network in networks:
        fold = json.loads((out / "folds" / f"{network['network']}.r0.f0.json").read_text())
        network["epochs"], network["test_loss"] = fold["epochs"], fold["test_loss"]
    return networks


def fixed(network):
    costs = network["costs"]
    return {
        "network": network["network"],
        "parameters": costs["parameters"],
        "macs": costs["macs"],
        "train_loss": network["epochs"][0]["train_loss"] if network["epochs"] else None,
        "test_loss": network["test_loss"],
        "accuracy": network["mean"]["accuracy"],
        "confusion": network.get("confusion"),
    }


def pins(binary, config, folder):
    choice = [CHOICE] if "[choose]" in config.read_text() else []
    drawn = run(binary, config, FIXED + choice, folder / f"{config.stem}-fixed")
    trained = {}
    for seed in range(SEEDS):
        for network in run(binary, config, [f"seed={seed}"], folder / f"{config.stem}-{seed}"):
            trained.setdefault(network["network"], []).append(round(network["mean"]["accuracy"], 2))
    return {
        "fixed": [fixed(network) for network in drawn],
        "trained": [{"network": name, "accuracy": accuracy} for name, accuracy in trained.items()],
    }


def lines(papers):
    """JSON with a line for each network, so that a diff names what has moved."""
    def rows(networks):
        return ",\n".join(f"   {json.dumps(network)}" for network in networks)

    kinds = {paper: [f'  "{kind}": [\n{rows(own)}\n  ]' for kind, own in kinds.items()] for paper, kinds in papers.items()}
    own = [f' "{paper}": {{\n' + ",\n".join(parts) + "\n }" for paper, parts in kinds.items()]
    return "{\n" + ",\n".join(own) + "\n}\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=ROOT / "target" / "release" / "taxel")
    binary = parser.parse_args().binary
    with tempfile.TemporaryDirectory() as folder:
        papers = {c.stem: pins(binary, c, Path(folder)) for c in sorted(CONFIGS.glob("*.toml"))}
    (CONFIGS / "pins.json").write_text(lines(papers))


if __name__ == "__main__":
    main()
