#!/usr/bin/env python3
"""Builds taxel for 64-bit Arm and tries it under QEMU.

    python3 scripts/arm64.py tests                 # tests of the crates that hold vectors and what is made of them
    python3 scripts/arm64.py count                 # instructions of one prediction of every network: docs/benchmarks/<date>-arm64.md
    python3 scripts/arm64.py robot                 # the robot's program, static; prints where it is and its size

Needs Debian's gcc-aarch64-linux-gnu, libc6-dev-arm64-cross, qemu-user-static (tests) and qemu-user (count), and a Rust with the target:
`rustup target add aarch64-unknown-linux-gnu`, or, where rustup cannot have it, RUSTC=/usr/bin/rustc of Debian's rustc-web with
libstd-rust-web-dev:arm64. Programs are linked statically: threads of dynamic ones hang in qemu-user 7.2. Instructions are exact and
repeatable; they are not cycles. On a board scripts/bench_answers.py measures times, as on any other processor.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
TARGET = "aarch64-unknown-linux-gnu"
CRATES = ["kernels", "engine", "runtime", "encodings", "baselines"]
# Tests of all networks: many minutes under an emulator. The test `bits` compares most of these networks with x86-64.
SLOW = ["threads_share_an_evaluator", "every_network_answers"]
# Widths of vectors, and what they are called on the page.
LEVELS = {"portable": "portable", "neon": "NEON", "": "with `sdot`"}
NETWORKS = """mlp lstm vgg6-lite-1d resnet8-lite-1d densenet6-lite-1d dilated-resnet-1d vgg6-lite-2d resnet8-lite-2d densenet6-lite-2d
hybrid-resvgg tactnet6 tactnet3d multiscale-cnn mobilenet-v2 resnet18""".split()


def environment():
    name = TARGET.upper().replace("-", "_")
    return os.environ | {
        f"CARGO_TARGET_{name}_LINKER": "aarch64-linux-gnu-gcc",
        f"CARGO_TARGET_{name}_RUSTFLAGS": "-C target-feature=+crt-static",
        f"CARGO_TARGET_{name}_RUNNER": "qemu-aarch64-static",
        # Tests of one program share an emulated processor.
        "RUST_TEST_THREADS": "1",
    }


def cargo(*arguments, behind=()):
    command = ["cargo", *arguments, "--locked", "--target", TARGET, *(["--", *behind] if behind else [])]
    subprocess.run(command, cwd=ROOT, env=environment(), check=True)


def folder():
    """Where cargo puts programs for the target."""
    command = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    metadata = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    return pathlib.Path(json.loads(metadata)["target_directory"]) / TARGET


def tests(only):
    for level in ["", "neon"]:
        print(f"TAXEL_SIMD={level}", flush=True)
        os.environ["TAXEL_SIMD"] = level
        crates = [word for crate in only or CRATES for word in ("--package", f"taxel-{crate}")]
        cargo("test", *crates, "--lib", "--tests", behind=[word for name in SLOW for word in ("--skip", name)])


class Counter:
    """Counts instructions of the example that predicts on request."""

    def __init__(self, home):
        self.plugin = home / "count.so"
        subprocess.run(["cc", "-shared", "-fPIC", "-O2", str(ROOT / "scripts/arm64/count.c"), "-o", str(self.plugin)], check=True)
        cargo("build", "--release", "--package", "taxel-runtime", "--example", "answers")
        self.program = folder() / "release" / "examples" / "answers"

    def all(self, network, how, level, orders):
        """Returns all instructions of a process with these orders, and what it said of itself."""
        command = ["qemu-aarch64", "-plugin", str(self.plugin), str(self.program), network, how]
        done = subprocess.run(command, env=os.environ | {"TAXEL_SIMD": level}, input=orders, capture_output=True, text=True)
        counted = re.search(r"instructions (\d+)", done.stderr)
        if done.returncode or not counted:
            raise SystemExit(f"{' '.join(command)}: {done.stderr}")
        return int(counted[1]), json.loads(done.stdout.splitlines()[0])

    def of(self, network, how, level):
        """Returns the instructions of one prediction and its multiply–adds."""
        few, about = self.all(network, how, level, "run 1\n")
        more, _ = self.all(network, how, level, "run 1\nrun 1\n")
        return more - few, about["macs"]


def count(only):
    names = only or NETWORKS
    with tempfile.TemporaryDirectory() as home:
        counter = Counter(pathlib.Path(home))
        floats, bytes_ = [], []
        for name in names:
            found = {level: counter.of(name, "frozen", level) for level in ("portable", "neon")}
            floats.append((name, found))
            print(name, "floats", found, flush=True)
            found = {level: counter.of(name, "int8", level) for level in LEVELS}
            bytes_.append((name, found))
            print(name, "int8", found, flush=True)
    emulator = subprocess.run(["qemu-aarch64", "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    compiler = subprocess.run([os.environ.get("RUSTC", "rustc"), "--version"], capture_output=True, text=True).stdout.strip()
    today = datetime.date.today().isoformat()
    lines = [
        "# Predictions on 64-bit Arm, in instructions",
        "",
        f"Written by `scripts/arm64.py count` on {today}.",
        f"{compiler}; {emulator}.",
        "One prediction of one sample with fresh weights, from inputs to logits. QEMU counts instructions exactly.",
        "**Instructions are not cycles**: how many run in one depends on the core.",
        "",
        "## In floats",
        "",
        *table(floats),
        "",
        "## In eight bits",
        "",
        "`sdot` multiplies sixteen bytes at once; the Cortex-A76, the Apple M1 and later cores have it, the Cortex-A53 and A72 do not.",
        "",
        *table(bytes_),
    ]
    page = ROOT / "docs" / "benchmarks" / f"{today}-arm64.md"
    page.write_text("\n".join(lines) + "\n")
    print(page)


def table(rows):
    levels = list(rows[0][1])
    head = [f"{LEVELS[level]} per MAC" for level in levels] + [f"{LEVELS[level]}: fewer" for level in levels[1:]]
    lines = ["| network | MACs | " + " | ".join(head) + " |", "|---|---:|" + "---:|" * len(head)]
    for name, found in rows:
        macs = found["portable"][1]
        each = [f"{found[level][0] / macs:.2f}" for level in levels]
        fewer = [f"{found['portable'][0] / found[level][0]:.1f} ×" for level in levels[1:]]
        lines.append(f"| {name} | {macs:,} | " + " | ".join(each + fewer) + " |")
    return lines


def robot(_):
    cargo("build", "--profile", "robot", "--package", "taxel", "--no-default-features", "--features", "runtime")
    program = folder() / "robot" / "taxel"
    print(f"{program}: {program.stat().st_size / 1e6:.1f} MB")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["tests", "count", "robot"])
    parser.add_argument("only", nargs="*", help="crates to test, or networks to count [default: all]")
    arguments = parser.parse_args()
    {"tests": tests, "count": count, "robot": robot}[arguments.command](arguments.only)


if __name__ == "__main__":
    main()
