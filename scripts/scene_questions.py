#!/usr/bin/env python3
"""Runs one short experiment for each scene that contradicts its paper: writes docs/scenes/questions.md.

    cargo build --release          # or TAXEL=/path/to/taxel
    python3 scripts/scene_questions.py runs/questions [--only fingertip glove gripper bags multiscale] [--threads 2]

Trainings go into folders below the one named and resume where they were stopped. fingertip takes about 10 min on two cores,
glove five, gripper one, bags about 20, multiscale about 15. glove needs TAXEL_DATA. Needs numpy and scikit-learn.
"""

import argparse
import json
import os
import pathlib
import subprocess

import numpy as np
from sklearn.linear_model import LogisticRegression, RidgeCV
from sklearn.model_selection import GroupKFold, StratifiedKFold, cross_val_predict, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler

ROOT = pathlib.Path(__file__).resolve().parents[1]
TAXEL = os.environ.get("TAXEL", ROOT / "target" / "release" / "taxel")
PAGE = ROOT / "docs" / "scenes" / "questions.md"


def simulate(out, scene, samples, *settings):
    """A scene as the arrays of its archive; its seed is that of the configs."""
    subprocess.run([TAXEL, "simulate", scene, "--samples", str(samples), "--seed", "0", *settings, "--output", out], check=True)
    with np.load(out) as arrays:
        return {name: arrays[name] for name in arrays}


def again(out, source, arrays):
    """The same recordings with other values; the facts beside them stay."""
    np.savez(out, **arrays)
    out.with_suffix(".classes.json").write_text(source.with_suffix(".classes.json").read_text())
    return out


def run(out, config, threads, rows, *settings):
    """Mean accuracy and standard deviation of each row over its folds, in %."""
    command = [TAXEL, "run", ROOT / "configs" / config, "--output", out, "--resume", "--threads", str(threads)]
    done = subprocess.run([*command, "--only", ",".join(rows), "--format", "json", *settings], check=True, capture_output=True, text=True)
    networks = {own["network"]: own["measured"] for own in json.loads(done.stdout)["networks"]}
    own = {row: networks[row] for row in rows}
    return {row: (each["mean"]["accuracy"], (each.get("sd") or {}).get("accuracy")) for row, each in own.items()}


def shown(score):
    mean, sd = score
    return f"{mean:.1f}" if sd is None else f"{mean:.1f} ± {sd:.1f}"


def own_range(x):
    """Each grasp [N, channels, readings] from 0 to 1 of its own range; one that is constant becomes 0."""
    low, high = x.min(axis=(1, 2), keepdims=True), x.max(axis=(1, 2), keepdims=True)
    return (x - low) / np.where(high > low, high - low, np.float32(1))


def fingertip(folder, threads):
    """Whether images beat series, or the range that each is scaled to."""
    config, lines, images = "hardness/hardness.toml", ["vgg6-lite-1d", "resnet8-lite-1d", "densenet6-lite-1d"], ["resnet8-lite-2d"]
    source = folder / "fingertip.npz"
    arrays = simulate(source, "fingertip", 1500)
    own = again(folder / "fingertip-own-range.npz", source, {**arrays, "x": own_range(arrays["x"].astype(np.float32))})
    fixed = ["--set", "encoding.image.range={low=0,high=1023}"]
    one = [run(folder / "series", config, threads, lines), run(folder / "series-own-range", config, threads, lines, "--data", own)]
    two = [run(folder / "images-full-scale", config, threads, images, *fixed), run(folder / "images", config, threads, images)]
    rows = [f"| {name} | {' | '.join(shown(side[name]) for side in sides)} |" for names, sides in ((lines, one), (images, two)) for name in names]
    return ["| network | strength kept | each grasp on its own range |", "|---|---:|---:|", *rows]


def glove(folder, threads):
    """The same of a person's glove with five force sensors."""
    config, rows = "real/fsr-glove28.toml", ["vgg6-lite-1d", "resnet8-lite-1d"]
    series = ["--set", "networks=[" + ", ".join(f'{{ name = "{name}" }}' for name in rows) + "]"]
    source = pathlib.Path(os.environ["TAXEL_DATA"]) / "fsr-glove28"
    with np.load(source / "data.npz") as arrays:
        arrays = {name: arrays[name] for name in arrays}
    own = folder / "glove-own-range"
    own.mkdir(exist_ok=True)
    # The config takes the force sensors out of all channels.
    arrays["x"][:, 30:35] = own_range(arrays["x"][:, 30:35])
    np.savez(own / "data.npz", **arrays)
    (own / "labels.json").write_text((source / "labels.json").read_text())
    kept = run(folder / "glove-series", config, threads, rows, *series)
    ranged = run(folder / "glove-series-own-range", config, threads, rows, *series, "--data", own)
    images = run(folder / "glove-images", config, threads, ["vgg6-lite-2d"])
    lines = [f"| {name} | {shown(kept[name])} | {shown(ranged[name])} |" for name in rows]
    lines += [f"| {name} | – | {shown(score)} |" for name, score in images.items()]
    return ["| network | strength kept | each grasp on its own range |", "|---|---:|---:|", *lines]


