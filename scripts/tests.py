#!/usr/bin/env python3
"""Runs all tests of the workspace, as many test programs at a time as there are cores, and names the slowest.

    python3 scripts/tests.py --workspace --features taxel/candle -- --include-ignored

`cargo test` runs one program after the other, and most end with one long test on one core. cargo-nextest runs each test in a process
of its own, and would make anew what the tests of a program share. Arguments before `--` go to cargo, those
behind it to every test program; documentation tests come last. Exit code 1 if a test failed.
"""

import json
import os
import pathlib
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

# Long ones first, so that none is left alone at the end.
LONG = ["configs", "papers", "noise_audit", "readers", "hostile", "damaged", "kill", "sweep", "starting", "certainty", "firmware", "metamorphic"]


def programs(options):
    """Builds the tests: path, folder of the package, name."""
    command = ["cargo", "test", *options, "--no-run", "--message-format=json-render-diagnostics"]
    built = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if built.returncode:
        sys.exit(built.returncode)
    found = []
    for line in built.stdout.splitlines():
        message = json.loads(line)
        if message.get("reason") == "compiler-artifact" and message.get("executable") and message["profile"]["test"]:
            folder = pathlib.Path(message["manifest_path"]).parent
            found.append((message["executable"], folder, message["target"]["name"]))
    rank = {name: at for at, name in enumerate(LONG)}
    return sorted(found, key=lambda one: rank.get(one[2], len(LONG)))


def run(program, arguments):
    path, folder, name = program
    start = time.time()
    environment = {**os.environ, "CARGO_MANIFEST_DIR": str(folder), "RUST_TEST_THREADS": "1"}
    done = subprocess.run([path, *arguments], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    seconds = time.time() - start
    is_good = done.returncode == 0
    print(f"{'ok    ' if is_good else 'FAILED'} {seconds:6.1f} s  {folder.name}/{name}", flush=True)
    if not is_good:
        print(done.stdout, flush=True)
    return seconds, f"{folder.name}/{name}", is_good


def main():
    options, arguments = sys.argv[1:], []
    if "-h" in options or "--help" in options:
        print(__doc__)
        return
    if "--" in options:
        at = options.index("--")
        options, arguments = options[:at], options[at + 1 :]
    every, start = programs(options), time.time()
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        results = list(pool.map(lambda program: run(program, arguments), every))
    failed = [name for _, name, is_good in results if not is_good]
    print(f"\n{len(results)} test programs in {time.time() - start:.0f} s; the slowest:")
    for seconds, name, _ in sorted(results, reverse=True)[:10]:
        print(f"  {seconds:6.1f} s  {name}")
    documented = subprocess.run(["cargo", "test", *options, "--doc"]).returncode
    if failed:
        print("failed: " + ", ".join(failed))
    sys.exit(1 if failed or documented else 0)


if __name__ == "__main__":
    main()
