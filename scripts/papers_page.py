#!/usr/bin/env python3
"""Writes docs/results/papers.md: every row of every table of the five papers, published, simulated and real side by side.

    python3 scripts/papers_page.py

Needs Python 3 alone. Printed numbers, and which page of docs/results has a row, come from docs/results/papers.toml; scores
come from those pages, which scripts wrote from run folders. A row that no page has says so, and its table says why.
"""

import pathlib
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"
TITLES = {
    "000": "hardness of grasped objects from fingertips (Hybrid-CNN)",
    "001": "vision networks for touch (visuotactile transfer)",
    "002": "deformable objects squeezed by hand (TactNet3D)",
    "003": "objects in an underactuated gripper (TactNet3D against 2D networks)",
    "004": "elasticity and hardness levels from two fingers (multi-scale CNN)",
}
# What a table names a page for, and what is said of its column.
HEADS = {
    "simulated": "simulated",
    "sessions": "simulated, unseen sessions",
    "imagenet": "simulated, from ImageNet at 96 × 96 pixels",
    "real": "real",
}


def tables(page):
    """The tables of a page, each as (heading above it, head, rows by their first cell)."""
    found, heading, head = [], "", None
    for line in (RESULTS / f"{page}.md").read_text().splitlines():
        if line.startswith("## "):
            heading = line[3:]
        if not line.startswith("| ") and not line.startswith("|-"):
            head = None
            continue
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if head is None:
            head = cells
            found.append((heading, head, {}))
        elif not set(line) <= set("|-: "):
            found[-1][2][cells[0].strip("`")] = cells
    return found


def score(page, row, kind, column="accuracy % ["):
    """What a page says of a row, without the marks around it; None where it has no such row or did not run it."""
    if not (RESULTS / f"{page}.md").exists():
        return None
    for _, head, rows in tables(page):
        at = next((at for at, name in enumerate(head) if name.startswith(column)), None)
        if at is None or row not in rows:
            continue
        sources = [name for name in head if "[" in name]
        if not any(f"[{kind}: " in name for name in sources):
            raise SystemExit(f"{page}: not {kind}, as papers.toml has it, but {sources}")
        return None if rows[row][at] == "not run" else rows[row][at]
    return None


def levels(page, attribute, row):
    """Accuracy of an attribute, and precision / recall / F1 of each of its levels."""
    for heading, head, rows in tables(page):
        if heading == attribute and row in rows:
            return rows[row][head.index("accuracy %")], rows[row][4:]
    raise SystemExit(f"{page}: no {attribute} of {row}")


def cell(value):
    return value or "–"


def of_levels(table):
    lines = ["| network | | accuracy % | " + " | ".join(map(str, range(1, 11))) + " |", "| --- | --- | ---: |" + " ---: |" * 10]
    for row in table["rows"]:
        printed = [" / ".join(map(str, level)) for level in row["levels"]]
        own, each = levels(table["simulated"], table["attribute"], row["row"])
        lines.append(f"| {row['is']} | *published* | *{row['published']}* | " + " | ".join(f"*{level}*" for level in printed) + " |")
        lines.append(f"| `{row['row']}` | simulated | {own} | " + " | ".join(each) + " |")
    return lines


def of_scores(table):
    kinds = [kind for kind in HEADS if kind in table]
    lines = ["| " + " | ".join(["row", "*published*", *(HEADS[kind] for kind in kinds)]) + " |", "| --- | ---: |" + " ---: |" * len(kinds)]
    for row in table["rows"]:
        cells = [row["is"], f"*{row['published']}*"]
        for kind in kinds:
            # What starts from ImageNet has rows of other names, and the stitched network another column.
            own = row.get("imagenet_row") if kind == "imagenet" else row.get(f"{kind}_row", row.get("row"))
            column = table.get("column", "accuracy % [") if kind == "simulated" else "accuracy % ["
            cells.append(cell(own and score(table[kind], own, "real" if kind == "real" else "simulated", column)))
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def of_counts(table):
    """A learning curve a row."""
    lines = ["| simulated | " + " | ".join(map(str, table["counts"])) + " |", "| --- |" + " ---: |" * len(table["counts"])]
    for row in table["rows"]:
        page = row.get("page", table["simulated"])
        lines.append(f"| {row['is']} | " + " | ".join(cell(score(page, f"{row['row']}.n{count}", "simulated")) for count in table["counts"]) + " |")
    return lines


def pages(table):
    """Where the scores of a table stand."""
    named = [table[key] for key in HEADS if key in table]
    named += [row["page"] for row in table["rows"] if "page" in row]
    return ", ".join(f"[{name}]({name}.md)" for name in dict.fromkeys(named) if (RESULTS / f"{name}.md").exists())


def main():
    printed = tomllib.loads((RESULTS / "papers.toml").read_text())["tables"]
    lines = ["# The tables of the five papers", "", "Generated by `scripts/papers_page.py`.", "",
             "*Published* numbers were measured on recordings of the papers' own, which nobody else has; *simulated* ones on our scenes, "
             "*real* ones on recordings of other objects and mostly other sensors. So rows of one column compare, and columns do not: which "
             "order of rows a column bears out, and with what certainty, is on [claims](claims.md). – stands where a row was not run.", ""]
    for paper in sorted({table["paper"] for table in printed}):
        lines += [f"## Paper {paper}: {TITLES[paper]}", ""]
        for table in (own for own in printed if own["paper"] == paper):
            lines += [f"### {table['table']}", "", f"{table['says'][0].upper()}{table['says'][1:]}." + (f" Pages: {pages(table)}." if pages(table) else ""), ""]
            drawn = of_levels if "attribute" in table else of_counts if "counts" in table else of_scores
            lines += drawn(table)
            lines += ["", f"{table['lacks'][0].upper()}{table['lacks'][1:]}.", ""] if "lacks" in table else [""]
    (RESULTS / "papers.md").write_text("\n".join(lines).rstrip() + "\n")


if __name__ == "__main__":
    main()
