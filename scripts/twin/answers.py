#!/usr/bin/env python3
"""Answers of a PyTorch twin in onnxruntime on request: `crates/runtime/examples/answers.rs` in Python.

    python3 scripts/twin/answers.py resnet8-lite-1d

Needs torch, onnx and onnxruntime. Exports the twin in evaluation mode, prints a line about itself, and obeys `run N` on its
standard input: N answers to one sample on one thread, and a JSON line with the CPU time of the whole process.
"""

import io
import json
import pathlib
import sys
import time

import onnxruntime
import torch

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import networks  # noqa: E402


def main():
    name = sys.argv[1]
    torch.manual_seed(0)
    net = networks.build(name).eval()
    shapes = networks.input_shapes(name)
    inputs = tuple(torch.rand(1, *shape) * 2 - 1 for shape in shapes)
    names = [f"x{i}" for i in range(len(inputs))]
    file = io.BytesIO()
    torch.onnx.export(net, inputs, file, input_names=names, dynamo=False)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(file.getvalue(), options, providers=["CPUExecutionProvider"])
    feed = {key: x.numpy() for key, x in zip(names, inputs)}
    parameters = sum(p.numel() for p in net.parameters())
    about = dict(inputs=[list(shape) for shape in shapes], parameters=parameters, version=onnxruntime.__version__)
    print(json.dumps(about), flush=True)
    for line in sys.stdin:
        answers = int(line.removeprefix("run "))
        begun = time.process_time()
        for _ in range(answers):
            session.run(None, feed)
        print(json.dumps(dict(answers=answers, cpu_s=time.process_time() - begun)), flush=True)


main()
