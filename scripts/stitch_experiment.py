#!/usr/bin/env python3
"""Rouhafzay et al. 2021, section 7: two MobileNetV2 trained apart on pictures and imprints, stitched into one of two streams.

    TAXEL_WEIGHTS=... python3 scripts/stitch_experiment.py --taxel target/release/taxel --work runs/stitch

Needs numpy. Simulates imprints with pictures of the same objects, trains configs/visuotactile/
visuotactile-001-section-7.toml on each (layers 18 to 139 frozen as ImageNet left them), stitches the two with
`taxel stitch`, and lets the stitched network predict the test samples of both. It should predict what its parents
predict. Writes docs/results/visuotactile-001-section-7.md. Published: 100 % visual, 77.63 % tactile.
"""

import argparse
import json
import pathlib
import shlex
import subprocess

import numpy as np

from results_table import commit, config_line

ROOT = pathlib.Path(__file__).resolve().parents[1]
NAME = "visuotactile-001-section-7"
CONFIG = pathlib.Path("configs", "visuotactile", f"{NAME}.toml")
PUBLISHED = {"visual": 100.0, "tactile": 77.63}
# torchvision's, as scale = "imagenet" of the config.
MEAN, SD = [0.485, 0.456, 0.406], [0.229, 0.224, 0.225]


def call(*command) -> str:
    return subprocess.run([str(c) for c in command], check=True, stdout=subprocess.PIPE, text=True).stdout


def settings(args, stream) -> list[str]:
    """The settings that the training of one parent changes."""
    of_stream = ["data.x=view", "data.layout=colour", "encoding.image.red=false"] if stream == "visual" else []
    return ["data.full_scale=1", f"encoding.image.resize=[{args.size}, {args.size}]", *of_stream, *args.set]


def train(args, data, stream) -> pathlib.Path:
    """The run folder of one parent; taken as it is where it is there."""
    run = args.work / stream
    if not (run / "results.json").exists():
        options = [part for value in settings(args, stream) for part in ("--set", value)]
        call(args.taxel, "run", ROOT / CONFIG, "--data", data, "--threads", args.threads, "--output", run, *options)
    return run


def stitched(args, runs) -> pathlib.Path:
    models = {stream: next((run / "models").glob("frozen-18-139.*")) for stream, run in runs.items()}
    output = args.work / "stitched.safetensors"
    scale = ["--mean", ",".join(map(str, 2 * MEAN)), "--std", ",".join(map(str, 2 * SD))]
    sizes = ["--set", f"height={args.size}", "--set", f"width={args.size}", "--set", "classes=6"]
    print(call(args.taxel, "stitch", "--visual", models["visual"], "--tactile", models["tactile"], "--output", output,
               *scale, *sizes), end="")
    return output


def answers(args, weights, images, stream):
    """Class that the stitched network gives to images `[n, 3, size, size]` of one stream, the other dark."""
    both = np.zeros((len(images), 6, args.size, args.size), np.float32)
    (both[:, :3] if stream == "visual" else both[:, 3:])[...] = images
    np.save(args.work / "input.npy", both)
    sizes = ["--set", f"height={args.size}", "--set", f"width={args.size}", "--set", "classes=6"]
    call(args.taxel, "forward", "--model", "mobilenet-v2-split", "--weights", weights, "--input",
         args.work / "input.npy", "--output", args.work / "output.npy", *sizes)
    return np.load(args.work / f"output.{stream}.npy").argmax(1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taxel", default="target/release/taxel", type=pathlib.Path)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--size", type=int, default=128, help="elements of the array and pixels of the pictures")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], help="a further value of the config: train.epochs=2")
    args = parser.parse_args()
    args.taxel, args.work = args.taxel.resolve(), args.work.resolve()
    args.work.mkdir(parents=True, exist_ok=True)
    data = args.work / "both.npz"
    if not data.exists():
        call(args.taxel, "simulate", "imprint", "--samples", 840, "--set", f"elements={args.size}", "--set",
             f"view={args.size}", "--output", data)
    runs = {stream: train(args, data, stream) for stream in PUBLISHED}
    weights = stitched(args, runs)
    arrays = np.load(data)
    rows, counts = [], ["run,stream,samples,gained,lost"]
    for stream, run in runs.items():
        said = np.load(run / "predictions.npz")
        index, truth, parent = (said[f"frozen-18-139.{name}"] for name in ("index", "true", "predicted"))
        images = np.zeros((len(index), 3, args.size, args.size), np.float32)
        if stream == "visual":
            images[...] = arrays["view"][index]
        else:
            images[:, 0] = arrays["x"][index]
        both = answers(args, weights, images, stream)
        gained, lost = (np.sum((a == truth) & (b != truth)) for a, b in ((both, parent), (parent, both)))
        counts.append(f"{NAME},{stream},{len(index)},{gained},{lost}")
        percent = [100 * np.mean(own == truth) for own in (parent, both)]
        cells = [stream, f"{percent[0]:.2f}", f"{percent[1]:.2f}", f"{np.sum(parent == both)} of {len(index)}",
                 f"*{PUBLISHED[stream]:.2f}*"]
        rows.append("| " + " | ".join(cells) + " |")
        print(rows[-1])
    environment = json.loads((runs["tactile"] / "environment.json").read_text())
    head = "| stream | parent % [simulated: imprint] | stitched % | same answers | *published*: the paper's own data % |"
    # Where the work folder was says nothing.
    config = (runs["tactile"] / "config.toml").read_text().replace(str(data), data.name)
    sets = [part for value in args.set for part in ("--set", value)]
    command = shlex.join(["python3", "scripts/stitch_experiment.py", "--work", "runs/stitch", "--size", str(args.size), *sets])
    page = f"""# {NAME}

Generated by `scripts/stitch_experiment.py`.

Made again by:

```sh
{command}
```

{config_line(config, (CONFIG, [f"data.path={data.name}", *settings(args, "tactile")]))}

{head}
|---|---:|---:|---:|---:|
{chr(10).join(rows)}

Measured on simulated imprints and pictures of the same 30 objects, 840 samples, {args.size} × {args.size}, one split of
25 % test, seed 0. taxel {environment['taxel']} at {commit(environment)}, {environment['cpu']}. The stitched network sees one
stream at a time, the other is dark. Batch norms of the layers 18 to 139 keep ImageNet's statistics, in the parents too: both share the
middle, so it cannot have the statistics of either's samples.
"""
    results = ROOT / "docs" / "results"
    (results / f"{NAME}.md").write_text(page)
    # `taxel-reproduction claims` reads it.
    (results / "reference" / "stitched.csv").write_text("\n".join(counts) + "\n")


if __name__ == "__main__":
    main()
