"""Counts the instructions of CMSIS-NN, emlearn and onnx2c for the networks that taxel prints, beside taxel's own.

    python scripts/firmware_compare.py --cmsis-nn FOLDER --emlearn FOLDER --rows target/firmware-rows.jsonl
    python scripts/firmware_compare.py --onnx2c PROGRAM --onnx resnet8-lite-1d.onnx --rows target/firmware-rows.jsonl

FOLDER is a clone of ARM-software/CMSIS-NN, and the folder of emlearn's headers (eml_net.h); PROGRAM is onnx2c as it was built, and
the file what `taxel export` wrote of a network in floats. Where onnx and onnxruntime are installed, batch norms are folded first. Nothing of them is copied. The same shapes are run, for CMSIS-NN and emlearn with numbers that mean nothing: what they
take does not depend on them. CMSIS-NN has no standard deviation, so that dilated-resnet-1d goes without. A prediction goes from raw
floats to logits of bytes (CMSIS-NN) or probabilities. Flash is what is linked in besides an empty prediction, RAM what it
keeps in memory besides. Rows go to the file from which `firmware_cores.py` writes its page.
"""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

import firmware_cores as cores

SCRIPTS = Path(__file__).parent.resolve()
# Layers of resnet8-lite-1d: kind, taps, stride, channels, filters, positions in, positions out, from, to, addend (bytes of the arena).
RESNET8 = [
    ("conv", 5, 1, 5, 16, 50, 50, 0, 400, None),
    ("most", 3, 2, 16, 16, 50, 25, 400, 0, None),
    ("conv", 3, 1, 16, 16, 25, 25, 0, 400, None),
    ("conv", 3, 1, 16, 16, 25, 25, 400, 800, None),
    ("add", 1, 1, 16, 16, 25, 25, 800, 0, 0),
    ("conv", 3, 2, 16, 32, 25, 13, 0, 416, None),
    ("conv", 3, 1, 32, 32, 13, 13, 416, 832, None),
    ("conv", 1, 2, 16, 32, 25, 13, 0, 416, None),
    ("add", 1, 1, 32, 32, 13, 13, 832, 0, 416),
    ("conv", 3, 1, 32, 32, 13, 13, 0, 416, None),
    ("conv", 3, 1, 32, 32, 13, 13, 416, 832, None),
    ("add", 1, 1, 32, 32, 13, 13, 832, 0, 0),
    ("mean", 13, 1, 32, 32, 13, 1, 0, 416, None),
    ("full", 1, 1, 32, 3, 1, 1, 416, 0, None),
]
MLP = [("full", 1, 1, 250, 128, 1, 1, 0, 256, None), ("full", 1, 1, 128, 3, 1, 1, 256, 0, None)]
# Of 5 x 50 values; "apart" is a convolution whose taps are two positions apart.
DILATED = [
    ("conv", 1, 1, 5, 64, 50, 50, 3200, 0, None),
    ("conv", 3, 1, 64, 64, 50, 50, 0, 3200, None),
    ("conv", 3, 1, 64, 64, 50, 50, 3200, 6400, None),
    ("add", 1, 1, 64, 64, 50, 50, 6400, 0, 0),
    ("apart", 3, 1, 64, 64, 50, 50, 0, 3200, None),
    ("apart", 3, 1, 64, 64, 50, 50, 3200, 6400, None),
    ("add", 1, 1, 64, 64, 50, 50, 6400, 0, 0),
    ("most", 50, 50, 64, 64, 50, 1, 0, 3200, None),
    ("mean", 50, 1, 64, 64, 50, 1, 0, 3264, None),
    ("full", 1, 1, 128, 3, 1, 1, 3200, 0, None),
]
# Layers, bytes of the arena, and of scratch without Helium and with it: what the get_buffer_size functions ask for, or more.
NETWORKS = {
    "resnet8_lite_1d": (RESNET8, 1250, (384, 384)),
    "mlp": (MLP, 384, (4, 512)),
    "dilated_resnet_1d": (DILATED, 9600, (768, 1600)),
}
EMPTY = "#include <stdint.h>\nint taxel_{name}_predict(const float *x, float *y) {{ y[0] = x[0]; return 0; }}\n"
STAGE = """
    for (int i = 0; i < 250; i++) {
        float v = (sample[i] - means[i / 50]) * scales[i / 50];
        v = v < -128.0f ? -128.0f : (v > 127.0f ? 127.0f : v);
        %s
    }
"""


