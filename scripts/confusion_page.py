#!/usr/bin/env python3
"""Writes docs/results/palpation-003-fig-7-8.md: which objects are taken for which after two grasps (paper 003, Figs. 7 and 8).

    python3 scripts/confusion_page.py [RUN ...]

RUN are run folders with the names of its pages (palpation-003-fig-6-rigid, -frames, -frames-eyes and their like for the other
objects), of which the rows with two grasps are taken. Their confusion matrices are kept in
docs/results/reference/palpation-003-fig-7-8.json, each run's in the place of those that it had, so that runs may be told one
after another; without a run the page and its pictures are drawn anew.
Needs matplotlib.
"""

import argparse
import json
import pathlib
import re
import tomllib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from claims_page import RESULTS, ROOT

NAME = "palpation-003-fig-7-8"
KEPT = RESULTS / "reference" / f"{NAME}.json"
PICTURES = ROOT / "docs" / "pictures"
GRASPS = 2
SUBSETS = {"rigid": "rigid objects", "deformable": "deformable objects", "in-bag": "bags", "all": "all objects"}
# Methods in the order of the figures: name, page, and row there without the number of grasps.
METHODS = [
    ("TactNet3D", "fig-6", "tactnet3d-51"),
    ("TactNet3D with pools of 2", "fig-6", "tactnet3d-51-pool"),
    ("TactNet6", "frames", "tactnet6"),
    ("VGG16_SVM on eyes of our own", "frames-eyes", "vgg16-svm"),
    ("ResNet50_NN on eyes of our own", "frames-eyes", "resnet50-nn"),
]


def page_of(kind, subset):
    """The page of a method on a subset; single frames of rigid objects have their config's own name."""
    return f"palpation-003-{kind}" + ("" if subset == "rigid" and kind != "fig-6" else f"-{subset}")


def matrices(folder):
    """Confusion matrices of a run with two grasps by row, with what they were measured on."""
    own = {row for _, kind, row in METHODS for subset in SUBSETS if page_of(kind, subset) == folder.resolve().name}
    results = json.loads((folder / "results.json").read_text())
    environment = json.loads((folder / "environment.json").read_text())
    rows = {}
    for network in results["networks"]:
        name, _, grasps = network["network"].rpartition(".n")
        if network["confusion"] and grasps == str(GRASPS) and name in own:
            rows[name] = {"repetitions": len(network["folds"]), "confusion": network["confusion"]}
    if not rows:
        raise SystemExit(f"{folder}: no network of the page with {GRASPS} grasps")
    return {"commit": environment.get("commit", "")[:9], "data_digest": results["data_digest"], "source": results["source"],
            "classes": results["classes"], "rows": rows}


def groups(subset):
    """Look-alikes by object."""
    config = tomllib.loads((ROOT / "configs" / "palpation" / f"palpation-003-fig-6-{subset}.toml").read_text())
    return {name: group for group, names in config["data"]["look_alikes"].items() for name in names}


def inside(confusion, classes, group):
    """Share of mistakes among look-alikes, and what it would be were each other object as likely, in %."""
    mistakes = within = chance = 0
    for truth, row in zip(classes, confusion):
        alike = sum(group[name] == group[truth] for name in classes) - 1
        for answer, count in zip(classes, row):
            if answer != truth:
                mistakes += count
                within += count * (group[answer] == group[truth])
                chance += count * alike / (len(classes) - 1)
    return 100 * within / max(mistakes, 1), 100 * chance / max(mistakes, 1)


def share(confusion):
    return 100 * sum(row[i] for i, row in enumerate(confusion)) / sum(map(sum, confusion))


def ordered(confusion, classes, group):
    """The matrix and its classes with look-alikes side by side, in the order in which their first ones come."""
    first = {}
    for i, name in enumerate(classes):
        first.setdefault(group[name], i)
    order = sorted(range(len(classes)), key=lambda i: (first[group[classes[i]]], i))
    return [[confusion[i][j] for j in order] for i in order], [classes[i] for i in order]


def draw(axes, confusion, classes, group, title, names):
    """Shares of each object's answers, with look-alikes framed."""
    confusion, classes = ordered(confusion, classes, group)
    shares = [[100 * count / max(sum(row), 1) for count in row] for row in confusion]
    image = axes.imshow(shares, cmap="Blues", vmin=0, vmax=100)
    start = 0
    for at in range(1, len(classes) + 1):
        if at == len(classes) or group[classes[at]] != group[classes[start]]:
            side = at - start
            axes.add_patch(plt.Rectangle((start - 0.5, start - 0.5), side, side, fill=False, edgecolor="#c8502d", linewidth=1))
            start = at
    axes.set_xticks([])
    axes.set_yticks(range(len(classes)), classes if names else [""] * len(classes), fontsize=7)
    axes.tick_params(length=0)
    axes.set_title(title, fontsize=9)
    return image


