#!/usr/bin/env python3
"""Changes one operator of a crate after the other and lists the changes that no test notices.

    python3 scripts/mutants.py data --count 150 --seed 0 --folder ../mutants
    python3 scripts/mutants.py data --count 150 --seed 0 --folder ../mutants --list       what would be changed

Needs tree-sitter and tree-sitter-rust. The source is copied to --folder; there every chosen operator becomes a switch that
TAXEL_MUTANT turns at run time, so that one build serves all: `<` becomes `<=`, `==` `!=`, `&&` `||`, `!x` `x`, `+ 1` `+ 0`. The tests
of the crate run first, then --also (tests of other crates) for what they leave alive. A test that takes ten times as long as without a
change has noticed too. Exit code 1 if one lives that is not in scripts/mutants_explained.txt.
"""

import argparse
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
EXPLAINED = ROOT / "scripts" / "mutants_explained.txt"
OTHER = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&"}
SWITCH = """
#[doc(hidden)]
#[must_use]
pub fn is_mutant(number: u32) -> bool {
    static CHOSEN: std::sync::OnceLock<u32> = std::sync::OnceLock::new();
    let read = || std::env::var("TAXEL_MUTANT").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    *CHOSEN.get_or_init(read) == number
}
"""


def is_left_alone(node, text):
    """Tests, constants and lets in conditions cannot be switched."""
    while node is not None:
        if node.type in ("const_item", "static_item", "macro_definition", "macro_invocation", "attribute_item", "array_type", "let_chain"):
            return True
        if node.type == "function_item" and b"const" in text[node.start_byte : node.start_byte + 40].split(b"fn")[0]:
            return True
        before = node.prev_named_sibling
        while before is not None and before.type in ("attribute_item", "line_comment"):
            if b"cfg(test)" in text[before.start_byte : before.end_byte] or b"#[test]" in text[before.start_byte : before.end_byte]:
                return True
            before = before.prev_named_sibling
        node = node.parent
    return False


def changed(node, text):
    """What an expression becomes, or none."""
    def of(child):
        return text[child.start_byte : child.end_byte].decode()

    if node.type == "binary_expression":
        left, operator, right = of(node.child_by_field_name("left")), of(node.child_by_field_name("operator")), of(node.child_by_field_name("right"))
        if "let " in left + right:
            return None
        if operator in OTHER:
            return f"{left} {OTHER[operator]} {right}"
        if operator in "+-" and right == "1":
            return f"{left} {operator} 0"
    if node.type == "unary_expression" and of(node).startswith("!"):
        return of(node)[1:]
    return None


def places(crate):
    """All expressions of a crate that can be changed: file, from, to, the change."""
    import tree_sitter
    import tree_sitter_rust

    parser = tree_sitter.Parser(tree_sitter.Language(tree_sitter_rust.language()))
    for path in sorted((ROOT / "crates" / crate / "src").rglob("*.rs")):
        if "tests" in path.parts or path.name in ("tests.rs",) or path.name.endswith("_tests.rs"):
            continue
        text = path.read_bytes()
        nodes = [parser.parse(text).root_node]
        while nodes:
            node = nodes.pop()
            nodes += node.children
            new = changed(node, text)
            if new and not is_left_alone(node, text):
                line = text[: node.start_byte].count(b"\n") + 1
                yield path, node.start_byte, node.end_byte, text[node.start_byte : node.end_byte].decode(), new, line


def chosen(crate, count, seed):
    """Draws changes that do not stand in each other."""
    everything = list(places(crate))
    random.Random(seed).shuffle(everything)
    taken = []
    for place in everything:
        path, start, end = place[:3]
        if len(taken) < count and not any(p == path and s < end and start < e for p, s, e, *_ in taken):
            taken.append(place)
    return sorted(taken, key=lambda place: (str(place[0]), place[1])), len(everything)