def table(kind, name, count, value):
    return f"static const {kind} {name}[{count}] = {{ {', '.join(str(value(i)) for i in range(count))} }};\n"


def cmsis_nn(name):
    """Writes a prediction that calls CMSIS-NN."""
    layers, arena, scratch = NETWORKS[name]
    tables, calls = "", ""
    for number, (kind, taps, stride, channels, filters, inside, outside, at, to, addend) in enumerate(layers):
        dilation = 2 if kind == "apart" else 1
        before = (taps - 1) // 2 * dilation if kind in ("conv", "apart", "most") and outside > 1 else 0
        dims = (f"const cmsis_nn_dims in = {{1, 1, {inside}, {channels}}}, out = {{1, 1, {outside}, {filters}}}, "
                f"bias = {{1, 1, 1, {filters}}};")
        if kind in ("conv", "apart"):
            tables += table("int8_t", f"w{number}", taps * channels * filters, lambda i: i * 37 % 255 - 127)
            tables += table("int32_t", f"b{number}", filters, lambda i: i * 91 % 1000)
            tables += table("int32_t", f"m{number}", filters, lambda i: 1200000000 + i)
            tables += table("int32_t", f"s{number}", filters, lambda i: -8)
            calls += f"""    {{
        {dims}
        const cmsis_nn_dims filter = {{{filters}, 1, {taps}, {channels}}};
        const cmsis_nn_conv_params how = {{128, -128, {{{stride}, 1}}, {{{before}, 0}}, {{{dilation}, 1}}, {{-128, 127}}}};
        const cmsis_nn_per_channel_quant_params scale = {{(int32_t *)m{number}, (int32_t *)s{number}}};
        arm_convolve_wrapper_s8(&context, &how, &scale, &in, arena + {at}, &filter, w{number}, &bias, b{number}, &out, arena + {to});
    }}
"""
        elif kind in ("most", "mean"):
            call = "arm_max_pool_s8" if kind == "most" else "arm_avgpool_s8"
            calls += f"""    {{
        {dims}
        const cmsis_nn_dims filter = {{1, 1, {taps}, 1}};
        const cmsis_nn_pool_params how = {{{{{stride}, 1}}, {{{before}, 0}}, {{-128, 127}}}};
        (void)bias;
        {call}(&context, &how, &in, arena + {at}, &filter, &out, arena + {to});
    }}
"""
        elif kind == "add":
            calls += (f"    arm_elementwise_add_s8(arena + {at}, arena + {addend}, 128, 1200000000, -1, 128, 1300000000, -1, 20, "
                      f"arena + {to}, -128, 1400000000, -18, -128, 127, {filters * outside});\n")
        else:
            tables += table("int8_t", f"w{number}", channels * filters, lambda i: i * 37 % 255 - 127)
            tables += table("int32_t", f"b{number}", filters, lambda i: i * 91 % 1000)
            calls += f"""    {{
        const cmsis_nn_dims in = {{1, 1, 1, {channels}}}, out = {{1, 1, 1, {filters}}}, bias = {{1, 1, 1, {filters}}};
        const cmsis_nn_dims filter = {{{channels}, 1, 1, {filters}}};
        const cmsis_nn_fc_params how = {{128, 0, -128, {{-128, 127}}}};
        const cmsis_nn_per_tensor_quant_params scale = {{1200000000, -8}};
        SUMS({number}, {channels}, {filters})
        arm_fully_connected_s8(&context, &how, &scale, &in, arena + {at}, &filter, w{number}, &bias, b{number}, &out, arena + {to});
    }}
"""
    head = f"""#include "arm_nnfunctions.h"
static int8_t arena[{arena}];
#if defined(ARM_MATH_MVEI)
#define SCRATCH {scratch[1]}
#else
#define SCRATCH {scratch[0]}
#endif
static int32_t scratch[SCRATCH / 4];
static const float means[5] = {{511.f, 480.f, 1.f, .3f, 40.f}}, scales[5] = {{.1f, .2f, 3.f, 4.f, 5.f}};
static cmsis_nn_context context = {{scratch, sizeof scratch}};
/* With Helium sums of weights are wanted beforehand. */
#if defined(ARM_MATH_MVEI)
#define SUMS(n, channels, filters) arm_vector_sum_s8(scratch, channels, filters, w##n, 128, 0, b##n);
#else
#define SUMS(n, channels, filters)
#endif
"""
    stage = STAGE % ("arena[i % 50 * 5 + i / 50] = (int8_t)__builtin_lrintf(v);" if name != "mlp" else "arena[i] = (int8_t)__builtin_lrintf(v);")
    return (f"{head}{tables}int taxel_{name}_predict(const float *sample, float *row)\n{{{stage}{calls}"
            f"    for (int i = 0; i < 3; i++) {{\n        row[i] = (float)arena[i];\n    }}\n    return 0;\n}}\n")


