"""Runs printed C under QEMU on microcontrollers' cores: bits, instructions, flash, RAM and stack.

    python scripts/firmware_cores.py --taxel target/release/taxel --output docs/benchmarks/DATE-firmware.md

It trains small models on simulated grasps, puts them in eight bits, exports them, and runs test/check.c of each on every
core, at -Os, -O2, -O3 and -O2 -ffast-math. QEMU counts instructions exactly; instructions are not cycles. Debian's packages
gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf
qemu-system-misc have all that it needs. With --folders it takes folders that are there.
"""

import argparse
import datetime
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent / "firmware"
NETWORKS = ["mlp", "vgg6-lite-1d", "resnet8-lite-1d", "densenet6-lite-1d", "dilated-resnet-1d"]
LEVELS = [["-O2"], ["-O2", "-ffast-math"], ["-Os"], ["-O3"]]
COUNTED = ["-O2"]
# Cores whose floats are software; there only every so many filters are checked.
SOFT, SPARSE = ["M0", "M3", "RV32IMAC"], 16
CONFIG = """name = "firmware"
seed = 0
[data]
scene = "fingertip"
samples = 120
[encoding]
signal = { scale = "z-score" }
[train]
epochs = 5
batch_size = 32
"""
WARNINGS = "-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Werror".split()


class Arm:
    def __init__(self, cpu, machine, flash, ram, ticks, options):
        self.name, self.machine, self.flash, self.ram, self.ticks = cpu, machine, flash, ram, ticks
        self.options = [f"-mcpu=cortex-{cpu.split()[0].lower()}", "-mthumb", *options]
        self.compiler, self.tools = "arm-none-eabi-gcc", "arm-none-eabi-"

    def link(self):
        memory = {"FLASH_AT": self.flash[0], "FLASH_SIZE": self.flash[1], "RAM_AT": self.ram[0], "RAM_SIZE": self.ram[1]}
        script = (HERE / "cortex_m.ld").read_text()
        for key, value in memory.items():
            script = script.replace(key, hex(value))
        return script

    def build(self, home, source, flags, out):
        script = home / "core.ld"
        script.write_text(self.link())
        start = home / "start.o"
        run([self.compiler, *self.options, "-O2", "-c", str(HERE / "start.c"), "-o", str(start)])
        run([self.compiler, *self.options, *flags, str(source), str(start), "-nostartfiles", "--specs=nano.specs",
             "--specs=rdimon.specs", "-T", str(script), "-Wl,--gc-sections", "-o", str(out)])

    def emulator(self, program, counted):
        counting = ["-icount", "shift=5"] if counted else []
        return ["qemu-system-arm", "-M", self.machine, *QUIET, *counting, "-kernel", str(program)]

    def instructions(self, ticks):
        return round(ticks / self.ticks)


class RiscV:
    def __init__(self, name, march, abi):
        self.name = name
        self.options = [f"-march={march}", f"-mabi={abi}", "-misa-spec=2.2", "--specs=picolibc.specs"]
        self.compiler, self.tools = "riscv64-unknown-elf-gcc", "riscv64-unknown-elf-"

    def build(self, home, source, flags, out):
        places = ["__flash=0x80000000", "__flash_size=0x200000", "__ram=0x80200000", "__ram_size=0x200000"]
        run([self.compiler, *self.options, *flags, str(source), "--oslib=semihost",
             "--crt0=semihost", *[f"-Wl,--defsym={place}" for place in places], "-o", str(out)])

    def emulator(self, program, counted):
        counting = ["-icount", "shift=0"] if counted else []
        return ["qemu-system-riscv32", "-M", "virt", "-bios", "none", *QUIET, *counting, "-kernel", str(program)]

    def instructions(self, ticks):
        return ticks


