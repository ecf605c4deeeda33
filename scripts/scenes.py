"""Draws the pictures of docs/scenes.md and writes its tables, from `taxel simulate` and real recordings.

Run from the repository root; needs NumPy, matplotlib, Pillow, scikit-learn and PyTorch:

    cargo build --release          # or TAXEL=/path/to/taxel
    TAXEL_DATA=/path/to/recordings python3 scripts/scenes.py [pictures] [looks] [gels] [hands] [statistics] [difficulty]

Pictures and tables go to docs/scenes/. Pictures of real recordings go to docs/scenes/real/, which git
ignores: most of those data sets state no licence. Without TAXEL_DATA the real columns are left empty.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "docs" / "scenes"
DATA = os.environ.get("TAXEL_DATA")
TAXEL = os.environ.get("TAXEL", ROOT / "target" / "release" / "taxel")


def simulate(scene: str, samples: int, *options: str, seed: int = 0):
    """Arrays and names of a simulated data set."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "set.npz"
        command = [TAXEL, "simulate", scene, "--samples", str(samples)]
        subprocess.run([*command, "--seed", str(seed), *options, "--output", out], check=True, capture_output=True)
        arrays = dict(np.load(out))
        names = json.loads((Path(folder) / "set.classes.json").read_text())["classes"]
    return arrays, names


def real(name: str):
    if DATA is None:
        return None
    folder = Path(DATA) / name
    return dict(np.load(folder / "data.npz")), json.loads((folder / "labels.json").read_text())["classes"]


# Pictures


