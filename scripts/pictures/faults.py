"""Draws every fault in every severity on one sample of each layout, for docs/faults.md.

Run from the repository root; needs numpy, matplotlib and pillow:

    python3 scripts/pictures/faults.py

Writes docs/pictures/faults-<layout>.png from what `cargo run -p taxel-scenes --example faults` prints.
"""

import json
import subprocess
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "docs" / "pictures"


def samples() -> dict:
    """By layout, then fault: six (level, readings)."""
    command = ["cargo", "run", "--quiet", "--locked", "-p", "taxel-scenes", "--example", "faults"]
    text = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    layouts: dict = {}
    for line in text.splitlines():
        layout, fault, level, shape, readings = line.split("\t")
        x = np.array(readings.split(), np.float32).reshape(json.loads(shape))
        layouts.setdefault(layout, {}).setdefault(fault, []).append((level, x))
    return layouts


def draw(ax, layout: str, x: np.ndarray, top: float) -> None:
    if layout in ("Image", "Sequence"):
        # Frames of a sequence side by side.
        image = x if x.ndim == 2 else np.concatenate(list(x), axis=1)
        ax.imshow(image, vmin=0, vmax=top, cmap="viridis", interpolation="nearest", aspect="auto")
    else:
        fingers = layout == "Fingers"
        for at, series in enumerate(x.reshape(-1, x.shape[-1])):
            colour = plt.cm.plasma([0.1, 0.35, 0.65, 0.85][at]) if fingers else None
            ax.plot(series, lw=0.7, color=colour)
        ax.set_ylim(-0.03 * top, 1.03 * top)
    ax.set_xticks([])
    ax.set_yticks([])


def main() -> None:
    OUT.mkdir(parents=True, exist_ok=True)
    for layout, faults in samples().items():
        # Full scale is what stuck taxels read.
        top = max(x.max() for _, x in faults["stuck"])
        fig, axes = plt.subplots(len(faults), 6, figsize=(11, 0.95 * len(faults)), squeeze=False)
        for row, (fault, graded) in zip(axes, faults.items()):
            for ax, (level, x) in zip(row, graded):
                draw(ax, layout, x, top)
                ax.set_title(level, fontsize=5.5, pad=1.5)
            row[0].set_ylabel(fault, fontsize=7)
        fig.tight_layout(pad=0.3)
        path = OUT / f"faults-{layout.lower()}.png"
        fig.savefig(path, dpi=80)
        plt.close(fig)
        Image.open(path).convert("P", palette=Image.Palette.ADAPTIVE, colors=128).save(path, optimize=True)
        print(path.relative_to(ROOT), path.stat().st_size)


if __name__ == "__main__":
    main()