def emlearn():
    """Writes a prediction of the multilayer perceptron that calls emlearn."""
    tables = ""
    for number, (_, _, _, channels, filters, *_) in enumerate(MLP):
        tables += table("float", f"w{number}", channels * filters, lambda i: f"{(i * 37 % 255 - 127) / 900:.6f}f")
        tables += table("float", f"b{number}", filters, lambda i: f"{(i * 91 % 100) / 300:.6f}f")
    stage = STAGE % "values[i] = v;"
    return f"""#include "eml_net.h"
{tables}static float one[250], two[250], values[250];
static const float means[5] = {{511.f, 480.f, 1.f, .3f, 40.f}}, scales[5] = {{.1f, .2f, 3.f, 4.f, 5.f}};
static const EmlNetLayer layers[2] = {{
    {{128, 250, w0, b0, EmlNetActivationRelu}}, {{3, 128, w1, b1, EmlNetActivationSoftmax}},
}};
static EmlNet net = {{2, layers, one, two, 250}};
int taxel_mlp_predict(const float *sample, float *row)
{{{stage}    return (int)eml_net_predict_proba(&net, values, 250, row, 3);
}}
"""


def onnx2c(program, file, name):
    """Prints an ONNX file, batch norms folded where onnxruntime is there, as C behind taxel's interface."""
    with tempfile.TemporaryDirectory() as home:
        folded = Path(home) / "folded.onnx"
        try:
            import onnx
            import onnxruntime

            options = onnxruntime.SessionOptions()
            options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_BASIC
            options.optimized_model_filepath = str(folded)
            onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
            network = onnx.load(folded)
            for node in network.graph.node:
                # onnx2c does not know this one, which is 0.
                kept = [attribute for attribute in node.attribute if attribute.name != "storage_order"]
                del node.attribute[:]
                node.attribute.extend(kept)
            onnx.save(network, folded)
        except ImportError:
            folded = file
        text = cores.run([str(program), "-d", "batch:1", str(folded)])
    return f"""{text}
int taxel_{name}_predict(const float *sample, float *row)
{{
    static float logits[1][3];
    entry((const float (*)[5][50])sample, logits, (float (*)[3])row);
    return 0;
}}
"""


def linked(core, home, name, text, objects, includes, level):
    """Builds the program that counts one prediction; returns its bytes of flash and of RAM."""
    source, made, start, out = home / "other.c", home / "made.o", home / "start.o", home / "other.elf"
    source.write_text(text)
    script = home / "core.ld"
    script.write_text(core.link())
    flags = [level, f"-DNAME={name}", f'-DSOURCE="{source}"', "-DVALUES=250", "-DCLASSES=3", "-ffunction-sections", "-fdata-sections"]
    where = [f"-I{folder}" for folder in includes]
    cores.run([core.compiler, *core.options, "-O2", "-c", str(SCRIPTS / "firmware" / "start.c"), "-o", str(start)])
    cores.run([core.compiler, *core.options, "--specs=nano.specs", *where, *flags, "-c", str(SCRIPTS / "firmware" / "count.c"), "-o", str(made)])
    cores.run([core.compiler, *core.options, str(made), *map(str, objects), str(start), "-nostartfiles", "--specs=nano.specs",
               "--specs=rdimon.specs", "-T", str(script), "-Wl,--gc-sections", "-o", str(out), "-lm"])
    text_bytes, data, bss = map(int, cores.run([core.tools + "size", str(out)]).splitlines()[1].split()[:3])
    return text_bytes + data, data + bss


