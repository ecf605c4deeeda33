#!/usr/bin/env python3
"""Measures `taxel stream`: latencies and losses at a rate with a core kept busy, memory, and the start of the process.

    cargo build --release -p taxel
    python3 scripts/bench_stream.py [--model m.safetensors] [--decisions 100000] [--rate 1000] [--busy 1] [--priority 10]

Without --model, resnet8-lite-1d is first fitted to simulated grasps (5 channels, windows of 50 time steps). Measured are:

- paced: time steps replayed from a file at --rate with a hop of 1, so that each has a decision, while --busy processes count
  as fast as they can. Exact quantiles of the latencies in the decisions, dropped time steps, and samples of the resident memory
  of the process;
- fast: the same time steps as fast as they are predicted;
- start: from before the process is started to its first decision (a window of time steps is ready on standard input), the
  median over --starts, and the process's highest resident memory.

Needs Linux (/proc) and nothing beside Python's own library.
"""

import argparse
import json
import math
import multiprocessing
import pathlib
import statistics
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
BINARY = ROOT / "target/release/taxel"
CONFIG = """
name = "bench"
[data]
scene = "fingertip"
samples = 300
[train]
epochs = 5
[[networks]]
name = "resnet8-lite-1d"
"""
CHANNELS, TICKS = 5, 50


def reading(t):
    return ",".join(f"{2 + math.sin(t / (7 + c)) + 0.01 * math.cos(0.7 * t):.5f}" for c in range(CHANNELS))


def resident(pid, key):
    """A memory of a process in MB, by the key of /proc/PID/status; none when it is gone."""
    try:
        lines = pathlib.Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return None
    kilobytes = [int(line.split()[1]) for line in lines if line.startswith(key)]
    return kilobytes[0] / 1024 if kilobytes else None


def spin():
    while True:
        pass


def summary_of(errors):
    return json.loads(errors.read_text().splitlines()[-1])["summary"]


def quantile(values, share):
    return sorted(values)[min(len(values) - 1, math.ceil(share * len(values)) - 1)]


def replay(binary, model, file, folder, decisions, *arguments):
    """Streams a file with a hop of 1; latencies in ms, memory along the way, the summary."""
    out, errors = folder / "decisions.jsonl", folder / "errors.txt"
    command = [*binary, "stream", model, "--input", file, "--hop", "1", *arguments]
    memory, begin = [], time.monotonic()
    with open(out, "wb") as to, open(errors, "wb") as complain:
        process = subprocess.Popen([str(part) for part in command], stdout=to, stderr=complain)
        while process.poll() is None:
            memory.append(resident(process.pid, "VmRSS:"))
            time.sleep(0.1)
    seconds = time.monotonic() - begin
    if process.returncode:
        raise SystemExit(errors.read_text())
    with open(out) as lines:
        latencies = [json.loads(line)["latency_ms"] for line in lines]
    summary = summary_of(errors)
    # The first is that of a process that has hardly begun.
    memory = [own for own in memory[1:] if own]
    figures = {
        "readings": summary["readings"], "decisions": len(latencies), "dropped": summary["dropped"],
        "p50_ms": quantile(latencies, 0.5), "p99_ms": quantile(latencies, 0.99), "p999_ms": quantile(latencies, 0.999),
        "max_ms": max(latencies), "seconds": round(seconds, 1),
        "memory_mb": [round(own, 2) for own in (memory[len(memory) // 10], memory[-1])] if memory else None,
    }
    figures["p99 / p50"] = round(figures["p99_ms"] / figures["p50_ms"], 2)
    figures["lost"] = decisions - len(latencies)
    return figures


def start(binary, model):
    """Milliseconds from before the start of the process to its first decision, and its highest resident memory in MB."""
    lines = "".join(reading(t) + "\n" for t in range(TICKS)).encode()
    begin = time.monotonic()
    process = subprocess.Popen([binary, "stream", model], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                               stderr=subprocess.DEVNULL)
    process.stdin.write(lines)
    process.stdin.flush()
    process.stdout.readline()
    milliseconds = 1e3 * (time.monotonic() - begin)
    peak = resident(process.pid, "VmHWM:")
    process.stdin.close()
    process.wait()
    return milliseconds, peak


def fitted(binary, folder):
    config, model = folder / "bench.toml", folder / "model.safetensors"
    config.write_text(CONFIG)
    subprocess.run([binary, "fit", config, "--output", model], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    return model


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", type=pathlib.Path)
    parser.add_argument("--decisions", type=int, default=100_000)
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--busy", type=int, default=1, help="processes that count as fast as they can")
    parser.add_argument("--priority", type=int, help="real-time priority of the stream (SCHED_FIFO), as a robot gives it")
    parser.add_argument("--binary", type=pathlib.Path, default=BINARY)
    parser.add_argument("--starts", type=int, default=21)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        model = args.model or fitted(args.binary, folder)
        file = folder / "readings.csv"
        file.write_text("".join(reading(t) + "\n" for t in range(args.decisions + TICKS - 1)))
        starts = [start(args.binary, model) for _ in range(args.starts)]
        print(json.dumps({"start": {
            "median_ms": round(statistics.median(ms for ms, _ in starts), 1),
            "max_ms": round(max(ms for ms, _ in starts), 1), "peak_mb": round(max(mb for _, mb in starts), 1)}}))
        print(json.dumps({"fast": replay([args.binary], model, file, folder, args.decisions)}))
        idle = [multiprocessing.Process(target=spin, daemon=True) for _ in range(args.busy)]
        for own in idle:
            own.start()
        command = [] if args.priority is None else ["chrt", "-f", str(args.priority)]
        paced = ["--pace", "rate", "--rate", str(args.rate)]
        paced = replay([*command, args.binary], model, file, folder, args.decisions, *paced)
        for own in idle:
            own.kill()
        print(json.dumps({f"paced at {args.rate:g} Hz, {args.busy} busy": paced}))


if __name__ == "__main__":
    main()