def touched(arrays):
    """Plain measurements of a grasp, per finger: pressure, how it fades in the hold, when it is gone, how the first touch rings."""
    x = arrays["x"].astype(float)
    contact, stop = arrays["contact_s"] / 0.01, arrays["stop_s"] / 0.01
    features = []
    for own, first, last in zip(x, contact, stop):
        row = []
        for finger in own:
            pressure = finger[0] - finger[0][:30].mean()
            hold = pressure[int(last) + 1:][:98]
            top, end = hold[:4].mean(), hold[-10:].mean()
            gone = pressure[int(last) + 101:] < 0.2 * end
            ring = finger[1:].T.reshape(-1)[int(first * 22):][:22 * 12].reshape(12, 22)
            row += [top, hold[20:40].mean() / top, end / top, last - first, gone.argmax() if gone.any() else len(gone)]
            row += list(np.log1p(np.abs(ring - ring.mean(axis=1, keepdims=True)).max(axis=1)))
        features.append(row)
    return np.array(features)


def gripper(folder, threads):
    """Whether recordings of an unseen object contain its elasticity."""
    arrays = simulate(folder / "gripper.npz", "gripper", 1500)
    truth, objects = arrays["elasticity_level"], arrays["group"]
    ridge = make_pipeline(StandardScaler(), PolynomialFeatures(2), RidgeCV(np.logspace(0, 5, 12)))
    told = cross_val_predict(ridge, touched(arrays), truth, cv=GroupKFold(30), groups=objects)
    rows = []
    for name, levels in (("always 5", np.full(len(truth), 5.0)), ("ridge on 34 measurements", np.clip(np.round(told), 1, 10))):
        off = np.abs(levels - truth)
        rows.append(f"| {name} | {100 * (off == 0).mean():.1f} | {100 * (off <= 1).mean():.1f} | {off.mean():.2f} |")
    return ["| from grasps of 29 other objects | level, % | within one level, % | mean error, levels |", "|---|---:|---:|---:|", *rows]


