#!/usr/bin/env python3
"""Counts the crates that the program is built of, by feature set, and writes the counts into docs/robot.md.

    python3 scripts/count_crates.py [--check]

--check writes nothing and fails where the page has other counts: Cargo.lock or a feature has changed since.

A crate counts once for each version of it, procedural macros and taxel's own crates included, those of tests and build scripts not.
They are those of the platform that it runs on, as `cargo tree -e normal` lists them. Needs Python 3 and cargo.
"""

import argparse
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "robot.md"
BLOCK = re.compile(r"<!-- crates -->\n.*<!-- end of crates -->", re.S)
# Name on the page, and what cargo is told.
SETS = [
    ("robot's program", ["--no-default-features", "--features", "runtime"]),
    ("default build", []),
    ("with candle", ["--features", "candle"]),
]


def crates(words):
    """The crates of a feature set, each with its version."""
    command = ["cargo", "tree", "--locked", "--quiet", "-p", "taxel", "-e", "normal", "--prefix", "none", "--format", "{p}", *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}: {done.stderr.strip()}")
    # A crate whose dependencies are listed before is marked so.
    return {line.removesuffix(" (*)") for line in done.stdout.splitlines() if line}


def block():
    rows = ["| | " + " | ".join(name for name, _ in SETS) + " |", "|---|" + "---:|" * len(SETS)]
    counted = [crates(words) for _, words in SETS]
    own = [sum(f"({ROOT}" in crate for crate in each) for each in counted]
    rows.append("| crates | " + " | ".join(str(len(each)) for each in counted) + " |")
    rows.append("| of them taxel's own | " + " | ".join(map(str, own)) + " |")
    return "<!-- crates -->\n" + "\n".join(rows) + "\n<!-- end of crates -->"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare with the page, write nothing")
    args = parser.parse_args()
    before = PAGE.read_text()
    if not BLOCK.search(before):
        raise SystemExit(f"{PAGE}: has no place for the counts, <!-- crates --> to <!-- end of crates -->")
    found = block()
    after = BLOCK.sub(lambda _: found, before)
    print(found)
    if args.check and after != before:
        sys.exit(f"{PAGE.relative_to(ROOT)} has other counts: python3 scripts/count_crates.py")
    if not args.check:
        PAGE.write_text(after)


if __name__ == "__main__":
    main()
