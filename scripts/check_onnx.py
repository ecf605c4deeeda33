#!/usr/bin/env python3
"""Exports every listed network as ONNX and compares onnxruntime's and tract's logits with taxel's.

    cargo build --release && python3 scripts/check_onnx.py [NETWORK...] [--binary target/release/taxel] [--most 30000000]

Needs torch, numpy, safetensors, onnx, onnxruntime and, for that column, tract.
For each name that `taxel zoo` lists, its twin in `scripts/twin` gives names and shapes of tensors, a formula their values,
at the published input size. `taxel export` writes the model, `onnx.checker` checks it in full, and
`taxel forward`, onnxruntime and tract predict three samples. Then models are trained for a few epochs on simulated grasps,
MiniRocket and ridge among them, exported with their encoding, and onnxruntime predicts raw samples, foreign ones among them; `--trained` does that
alone and needs no torch. Ends with 1 if answers differ by more than 1e-4 of the largest, or the most likely class differs, or other
samples are unknown.
"""

import argparse
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy as np
import onnx
import onnxruntime

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts" / "twin"))
sys.path.insert(0, str(ROOT / "scripts" / "fixtures"))
try:
    import tract
except ImportError:
    tract = None

SAMPLES = 3
TOLERANCE = 1e-4


def save(path, tensors):
    """A .safetensors: eight bytes of length, a JSON header, values."""
    header, offset = {}, 0
    for name, values in tensors.items():
        header[name] = {"dtype": "F32", "shape": list(values.shape), "data_offsets": [offset, offset + values.nbytes]}
        offset += values.nbytes
    text = json.dumps(header).encode()
    with open(path, "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text)
        for values in tensors.values():
            file.write(values.tobytes())


def run(binary, *arguments):
    done = subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"taxel {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def by_onnxruntime(path, inputs):
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    names = [own.name for own in session.get_inputs()]
    outputs = [own.name for own in session.get_outputs()]
    return dict(zip(outputs, session.run(outputs, dict(zip(names, inputs)))))


def by_tract(path, inputs):
    """tract's answers in the order of outputs."""
    model = tract.onnx().load(str(path))
    for at, x in enumerate(inputs):
        model.set_input_fact(at, ",".join(map(str, x.shape)) + ",f32")
    for at in range(model.output_count()):
        model.set_output_fact(at, None)
    answers = model.into_model().into_runnable().run(list(inputs))
    return [answer.to_numpy() for answer in answers]


def difference(want, got):
    """Relative to the largest value, and whether each sample's largest is the same; NaN is above everything."""
    want, got = want.reshape(len(want), -1).astype(np.float64), got.reshape(len(got), -1).astype(np.float64)
    gap = np.abs(got - want).max() / max(np.abs(want).max(), 1e-30)
    return gap if gap == gap else np.inf, bool((want.argmax(1) == got.argmax(1)).all())


def compare(name, folder, binary):
    # Imported here: trained models need no torch.
    import networks
    from formula import hashed, tensor

    net = networks.build(name)
    state = {n: v for n, v in net.state_dict().items() if not n.endswith("num_batches_tracked")}
    save(folder / "w.safetensors", {n: np.asarray(tensor(n, tuple(v.shape), i), np.float32) for i, (n, v) in enumerate(state.items())})
    inputs = []
    for number, shape in enumerate(networks.input_shapes(name)):
        inputs.append(hashed(SAMPLES * int(np.prod(shape)), 500 + number).reshape(SAMPLES, *shape).astype(np.float32))
        if name == "mobilenet-v2-split":
            # The second sample is touch alone.
            inputs[-1][1, : shape[0] // 2] = 0
        np.save(folder / f"x{number}.npy", inputs[-1])
    path = folder / "model.onnx"
    run(binary, "export", name, "--output", path, "--weights", folder / "w.safetensors")
    onnx.checker.check_model(str(path), full_check=True)
    call = ["forward", "--model", name, "--weights", folder / "w.safetensors", "--output", folder / "y.npy"]
    for number in range(len(inputs)):
        call += ["--input", folder / f"x{number}.npy"]
    run(binary, *call)
    theirs = by_onnxruntime(path, inputs)
    single = len(theirs) == 1
    ours = {output: np.load(folder / ("y.npy" if single else f"y.{output}.npy")) for output in theirs}
    results = {"onnxruntime": [difference(ours[output], theirs[output]) for output in ours]}
    if tract is not None:
        try:
            results["tract"] = [difference(want, got) for want, got in zip(ours.values(), by_tract(path, inputs))]
        except Exception as error:  # noqa: BLE001  (tract raises its own kind)
            results["tract"] = str(error).strip().splitlines()[0][:90]
    return results


CONFIG = """
name = "small"
baselines = BASELINES
[data]
scene = "fingertip"
samples = 60
TARGET
[encoding]
signal = SIGNAL
[protocol]
kind = "k-fold"
folds = 2
[train]
epochs = 3
loss = "LOSS"
[[networks]]
name = "NETWORK"
"""
ENTROPY, Z_SCORE = "softmax-cross-entropy", '{ scale = "z-score" }'
# Method, loss, encoding of the signal, and whether values are learned.
TRAINED = [
    ("resnet8-lite-1d", ENTROPY, Z_SCORE, False),
    ("mlp", ENTROPY, Z_SCORE, False),
    ("mlp", "cumulative-logits", Z_SCORE, False),
    ("resnet8-lite-1d", ENTROPY, '{ kind = "quantile-code" }', False),
    ("mlp", ENTROPY, '{ kind = "quantile-code", steps = 12 }', False),
    ("mlp", ENTROPY, '{ kind = "history" }', False),
    ("mini-rocket", ENTROPY, Z_SCORE, False),
    ("deep-mlp", "huber", '{ kind = "history", lags = [1, 3, 9] }', True),
    ("deep-mlp", "gaussian-likelihood", '{ kind = "quantile-code" }', True),
    ("layer-norm-mlp", "huber", '{ kind = "history", lags = [1, 3, 9] }', True),
    ("ridge", "huber", Z_SCORE, True),
    ("mini-rocket", "huber", Z_SCORE, True),
]


def foreign(x):
    """Samples of dead, saturated, stuck and noisy sensors, and of others' gains, in the shape of `x`."""
    rng, full = np.random.default_rng(5), float(x.max())
    level = np.full_like(x[:5], full)
    return np.concatenate([0 * level, level, 0.4 * level, rng.uniform(0, full, level.shape), 10 * x[:5], 0.1 * x[:5]]).astype(np.float32)


def unknown(folder, x, binary):
    """Whether samples that the file's gates and `taxel predict` find unknown are others, and how many are unknown."""
    np.savez(folder / "all.npz", x=x)
    call = [binary, "predict", folder / "model.safetensors", folder / "all.npz", "--as-is", "--format", "npz", "--output", folder / "all-answers.npz"]
    run(*call)
    answers = np.load(folder / "all-answers.npz")
    facts = {entry.key: entry.value for entry in onnx.load(str(folder / "model.onnx")).metadata_props}
    outputs, beyond = by_onnxruntime(folder / "model.onnx", [x]), json.loads(facts["taxel.unknown_beyond"])
    ours = answers["unknown"]
    theirs = np.any([outputs[name] > limit for name, limit in beyond.items()], axis=0)
    near = np.any([abs(outputs[name] - limit) < 1e-3 * abs(limit) for name, limit in beyond.items()], axis=0)
    return bool(((ours != theirs) & ~near).any()), f"{int(theirs.sum())} of {len(x)}"


def trained(name, loss, signal, of_values, folder, binary):
    """A model with its encoding: its answers to raw readings, and what it finds unknown, against `taxel predict`."""
    is_network = name not in ("mini-rocket", "ridge")
    config = CONFIG.replace("NETWORK", name if is_network else "mlp").replace("LOSS", loss).replace("SIGNAL", signal)
    config = config.replace("BASELINES", "[]" if is_network else f'["{name}"]')
    (folder / "small.toml").write_text(config.replace("TARGET", 'y = "shore"' if of_values else ""))
    run(binary, "run", folder / "small.toml", "--output", folder / "run")
    run(binary, "fit", folder / "run", "--network", name, "--output", folder / "model.safetensors")
    run(binary, "simulate", "fingertip", "--samples", 20, "--seed", 7, "--output", folder / "new.npz")
    run(binary, "predict", folder / "model.safetensors", folder / "new.npz", "--format", "npz", "--output", folder / "answers.npz")
    run(binary, "export", folder / "model.safetensors", "--output", folder / "model.onnx")
    onnx.checker.check_model(str(folder / "model.onnx"), full_check=True)
    x = np.load(folder / "new.npz")["x"].astype(np.float32)
    answers = np.load(folder / "answers.npz")
    ours, theirs = ("predicted", "values") if of_values else ("probabilities", "probabilities")
    gap, equal = difference(answers[ours], by_onnxruntime(folder / "model.onnx", [x])[theirs])
    return gap, equal, *unknown(folder, np.concatenate([x, foreign(x)]), binary)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("networks", nargs="*", metavar="NETWORK")
    parser.add_argument("--binary", default=ROOT / "target" / "release" / "taxel")
    parser.add_argument("--trained", action="store_true", help="only models that are trained and exported with their encoding")
    parser.add_argument("--most", type=int, default=10**9, help="parameters of the largest network")
    args = parser.parse_args()
    listed = json.loads(run(args.binary, "zoo", "--format", "json"))
    names = [] if args.trained else args.networks or [entry["name"] for entry in listed if entry["parameters"] <= args.most]
    failed, worst, refused = [], {}, []
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            results = compare(name, pathlib.Path(folder), args.binary)
        words = []
        for runtime, found in results.items():
            if isinstance(found, str):
                words.append(f"{runtime}: {found}")
                refused.append(f"{name} ({runtime})")
                continue
            gap, equal = max(gap for gap, _ in found), all(equal for _, equal in found)
            worst[runtime] = max(worst.get(runtime, 0), gap)
            words.append(f"{runtime} {gap:.1e}{'' if equal else ' another class'}")
            if not (gap <= TOLERANCE and equal):
                failed.append(f"{name} ({runtime})")
        print(f"{name:20} {'  '.join(words)}", flush=True)
    if not args.networks:
        for name, loss, signal, of_values in TRAINED:
            with tempfile.TemporaryDirectory() as folder:
                gap, equal, other, count = trained(name, loss, signal, of_values, pathlib.Path(folder), args.binary)
            words = f"{signal} {'values' if of_values else 'classes'}, {loss}, trained, raw readings"
            print(f"{name:20} {words}: onnxruntime {gap:.1e}{'' if equal else ' another class'}, unknown {count}{', but others' if other else ''}", flush=True)
            if not (gap <= TOLERANCE and equal) or other:
                failed.append(f"{name} (trained)")
    if names:
        print(f"{len(names)} networks; largest differences: " + ", ".join(f"{runtime} {gap:.1e}" for runtime, gap in worst.items()))
    if refused:
        print(f"not run: {', '.join(refused)}")
    if failed:
        raise SystemExit(f"further than {TOLERANCE:g} from taxel, or of another class: {', '.join(failed)}")


if __name__ == "__main__":
    main()
