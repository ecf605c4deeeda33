#!/usr/bin/env python3
"""Runs every fuzz target and prints a table of what each did.

    python3 scripts/fuzz.py                        10^7 files over all readers
    python3 scripts/fuzz.py --files 100000 npz mat   100,000 over two of them
    python3 scripts/fuzz.py --page                   docs/fuzzing.md, of all runs together

Needs a nightly compiler, `cargo install cargo-fuzz`, and for --lines `rustup component add --toolchain nightly
llvm-tools`. A first second per target measures how fast it is. All then get about the same time, so a fast reader
gets more of the files. Corpora stay in fuzz/corpus and are used again, and
fuzz/artifacts/ledger.json adds up what all runs did, so that a long job may be cut into evenings (--seconds, --built). A
machine without a ledger begins with the table of docs/fuzzing.md. A file that breaks a reader ends its target and lies in
fuzz/artifacts/<reader>; the exit code is 1.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FUZZ = ROOT / "fuzz"
LEDGER = FUZZ / "artifacts" / "ledger.json"
PAGE = ROOT / "docs" / "fuzzing.md"
NIGHTLY = ["cargo", "+nightly"]
# Crates whose lines a reader is made of.
READERS = ["data", "checkpoint", "onnx", "learn", "judge", "trainer", "scenes"]


def host():
    text = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    return re.search(r"^host: (.*)$", text, re.M).group(1)


def folder(kind, name):
    path = FUZZ / kind / name
    path.mkdir(parents=True, exist_ok=True)
    return path


def fuzz(binary, name, options, limits):
    """One run of a target; its last numbers."""
    command = [binary, folder("corpus", name), f"-artifact_prefix={folder('artifacts', name)}/", "-print_final_stats=1"]
    command += [f"-max_len={limits.max_len}", f"-rss_limit_mb={limits.rss_mb}", f"-timeout={limits.timeout}"]
    environment = {**os.environ, "TAXEL_FUZZ_READER": name}
    child = subprocess.Popen([*command, *options], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")
    said = child.communicate()[1]
    shutil.rmtree(f"/dev/shm/taxel-fuzz-{child.pid}", ignore_errors=True)
    (FUZZ / "artifacts" / f"{name}.log").write_text(said)
    numbers = re.findall(r"cov: (\d+) ft: (\d+) corp: (\d+)", said)
    own = dict(zip(("edges", "features", "corpus"), map(int, numbers[-1] if numbers else (0, 0, 0))))
    for key, stat in [("files", "number_of_executed_units"), ("rate", "average_exec_per_sec"), ("rss", "peak_rss_mb")]:
        found = re.search(rf"stat::{stat}:\s*(\d+)", said)
        own[key] = int(found.group(1)) if found else 0
    own["found"] = re.findall(r"Test unit written to (.*)", said)
    own["ok"] = child.returncode == 0
    return own


def before(ledger=LEDGER, table=PAGE):
    """Sums of all runs so far: of the ledger, or of the page where this machine has no ledger."""
    if ledger.exists():
        return json.loads(ledger.read_text())
    known = {}
    for row in re.findall(r"^\| (\w+) \| ([\d,]+ \|(?: \d+ \|){5})$", table.read_text(), re.M):
        files, edges, features, corpus, rss, found = (int(cell.replace(",", "")) for cell in row[1].split("|")[:6])
        # The page counts what was found and does not name it.
        known[row[0]] = {"files": files, "edges": edges, "features": features, "corpus": corpus, "rss": rss, "found": [""] * found}
    return known


def add(name, own, ledger=LEDGER):
    """Adds a run of a target to what was done before."""
    known = before(ledger)
    sums = known.setdefault(name, {"files": 0, "edges": 0, "features": 0, "corpus": 0, "rss": 0, "found": []})
    sums["files"] += own["files"]
    for key in ("edges", "features", "corpus", "rss"):
        sums[key] = max(sums[key], own[key])
    sums["found"] += [Path(path).name for path in own["found"]]
    ledger.parent.mkdir(parents=True, exist_ok=True)
    ledger.write_text(json.dumps(known, indent=1) + "\n")


def page(names):
    """Writes docs/fuzzing.md from the ledger."""
    known = before()
    rows, total = [], 0
    for name in names:
        own = known.get(name)
        if own:
            total += own["files"]
            cells = [name, f"{own['files']:,}", own["edges"], own["features"], own["corpus"], own["rss"], len(own["found"])]
            rows.append("| " + " | ".join(map(str, cells)) + " |")
    text = f"""# Fuzzing

Every reader of files is fed with damaged files by libFuzzer, which keeps those that reach new code. A reader must give a value or
an error: no panic, no hang over ten seconds, and no more memory than four times the file and 64 MiB.
[`fuzz/README.md`](../fuzz/README.md) says how to run it. `python3 scripts/fuzz.py --page` writes this page.

