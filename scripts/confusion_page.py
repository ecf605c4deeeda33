#!/usr/bin/env python3
"""Writes docs/results/palpation-003-fig-7-8.md: which objects are taken for which after two grasps (Pastor et al. 2019, Figs. 7 and 8).

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

from results_table import RESULTS, ROOT, commit, markdown, processor, remarks_line

NAME = "palpation-003-fig-7-8"
KEPT = RESULTS / "reference" / f"{NAME}.json"
PICTURES = ROOT / "docs" / "pictures"
FIGURE_7 = PICTURES / "palpation-003-fig-7.png"
FIGURE_8 = PICTURES / "palpation-003-fig-8.png"
ALL = "all objects"
GRASPS = 2
# Rows of Fig. 6 in papers.toml, in the order of the figures.
METHODS = [
    "TactNet3D",
    "TactNet3D with pools of 2",
    "TactNet6, every frame",
    "VGG16_SVM pretrained on synthetic pictures, every frame",
    "ResNet50_NN pretrained on synthetic pictures, every frame",
]


def figure_6():
    """The tables of Fig. 6 by their objects, each as the page of its whole squeezes and page and row of each method."""
    found = {}
    for table in tomllib.loads((RESULTS / "papers.toml").read_text())["tables"]:
        part, _, objects = table["table"].partition(", ")
        if table["paper"] == "003" and part == "Fig. 6":
            rows = {row["is"]: (row.get("page", table["simulated"]), row["row"]) for row in table["rows"]}
            found[objects] = table["simulated"], {method: rows[method] for method in METHODS}
    return found


def rows_of(page):
    return [row for _, methods in figure_6().values() for own, row in methods.values() if own == page]


def matrices(folder):
    """Confusion matrices of a run with two grasps by row, with what they were measured on."""
    results = json.loads((folder / "results.json").read_text())
    environment = json.loads((folder / "environment.json").read_text())
    networks = {network["network"]: network for network in results["networks"]}
    rows = {}
    for row in rows_of(folder.resolve().name):
        network = networks.get(f"{row}.n{GRASPS}")
        if not (network and network["confusion"]):
            raise SystemExit(f"{folder}: {row} was not trained on {GRASPS} grasps: taxel run ... --resume --only {row}.n{GRASPS}")
        rows[row] = {"repetitions": len(network["folds"]), "confusion": network["confusion"]}
    if not rows:
        raise SystemExit(f"{folder}: the page has no row of a run of this name")
    return {"commit": commit(environment), "processor": processor(environment), "seed": results["seed"],
            "data_digest": results["data_digest"], "source": results["source"], "classes": results["classes"], "rows": rows}


def groups(page):
    """Look-alikes by object, from the config of whole squeezes."""
    config = tomllib.loads((ROOT / "configs" / "palpation" / f"{page}.toml").read_text())
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


def picture(path, parts, size):
    """A row of matrices for some objects, a column for each method."""
    figure, grid = plt.subplots(len(parts), len(METHODS), figsize=(size * len(METHODS) + 2, 1.08 * size * len(parts)),
                                squeeze=False, layout="constrained")
    for (objects, (group, methods)), line in zip(parts.items(), grid):
        line[0].set_ylabel(f"{objects}: grasped", fontsize=9)
        for (method, (classes, confusion)), axes in zip(methods.items(), line):
            image = draw(axes, confusion, classes, group, method.removesuffix(", every frame").removesuffix(" pretrained on synthetic pictures"),
                         axes is line[0])
    bar = figure.colorbar(image, ax=grid, shrink=0.4, pad=0.01)
    bar.set_label("% of its answers", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def page(parts, kept):
    cells = []
    for method in METHODS:
        cells.append([method])
        for group, methods in parts.values():
            classes, confusion = methods[method]
            within, chance = inside(confusion, classes, group)
            cells[-1].append(f"**{within:.0f}** ({chance:.0f}); {share(confusion):.1f}")
    scores = markdown(["mistakes among look-alikes, % (by chance, of as many mistakes); accuracy %", *parts], cells)
    runs = markdown(["page", "repetitions", "seed", "of taxel at", "processor"],
                    [[f"[{name}]({name}.md)", ", ".join(f"`{row}` {own['repetitions']}" for row, own in run["rows"].items()),
                      str(run["seed"]), run["commit"], run["processor"]] for name, run in sorted(kept.items())])
    return f"""# {NAME}

Generated by `scripts/confusion_page.py` from run folders.

{remarks_line(NAME)}

Pastor et al. 2019, Figs. 7 and 8: which objects are taken for which, by methods that were trained on two grasps of each. \
All of it is *simulated*; the figures print no numbers. The paper says of them (section 5) that mistakes of TactNet3D stay among objects that \
feel alike, and those of 2D networks do not. Look-alikes are those that it names: kinds of bottles, cans, mice, balls, sponges, \
nuts. Whether the claim holds, with its interval, is on [claims](claims.md).

{scores}

By chance: had each mistake gone to every other object equally often. Matrices are sums over repetitions; whole squeezes are \
counted for TactNet3D, single frames for the others.

Each row of a matrix is an object that was grasped, each column a prediction, in the order of the rows; frames hold look-alikes.

![confusion matrices on rigid objects, deformable objects and bags](../pictures/{FIGURE_7.name})

![confusion matrices on all objects](../pictures/{FIGURE_8.name})

## Runs

{runs}

Each is made again by the command of its page, where `--only tactnet6.n2` and the like leave out other rows, and then told by \
`python3 scripts/confusion_page.py RUN`.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="*", type=pathlib.Path)
    kept = json.loads(KEPT.read_text())
    for folder in parser.parse_args().runs:
        kept[folder.resolve().name] = matrices(folder)
    parts = {}
    for objects, (squeezes, methods) in figure_6().items():
        parts[objects] = groups(squeezes), {method: (kept[own]["classes"], kept[own]["rows"][row]["confusion"])
                                            for method, (own, row) in methods.items()}
    picture(FIGURE_7, {objects: part for objects, part in parts.items() if objects != ALL}, 2.6)
    picture(FIGURE_8, {ALL: parts[ALL]}, 4.4)
    KEPT.write_text(re.sub(r"\[[\d,\s]*\]", lambda row: " ".join(row[0].split()), json.dumps(kept, indent=1)) + "\n")
    (RESULTS / f"{NAME}.md").write_text(page(parts, kept))


if __name__ == "__main__":
    main()
