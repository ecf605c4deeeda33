#!/usr/bin/env python3
"""Compares the time of one prediction with onnxruntime's; prints a table and, with --write, writes it to docs/benchmarks/.

    python3 scripts/bench_answers.py [--networks mlp,lstm] [--rounds 9] [--seconds 0.3] [--int8 | --bf16 | --tract] [--write]

Needs cargo and a Python with torch, onnx, onnxruntime and, for --tract, tract. The same network predicts one sample on one thread in
taxel's runtime, in taxel's training engine in evaluation mode, in onnxruntime and, with --tract, in tract. The network is PyTorch's from
`scripts/twin/networks.py`, exported to ONNX. Its input shapes and numbers of parameters must equal taxel's.

Each program is a process of its own that stays alive. They work in turns, in reversed order in the next round. A cell is the median
over rounds of CPU time per prediction. Other programs disturb CPU time less than wall time, but they share caches and memory.
So publish numbers of a quiet machine; the page says how busy it was. --bf16 compares products of bf16 with floats in taxel's runtime, beside
onnxruntime in floats, and needs AVX512-BF16. --int8 compares 2D and 3D networks in floats and in eight bits,
in taxel's runtime and in onnxruntime (QDQ, weights per channel).
"""

import argparse
import contextlib
import datetime
import json
import pathlib
import statistics
import sys

import bench_training
from bench_training import ROOT, Worker, geometric_mean, processors

TARGET, LEAST = 1.8, 1.2
# Of eight bits and of bf16 against floats, all taxel's.
TARGET_INT8, TARGET_BF16 = 1.5, 1.4
NETWORKS = """mlp lstm tactnet4 tactnet6 tactresnet vgg6-lite-1d resnet8-lite-1d densenet6-lite-1d vgg6-lite-2d resnet8-lite-2d
densenet6-lite-2d hybrid-vgg hybrid-resnet hybrid-densenet hybrid-resvgg tactnet3d multiscale-cnn dilated-resnet-1d
mobilenet-v2 shufflenet-v2 mnasnet1-0 resnet18""".split()


NETWORKS_INT8 = """vgg6-lite-2d resnet8-lite-2d densenet6-lite-2d hybrid-resvgg tactnet3d multiscale-cnn mobilenet-v2 shufflenet-v2
mnasnet1-0 resnet18""".split()


NETWORKS_BF16 = "mobilenet-v2 mnasnet1-0 resnet18".split()


class Answers(Worker):
    def fill(self, seconds):
        """Finds how many answers fill `seconds`."""
        answers = 1
        while (took := self.ask(f"run {answers}")["cpu_s"]) < seconds / 4:
            answers *= 4
        self.steps = max(1, round(answers * seconds / took))

    def once(self):
        return self.ask(f"run {self.steps}")["cpu_s"] / self.steps


def measure(name, program, args):
    with contextlib.ExitStack() as stack:
        twin = [sys.executable, str(ROOT / "scripts/twin/answers.py"), name]
        if args.int8:
            commands = {
                "frozen": [program, name, "frozen"],
                "int8": [program, name, "int8"],
                "onnxruntime": twin,
                "onnxruntime int8": [*twin, "--int8"],
            }
        elif args.bf16:
            commands = {
                "frozen": [program, name, "frozen"],
                "bf16": [program, name, "bf16"],
                "onnxruntime": twin,
            }
        else:
            commands = {
                "frozen": [program, name, "frozen"],
                "engine": [program, name, "engine"],
                "onnxruntime": twin,
            }
            if args.tract:
                commands["tract"] = [*twin, "--tract"]
        workers = {}
        for column, command in commands.items():
            workers[column] = Answers(f"{name} ({column})", command, 600)
            stack.callback(workers[column].close)
        for key in ("inputs", "parameters"):
            if len({json.dumps(worker.about[key]) for worker in workers.values()}) > 1:
                raise SystemExit(f"{name}: {key} differ: {[worker.about[key] for worker in workers.values()]}")
        for worker in workers.values():
            worker.fill(args.seconds)
        rounds = {column: [] for column in workers}
        for number in range(args.rounds):
            for column in list(workers)[:: 1 if number % 2 == 0 else -1]:
                rounds[column].append(workers[column].once())
        us = {column: 1e6 * statistics.median(times) for column, times in rounds.items()}
        versions = {column: worker.about["version"] for column, worker in workers.items() if "version" in worker.about}
        return dict(network=name, us=us, versions=versions)