def picture(path, kept, subsets, size):
    """A row of matrices for each subset, a column for each method that any of them has."""
    columns = [method for method in METHODS if any(found(kept, method, subset) for subset in subsets)]
    figure, grid = plt.subplots(len(subsets), len(columns), figsize=(size * len(columns) + 2, 1.08 * size * len(subsets)),
                                squeeze=False, layout="constrained")
    for subset, line in zip(subsets, grid):
        names = True
        for method, axes in zip(columns, line):
            own = found(kept, method, subset)
            if not own:
                axes.set_axis_off()
                continue
            run, row = own
            image = draw(axes, row["confusion"], run["classes"], groups(subset), method[0].replace(" on eyes of our own", ""), names)
            names = False
        first = next(axes for axes in line if axes.axison)
        first.set_ylabel(f"{SUBSETS[subset]}: grasped", fontsize=9)
    bar = figure.colorbar(image, ax=grid, shrink=0.4, pad=0.01)
    bar.set_label("% of its answers", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def found(kept, method, subset):
    """A method's run and row on a subset, where it was run."""
    _, kind, row = method
    run = kept.get(page_of(kind, subset))
    return (run, run["rows"][row]) if run and row in run["rows"] else None


def markdown(kept):
    lines = [f"# {NAME}", "", "Generated by `scripts/confusion_page.py` from run folders.", "",
             "Paper 003, Figs. 7 and 8: which objects are taken for which by methods that were trained on two grasps of each. All of "
             "it is *simulated*; the figures print no numbers. The paper says of them (section 5) that mistakes of TactNet3D stay among "
             "objects that feel alike, and those of 2D networks do not. Look-alikes are those that it names: kinds of bottles, "
             "cans, mice, balls, sponges, nuts. Whether the claim holds, with its interval, is on [claims](claims.md).", "",
             f"| mistakes among look-alikes, % (by chance, of as many mistakes); accuracy % | {' | '.join(SUBSETS.values())} |",
             "| --- |" + " ---: |" * len(SUBSETS)]
    for method in METHODS:
        cells = []
        for subset in SUBSETS:
            own = found(kept, method, subset)
            if not own:
                cells.append("–")
                continue
            run, row = own
            within, chance = inside(row["confusion"], run["classes"], groups(subset))
            cells.append(f"**{within:.0f}** ({chance:.0f}); {share(row['confusion']):.1f}")
        lines.append(f"| {method[0]} | {' | '.join(cells)} |")
    lines += ["", "By chance: had each mistake gone to every other object equally often. Matrices are sums over repetitions; "
              "whole squeezes are counted for TactNet3D, single frames for the others.", "",
              "Each row of a matrix is an object that was grasped, each column an answer, in the order of the rows; frames hold look-alikes.", "",
              f"![confusion matrices on rigid objects, deformable objects and bags](../pictures/{NAME[:-2]}.png)", "",
              f"![confusion matrices on all objects](../pictures/{NAME.replace('7-8', '8')}.png)", "",
              "## Runs", "", "| page | of taxel at | repetitions |", "| --- | --- | ---: |"]
    for name, run in sorted(kept.items()):
        repetitions = ", ".join(f"`{row}` {own['repetitions']}" for row, own in run["rows"].items())
        lines.append(f"| [{name}]({name}.md) | {run['commit']} | {repetitions} |")
    lines += ["", "Each is made again by the command of its page, where `--only tactnet6.n2` and the like leave out other rows, "
              "and then told by `python3 scripts/confusion_page.py RUN`.", ""]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="*", type=pathlib.Path)
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    pages = {page_of(kind, subset) for _, kind, _ in METHODS for subset in SUBSETS}
    for folder in parser.parse_args().runs:
        name = folder.resolve().name
        if name not in pages:
            raise SystemExit(f"{folder}: none of {', '.join(sorted(pages))}")
        kept[name] = matrices(folder)
    if not kept:
        raise SystemExit("no run was ever told: name run folders")
    picture(PICTURES / f"{NAME[:-2]}.png", kept, ["rigid", "deformable", "in-bag"], 2.6)
    picture(PICTURES / f"{NAME.replace('7-8', '8')}.png", kept, ["all"], 4.4)
    KEPT.write_text(re.sub(r"\[[\d,\s]*\]", lambda row: " ".join(row[0].split()), json.dumps(kept, indent=1)) + "\n")
    (RESULTS / f"{NAME}.md").write_text(markdown(kept))


if __name__ == "__main__":
    main()