QUIET = ["-nographic", "-monitor", "none", "-serial", "none", "-semihosting-config", "enable=on,target=native"]
MIB = 1 << 20
CORES = [
    Arm("M0", "microbit", (0, 256 << 10), (0x20000000, 16 << 10), 0.512, ["-mfloat-abi=soft"]),
    Arm("M3", "mps2-an385", (0, 4 * MIB), (0x20000000, 4 * MIB), 0.8, ["-mfloat-abi=soft"]),
    Arm("M4 with FPU", "mps2-an386", (0, 4 * MIB), (0x20000000, 4 * MIB), 0.8, ["-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]),
    Arm("M7", "mps2-an500", (0, 4 * MIB), (0x20000000, 4 * MIB), 0.8, ["-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"]),
    Arm("M33", "mps2-an505", (0x10000000, 4 * MIB), (0x38000000, 2 * MIB), 0.64, ["-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"]),
    Arm("M55", "mps3-an547", (0, 512 << 10), (0x20000000, 512 << 10), 1.024, ["-mfloat-abi=hard"]),
    RiscV("RV32IMAC", "rv32imac", "ilp32"),
    RiscV("RV32IMAFC", "rv32imafc", "ilp32f"),
]


def run(command, seconds=600):
    done = subprocess.run(command, capture_output=True, text=True, timeout=seconds)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr[-3000:]}")
    return done.stdout


def export(taxel, home, networks):
    """Trains, quantises and exports each network on the same simulated grasps."""
    data, config = home / "grasps.npz", home / "small.toml"
    listed = "".join(f'[[networks]]\nname = "{network}"\n' for network in networks)
    config.write_text(CONFIG + listed)
    run([taxel, "simulate", "fingertip", "--samples", "120", "--seed", "0", "--output", str(data)])
    folders = []
    for network in networks:
        model, small, folder = home / f"{network}.safetensors", home / f"{network}.int8.safetensors", home / network
        run([taxel, "fit", str(config), "--network", network, "--output", str(model)])
        run([taxel, "quantize", str(model), "--calibrate", str(data), "--output", str(small)])
        run([taxel, "export", str(small), "--format", "c", "--name", network, "--output", str(folder)])
        folders.append(folder)
    return folders


def facts(folder):
    """Reads the numbers of a library's header."""
    header = next((folder / "src").glob("*.h"))
    names = dict(re.findall(r"#define TAXEL_\w+?_(CLASSES|VALUES|RAM_BYTES|FLASH_BYTES|TABLE_BYTES|MACS) (\d+)u", header.read_text()))
    return {"name": header.stem.removeprefix("taxel_"), "source": header.with_suffix(".c"), **{k: int(v) for k, v in names.items()}}


def check(core, folder, home, flags, every):
    """Runs the test of a folder; says what it printed."""
    out = home / "check.elf"
    wide = ["-std=c99", *WARNINGS, *flags, f"-DCHECK_EVERY={every}u", "-ffunction-sections", "-fdata-sections"]
    core.build(home, folder / "test" / "check.c", wide, out)
    done = subprocess.run(core.emulator(out, False), capture_output=True, text=True, timeout=1200)
    return (done.stdout + done.stderr).strip()


def measure(core, library, home):
    """Counts instructions and stack of one prediction, and the bytes of the code that it needs."""
    flags = [*COUNTED, f"-DNAME={library['name']}", f'-DSOURCE="{library["source"]}"', f"-DVALUES={library['VALUES']}",
             f"-DCLASSES={library['CLASSES']}", "-ffunction-sections", "-fdata-sections"]
    out = home / "count.elf"
    core.build(home, HERE / "count.c", flags, out)
    said = subprocess.run(core.emulator(out, True), capture_output=True, text=True, timeout=600)
    said = said.stdout + said.stderr
    ticks, stack = map(int, re.search(r"ticks (\d+) stack (\d+)", said).groups())
    return core.instructions(ticks), stack, flash(core, library, home)


def flash(core, library, home):
    """Adds up the sections of the library that `predict` needs; libgcc's floats of cores without FPU come on top."""
    out = home / "library.o"
    run([core.compiler, *core.options, *COUNTED, "-ffunction-sections", "-fdata-sections", "-c", str(library["source"]), "-o", str(out)])
    lines = run([core.tools + "size", "-A", str(out)]).splitlines()
    sizes = [line.split()[:2] for line in lines if re.match(r"\.(text|rodata|srodata|data\.rel\.ro)", line)]
    others = re.compile(r"_(push|ready|clear|predict_latest)$")
    return sum(int(size) for name, size in sizes if not others.search(name))


def page(rows, bits, compilers):
    lines = ["# Printed C under QEMU", ""]
    lines += [f"Written by `scripts/firmware_cores.py` on {datetime.date.today()}. Compilers: {'; '.join(compilers)}. One prediction is",
              "5 channels × 50 time steps, from raw values to probabilities, compiled at -O2. QEMU counts instructions exactly.",
              "**Instructions are not cycles**: how many cycles one takes depends on the core, its caches and its flash. Flash is",
              "code and tables that `predict` needs; on cores without an FPU libgcc's float routines come on top.", ""]
    lines += ["| network | core | instructions | per MAC | flash | RAM | stack |", "|---|---|---|---|---|---|---|"]
    for library, core, instructions, stack, size in rows:
        per = instructions / library["MACS"]
        lines.append(f"| {library['name']} | {core} | {instructions:,} | {per:.2f} | {size:,} | {library['RAM_BYTES']:,} | {stack} |")
    lines += ["", "## Bits", "", "`test/check.c` on every core: 200 samples, and every threshold of every layer;",
              f"on cores without an FPU of every {SPARSE}th filter.", ""]
    lines += ["| network | core | flags | result |", "|---|---|---|---|"]
    lines += [f"| {name} | {core} | {flags} | {said} |" for name, core, flags, said in bits]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taxel", default="target/release/taxel")
    parser.add_argument("--folders", nargs="*", type=Path, default=[])
    parser.add_argument("--networks", nargs="*", default=NETWORKS)
    parser.add_argument("--cores", nargs="*", help="names of cores, such as M4")
    parser.add_argument("--levels", type=int, default=len(LEVELS), help="how many levels of optimisation are checked")
    parser.add_argument("--output", type=Path)
    args = parser.parse_args()
    cores = [core for core in CORES if not args.cores or core.name.split()[0] in args.cores]
    compilers = sorted({run([core.compiler, "--version"]).splitlines()[0] for core in cores})
    rows, bits, failed = [], [], False
    with tempfile.TemporaryDirectory() as home:
        home = Path(home)
        for folder in args.folders or export(args.taxel, home, args.networks):
            library = facts(folder)
            for core in cores:
                # The test's own memory is about 3 KB.
                if core.name == "M0" and library["RAM_BYTES"] + 3500 > 16 << 10:
                    bits.append((library["name"], core.name, "", "does not fit 16 KB of RAM"))
                    continue
                rows.append((library, core.name, *measure(core, library, home)))
                print(library["name"], core.name, *rows[-1][2:], flush=True)
                for flags in LEVELS[: args.levels]:
                    said = check(core, folder, home, flags, SPARSE if core.name in SOFT else 1)
                    failed |= not said.startswith("equal")
                    bits.append((library["name"], core.name, " ".join(flags), said.replace("\n", " ")))
                    print(" ", *flags, said, flush=True)
                if args.output:
                    args.output.write_text(page(rows, bits, compilers))
    sys.exit(failed)


if __name__ == "__main__":
    main()
