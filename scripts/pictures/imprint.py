"""Pictures and figures of the scene imprint, for docs/scenes/imprint.md.

Run from the repository root; needs numpy, matplotlib, pillow and scikit-learn:

    cargo build --release --locked
    TAXEL_DATA=... python3 scripts/pictures/imprint.py --taxel target/release/taxel --work runs/imprint

Writes docs/pictures/imprint-*.png, and puts the tables between the marks of the page. Run folders
that --work already holds are taken as they are. Without TAXEL_DATA the row of real recordings is
left out. Takes about 15 minutes on 2 cores, most of it training.
"""

import argparse
import json
import os
import subprocess
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image
from sklearn.ensemble import RandomForestClassifier
from sklearn.model_selection import StratifiedKFold
from sklearn.neighbors import KNeighborsClassifier

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "scenes" / "imprint.md"
PICTURES = ROOT / "docs" / "pictures"
CLASSES = ["bird", "chair", "hand", "head", "plane", "quadruped"]
SAMPLES = 1500
# Which splits the network is trained on; at 64 × 64 a split takes eight minutes.
NETWORK = {"e16": ["stratified", "group"], "e64": ["group"]}


class Taxel:
    def __init__(self, binary: str, work: Path):
        self.binary, self.work = str(Path(binary).resolve()), work

    def simulate(self, name: str, samples: int, *options: str):
        path = self.work / f"{name}.npz"
        if not path.exists():
            command = [self.binary, "simulate", "imprint", "--samples", str(samples), "--output", str(path)]
            subprocess.run([*command, *options], check=True, stdout=subprocess.DEVNULL)
        return np.load(path)

    def network(self, data: str, split: str) -> dict:
        """Scores of the config's network."""
        run = self.work / f"{data}-{split}"
        if not (run / "results.json").exists():
            options = ["--data", str(self.work / f"{data}.npz"), "--set", "data.full_scale=1"]
            options += ["--set", f'protocol.split="{split}"', "--output", str(run)]
            subprocess.run([self.binary, "run", str(ROOT / "configs/visuotactile/imprint.toml"), *options], check=True)
        return json.loads((run / "results.json").read_text())["networks"][0]


def save(fig, name: str) -> None:
    path = PICTURES / f"imprint-{name}.png"
    fig.savefig(path, dpi=80)
    plt.close(fig)
    Image.open(path).convert("P", palette=Image.Palette.ADAPTIVE, colors=96).save(path, optimize=True)
    print(path.relative_to(ROOT), path.stat().st_size)