def table(results):
    others = [column for column in results[0]["us"] if column not in ("frozen", "engine")]
    head = " | ".join(f"{other} µs | times as fast" for other in others)
    lines = [f"| network | frozen µs | engine µs | {head} | |", "|---|---:|---:|" + "---:|---:|" * len(others) + "---|"]
    ratios = {other: [result["us"][other] / result["us"]["frozen"] for result in results] for other in others}
    for at, result in enumerate(results):
        us = result["us"]
        cells = " | ".join(f"{us[other]:.3g} | {ratios[other][at]:.2f}×" for other in others)
        verdict = "met" if ratios["onnxruntime"][at] >= LEAST else "**missed**"
        lines.append(f"| `{result['network']}` | {us['frozen']:.3g} | {us['engine']:.3g} | {cells} | {verdict} |")
    means = {other: geometric_mean(own) for other, own in ratios.items()}
    verdict = "met" if means["onnxruntime"] >= TARGET else "**missed**"
    lines.append(f"| geometric mean | | | {' | '.join(f'| {mean:.2f}×' for mean in means.values())} | {verdict} |")
    return "\n".join(lines)


def table_int8(results):
    columns = ("frozen", "int8", "onnxruntime", "onnxruntime int8")
    lines = ["| network | floats µs | int8 µs | onnxruntime µs | onnxruntime int8 µs | int8 against floats | against onnxruntime int8 |", "|---|---:|---:|---:|---:|---:|---:|"]
    own, others = [], []
    for result in results:
        us = result["us"]
        own.append(us["frozen"] / us["int8"])
        others.append(us["onnxruntime int8"] / us["int8"])
        cells = [f"{us[column]:.3g}" for column in columns]
        lines.append(f"| `{result['network']}` | {' | '.join(cells)} | {own[-1]:.2f}× | {others[-1]:.2f}× |")
    mean = geometric_mean(own)
    verdict = "met" if mean >= TARGET_INT8 else "**missed**"
    lines.append(f"| geometric mean | | | | | {mean:.2f}× ({verdict}) | {geometric_mean(others):.2f}× |")
    return "\n".join(lines)


def table_bf16(results):
    lines = ["| network | floats µs | bf16 µs | onnxruntime µs | bf16 against floats | against onnxruntime | |", "|---|---:|---:|---:|---:|---:|---|"]
    ratios = []
    for result in results:
        us = result["us"]
        ratios.append(us["frozen"] / us["bf16"])
        cells = " | ".join(f"{us[column]:.3g}" for column in ("frozen", "bf16", "onnxruntime"))
        verdict = "met" if ratios[-1] >= TARGET_BF16 else "**missed**"
        lines.append(f"| `{result['network']}` | {cells} | {ratios[-1]:.2f}× | {us['onnxruntime'] / us['bf16']:.2f}× | {verdict} |")
    lines.append(f"| geometric mean | | | | {geometric_mean(ratios):.2f}× | | |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--networks")
    parser.add_argument("--int8", action="store_true", help="eight bits against floats")
    parser.add_argument("--bf16", action="store_true", help="products of bf16 against floats")
    parser.add_argument("--tract", action="store_true", help="beside tract as well")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--seconds", type=float, default=0.3)
    parser.add_argument("--write", action="store_true", help="writes docs/benchmarks/DATE-CPU-answers.md and .json")
    args = parser.parse_args()
    program = bench_training.build("taxel-runtime", "answers")
    before = processors()
    results = []
    kind, title, target = "", "against onnxruntime", f"targets: {TARGET}× of onnxruntime in geometric mean, none below {LEAST}×"
    show, networks = table, NETWORKS
    if args.int8:
        kind, title, target = "-int8", "in eight bits", f"target: {TARGET_INT8}× of floats in geometric mean"
        show, networks = table_int8, NETWORKS_INT8
    elif args.bf16:
        kind, title, target = "-bf16", "in bf16", f"target: {TARGET_BF16}× of floats"
        show, networks = table_bf16, NETWORKS_BF16
    names = args.networks.split(",") if args.networks else networks
    for name in names:
        results.append(measure(name, program, args))
        print(show(results[-1:]).splitlines()[2], flush=True)
    busy, total = (after - first for after, first in zip(processors(), before))
    facts = bench_training.environment(argparse.Namespace(rounds=args.rounds, seconds=args.seconds, fused=False, quick=False))
    page = [
        f"# One answer {title}: {facts['cpu']}, {facts['date']}",
        "",
        "Generated by `scripts/bench_answers.py`, which says how it measures: batch 1, one thread, CPU time.",
        "",
        f"- {facts['cpu']}, {facts['cores']} cores of which {busy / total:.0%} of the time was used by all programs together "
        f"(one core is {1 / facts['cores']:.0%}), {', '.join(facts['vectors'])}",
        f"- taxel at {facts['commit']}{' with uncommitted changes' if facts['changed'] else ''}, {', '.join(f'{column} {version}' for column, version in results[0]['versions'].items() if 'int8' not in column)}",
        f"- {target}",
        "",
        show(results),
        "",
    ]
    print("\n".join(page))
    if args.write:
        cpu = "-".join(facts["cpu"].lower().replace("(r)", "").split()[:2])
        stem = ROOT / "docs/benchmarks" / f"{datetime.date.today().isoformat()}-{cpu}-answers{kind}"
        stem.with_suffix(".md").write_text("\n".join(page))
        stem.with_suffix(".json").write_text(json.dumps(dict(environment=facts, results=results), indent=1) + "\n")


main()
