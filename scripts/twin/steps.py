#!/usr/bin/env python3
"""Training steps of a PyTorch twin on request: `crates/engine/examples/steps.rs` in PyTorch.

    python3 scripts/twin/steps.py resnet8-lite-2d --batch 64 --threads 1 --format channels_last

Needs torch. Builds the twin, prepares one fixed batch, warms up, prints a line about itself and then obeys
`run K`, `memory` and `quit` on its standard input, one JSON line per order. Formats:

    default         PyTorch's own memory layout
    channels_last   the layout that oneDNN's convolutions prefer, for inputs with rows and columns
    bf16            channels_last under torch.autocast in bfloat16

A step is what a PyTorch user writes: zero_grad, cross-entropy, backward, torch.optim.SGD with momentum
0.9; `--fused` takes the fused implementation of SGD. With `--device cuda` network and batch lie on the graphics card, and
a time ends when the card has finished. CPU time is that of the whole process, all threads.
"""

import argparse
import json
import pathlib
import sys
import time

import torch
from torch.nn import functional as F

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import networks  # noqa: E402

WARM_UP = 3
# By the number of axes, batch and channels included; signals have no second layout.
CHANNELS_LAST = {4: torch.channels_last, 5: torch.channels_last_3d}


def peak_memory():
    for line in pathlib.Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1])
    raise SystemExit("/proc/self/status: no VmHWM")


class Bench:
    def __init__(self, args, settings):
        torch.manual_seed(0)
        self.net = networks.build(args.network, **settings).train(not args.eval)
        shapes = networks.input_shapes(args.network, **settings)
        self.inputs = [torch.rand(args.batch, *shape) * 2 - 1 for shape in shapes]
        if args.format != "default":
            for axes, layout in CHANNELS_LAST.items():
                if any(x.ndim == axes for x in self.inputs):
                    self.net = self.net.to(memory_format=layout)
            self.inputs = [x.contiguous(memory_format=CHANNELS_LAST.get(x.ndim, torch.contiguous_format)) for x in self.inputs]
        self.device = args.device
        self.net, self.inputs = self.net.to(args.device), [x.to(args.device) for x in self.inputs]
        self.autocast = torch.autocast(args.device, dtype=torch.bfloat16, enabled=args.format == "bf16")
        self.eval = args.eval
        with torch.no_grad():
            classes = self.net.eval()(*self.inputs).shape[1]
        self.net.train(not args.eval)
        self.labels = (torch.arange(args.batch) % classes).to(args.device)
        # `fused=None` leaves the choice to PyTorch, as a user would.
        self.sgd = torch.optim.SGD(self.net.parameters(), lr=1e-3, momentum=0.9, fused=args.fused or None)
        self.about = dict(
            network=args.network,
            version=torch.__version__,
            batch=args.batch,
            threads=torch.get_num_threads(),
            inputs=[list(shape) for shape in shapes],
            classes=classes,
            parameters=sum(p.numel() for p in self.net.parameters()),
        )

    def run(self, steps):
        loss = None
        if self.eval:
            with torch.inference_mode(), self.autocast:
                for _ in range(steps):
                    self.net(*self.inputs)
            return None
        for _ in range(steps):
            self.sgd.zero_grad()
            with self.autocast:
                loss = F.cross_entropy(self.net(*self.inputs), self.labels)
            loss.backward()
            self.sgd.step()
        return loss.item()

    def wait(self):
        if self.device == "cuda":
            torch.cuda.synchronize()

    def timed(self, steps):
        self.wait()
        cpu, wall = time.process_time(), time.perf_counter()
        loss = self.run(steps)
        self.wait()
        wall_s, cpu_s = time.perf_counter() - wall, time.process_time() - cpu
        return dict(cpu_s=cpu_s, wall_s=wall_s, steps=steps, loss=loss)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("network")
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--format", choices=["default", "channels_last", "bf16"], default="default")
    parser.add_argument("--device", choices=["cpu", "cuda"], default="cpu")
    parser.add_argument("--eval", action="store_true", help="answers in inference mode in place of training steps")
    parser.add_argument("--fused", action="store_true")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting of the network; VALUE is JSON")
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    runtime = peak_memory()
    settings = {key: json.loads(value) for key, value in (pair.split("=", 1) for pair in args.set)}
    bench = Bench(args, settings)
    bench.run(WARM_UP)
    print(json.dumps(bench.about), flush=True)
    for line in sys.stdin:
        match line.split():
            case ["run", steps]:
                answer = bench.timed(int(steps))
            case ["memory"]:
                # Of the peak, so much was there before the network: Python and PyTorch themselves.
                answer = dict(peak_rss_kib=peak_memory(), runtime_kib=runtime)
            case ["quit"]:
                break
            case _:
                raise SystemExit(f"unknown order `{line.strip()}`; known: run K, memory, quit")
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
