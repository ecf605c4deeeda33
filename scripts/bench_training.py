#!/usr/bin/env python3
"""Compares the speed of taxel's training steps with PyTorch's; writes docs/benchmarks/<date>-<cpu>-training.*

    python3 scripts/bench_training.py [--networks mlp,vgg6-lite-2d] [--threads 1,2] [--rounds 15] [--quick]

Needs cargo and a Python with torch (`scripts/twin/steps.py` runs under the same one). How the numbers
are made:

*Programs.* The same network (PyTorch's from `scripts/twin/networks.py`; input shapes and numbers of
parameters are compared with taxel's before anything is timed), the same batch, one training step: forward,
cross-entropy, backward, SGD with momentum 0.9. PyTorch runs in its default memory format, in channels_last
where an input has rows and columns, and under bfloat16 autocast. taxel runs in f32 and, where the processor multiplies
bf16, in bf16. f32 is compared with the faster of PyTorch's two f32 columns, bf16 with our f32 and with PyTorch's bf16.
Without torch (`--no-torch`) only taxel's two columns are there.

*Method.* Every column is a process of its own that stays alive. They work one at a time, in turns: a round is
a short run of each (`--seconds`), the next round goes through them backwards, so that a machine that
gets slower or warmer does so for all. A cell is the median over rounds.

*Which clock.* Other programs disturb CPU time less than wall time, so it measures one thread; they still
share caches and memory, and on a busy machine PyTorch's times have come out a third too long. The page says
how busy others were: publish what a quiet machine gave. With more threads CPU time would hide waiting, so
wall time counts; there, a core lost to another program costs PyTorch's fixed split more than it costs
taxel, and a busy machine would flatter taxel. Wall times therefore count only from runs in which other
programs took at most a tenth of the processors (`/proc/stat`); there are up to four times as many rounds to
find enough of them, and where that fails, the row says `disturbed` in place of a ratio: with one of two
cores lost, PyTorch's threads wait for each other and ratios of 100 and more are seen.

*Targets.* A network meets its target if it is at least `target` times as fast as PyTorch; a group does if
its geometric mean is. Both tables are below; a new network is one entry in `NETWORKS` and one twin.

`--quick` tests this script: few short rounds, numbers without meaning.
"""

import argparse
import contextlib
import datetime
import json
import math
import os
import pathlib
import platform
import re
import select
import statistics
import subprocess
import sys
import time
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[1]
TWIN = ROOT / "scripts" / "twin" / "steps.py"


class Row(NamedTuple):
    batch: int
    target: float | None  # times as fast as PyTorch; None: only shown
    group: str | None = None  # counts in this group's geometric mean
    settings: dict = {}  # in place of the paper's sizes, on both sides


# Geometric mean over the networks of a group.
GROUPS = {"light": 2.0}
LIGHT = Row(64, 1.3, "light")
# A network may stand here with several batches or sizes.
NETWORKS = {
    "mlp": [LIGHT],
    "lstm": [LIGHT],
    "tactnet4": [LIGHT],
    "tactnet6": [LIGHT],
    "vgg6-lite-1d": [LIGHT],
    "resnet8-lite-1d": [LIGHT],
    "densenet6-lite-1d": [LIGHT],
    "vgg6-lite-2d": [LIGHT],
    "resnet8-lite-2d": [LIGHT],
    "densenet6-lite-2d": [LIGHT],
    "hybrid-vgg": [LIGHT],
    "hybrid-resnet": [LIGHT],
    "hybrid-densenet": [LIGHT],
    "hybrid-resvgg": [LIGHT],
    "hybrid-resvgg-nofc": [LIGHT],
    "tactnet3d": [Row(10, 1.5), Row(32, 1.5)],
    "tactnet3d-51": [Row(8, 1.5)],
    "multiscale-cnn": [Row(32, 2.0)],
    "mobilenet-v2": [Row(16, 1.5)],
    "resnet18": [Row(8, 1.0)],
}
FORMATS = ["default", "channels_last", "bf16"]
QUIET = 0.1  # share of the processors that other programs may take while a wall time is measured
SEARCH = 4  # times as many rounds to find quiet ones


