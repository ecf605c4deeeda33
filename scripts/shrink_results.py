#!/usr/bin/env python3
"""A page for docs/results from what `taxel shrink` wrote: its sentences, its tables, the config of the smaller model.

    python3 scripts/shrink_results.py runs/glove/shrink "fsr-glove28, how little suffices" > docs/results/glove-shrink.md

Needs Python alone.
"""

import argparse
import json
from pathlib import Path


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="the folder that taxel shrink wrote")
    parser.add_argument("title")
    parser.add_argument("--command", default="", help="how it was made, put above the tables")
    options = parser.parse_args()
    own = json.loads((options.folder / "shrink.json").read_text())
    print(f"# {options.title}\n")
    print(f"`{own['network']}` of `{own['run']}`: {own['source']}, {own['samples']} samples, {own['protocol']}; "
          f"{own['parts']} test parts, {own['inner']} inner folds of each training part, margin {own['margin']:g} points.\n")
    if options.command:
        print(f"```sh\n{options.command}\n```\n")
    for note in own.get("notes", []):
        print(f"{note}\n")
    for words in own["words"]:
        print(f"- {words}")
    for axis, reason in own["left_out"]:
        print(f"- {axis}: left out: {reason}")
    print()
    names = [f"curve-{curve['axis']}" for curve in own["curves"]] + (["models"] if own["models"] else [])
    for name in names:
        print((options.folder / "tables" / f"{name}.md").read_text().strip() + "\n")
    config = options.folder / "shrunk.toml"
    if own["models"] and config.is_file():
        print("The smaller model's experiment:\n")
        print(f"```toml\n{config.read_text().strip()}\n```")


if __name__ == "__main__":
    main()
