#!/usr/bin/env python3
"""Measures what labelled touches of a new sensor gain: `taxel fit TOUCHES --from MODEL`; writes docs/benchmarks/tuning.md.

    python3 scripts/bench_tuning.py [--taxel target/release/taxel] [--output FILE]

Needs numpy and TAXEL_DATA. The set is fsi-tube1d, nine sensors. For each of them a network learns the other eight, goes on learning from
touches of this one, and is tested on touches of it that are in no draw.
"""

import argparse
import json
import os
import pathlib
import subprocess
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
CONFIG = ROOT / "configs" / "real" / "fsi-tube1d.toml"
TOUCHES, DRAWS = [10, 20, 50], 3


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--taxel", default=ROOT / "target" / "release" / "taxel", type=pathlib.Path)
    parser.add_argument("--output", default=ROOT / "docs" / "benchmarks" / "tuning.md", type=pathlib.Path)
    arguments = parser.parse_args()
    arrays = np.load(pathlib.Path(os.environ["TAXEL_DATA"]) / "fsi-tube1d" / "data.npz", allow_pickle=True)
    x, y, group = arrays["x"], arrays["y"].astype(np.float32), arrays["group"]

    def taxel(*words):
        done = subprocess.run([arguments.taxel, *map(str, words)], capture_output=True, text=True)
        assert done.returncode == 0, f"taxel {words}: {done.stderr}"
        return done.stdout

    errors = {0: [], **{touches: [] for touches in TOUCHES}}
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def save(name, rows):
            np.savez(folder / name, x=x[rows], y=y[rows], group=group[rows])
            return folder / name

        def error(model, file):
            answers = json.loads(taxel("predict", model, file, "--format", "json"))["answers"]
            said = np.array([list(answer["predicted"].values()) for answer in answers])
            return np.abs(said - np.load(file)["y"]).mean(0)

        for sensor in np.unique(group):
            of_sensor = np.flatnonzero(group == sensor)
            model, tuned = folder / "old.safetensors", folder / "new.safetensors"
            others = save("others.npz", np.flatnonzero(group != sensor))
            taxel("fit", CONFIG, "--network", "deep-mlp", "--data", others, "--output", model)
            for draw in range(DRAWS):
                order = np.random.default_rng(draw).permutation(of_sensor)
                test = save("test.npz", order[max(TOUCHES) :])
                errors[0].append(error(model, test))
                for touches in TOUCHES:
                    few = save("few.npz", order[:touches])
                    taxel("fit", few, "--from", model, "--quantities", "place_mm,force_N", "--output", tuned)
                    errors[touches].append(error(tuned, test))
            print(f"sensor {sensor} done", flush=True)

    lines = [
        "# Labelled touches of a new sensor",
        "",
        "The mean absolute error on a sensor that training has not seen, before and after the network goes on learning from a few labelled",
        f"touches of it (`taxel fit TOUCHES --from MODEL`). Mean over nine sensors and {DRAWS} draws of touches each, with the standard deviation",
        "over the sensors. Real data: fsi-tube1d. The number of epochs (300) was chosen on this set, among 30, 100, 300 and 1000.",
        "",
        "`scripts/bench_tuning.py` writes this page.",
        "",
        "| touches | place (mm) | force (N) |",
        "|---:|---:|---:|",
    ]
    for touches, each in errors.items():
        sensors = np.array(each).reshape(-1, DRAWS, 2).mean(1)
        cells = [f"{mean:.2f} ± {sd:.2f}" for mean, sd in zip(sensors.mean(0), sensors.std(0, ddof=1))]
        lines.append(f"| {touches} | {cells[0]} | {cells[1]} |")
        print(lines[-1])
    arguments.output.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