def looked_at(frames):
    """Plain measurements of pressure images [N, rows, columns]: load, area, peaks, and how coarse the grain is."""
    x = frames.astype(float)
    load, area = x.sum(axis=(1, 2)), (x > 8).sum(axis=(1, 2))
    power = np.abs(np.fft.rfft2(x - x.mean(axis=(1, 2), keepdims=True))) ** 2
    waves = np.hypot(np.fft.fftfreq(x.shape[1])[:, None], np.fft.rfftfreq(x.shape[2])[None])
    ends = np.linspace(0, 0.5, 11)
    grain = [np.log1p(power[:, (waves >= low) & (waves < high)].sum(axis=1)) for low, high in zip(ends, ends[1:])]
    inner = x[:, 1:-1, 1:-1]
    around = [x[:, 1 + i:x.shape[1] - 1 + i, 1 + j:x.shape[2] - 1 + j] for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    peaks = ((inner > 8) & np.all([inner >= other for other in around], axis=0)).sum(axis=(1, 2))
    return np.column_stack([load, area, x.max(axis=(1, 2)), peaks, load / np.maximum(area, 1), *grain])


def measured(x, labels):
    """Accuracy of a logistic regression on the frame of greatest force, and on four frames before it as well; 5 folds."""
    last = x.sum(axis=(2, 3), dtype=np.int64).argmax(axis=1)
    at = lambda share: looked_at(x[np.arange(len(x)), np.round(share * last).astype(int)])
    model = make_pipeline(StandardScaler(), LogisticRegression(C=0.3, max_iter=2000))
    folds = StratifiedKFold(5, shuffle=True, random_state=0)
    parts = [at(1.0)], [at(share) for share in (0.2, 0.4, 0.6, 0.8, 1.0)]
    scores = [100 * cross_val_score(model, np.hstack(part), labels, cv=folds) for part in parts]
    return [(own.mean(), own.std(ddof=1)) for own in scores]


def bags(folder, threads):
    """Whether the course of a squeeze says more than its frame of greatest force, to the same network or to plain measurements."""
    rows = []
    for subset in ("in-bag", "deformable"):
        config, source = f"palpation/palpation-003-fig-6-{subset}.toml", folder / f"{subset}.npz"
        arrays = simulate(source, "palpation", 480, "--set", "paper=003", "--set", f"subset={subset}")
        x = arrays["x"]
        peak = x[np.arange(len(x)), x.sum(axis=(2, 3), dtype=np.int64).argmax(axis=1)]
        still = again(folder / f"{subset}-still.npz", source, {**arrays, "x": np.repeat(peak[:, None], x.shape[1], axis=1)})
        name = "tactnet3d-51-pool.n10"
        settings = ["--set", "protocol.repetitions=3", "--set", "protocol.per_class=[10]"]
        sides = [run(folder / f"{subset}{end}", config, threads, [name], *settings, *data)[name]
                 for end, data in (("", ["--data", source]), ("-still", ["--data", still]))]
        one, five = measured(x, arrays["y"])
        rows.append(f"| {subset} | {' | '.join(map(shown, [sides[1], sides[0], one, five]))} |")
    head = ("| objects | pooled TactNet3D, 10 squeezes of each: frame of greatest force, 51 times | whole squeeze "
            "| logistic regression on 15 measurements: of that frame | of five frames up to it |")
    return [head, "|---|---:|---:|---:|---:|", *rows]


# Changes of the network of Zhang et al. 2022 or of its training, one at a time: folder, words, settings, settings of the network.
CHANGES = [
    ("as-is", "as the paper has it", [], ""),
    ("he", "weights drawn by He's rule, not normal with SD 1", ['train.init="he"'], ""),
    ("glorot", "weights drawn by Glorot's rule", ['train.init="glorot"'], ""),
    ("rate-ten", "ten times the learning rate", ["train.optimizer.lr=0.01"], ""),
    ("epochs-300", "three times the epochs", ["train.epochs=300"], ""),
    ("quarter", "a quarter of the channels in every layer", [], ", set = { width_mult = 0.25 }"),
    ("no-hidden", "without its hidden layer", [], ", set = { without_layers = 1 }"),
    ("grasps-6000", "four times the grasps", ["data.samples=6000"], ""),
]


def multiscale(folder, threads):
    """Why the network of Zhang et al. 2022 lags behind MiniRocket on this scene; on grasps of a seed that no other page uses."""
    rows = []
    for name, words, changed, own in CHANGES:
        baselines = ["majority", "mini-rocket"] if name in ("as-is", "grasps-6000") else ["majority"]
        settings = [f'networks=[{{ name = "multiscale-cnn"{own} }}]', f"baselines={json.dumps(baselines)}", *changed]
        out = folder / f"multiscale-{name}"
        command = [TAXEL, "run", ROOT / "configs" / "strength" / "strength-004-table-2.toml", "--output", out, "--resume", "--seed", "1"]
        command += ["--threads", str(threads), *(part for setting in settings for part in ("--set", setting))]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        results = {row["network"]: row for row in json.loads((out / "results.json").read_text())["networks"]}
        epochs = [json.loads(line) for line in (out / "metrics.jsonl").read_text().splitlines()]
        known = [line["train_accuracy"] for line in epochs if line["network"] == "multiscale-cnn"][-1]
        asked = [("multiscale-cnn", f"multiscale-cnn, {words}", f"{known:.1f}")]
        asked += [("mini-rocket", f"MiniRocket, {words}" if changed else "MiniRocket", "–")] * ("mini-rocket" in baselines)
        for row, shown_as, learned in asked:
            levels = " | ".join(f"{100 * attribute['accuracy']:.1f}" for attribute in results[row]["attributes"])
            rows.append(f"| {shown_as} | {results[row]['costs']['parameters']:,} | {learned} | {levels} |")
    return ["| | parameters | training samples, % | elasticity, % | hardness, % |", "|---|---:|---:|---:|---:|", *rows]


ASKED = {"fingertip": fingertip, "glove": glove, "gripper": gripper, "bags": bags, "multiscale": multiscale}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path, help="where trainings and recordings go")
    parser.add_argument("--only", nargs="+", choices=ASKED, default=list(ASKED), help="the questions asked; the others stay on the page as they are")
    parser.add_argument("--threads", type=int, default=2)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    for name in args.only:
        table = "\n".join(ASKED[name](args.folder, args.threads))
        start, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        page = PAGE.read_text()
        head, rest = page.split(start, 1)
        PAGE.write_text(head + start + table + "\n" + end + rest.split(end, 1)[1])


if __name__ == "__main__":
    main()