def plant(crate, mutants, folder):
    """Copies the source and puts the switches in."""
    keep = shutil.ignore_patterns("target", "runs", ".git", "corpus", "artifacts")
    shutil.copytree(ROOT, folder, ignore=keep, dirs_exist_ok=True)
    files = {}
    for number, (path, start, end, old, new, _) in enumerate(mutants, 1):
        files.setdefault(path, []).append((start, end, f"(if crate::is_mutant({number}) {{ {new} }} else {{ {old} }})"))
    for path, changes in files.items():
        text = path.read_bytes()
        for start, end, new in sorted(changes, reverse=True):
            text = text[:start] + new.encode() + text[end:]
        (folder / path.relative_to(ROOT)).write_bytes(text)
    top = folder / "crates" / crate / "src" / "lib.rs"
    allowed = "#![allow(warnings)]\n"
    text = top.read_text()
    at = text.index("\n\n", text.rindex("//!")) if "//!" in text else 0
    top.write_text(text[:at] + "\n" + allowed + text[at:] + SWITCH)


def built(folder):
    """Builds all tests of the copy; path of each by crate and name."""
    command = ["cargo", "test", "--locked", "--workspace", "--features", "taxel/candle", "--no-run", "--message-format=json"]
    made = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True, env={**os.environ, "CARGO_INCREMENTAL": "0"})
    if made.returncode:
        sys.exit("the copy does not compile")
    tests, programs = {}, {}
    for line in made.stdout.splitlines():
        message = json.loads(line)
        if message.get("reason") != "compiler-artifact" or not message.get("executable"):
            continue
        crate = pathlib.Path(message["manifest_path"]).parent
        if message["profile"]["test"]:
            tests[f"{crate.name}/{message['target']['name']}"] = (message["executable"], crate)
        elif message["target"]["kind"] == ["bin"]:
            programs["CARGO_BIN_EXE_" + message["target"]["name"]] = message["executable"]
    return tests, programs


def passes(test, programs, number, limit):
    executable, crate = test
    environment = {**os.environ, **programs, "CARGO_MANIFEST_DIR": str(crate), "TAXEL_MUTANT": str(number)}
    try:
        done = subprocess.run([executable, "--quiet"], cwd=crate, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=limit)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("crate")
    parser.add_argument("--count", type=int, default=150)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=pathlib.Path, required=True)
    parser.add_argument("--also", nargs="*", default=["taxel/metamorphic", "taxel/readers", "taxel/expects", "taxel/lengths"])
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    mutants, of = chosen(arguments.crate, arguments.count, arguments.seed)
    names = [f"{path.relative_to(ROOT)}:{line}: {' '.join(old.split())}" for path, _, _, old, _, line in mutants]
    if arguments.list:
        print("\n".join(f"{number} {name}" for number, name in enumerate(names, 1)))
        return
    folder = arguments.folder.resolve()
    plant(arguments.crate, mutants, folder)
    tests, programs = built(folder)
    own = [name for name in tests if name.startswith(arguments.crate + "/")]
    limits = {}
    for name in own + arguments.also:
        start = time.time()
        if not passes(tests[name], programs, 0, 600):
            sys.exit(f"{name} fails without a change")
        limits[name] = 10 * (time.time() - start) + 5
    own.sort(key=limits.get)
    explained = {line.split("  ")[0] for line in EXPLAINED.read_text().splitlines()} if EXPLAINED.exists() else set()
    alive = []
    for number, name in enumerate(names, 1):
        noticed = next((test for test in own + arguments.also if not passes(tests[test], programs, number, limits[test])), None)
        # Lines move; the file and the expression say which.
        told = re.sub(r":\d+: ", ": ", name, count=1)
        state = f"noticed by {noticed}" if noticed else ("explained" if told in explained else "ALIVE")
        print(f"{number:4} {state:40} {name}", flush=True)
        if not noticed and told not in explained:
            alive.append(name)
    print(f"{len(mutants)} of {of} changes of {arguments.crate}: {len(alive)} noticed by no test and not explained")
    sys.exit(1 if alive else 0)


if __name__ == "__main__":
    main()