def count(core, home, name, text, objects=(), includes=(), level="-O2"):
    empty = linked(core, home, name, EMPTY.format(name=name), [], [], level)
    flash, ram = linked(core, home, name, text, objects, includes, level)
    done = subprocess.run(core.emulator(home / "other.elf", True), capture_output=True, text=True, timeout=600)
    ticks, stack = map(int, re.search(r"ticks (\d+) stack (\d+)", done.stdout + done.stderr).groups())
    return {"instructions": core.instructions(ticks), "stack": stack, "flash": flash - empty[0], "ram": ram - empty[1]}


def objects_of(core, folder, home):
    """Compiles CMSIS-NN for a core."""
    home = home / core.name.split()[0]
    home.mkdir(exist_ok=True)
    wanted = ["ConvolutionFunctions", "FullyConnectedFunctions", "NNSupportFunctions", "PoolingFunctions", "BasicMathFunctions"]
    made = []
    for source in sorted(path for part in wanted for path in (folder / "Source" / part).glob("*_s8*.c")) + sorted(
        (folder / "Source" / "NNSupportFunctions").glob("*.c")
    ):
        out = home / f"{source.stem}.o"
        is_wide = "_s16" in source.stem and "s8" not in source.stem
        if out in made or is_wide or re.search("_f16|_f32|flt|_s64|lstm|svdf|transpose", source.stem):
            continue
        cores.run([core.compiler, *core.options, "-O2", "-ffunction-sections", "-fdata-sections", f"-I{folder / 'Include'}",
                   "-c", str(source), "-o", str(out)])
        made.append(out)
    return made


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cmsis-nn", type=Path)
    parser.add_argument("--emlearn", type=Path)
    parser.add_argument("--onnx2c", type=Path)
    parser.add_argument("--onnx", type=Path, nargs="*", default=[], help="networks of 5 x 50 values and 3 classes in floats")
    parser.add_argument("--cores", nargs="*", default=["M0", "M3", "M4", "M55"])
    parser.add_argument("--rows", type=Path, default=Path("target/firmware-rows.jsonl"))
    args = parser.parse_args()
    rows = cores.Rows(args.rows)
    with tempfile.TemporaryDirectory() as home:
        home = Path(home)
        for core in (core for core in cores.CORES if core.name.split()[0] in args.cores):
            row = lambda name, library: {"digest": "", "network": name, "core": core.name, "flags": library}
            if args.cmsis_nn:
                made = []
                for name in NETWORKS:
                    if cores.Rows.key(row(name, "CMSIS-NN")) not in rows.rows:
                        made = made or objects_of(core, args.cmsis_nn.resolve(), home)
                    include = [args.cmsis_nn.resolve() / "Include"]
                    rows.get(row(name, "CMSIS-NN"), lambda: count(core, home, name, cmsis_nn(name), made, include))
            # Without an FPU floats are hopeless, and taxel has none there.
            for file in args.onnx if core.name not in cores.SOFT else []:
                name = f"{file.stem.replace('-', '_')}_f32"
                for level in ("-O2", "-O3"):
                    text = lambda: onnx2c(args.onnx2c, file, name)
                    rows.get(row(name, f"onnx2c, {level}"), lambda: count(core, home, name, text(), level=level))
            if args.emlearn and core.name != "M0":
                rows.get(row("mlp", "emlearn, 32-bit floats"), lambda: count(core, home, "mlp", emlearn(), [], [args.emlearn.resolve()]))


if __name__ == "__main__":
    main()