def draw_objects(taxel: Taxel) -> None:
    # Two pictures of each object; the second 30 samples are the other side.
    data = taxel.simulate("views", 60, "--set", "elements=4", "--set", "view=112", "--seed", "3")
    fig, axes = plt.subplots(6, 10, figsize=(10.2, 6.4))
    for at, (view, group) in enumerate(zip(data["view"], data["group"])):
        ax = axes[group // 5, 2 * (group % 5) + at // 30]
        ax.imshow(view.transpose(1, 2, 0), interpolation="bilinear")
        if group % 5 == 0 and at < 30:
            ax.set_title(CLASSES[group // 5], fontsize=8, loc="left", pad=2)
    for ax in axes.flat:
        ax.axis("off")
    fig.subplots_adjust(0, 0, 1, 0.97, 0, 0.08)
    save(fig, "objects")


def draw_patches(taxel: Taxel) -> None:
    fine, coarse = (taxel.simulate(f"patches{n}", 30, "--set", f"elements={n}", "--seed", "5") for n in (128, 16))
    fig, axes = plt.subplots(6, 10, figsize=(10.2, 6.4))
    for at, y in enumerate(fine["y"]):
        for side, data in enumerate((coarse, fine)):
            ax = axes[y, 2 * (at // 6) + side]
            ax.imshow(data["x"][at], vmin=0, vmax=1, cmap="viridis", interpolation="nearest")
            ax.set_xticks([])
            ax.set_yticks([])
    for y, name in enumerate(CLASSES):
        axes[y, 0].set_ylabel(name, fontsize=8)
    fig.subplots_adjust(0.025, 0.005, 0.995, 0.995, 0.06, 0.06)
    save(fig, "patches")


def statistics(taxel: Taxel) -> str:
    """Each image relative to its own largest value, so that units cancel."""
    rows = ["| images | share of active taxels | share above half | mean of active | correlation of neighbours |",
            "|---|---|---|---|---|"]
    sources = {f"simulated, {n} × {n}": taxel.simulate(f"e{n}", SAMPLES, "--set", f"elements={n}")["x"] for n in (16, 64)}
    if real := os.environ.get("TAXEL_DATA"):
        sources["real: tekscan22-images, 28 × 50"] = np.load(Path(real) / "tekscan22-images/data.npz")["x"]
    for name, x in sources.items():
        x = x.astype(np.float64) / x.max(axis=(1, 2), keepdims=True).clip(1e-9)
        # JPEG leaves a haze of a few counts of 255 around contacts.
        active = x > 0.05
        pairs = np.corrcoef(x[:, :, 1:].ravel(), x[:, :, :-1].ravel())[0, 1]
        values = [active.mean(), (x > 0.5).mean(), x[active].mean(), pairs]
        rows.append(f"| {name} | " + " | ".join(f"{v:.2f}" for v in values) + " |")
    return "\n".join(rows)


def scores(data, model) -> list[str]:
    """Accuracy in % over five folds: imprints mixed, and one object of each class left out."""
    x, y, group = data["x"].reshape(len(data["y"]), -1), data["y"], data["group"]
    unseen = [(np.flatnonzero(group % 5 != k), np.flatnonzero(group % 5 == k)) for k in range(5)]
    cells = []
    for folds in (StratifiedKFold(5, shuffle=True, random_state=0).split(x, y), unseen):
        each = [100 * model().fit(x[train], y[train]).score(x[test], y[test]) for train, test in folds]
        cells.append(f"{np.mean(each):.1f} ± {np.std(each, ddof=1):.1f}")
    return cells


def difficulty(taxel: Taxel) -> str:
    rows = ["| imprints | method | imprints mixed | objects unseen |", "|---|---|---|---|"]
    cases = {f"e{n}": (f"{n} × {n}, the same patch", ["--set", f"elements={n}"]) for n in (16, 64, 128)}
    cases["wide"] = ("16 × 16, pitch 5 mm: 80 mm wide", ["--set", "elements=16", "--set", "pitch_mm=5"])
    cases["upright"] = ("16 × 16, without spin", ["--set", "elements=16", "--without", "spin"])
    for name, (what, options) in cases.items():
        data = taxel.simulate(name, SAMPLES, *options)
        methods = {"5 nearest neighbours": lambda: KNeighborsClassifier(5)}
        if name in NETWORK:
            methods["random forest, 100 trees"] = lambda: RandomForestClassifier(100, random_state=0, n_jobs=-1)
        for method, model in methods.items():
            rows.append(f"| {what} | {method} | " + " | ".join(scores(data, model)) + " |")
            print(rows[-1], flush=True)
        if splits := NETWORK.get(name):
            runs = {split: taxel.network(name, split) for split in splits}
            accuracy = {split: f"{n['mean']['accuracy']:.1f} ± {n['sd']['accuracy']:.1f}" for split, n in runs.items()}
            cells = [accuracy.get(split, "–") for split in ("stratified", "group")]
            rows.append(f"| {what} | {runs['group']['network']} | " + " | ".join(cells) + " |")
            print(rows[-1], flush=True)
    return "\n".join(rows)


def put(mark: str, table: str) -> None:
    begin, end = f"<!-- {mark} -->", f"<!-- end {mark} -->"
    before, rest = PAGE.read_text().split(begin)
    PAGE.write_text(f"{before}{begin}\n{table}\n{end}{rest.split(end)[1]}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--taxel", default="target/release/taxel")
    parser.add_argument("--work", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    taxel = Taxel(arguments.taxel, arguments.work)
    draw_objects(taxel)
    draw_patches(taxel)
    put("statistics", statistics(taxel))
    put("difficulty", difficulty(taxel))


if __name__ == "__main__":
    main()