class Worker:
    """A process that speaks the protocol of `steps`: one order, one JSON line."""

    def __init__(self, name, command, patience, hide_card=True):
        self.name, self.patience, self.steps = name, patience, 1
        # A CUDA build of PyTorch shall not look for devices; threads are counted by the program itself.
        environment = {**os.environ, "CUDA_VISIBLE_DEVICES": ""} if hide_card else dict(os.environ)
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1, env=environment)
        self.about = self.answer("start")

    def answer(self, order):
        ready, _, _ = select.select([self.process.stdout], [], [], self.patience)
        if not ready:
            self.process.kill()
            raise SystemExit(f"{self.name}: no answer to `{order}` within {self.patience} s; --patience gives it longer")
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"{self.name}: ended at `{order}` with status {self.process.wait()}")
        return json.loads(line)

    def ask(self, order):
        self.process.stdin.write(order + "\n")
        return self.answer(order)

    def calibrate(self, seconds):
        """Finds how many steps fill `seconds`."""
        while True:
            took = self.ask(f"run {self.steps}")["wall_s"]
            if took >= seconds / 2:
                self.steps = max(1, round(self.steps * seconds / took))
                return
            self.steps = math.ceil(self.steps * min(10, seconds / max(took, 1e-6)))

    def close(self):
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def processors():
    """Busy and total processor time of the whole machine so far, in ticks."""
    ticks = [int(n) for n in pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
    return sum(ticks) - ticks[3] - ticks[4], sum(ticks)


def run(worker):
    """One run of a worker, with the share of the processors that other programs took meanwhile."""
    busy, total = processors()
    times = worker.ask(f"run {worker.steps}")
    busy, total = (after - before for after, before in zip(processors(), (busy, total)))
    ours = times["cpu_s"] * os.sysconf("SC_CLK_TCK")
    return dict(times, others=round(max(0.0, busy - ours) / max(total, 1), 3))


def build(package, example):
    """Builds an example and returns its path."""
    command = ["cargo", "build", "--release", "--locked", "-p", package, "--example", example, "--message-format", "json"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(f"cargo could not build the example `{example}`")
    for line in done.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and message["target"]["name"] == example:
            return message["executable"]
    raise SystemExit(f"cargo built no executable called `{example}`")


def commands(name, row, threads, steps, args):
    """Command by column."""
    common = [name, "--batch", str(row.batch), "--threads", str(threads)]
    common += [word for key, value in row.settings.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    torch = [sys.executable, str(TWIN), *common, *(["--fused"] if args.fused else [])]
    ours = {"taxel": [steps, *common]}
    if args.half:
        ours["taxel bf16"] = [steps, *common, "--precision", "bf16"]
    return ours if args.no_torch else {**ours, **{f: [*torch, "--format", f] for f in FORMATS}}


def check_same(name, workers):
    ours = workers["taxel"].about
    for column, worker in workers.items():
        for key in ("inputs", "classes", "parameters", "batch", "threads"):
            if worker.about[key] != ours[key]:
                raise SystemExit(f"{name}: {key} is {ours[key]} in taxel and {worker.about[key]} in {column}; the twin is another network")


def measure(name, row, threads, steps, args):
    """Runs one network in all columns: the times of every round and the memory."""
    with contextlib.ExitStack() as stack:
        workers = {}
        for column, command in commands(name, row, threads, steps, args).items():
            axes = max(map(len, workers["taxel"].about["inputs"])) if workers else 0
            if column == "channels_last" and axes < 3:
                continue  # a signal has one layout
            workers[column] = Worker(f"{name} ({column})", command, args.patience)
            stack.callback(workers[column].close)
        check_same(name, workers)
        for worker in workers.values():
            worker.calibrate(args.seconds)
        rounds = {column: [] for column in workers}
        for number in range(args.rounds * (SEARCH if threads > 1 else 1)):
            if all(len(quiet(times, threads)) >= args.rounds for times in rounds.values()):
                break
            for column in list(workers)[:: 1 if number % 2 == 0 else -1]:
                # Worker threads of the one before spin a little before they sleep.
                time.sleep(0.02)
                times = run(workers[column])
                if times["loss"] is None or not math.isfinite(times["loss"]):
                    raise SystemExit(f"{name} ({column}): the loss is {times['loss']} after {number} rounds")
                rounds[column].append(times)
        memory = {column: worker.ask("memory") for column, worker in workers.items()}
        abouts = {column: worker.about for column, worker in workers.items()}
    clock = "cpu_s" if threads == 1 else "wall_s"
    disturbed = any(len(quiet(times, threads)) < max(3, args.rounds / 3) for times in rounds.values())
    counted = {column: times if disturbed else quiet(times, threads) for column, times in rounds.items()}
    ms = {column: statistics.median(1000 * r[clock] / r["steps"] for r in times) for column, times in counted.items()}
    opponent = min((c for c in ("default", "channels_last") if c in ms), key=ms.get, default=None)
    return dict(
        network=name,
        batch=row.batch,
        settings=row.settings,
        threads=threads,
        clock=clock,
        ms=ms,
        opponent=opponent,
        ratio=ms[opponent] / ms["taxel"] if opponent else None,
        half_ratio=ms["taxel"] / ms["taxel bf16"] if args.half else None,
        half_torch=ms["bf16"] / ms["taxel bf16"] if args.half and opponent else None,
        target=row.target,
        group=row.group,
        memory_kib=memory,
        disturbed=disturbed,
        others=statistics.fmean(r["others"] for times in counted.values() for r in times),
        versions={"taxel": abouts["taxel"]["version"], "torch": abouts[opponent]["version"] if opponent else "none"},
        rounds=rounds,
    )


def quiet(times, threads):
    """The runs that count: all by CPU time, undisturbed ones by wall time."""
    return [r for r in times if threads == 1 or r["others"] <= QUIET]


def geometric_mean(values):
    return math.exp(statistics.fmean(map(math.log, values)))


def verdict(ratio, target, disturbed):
    return "–" if None in (ratio, target) or disturbed else "met" if ratio >= target else "**missed**"


def times_as_fast(ratio, disturbed):
    return "–" if ratio is None else "disturbed" if disturbed else f"{ratio:.2f}×"


def summaries(results):
    """Geometric means: of every group that has a target, and of everything."""
    lines = []
    for group, target in [*GROUPS.items(), (None, None)]:
        chosen = [r for r in results if group is None or r["group"] == group]
        if not chosen:
            continue
        ratios = [r["ratio"] for r in chosen if r["ratio"]]
        means = {key: geometric_mean([r[key] for r in chosen]) for key in ("half_ratio", "half_torch") if all(r[key] for r in chosen)}
        of = sum(group in (None, row.group) for rows in NETWORKS.values() for row in rows)
        what = f"geometric mean, {group or 'all'}" + ("" if len(chosen) == of else f" ({len(chosen)} of {of})")
        disturbed = any(r["disturbed"] for r in chosen)
        mean, least = (geometric_mean(ratios), min(ratios)) if ratios else (None, None)
        lines.append(dict(what=what, ratio=mean, least=least, target=target, disturbed=disturbed, **means))
    return lines


def milliseconds(value):
    return "–" if value is None else f"{value:.3g}" if value < 100 else f"{value:.0f}"


def mebibytes(memory, column):
    return f"{memory[column]['peak_rss_kib'] / 1024:.0f}"


def table(results):
    head = ["network", "batch", "taxel ms", "PyTorch default ms", "channels_last ms", "ratio", "target", ""]
    head += ["taxel bf16 ms", "PyTorch bf16 ms", "bf16 over f32", "bf16 over PyTorch's", "taxel MiB", "PyTorch MiB", "of it runtime MiB"]
    lines = [head, ["---"] + ["---:"] * 6 + ["---"] + ["---:"] * 7]
    for r in results:
        ms, memory = r["ms"], r["memory_kib"]
        row = [f"`{r['network']}`", str(r["batch"])] + [milliseconds(ms.get(c)) for c in ("taxel", "default", "channels_last")]
        row.append(times_as_fast(r["ratio"], r["disturbed"]))
        row.append(f"{r['target']:.1f}×" if r["target"] else "–")
        row.append(verdict(r["ratio"], r["target"], r["disturbed"]))
        row += [milliseconds(ms.get("taxel bf16")), milliseconds(ms.get("bf16"))]
        row += [times_as_fast(r[key], r["disturbed"]) for key in ("half_ratio", "half_torch")]
        row.append(mebibytes(memory, "taxel"))
        opponent = r["opponent"]
        row += [mebibytes(memory, opponent), f"{memory[opponent]['runtime_kib'] / 1024:.0f}"] if opponent else ["–", "–"]
        lines.append(row)
    for s in summaries(results):
        target = f"{s['target']:.1f}×" if s["target"] else "–"
        ratio, met = times_as_fast(s["ratio"], s["disturbed"]), verdict(s["ratio"], s["target"], s["disturbed"])
        halves = [times_as_fast(s.get(key), s["disturbed"]) for key in ("half_ratio", "half_torch")]
        lines.append([s["what"], "", "", "", "", ratio, target, met, "", "", *halves, "", "", ""])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def output_of(*command):
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else "unknown"


def environment(args):
    facts = {}
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        key, _, value = line.partition(":")
        facts.setdefault(key.strip(), value.strip())
    flags = set(facts.get("flags", "").split())
    return dict(
        date=datetime.date.today().isoformat(),
        cpu=facts.get("model name", platform.machine()),
        family=facts.get("cpu family"),
        model=facts.get("model"),
        cores=os.cpu_count(),
        vectors=[f for f in ("avx2", "fma", "avx512f", "avx512_bf16", "amx_tile") if f in flags],
        kernel=platform.release(),
        rustc=output_of("rustc", "--version"),
        commit=output_of("git", "rev-parse", "--short=9", "HEAD"),
        # Files that git does not know yet count as well.
        changed=output_of("git", "--no-optional-locks", "status", "--porcelain", "--", "crates", "Cargo.toml", "Cargo.lock") not in ("", "unknown"),
        python=platform.python_version(),
        rounds=args.rounds,
        seconds=args.seconds,
        fused=args.fused,
        quick=args.quick,
    )


def page(facts, results):
    versions = results[0]["versions"]
    lines = [
        f"# Training steps against PyTorch: {facts['cpu']}, {facts['date']}",
        "",
        "Generated by `scripts/bench_training.py`, which says how it measures; every round is in the JSON file beside this page.",
        "",
        f"- {facts['cpu']} (family {facts['family']}, model {facts['model']}), {facts['cores']} cores, "
        f"{', '.join(facts['vectors']) or 'no vector extensions'}; Linux {facts['kernel']}",
        f"- taxel {versions['taxel']} at {facts['commit']}{' with uncommitted changes' if facts['changed'] else ''}, {facts['rustc']}",
        f"- PyTorch {versions['torch']}, torch.optim.SGD{' (fused)' if facts['fused'] else ''}, Python {facts['python']}",
        f"- medians over {facts['rounds']} rounds of about {facts['seconds']} s per column",
    ]
    if facts["quick"]:
        lines.append("- **a quick trial: these numbers mean little**")
    for threads in dict.fromkeys(r["threads"] for r in results):
        chosen = [r for r in results if r["threads"] == threads]
        others = 100 * statistics.fmean(r["others"] for r in chosen)
        clock = "CPU time" if threads == 1 else "wall time"
        lines += ["", f"## {threads} thread{'s' if threads > 1 else ''}, {clock}", "", table(chosen), ""]
        lines.append(
            "Milliseconds per step of the whole batch; ratio: the faster f32 column of PyTorch over taxel; bf16 over f32: our f32 over our bf16. Memory is the peak of the "
            f"process. In the runs that count, other programs kept {others:.0f} % of the processors busy."
        )
    return "\n".join(lines) + "\n"


def positive_list(text):
    numbers = [int(n) for n in text.split(",")]
    if min(numbers) < 1:
        raise argparse.ArgumentTypeError(f"{text}: threads are counted from 1")
    return numbers


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--networks", help="comma-separated; default all of the table NETWORKS")
    parser.add_argument("--threads", type=positive_list, default=[1, 2], help="comma-separated numbers of threads; default 1,2")
    parser.add_argument("--rounds", type=int, help="default 15, with --quick 3")
    parser.add_argument("--seconds", type=float, help="length of one column's run in a round; default 0.4, with --quick 0.15")
    parser.add_argument("--quick", action="store_true", help="try the script out; the numbers mean little")
    parser.add_argument("--fused", action="store_true", help="PyTorch's fused SGD; its default on a CPU is not fused")
    parser.add_argument("--no-torch", action="store_true", help="only taxel's columns: f32 and bf16")
    parser.add_argument("--steps", help="a `steps` built from this commit; default: cargo builds it")
    parser.add_argument("--patience", type=float, default=300, help="seconds to wait for one answer; default 300")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "docs" / "benchmarks")
    args = parser.parse_args()
    args.rounds = args.rounds or (3 if args.quick else 15)
    args.seconds = args.seconds or (0.15 if args.quick else 0.4)
    args.networks = args.networks.split(",") if args.networks else list(NETWORKS)
    args.half = "avx512_bf16" in pathlib.Path("/proc/cpuinfo").read_text()
    unknown = [name for name in args.networks if name not in NETWORKS]
    if unknown:
        parser.error(f"--networks {','.join(unknown)}: not in the table; known: {', '.join(NETWORKS)}")
    return args


def main():
    args = arguments()
    steps = args.steps or build("taxel-engine", "steps")
    facts, results = environment(args), []
    for threads in args.threads:
        for name, row in ((name, row) for name in args.networks for row in NETWORKS[name]):
            result = measure(name, row, threads, steps, args)
            results.append(result)
            columns = ", ".join(f"{column} {milliseconds(ms)}" for column, ms in result["ms"].items())
            note = ", disturbed" if result["disturbed"] else ""
            print(f"{name}, batch {row.batch}, {threads} threads: {columns} ms; {times_as_fast(result['ratio'], False)}{note}", file=sys.stderr, flush=True)
    text = page(facts, results)
    print(text)
    means = {str(t): summaries([r for r in results if r["threads"] == t]) for t in args.threads}
    slug = re.sub(r"[^a-z0-9]+", "-", re.sub(r"\((r|tm)\)| cpu|@.*", "", facts["cpu"].lower())).strip("-")
    args.out.mkdir(parents=True, exist_ok=True)
    stem = args.out / f"{facts['date']}-{slug}-training"
    stem.with_name(stem.name + ".md").write_text(text)
    stem.with_name(stem.name + ".json").write_text(json.dumps(dict(environment=facts, means=means, results=results), indent=1) + "\n")
    print(f"wrote {stem}.md and .json", file=sys.stderr)


if __name__ == "__main__":
    main()
