#!/usr/bin/env python3
"""Predictions of a PyTorch twin in onnxruntime on request: `crates/runtime/examples/answers.rs` in Python.

    python3 scripts/twin/answers.py resnet8-lite-1d [--int8 | --tract]

Needs torch, onnx and onnxruntime or tract. Exports the twin in evaluation mode, prints a line about itself, and obeys `run N` on its
standard input: N predictions of one sample on one thread, and a JSON line with the CPU time of the whole process. --int8: in eight bits, as
onnxruntime's own static quantisation makes them (QDQ, unsigned values, signed weights per channel). --tract: by tract.
"""

import importlib.metadata
import io
import json
import pathlib
import sys
import tempfile
import time

import torch

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import networks  # noqa: E402


def eight_bits(model, feed):
    """The bytes of a model in eight bits, calibrated on one sample: speed does not depend on the ranges."""
    from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static
    from onnxruntime.quantization.shape_inference import quant_pre_process

    class One(CalibrationDataReader):
        left = iter([feed])

        def get_next(self):
            return next(self.left, None)

    with tempfile.TemporaryDirectory() as folder:
        plain, ready, small = (str(pathlib.Path(folder) / name) for name in ("plain.onnx", "ready.onnx", "small.onnx"))
        pathlib.Path(plain).write_bytes(model)
        quant_pre_process(plain, ready)
        kind = dict(activation_type=QuantType.QUInt8, weight_type=QuantType.QInt8, per_channel=True)
        quantize_static(ready, small, One(), quant_format=QuantFormat.QDQ, **kind)
        return pathlib.Path(small).read_bytes()


def by_onnxruntime(model, feed):
    """Its version, and a function that answers."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    return onnxruntime.__version__, lambda: session.run(None, feed)


def by_tract(model, feed):
    """Its version, and a function that answers."""
    import tract

    with tempfile.NamedTemporaryFile(suffix=".onnx") as file:
        file.write(model)
        file.flush()
        network = tract.onnx().load(file.name)
    for at, x in enumerate(feed.values()):
        network.set_input_fact(at, ",".join(map(str, x.shape)) + ",f32")
    for at in range(network.output_count()):
        network.set_output_fact(at, None)
    ready, inputs = network.into_model().into_runnable(), list(feed.values())
    return importlib.metadata.version("tract"), lambda: ready.run(inputs)


def main():
    name = sys.argv[1]
    torch.manual_seed(0)
    net = networks.build(name).eval()
    shapes = networks.input_shapes(name)
    inputs = tuple(torch.rand(1, *shape) * 2 - 1 for shape in shapes)
    names = [f"x{i}" for i in range(len(inputs))]
    file = io.BytesIO()
    torch.onnx.export(net, inputs, file, input_names=names, dynamo=False)
    feed = {key: x.numpy() for key, x in zip(names, inputs)}
    model = eight_bits(file.getvalue(), feed) if "--int8" in sys.argv else file.getvalue()
    version, answer = (by_tract if "--tract" in sys.argv else by_onnxruntime)(model, feed)
    parameters = sum(p.numel() for p in net.parameters())
    about = dict(inputs=[list(shape) for shape in shapes], parameters=parameters, version=version)
    print(json.dumps(about), flush=True)
    for line in sys.stdin:
        answers = int(line.removeprefix("run "))
        begun = time.process_time()
        for _ in range(answers):
            answer()
        print(json.dumps(dict(answers=answers, cpu_s=time.process_time() - begun)), flush=True)


main()