Files so far: {total:,}. *Edges* are places in the compiled code that were reached, *features* add how often. *Found* counts files that
broke a reader, each of which was mended and is kept in `fuzz/found/`.

| reader | files | edges | features | corpus | peak memory (MB) | found |
|---|---|---|---|---|---|---|
""" + "\n".join(rows) + "\n"
    PAGE.write_text(text)


def lines(name, triple):
    """Share of lines that the corpus of a target reaches, of all files it reaches at all."""
    environment = {**os.environ, "TAXEL_FUZZ_READER": name}
    command = [*NIGHTLY, "fuzz", "coverage", "-s", "none", "reader", folder("corpus", name)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, env=environment)
    sysroot = subprocess.run(["rustc", "+nightly", "--print", "sysroot"], capture_output=True, text=True, check=True).stdout.strip()
    tool = f"{sysroot}/lib/rustlib/{triple}/bin/llvm-cov"
    binary = ROOT / f"target/{triple}/coverage/{triple}/release/reader"
    if not binary.exists():
        binary = FUZZ / f"target/{triple}/coverage/{triple}/release/reader"
    profile = FUZZ / "coverage" / "reader" / "coverage.profdata"
    text = subprocess.run(
        [tool, "export", "-summary-only", f"-instr-profile={profile}", binary], capture_output=True, text=True, check=True
    ).stdout
    reached = {}
    for file in json.loads(text)["data"][0]["files"]:
        crate = re.search(r"/crates/([^/]+)/src/", file["filename"])
        count = file["summary"]["lines"]
        if crate and crate.group(1) in READERS and count["covered"]:
            reached[file["filename"].split("/crates/")[1]] = (count["covered"], count["count"])
    return reached


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("readers", nargs="*", help="targets [all]")
    parser.add_argument("--files", type=int, default=10_000_000, help="files over all targets together")
    parser.add_argument("--sanitizer", default="none", help="as cargo fuzz takes it: none or address")
    parser.add_argument("--built", action="store_true", help="use the targets as they were built last")
    parser.add_argument("--seconds", type=int, help="at most this long for a target")
    parser.add_argument("--max-len", type=int, default=16384, help="bytes of a file")
    parser.add_argument("--rss-mb", type=int, default=1024, help="memory of a process")
    parser.add_argument("--timeout", type=int, default=10, help="seconds of the clock for a file; more where others keep the machine busy")
    parser.add_argument("--page", action="store_true", help="write docs/fuzzing.md of all runs, in place of fuzzing")
    parser.add_argument("--lines", action="store_true", help="lines that the corpora reach, in place of fuzzing")
    limits = parser.parse_args()

    every = re.findall(r'\bname: "(\w+)"', (FUZZ / "readers.rs").read_text())
    names = limits.readers or every
    unknown = [name for name in names if name not in every]
    if unknown:
        sys.exit(f"no reader of the name {', '.join(unknown)}; there are {', '.join(every)}")
    triple = host()

    if limits.page:
        return page(every)
    if limits.lines:
        total = {}
        print("| reader | files reached | lines reached |\n|---|---|---|")
        for name in names:
            own = lines(name, triple)
            for file, (covered, count) in own.items():
                total[file] = (max(covered, total.get(file, (0, 0))[0]), count)
            covered, count = (sum(pair[part] for pair in own.values()) for part in (0, 1))
            print(f"| {name} | {len(own)} | {covered} of {count} |", flush=True)
        print("\n| file | most lines that one reader reaches |\n|---|---|")
        for file, (covered, count) in sorted(total.items()):
            print(f"| {file} | {covered} of {count} |")
        return

    if not limits.built:
        subprocess.run([*NIGHTLY, "fuzz", "build", "-s", limits.sanitizer], cwd=ROOT, check=True)
    binaries = FUZZ / "target" / triple / "release"
    subprocess.run([binaries / "seeds"], check=True)
    tried = {name: fuzz(binaries / "reader", name, ["-max_total_time=1"], limits) for name in names}
    together = sum(max(own["rate"], 1) for own in tried.values())
    left = limits.files - sum(own["files"] for own in tried.values())

    print("| reader | files | per second | edges | features | corpus | peak memory (MB) | found |\n|---|---|---|---|---|---|---|---|")
    sums, broken = 0, False
    for name in names:
        first = tried[name]
        options = [f"-runs={max(1000, round(left * max(first['rate'], 1) / together))}"]
        if limits.seconds:
            options.append(f"-max_total_time={limits.seconds}")
        own = fuzz(binaries / "reader", name, options, limits) if first["ok"] else first
        files = own["files"] + (first["files"] if first["ok"] else 0)
        found = ", ".join(Path(path).name for path in own["found"]) or ("-" if own["ok"] else "see its log")
        add(name, {**own, "files": files})
        sums, broken = sums + files, broken or not own["ok"]
        cells = [name, f"{files:,}", f"{own['rate']:,}", own["edges"], own["features"], own["corpus"], own["rss"], found]
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)
    print(f"\n{sums:,} files")
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