def save(figure, path: Path) -> None:
    """A PNG of 64 colours, a third of the size."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)
    Image.open(path).convert("RGB").quantize(64).save(path, optimize=True)


def frames_of(rows: list, title: str, path: Path, times: list[str]) -> None:
    """One row of pressure frames per (name, [frames])."""
    figure, axes = plt.subplots(len(rows), len(times), figsize=(1.5 * len(times) + 1.6, 0.9 * len(rows) + 0.5))
    for line, (name, frames) in zip(axes, rows):
        for axis, frame in zip(line, frames):
            axis.imshow(frame, vmin=0, vmax=255, cmap="viridis")
            axis.set_xticks([]), axis.set_yticks([])
        line[0].set_ylabel(name, rotation=0, ha="right", va="center", fontsize=7)
    for axis, time in zip(axes[0], times):
        axis.set_title(time, fontsize=7)
    figure.suptitle(title, fontsize=8)
    figure.tight_layout()
    save(figure, path)
    plt.close(figure)


def grasps_of(rows: list, title: str, path: Path) -> None:
    """Rows of (name, grasps [n, 5 fingers, 50 readings]), shares of full scale."""
    figure, axes = plt.subplots(len(rows), len(rows[0][1]), figsize=(9, 1.4 * len(rows)), sharex=True, sharey=True)
    for line, (name, grasps) in zip(axes, rows):
        line[0].set_ylabel(name, fontsize=7)
        for axis, grasp in zip(line, grasps):
            axis.plot(grasp.T, lw=0.8)
            axis.set_ylim(-0.02, 1.02), axis.tick_params(labelsize=6)
    figure.suptitle(title + "; five fingers, 50 readings, shares of full scale", fontsize=8)
    figure.tight_layout()
    save(figure, path)
    plt.close(figure)


def pictures() -> None:
    arrays, names = simulate("fingertip", 60)
    rows = [(name, arrays["x"][arrays["y"] == c][:5] / 1023) for c, name in enumerate(names)]
    grasps_of(rows, "simulated: fingertip (Kaewrakmuk and Srinonchat 2026)", OUT / "fingertip.png")
    if DATA:
        recorded, names = real("fsr-glove28")
        shown = [3, 9, 15, 21]
        rows = [(names[c], recorded["x"][recorded["y"] == c][:5, 30:35] / 5) for c in shown]
        grasps_of(rows, "real: fsr-glove28", OUT / "real" / "fsr-glove28.png")
    arrays, names = simulate("palpation", 24)
    shown = [1, 2, 4, 5, 8, 12, 13, 14, 15, 17, 20, 22]
    at = [0, 6, 13, 19, 25, 38]
    rows = [(names[i], arrays["x"][i][at]) for i in shown]
    frames_of(rows, "simulated: palpation (Pastor et al. 2019)", OUT / "palpation-003.png", [f"frame {t}" for t in at])
    arrays, names = simulate("palpation", 9, "--set", "paper=002")
    at = [0, 1, 2, 3, 4, 7]
    rows = [(names[i], arrays["x"][i][at]) for i in range(9)]
    frames_of(rows, "simulated: palpation (Gandarias et al. 2019b)", OUT / "palpation-002.png", [f"frame {t}" for t in at])
    if DATA:
        recorded, names = real("tekscan3d-fixtures24")
        at = [0, 4, 8, 12, 16, 20]
        rows = [(name, recorded["x"][np.flatnonzero(recorded["y"] == c)[0]][at]) for c, name in enumerate(names)]
        title = "real: tekscan3d-fixtures24"
        frames_of(rows, title, OUT / "real" / "tekscan3d-fixtures24.png", [f"frame {t}" for t in at])

    arrays, _ = simulate("gripper", 30)
    shown = [("garbage bag: 1, 1", 1), ("square sponge: 10, 2", 8), ("draw paper: 6, 4", 3), ("tennis: 10, 7", 12), ("metal column: 1, 10", 18)]
    figure, axes = plt.subplots(len(shown), 3, figsize=(9, 8))
    for line, (name, i) in zip(axes, shown):
        x, contact = arrays["x"][i].astype(float), arrays["contact_s"][i]
        line[0].plot(np.arange(450) / 100, x[:, 0].T, lw=0.8)
        line[0].axvline(contact, color="0.6", lw=0.5)
        line[0].set_ylabel(name + "\nDC, bit", fontsize=7)
        ac, time = x[0, 1:].T.ravel(), np.arange(9900) / 2200
        line[1].plot(time, ac, lw=0.3)
        tap = (time > contact - 0.01) & (time < contact + 0.06)
        line[2].plot(1e3 * (time[tap] - contact), ac[tap], lw=0.8)
    for axis, title in zip(axes[0], ["both fingers, s", "AC of one finger, bit, s", "AC around contact, ms"]):
        axis.set_title(title, fontsize=7)
    for axis in axes.ravel():
        axis.tick_params(labelsize=6)
    figure.suptitle("simulated: gripper (Zhang et al. 2022); elasticity, hardness", fontsize=8)
    figure.tight_layout()
    save(figure, OUT / "gripper.png")
    plt.close(figure)
    spectrum_picture(arrays)
    looks()
    gels()
    hands()


def tiled(x: np.ndarray, rows: int) -> np.ndarray:
    """Colour pictures [N, 3, H, W] as one, row by row."""
    n, _, height, width = x.shape
    return x.reshape(rows, n // rows, 3, height, width).transpose(0, 3, 1, 4, 2).reshape(rows * height, -1, 3)


def looks() -> None:
    """Each object twice: another light, texture, background and pose."""
    arrays, _ = simulate("vision", 60, seed=1)
    tiles = tiled(arrays["x"], 4)
    Image.fromarray((255 * tiles).round().astype(np.uint8)).quantize(128).save(OUT / "vision.png", optimize=True)


def gels() -> None:
    """Four touches of each cloth, a column per cloth; below eight of each class of objects, two in a row."""
    cloths, objects = (
        tiled(simulate("gel", 48, "--set", f"touches={touches}", seed=1)[0]["x"], 4) for touches in ("cloths", "objects")
    )
    gap = np.full((8, cloths.shape[1], 3), 255)
    picture = np.concatenate([cloths, gap, objects]).astype(np.uint8)
    Image.fromarray(picture).quantize(128).save(OUT / "gel.png", optimize=True)


def hands() -> None:
    """One grasp of each object: its electrodes over time, and what they lose in the hold."""
    arrays, names = simulate("hand", 3, seed=1)
    figure, axes = plt.subplots(2, 3, figsize=(9, 4), height_ratios=[3, 2])
    for c, name in enumerate(names):
        x = arrays["x"][c].astype(float)
        lost = x[0] - x
        axes[0, c].plot(np.arange(700) / 100, lost.reshape(700, 21), lw=0.6)
        axes[0, c].set_title(name, fontsize=8), axes[0, c].set_ylim(-10, 420), axes[0, c].tick_params(labelsize=6)
        axes[1, c].imshow(lost[280].T, vmin=0, vmax=400), axes[1, c].set_xticks([]), axes[1, c].set_yticks([])
    axes[0, 0].set_ylabel("counts below rest", fontsize=7), axes[1, 0].set_ylabel("at 2.8 s", fontsize=7)
    figure.suptitle("simulated: hand, 7 × 3 electrodes over 7 s", fontsize=8)
    figure.tight_layout()
    save(figure, OUT / "hand.png")
    plt.close(figure)


def spectrum_picture(arrays: dict) -> None:
    figure, axis = plt.subplots(figsize=(5, 3))
    frequency, power = spectrum(holds(arrays))
    axis.loglog(frequency, power, label="simulated: gripper, hold", lw=0.8)
    axis.set_xlabel("Hz", fontsize=7), axis.set_ylabel("bit² per bin", fontsize=7)
    axis.tick_params(labelsize=6), axis.legend(fontsize=6)
    figure.tight_layout()
    save(figure, OUT / "gripper-spectrum.png")
    if DATA:
        frequency, power = spectrum(real_holds())
        axis.loglog(frequency, power, label="real: biotac-pr2-hold6, hold", lw=0.8)
        axis.legend(fontsize=6)
        save(figure, OUT / "real" / "spectrum.png")
    plt.close(figure)


# Statistics


def pressure(x: np.ndarray, y: np.ndarray) -> dict:
    """Of squeezes [N, 21, 28, 50], 255 at full scale; the mean over classes of the mean over samples."""

    def mean(values) -> float:
        return float(np.mean([np.mean(values[y == c], axis=0) for c in np.unique(y)]))

    def neighbours(apart: int):
        middle = x[:, 10] - x[:, 10].mean((1, 2), keepdims=True)
        product = (middle[:, :, :-apart] * middle[:, :, apart:]).mean((1, 2))
        return product / middle.var((1, 2))

    x = x.astype(np.float64)
    sums = x.sum((2, 3)) / 255
    return {
        "active taxels, first frame": mean((x[:, 0] > 0).mean((1, 2))),
        "active taxels, whole squeeze": mean((x > 0).mean((1, 2, 3))),
        "active taxels, last frame": mean((x[:, 20] > 0).mean((1, 2))),
        "frame sum, first frame (full scales)": mean(sums[:, 0]),
        "frame sum, middle frame": mean(sums[:, 10]),
        "frame sum, last frame": mean(sums[:, 20]),
        "saturated taxels": mean((x >= 255).mean((1, 2, 3))),
        "smallest reading above 0 (counts)": float(x[x > 0].min()),
        "correlation of neighbours, 1 apart": mean(neighbours(1)),
        "correlation of neighbours, 3 apart": mean(neighbours(3)),
    }


def fingers(x: np.ndarray, full: float) -> dict:
    """Of grasps [N, 5 fingers, 50 readings]; shares of full scale, means over the samples."""
    x = x.astype(np.float64) / full
    moves = np.diff(x, axis=2)
    peak = x.max(2)
    touched = peak > 0.05
    # Readings from a tenth to nine tenths of a finger's way up.
    low, high = x.min(2, keepdims=True), x.max(2, keepdims=True)
    way = (x - low) / np.maximum(high - low, 1e-9)
    rise = (way >= 0.9).argmax(2) - (way >= 0.1).argmax(2)
    end = x[:, :, 40:]
    shared = [np.corrcoef(grasp)[np.triu_indices(5, 1)].mean() for grasp in x if (grasp.std(1) > 0).all()]
    return {
        "fingers in contact (peak above 5 %)": float(touched.mean()),
        "peak of a finger in contact": float(peak[touched].mean()),
        "SD of peaks over a grasp's fingers": float(peak.std(1).mean()),
        "last 10 readings": float(end.mean()),
        "readings from 10 to 90 % of the way": float(rise[touched].mean()),
        "largest step between readings": float(np.abs(moves).max(2)[touched].mean()),
        "median step in the last 10 readings": float(np.median(np.abs(np.diff(end, axis=2)), axis=2)[touched].mean()),
        "change over the last 10 readings": float((end[:, :, -1] - end[:, :, 0])[touched].mean()),
        "saturated readings (above 99.5 %)": float((x > 0.995).mean()),
        "correlation between fingers": float(np.mean(shared)),
    }


def holds(arrays: dict, ticks: int = 75) -> np.ndarray:
    """AC of both fingers in the hold, [pieces, values], bits."""
    pieces = []
    for x, stop in zip(arrays["x"].astype(float), arrays["stop_s"]):
        start = int(stop * 100) + 22
        pieces += [finger[1:, start : start + ticks].T.ravel() for finger in x]
    return np.array(pieces)


def real_holds(ticks: int = 75) -> np.ndarray:
    x = real("biotac-pr2-hold6")[0]["x"][:, :, 19:41].astype(float)
    pieces = [finger[:, s : s + ticks].T.ravel() for grasp in x for finger in grasp for s in range(0, 900, 300)]
    return np.array(pieces)


def spectrum(pieces: np.ndarray, rate: float = 2200.0):
    pieces = pieces - pieces.mean(1, keepdims=True)
    power = (np.abs(np.fft.rfft(pieces, axis=1)) ** 2).mean(0) / pieces.shape[1] ** 2
    return np.fft.rfftfreq(pieces.shape[1], 1 / rate)[1:], power[1:]


def vibration(pieces: np.ndarray, rate: float, bands: list) -> dict:
    frequency, power = spectrum(pieces, rate)
    table = {"SD (bits)": float(pieces.std(1).mean())}
    for low, high in bands:
        share = power[(frequency > low) & (frequency <= high)].sum() / power.sum()
        table[f"power in {low} to {high} Hz"] = float(share)
    return table


def table(title: str, columns: dict) -> str:
    names = list(columns)
    lines = [f"### {title}", "", "| statistic | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
    for key in columns[names[0]]:
        values = [f"{columns[n][key]:.3g}" if columns[n] else "not at hand" for n in names]
        lines.append(f"| {key} | " + " | ".join(values) + " |")
    return "\n".join(lines) + "\n"


def statistics() -> None:
    arrays, _ = simulate("palpation", 480, "--set", "frames=41")
    recorded = real("tekscan3d-fixtures24")
    squeeze = {
        "simulated: palpation (003)": pressure(arrays["x"][:, :21], arrays["y"]),
        "real: tekscan3d-fixtures24": pressure(recorded[0]["x"], recorded[0]["y"]) if recorded else None,
    }
    arrays, _ = simulate("fingertip", 1500)
    glove = real("fsr-glove28")
    grasps = {
        "simulated: fingertip": fingers(arrays["x"], 1023),
        "real: fsr-glove28": fingers(glove[0]["x"][:, 30:35], 5.0) if glove else None,
    }
    arrays, _ = simulate("gripper", 300)
    fine = [(0, 5), (5, 20), (20, 50), (50, 200), (200, 1100)]
    hold = {
        "simulated: gripper, hold": vibration(holds(arrays), 2200, fine),
        "real: biotac-pr2-hold6, hold": vibration(real_holds(), 2200, fine) if DATA else None,
    }
    ticks = arrays["x"][:, :, 1:].mean(2).reshape(-1, 450)[:, :400]
    slide = real("biotac-slide20")
    coarse = [(0, 5), (5, 10), (10, 20), (20, 50)]
    slow = {
        "simulated: gripper, whole grasp, mean of each tick": vibration(ticks, 100, coarse),
        "real: biotac-slide20, sliding, mean of each tick": vibration(slide[0]["x"][:, 19], 100, coarse) if slide else None,
    }
    text = "<!-- written by scripts/scenes.py -->\n\n# Scenes beside real recordings\n\n"
    text += "Statistics of simulated samples beside those of the nearest real recordings. [scenes.md](../scenes.md) says how far they agree.\n\n"
    text += table("Grasp: five force-sensitive resistors, 50 readings, shares of full scale", grasps) + "\n"
    text += table("Squeeze: 21 frames from first touch to full force", squeeze) + "\n"
    text += table("AC in the hold, 2200 Hz", hold) + "\n" + table("AC at 100 Hz", slow)
    (OUT / "statistics.md").write_text(text)
    print(text)


# Difficulty


def train(x: np.ndarray, y: np.ndarray, fit, test, classes: list[int], flat: bool, epochs: int) -> np.ndarray:
    """Predictions of a small convolutional network, one column per attribute."""
    import torch
    from torch import nn

    torch.manual_seed(0)
    torch.set_num_threads(1)
    if flat:
        layers = [nn.Conv1d(x.shape[1], 32, 7, 2), nn.BatchNorm1d(32), nn.ReLU(), nn.Conv1d(32, 48, 5, 2), nn.BatchNorm1d(48), nn.ReLU(), nn.Conv1d(48, 48, 5, 2), nn.ReLU(), nn.AdaptiveMaxPool1d(8), nn.Flatten(), nn.Dropout(0.3), nn.Linear(384, sum(classes))]
    else:
        layers = [nn.Conv2d(x.shape[1], 24, 5, 2), nn.BatchNorm2d(24), nn.ReLU(), nn.Conv2d(24, 48, 3, 2), nn.BatchNorm2d(48), nn.ReLU(), nn.Conv2d(48, 48, 3), nn.ReLU(), nn.AdaptiveMaxPool2d(2), nn.Flatten(), nn.Dropout(0.3), nn.Linear(192, sum(classes))]
    network = nn.Sequential(*layers)
    steps = epochs * -(-len(fit) // 32)
    optimiser = torch.optim.Adam(network.parameters(), 2e-3)
    rate = torch.optim.lr_scheduler.OneCycleLR(optimiser, 4e-3, total_steps=steps)
    x, labels = torch.from_numpy(x.astype(np.float32)), torch.from_numpy(y)
    generator = np.random.default_rng(0)
    for _ in range(epochs):
        network.train()
        for rows in np.array_split(generator.permutation(fit), -(-len(fit) // 32)):
            parts = torch.split(network(x[rows]), classes, 1)
            loss = sum(nn.functional.cross_entropy(p, labels[rows, k]) for k, p in enumerate(parts))
            optimiser.zero_grad(), loss.backward(), optimiser.step(), rate.step()
    network.eval()
    with torch.no_grad():
        parts = torch.split(network(x[test]), classes, 1)
    return np.stack([p.argmax(1).numpy() for p in parts], 1)


HEAD = ["| data | classes | chance | 3-NN | small network |", "|---|---|---|---|---|"]


def difficulty() -> None:
    lines, notes = list(HEAD), []

    def tell(line: str, note: str) -> None:
        # Written as it goes: the whole takes minutes.
        lines.append(line), notes.append(note)
        head = "<!-- written by scripts/scenes.py -->\n\n# How hard the scenes are\n\n"
        head += "Accuracy on *simulated* samples: chance, three nearest neighbours on raw samples, and a small network.\n\n"
        text = head + "\n".join(lines) + "\n\n" + "\n".join(notes) + "\n"
        (OUT / "difficulty.md").write_text(text)
        print(line, note, sep="\n", flush=True)

    cylinders(tell)
    grips(tell)
    jobs = [("003", "all", 720), ("002", "all", 450), ("003", "rigid", 320), ("003", "deformable", 320), ("003", "in-bag", 320)]
    for paper, subset, samples in jobs:
        squeezes(paper, subset, samples, tell)


def nearest(x: np.ndarray, y: np.ndarray, fit, test) -> float:
    from sklearn.neighbors import KNeighborsClassifier

    x = x.reshape(len(x), -1)
    return 100 * (KNeighborsClassifier(3).fit(x[fit], y[fit]).predict(x[test]) == y[test]).mean()


def cylinders(tell) -> None:
    arrays, names = simulate("fingertip", 1500)
    x, y, session = arrays["x"].astype(np.float32), arrays["y"].astype(np.int64), arrays["group"]
    last = session.max()
    fit, test = np.flatnonzero(session != last), np.flatnonzero(session == last)
    z = (x - x[fit].mean((0, 2), keepdims=True)) / x[fit].std((0, 2), keepdims=True)
    predicted = train(z, y[:, None], fit, test, [len(names)], True, 20)[:, 0]
    near = nearest(z, y, fit, test)
    tell(
        f"| fingertip, unseen session, {len(x)} samples | {len(names)} | {100 / len(names):.1f} % | {near:.1f} % | {100 * (predicted == y[test]).mean():.1f} % |",
        f"- fingertip: most confused: {confused(y[test], predicted, names)}.",
    )


def squeezes(paper: str, subset: str, samples: int, tell) -> None:
    arrays, names = simulate("palpation", samples, "--set", f"paper={paper}", "--set", f"subset={subset}")
    y, session = arrays["y"].astype(np.int64), arrays["group"]
    frames = np.linspace(0, arrays["x"].shape[1] - 1, 9).astype(int)
    x = arrays["x"][:, frames].astype(np.float32) / 255
    fit, test = np.flatnonzero(session < 4), np.flatnonzero(session == 4)
    predicted = train(x, y[:, None], fit, test, [len(names)], False, 30)[:, 0]
    # One frame of each squeeze, wherever its force is: what a 2D method gets.
    some = np.random.default_rng(1).integers(0, x.shape[1], len(x))
    single = train(x[np.arange(len(x)), some][:, None], y[:, None], fit, test, [len(names)], False, 30)[:, 0]
    name, right = f"palpation, {paper}, {subset}", lambda guess: 100 * (guess == y[test]).mean()
    tell(
        f"| {name}, {samples} samples | {len(names)} | {100 / len(names):.1f} % | {nearest(x, y, fit, test):.1f} % | {right(predicted):.1f} % |",
        f"- {name}: from one random frame of each squeeze the network reaches {right(single):.1f} %. Most confused: {confused(y[test], predicted, names)}.",
    )


def grips(tell) -> None:
    arrays, _ = simulate("gripper", 900)
    y, session, thing = arrays["y"].astype(np.int64), arrays["session"], arrays["group"]
    x = cut(arrays["x"].astype(np.float32))
    for split, held in [("unseen session", session == 4), ("unseen objects", thing % 5 == 2)]:
        fit, test = np.flatnonzero(~held), np.flatnonzero(held)
        z = (x - x[fit].mean((0, 2), keepdims=True)) / x[fit].std((0, 2), keepdims=True)
        predicted = train(z, y, fit, test, [10, 10], True, 20)
        for k, attribute in enumerate(["elasticity", "hardness"]):
            gap = np.abs(predicted[:, k] - y[test, k])
            by_one = 100 * (gap == 1).sum() / max((gap > 0).sum(), 1)
            near = nearest(z[:, :, ::3], y[:, k], fit, test)
            tell(
                f"| gripper, {attribute}, {split}, 900 samples | 10 | 10.0 % | {near:.1f} % | {100 * (gap == 0).mean():.1f} % |",
                f"- gripper, {attribute}, {split}: {by_one:.0f} % of the network's errors are by one level. Mean absolute error: {gap.mean():.2f} levels.",
            )


def confused(y, predicted, names) -> str:
    pairs = {}
    for true, guess in zip(y, predicted):
        if true != guess:
            pairs[frozenset((true, guess))] = pairs.get(frozenset((true, guess)), 0) + 1
    worst = sorted(pairs.items(), key=lambda item: (-item[1], sorted(item[0])))[:3]
    return ", ".join(f"{names[min(pair)]} / {names[max(pair)]}" for pair, _ in worst)


def cut(x: np.ndarray) -> np.ndarray:
    """300 ticks from contact on, offsets removed, [N, 46 features, 300]."""
    samples = []
    for recording in x:
        ac = recording[:, 1:].transpose(0, 2, 1).reshape(2, -1)
        ratio = ac[:, 1:] / ac[:, :-1]
        onset = (np.flatnonzero(((ratio > 1.1) | (ratio < 0.9)).any(0))[0] + 1) // 22
        rest = recording[:, :, :onset].mean(2, keepdims=True)
        samples.append((recording - rest)[:, :, onset : onset + 300].reshape(46, 300))
    return np.array(samples)


if __name__ == "__main__":
    OUT.mkdir(exist_ok=True)
    steps = {"pictures": pictures, "looks": looks, "gels": gels, "hands": hands, "statistics": statistics, "difficulty": difficulty}
    for step in sys.argv[1:] or ["pictures", "statistics", "difficulty"]:
        steps[step]()
