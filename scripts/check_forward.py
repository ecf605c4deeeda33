#!/usr/bin/env python3
"""Compares the logits of every listed network with PyTorch's: weights made by PyTorch go through `taxel forward`.

    cargo build --release --features candle && python3 scripts/check_forward.py [NETWORK...] [--binary target/release/taxel]

Needs torch, numpy and safetensors. For each name that `taxel zoo` lists, its twin in `scripts/twin` gets weights
from a formula, saves them (`.safetensors`; `.pth` where the name is known from torchvision, as such users have)
and predicts two samples at the published input size in float64. `taxel forward` predicts with both backends. Prints
the largest difference per network, relative to the largest logit; ends with 1 if one is above 1e-4.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import torch
from safetensors.torch import save_file

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts" / "twin"))
sys.path.insert(0, str(ROOT / "scripts" / "fixtures"))
import networks  # noqa: E402
from formula import hashed, tensor  # noqa: E402

BATCH = 2
TOLERANCE = 1e-4
OUTPUTS = {"mobilenet-v2-split": ["visual", "tactile"]}


def answers(name, folder):
    """Saves weights and inputs; PyTorch's outputs by name."""
    net = networks.build(name).eval()
    names = [n for n in net.state_dict() if not n.endswith("num_batches_tracked")]
    state = {n: torch.tensor(tensor(n, tuple(net.state_dict()[n].shape), i)).float() for i, n in enumerate(names)}
    net.load_state_dict(state, strict=False)
    if name in networks.image_networks.TWINS:
        torch.save(net.state_dict(), folder / "w.pth")
    else:
        save_file({n: v.contiguous() for n, v in state.items()}, folder / "w.safetensors")
    inputs = []
    for number, shape in enumerate(networks.input_shapes(name)):
        x = hashed(BATCH * int(np.prod(shape)), 500 + number).reshape(BATCH, *shape).astype(np.float32)
        if name in OUTPUTS:
            # The second sample is touch alone.
            x[1, : shape[0] // 2] = 0
        np.save(folder / f"x{number}.npy", x)
        inputs.append(torch.from_numpy(x).double())
    with torch.inference_mode():
        outputs = net.double()(*inputs)
    return dict(zip(OUTPUTS[name], outputs)) if name in OUTPUTS else {"": outputs}


def gap(name, outputs, folder, binary, backend):
    weights = next(folder.glob("w.*"))
    call = [binary, "forward", "--model", name, "--weights", weights, "--backend", backend, "--output", folder / "y.npy"]
    for x in sorted(folder.glob("x*.npy")):
        call += ["--input", x]
    subprocess.run(call, check=True)
    worst = 0.0
    for output, want in outputs.items():
        got = np.load(folder / (f"y.{output}.npy" if output else "y.npy")).astype(np.float64)
        want = want.numpy()
        assert got.shape == want.shape, f"{name}: {got.shape} and {want.shape}"
        difference = np.abs(got - want).max() / np.abs(want).max()
        # NaN is above everything.
        worst = difference if not difference <= worst else worst
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("networks", nargs="*", metavar="NETWORK")
    parser.add_argument("--binary", default=ROOT / "target" / "release" / "taxel")
    args = parser.parse_args()
    listed = json.loads(subprocess.run([args.binary, "zoo", "--format", "json"], check=True, capture_output=True).stdout)
    failed = []
    for name in args.networks or [entry["name"] for entry in listed]:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            outputs = answers(name, folder)
            gaps = {backend: gap(name, outputs, folder, args.binary, backend) for backend in ("native", "candle")}
            suffix = next(folder.glob("w.*")).suffix
        print(f"{name:20} {suffix:12} " + "  ".join(f"{backend} {value:.1e}" for backend, value in gaps.items()), flush=True)
        if not all(value <= TOLERANCE for value in gaps.values()):
            failed.append(name)
    if failed:
        raise SystemExit(f"further than {TOLERANCE:g} from PyTorch: {', '.join(failed)}")


if __name__ == "__main__":
    main()
