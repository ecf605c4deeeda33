"""Runs printed C under QEMU on microcontrollers' cores: bits, instructions, flash, RAM and stack.

    TAXEL_FIRMWARE=target/firmware cargo test -p taxel-firmware --test strict -- --ignored compilers
    python scripts/firmware_cores.py --folders target/firmware/* --output docs/benchmarks/DATE-firmware.md

Each folder's test/check.c runs on every core, at -Os, -O2, -O3 and -O2 -ffast-math. QEMU counts instructions exactly;
instructions are not cycles. Debian's packages gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm
gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf qemu-system-misc clang have all that it needs. Without --folders it trains
small networks on simulated grasps and exports them. Rows are kept in a file as they come (--rows); a run that was stopped goes on
where it was, and rows of another C are measured again. The page has the rows that are there.
"""

import argparse
import datetime
import hashlib
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).parent / "firmware"
NETWORKS = ["mlp", "vgg6-lite-1d", "resnet8-lite-1d", "densenet6-lite-1d", "dilated-resnet-1d"]
LEVELS = [["-O2"], ["-O2", "-ffast-math"], ["-Os"], ["-O3"]]
COUNTED = ["-O2"]
# Functions that say whether a sample is unknown, and what each looks at.
GATES = {"gate of logits": ("_is_unknown", "row"), "gate of readings": ("_readings_are_unknown", "sample")}
# Cores whose floats are software; there only every so many filters are checked, and networks in floats are counted alone.
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


def soft(core):
    """Lets networks in floats compile where floats are software."""
    return ["-DSOFT_FLOATS"] if core in SOFT else []


class Arm:
    def __init__(self, cpu, machine, flash, ram, ticks, options, clang=False):
        self.name, self.machine, self.flash, self.ram, self.ticks = cpu, machine, flash, ram, ticks
        self.options = [f"-mcpu=cortex-{cpu.split()[0].lower()}", "-mthumb", *options, *soft(cpu)]
        self.compiler, self.tools = "arm-none-eabi-gcc", "arm-none-eabi-"
        self.translator = [self.compiler, "--specs=nano.specs"]
        if clang:
            self.name += ", clang"
            self.translator = ["clang", "--target=arm-none-eabi", "-isystem", "/usr/lib/arm-none-eabi/include"]

    def link(self):
        memory = {"FLASH_AT": self.flash[0], "FLASH_SIZE": self.flash[1], "RAM_AT": self.ram[0], "RAM_SIZE": self.ram[1]}
        script = (HERE / "cortex_m.ld").read_text()
        for key, value in memory.items():
            script = script.replace(key, hex(value))
        return script

    def build(self, home, source, flags, out):
        script = home / "core.ld"
        script.write_text(self.link())
        start, made = home / "start.o", home / "made.o"
        run([self.compiler, *self.options, "-O2", "-c", str(HERE / "start.c"), "-o", str(start)])
        run([*self.translator, *self.options, *flags, "-c", str(source), "-o", str(made)])
        run([self.compiler, *self.options, str(made), str(start), "-nostartfiles", "--specs=nano.specs",
             "--specs=rdimon.specs", "-T", str(script), "-Wl,--gc-sections", "-o", str(out)])

    def emulator(self, program, counted):
        counting = ["-icount", "shift=5"] if counted else []
        return ["qemu-system-arm", "-M", self.machine, *QUIET, *counting, "-kernel", str(program)]

    def instructions(self, ticks):
        return round(ticks / self.ticks)


class RiscV:
    def __init__(self, name, march, abi):
        self.name = name
        self.options = [f"-march={march}", f"-mabi={abi}", "-misa-spec=2.2", "--specs=picolibc.specs", *soft(name)]
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


class Host:
    """This computer: bits alone."""

    def __init__(self, compiler):
        self.name, self.compiler, self.options, self.translator = f"PC, {compiler}", compiler, [], [compiler]

    def build(self, home, source, flags, out):
        run([self.compiler, *flags, str(source), "-o", str(out)])

    def emulator(self, program, counted):
        return [str(program)]


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
# Those of which bits alone are looked at.
OTHERS = [
    Host("gcc"),
    Host("clang"),
    Arm("M4 with FPU", "mps2-an386", (0, 4 * MIB), (0x20000000, 4 * MIB), 0.8, ["-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"], True),
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
    names = dict(re.findall(r"#define TAXEL_\w+?_(CLASSES|QUANTITIES|VALUES|RAM_BYTES|FLASH_BYTES|TABLE_BYTES|MACS|NEEDS_FPU) (\d+)u", header.read_text()))
    names.setdefault("CLASSES", names.get("QUANTITIES"))
    gates = [name for name in GATES if f"{GATES[name][0]}(" in header.read_text()]
    return {"name": header.stem.removeprefix("taxel_"), "source": header.with_suffix(".c").resolve(), "gates": gates, **{k: int(v) for k, v in names.items() if v}}


def check(core, folder, home, flags, every):
    """Runs the test of a folder; says what it printed."""
    out = home / "check.elf"
    wide = ["-std=c99", *WARNINGS, *flags, f"-DCHECK_EVERY={every}u", "-ffunction-sections", "-fdata-sections"]
    core.build(home, folder / "test" / "check.c", wide, out)
    done = subprocess.run(core.emulator(out, False), capture_output=True, text=True, timeout=3600)
    return (done.stdout + done.stderr).strip()


def counted(core, library, home, more=()):
    """Counts instructions and stack of one prediction, or of what `more` flags ask for."""
    flags = [*more, *COUNTED, f"-DNAME={library['name']}", f'-DSOURCE="{library["source"]}"', f"-DVALUES={library['VALUES']}",
             f"-DCLASSES={library['CLASSES']}", "-ffunction-sections", "-fdata-sections"]
    out = home / "count.elf"
    core.build(home, HERE / "count.c", flags, out)
    said = subprocess.run(core.emulator(out, True), capture_output=True, text=True, timeout=600)
    said = said.stdout + said.stderr
    ticks, stack = map(int, re.search(r"ticks (\d+) stack (\d+)", said).groups())
    return core.instructions(ticks), stack


def gate(core, library, home, name):
    """Counts a gate."""
    function, of = GATES[name]
    instructions, stack = counted(core, library, home, [f"-DGATE={function}", f"-DGATED={of}"])
    return {"instructions": instructions, "stack": stack}


def flash(core, library, home):
    """Adds up the sections of the library that `predict` needs; libgcc's floats of cores without FPU come on top."""
    out = home / "library.o"
    run([core.compiler, *core.options, *COUNTED, "-ffunction-sections", "-fdata-sections", "-c", str(library["source"]), "-o", str(out)])
    lines = run([core.tools + "size", "-A", str(out)]).splitlines()
    sizes = [line.split()[:2] for line in lines if re.match(r"\.(text|rodata|srodata|data\.rel\.ro)", line)]
    others = re.compile(r"_(push|ready|clear|predict_latest)$")
    return sum(int(size) for name, size in sizes if not others.search(name))


class Rows:
    """Rows of a file, one JSON object a line, each with the digest of the C that it is about."""

    def __init__(self, path):
        self.path, self.rows = path, {}
        path.parent.mkdir(parents=True, exist_ok=True)
        for line in path.read_text().splitlines() if path.exists() else []:
            row = json.loads(line)
            self.rows[self.key(row)] = row

    @staticmethod
    def key(row):
        return tuple(row[name] for name in ("digest", "network", "core", "flags"))

    def get(self, row, found):
        """Returns the row that is there, or measures and keeps it."""
        key = self.key(row)
        if key not in self.rows:
            self.rows[key] = {**row, **found()}
            with self.path.open("a") as file:
                file.write(json.dumps(self.rows[key]) + "\n")
            print(*self.rows[key].values(), flush=True)
        return self.rows[key]


def digest(folder):
    text = b"".join(path.read_bytes() for path in sorted(folder.glob("*/*.[ch]")))
    return hashlib.sha256(text).hexdigest()[:16]


def page(counts, gates, others, bits, missing):
    compilers = sorted({run([core.compiler, "--version"]).splitlines()[0] for core in [*CORES, *OTHERS]})
    lines = ["# Printed C under QEMU", ""]
    lines += [f"Written by `scripts/firmware_cores.py` on {datetime.date.today()}. Compilers: {'; '.join(compilers)}. One prediction is",
              "5 channels × 50 time steps, from raw values to probabilities, compiled by gcc at -O2. QEMU counts instructions exactly.",
              "**Instructions are not cycles**: how many cycles one takes depends on the core, its caches and its flash. Flash is",
              "code and tables that `predict` needs; on cores without an FPU libgcc's float routines come on top.", ""]
    lines += ["| network | core | instructions | per MAC | flash | RAM | stack |", "|---|---|---|---|---|---|---|"]
    lines += [line(row) for row in counts]
    if gates:
        lines += ["", "## Gates", "", "What asking whether a sample is unknown takes besides, and its share of the prediction.", ""]
        lines += ["| network | core | gate | instructions | stack | of the prediction |", "|---|---|---|---|---|---|"]
        printed = {(row["digest"], row["core"]): row["instructions"] for row in counts}
        for row in gates:
            share = 100 * row["instructions"] / printed[row["digest"], row["core"]]
            lines.append(f"| {row['network']} | {row['core']} | {row['flags']} | {row['instructions']:,} | {row['stack']} | {share:.1f} % |")
    if others:
        lines += ["", "## Beside others", "", "`scripts/firmware_compare.py` runs the same shapes with CMSIS-NN and emlearn at -O2, and with onnx2c.", ""]
        lines += ["| network | core | library | instructions | flash | RAM | stack | taxel's instructions |", "|---|---|---|---|---|---|---|---|"]
        printed = {(row["network"], row["core"]): row["instructions"] for row in counts}
        for row in others:
            share = printed.get((row["network"], row["core"]), 0) / row["instructions"]
            cells = [row["network"], row["core"], row["flags"], f"{row['instructions']:,}", f"{row['flash']:,}", f"{row['ram']:,}", row["stack"]]
            lines.append(f"| {' | '.join(map(str, cells))} | {share:.2f} × |")
    lines += ["", "## Bits", "", "`test/check.c` on every core: 200 samples, and every threshold of every layer;",
              f"on cores without an FPU of every {SPARSE}th filter.", ""]
    if missing:
        lines += [f"{missing} of {missing + len(bits)} rows are not there: the run was stopped before.", ""]
    lines += ["| network | core | flags | result |", "|---|---|---|---|"]
    lines += [f"| {row['network']} | {row['core']} | {row['flags']} | {row['said']} |" for row in bits]
    return "\n".join(lines) + "\n"


def line(row):
    """Writes what was counted as a row of the page."""
    per = f"{row['instructions'] / row['macs']:.2f}"
    cells = [row["network"], row["core"], f"{row['instructions']:,}", per, f"{row['flash']:,}", f"{row['ram']:,}", row["stack"]]
    return f"| {' | '.join(map(str, cells))} |"


def unpinned(counts, page):
    """Returns the rows that a page does not have."""
    lines = set(page.splitlines())
    return [f"not on the page: {line(row)}" for row in counts if line(row) not in lines]


def fits(core, library):
    # The test's own memory is about 3 KB, its code about 20 KB.
    return core.name != "M0" or library["RAM_BYTES"] + 3500 <= 16 << 10 and library["FLASH_BYTES"] + 20_000 <= 256 << 10


def is_hopeless(core, library):
    """Floats in software are counted of small networks alone."""
    return core.name in SOFT and library.get("NEEDS_FPU") and library["MACS"] > 250_000


def measured(core, library, home):
    instructions, stack = counted(core, library, home)
    return {"instructions": instructions, "stack": stack, "flash": flash(core, library, home), "ram": library["RAM_BYTES"], "macs": library["MACS"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taxel", default="target/release/taxel")
    parser.add_argument("--folders", nargs="*", type=Path, default=[])
    parser.add_argument("--networks", nargs="*", default=NETWORKS)
    parser.add_argument("--cores", nargs="*", help="names of cores, such as M4")
    parser.add_argument("--levels", type=int, default=len(LEVELS), help="how many levels of optimisation are checked")
    parser.add_argument("--rows", type=Path, default=Path("target/firmware-rows.jsonl"), help="where rows are kept")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="when to stop and write the page")
    parser.add_argument("--pinned", type=Path, help="a page whose instructions and bytes have to come out again")
    parser.add_argument("--output", type=Path)
    args = parser.parse_args()
    chosen = lambda core: not args.cores or core.name.split()[0] in args.cores
    rows, begun, missing = Rows(args.rows), time.monotonic(), 0
    counts, gates, bits = [], [], []
    with tempfile.TemporaryDirectory() as home:
        home = Path(home)
        folders = [(folder, facts(folder), digest(folder)) for folder in args.folders or export(args.taxel, home, args.networks)]
        for folder, library, key in folders:
            for core in filter(chosen, CORES):
                row = {"digest": key, "network": library["name"], "core": core.name, "flags": "counted"}
                if fits(core, library) and not is_hopeless(core, library):
                    counts.append(rows.get(row, lambda: measured(core, library, home)))
                    for name in library["gates"]:
                        gates.append(rows.get({**row, "flags": name}, lambda: gate(core, library, home, name)))
        # The quick ones first.
        for core in filter(chosen, [*OTHERS, *sorted(CORES, key=lambda core: core.name in SOFT)]):
            for folder, library, key in folders:
                for flags in LEVELS[: args.levels]:
                    row = {"digest": key, "network": library["name"], "core": core.name, "flags": " ".join(flags)}
                    if not fits(core, library) or core.name in SOFT and library.get("NEEDS_FPU"):
                        continue
                    if Rows.key(row) not in rows.rows and time.monotonic() - begun > args.seconds:
                        missing += 1
                        continue
                    every = SPARSE if core.name in SOFT else 1
                    bits.append(rows.get(row, lambda: {"said": check(core, folder, home, flags, every).replace("\n", " ")}))
    bits.sort(key=lambda row: (row["network"], row["core"]))
    if args.output:
        others = sorted((row for row in rows.rows.values() if not row["digest"]), key=lambda row: row["network"])
        args.output.write_text(page(counts, gates, others, bits, missing))
    others = unpinned(counts, args.pinned.read_text()) if args.pinned else []
    print(*others, sep="\n", end="\n" if others else "")
    sys.exit(bool(others) or any(not row["said"].startswith("equal") for row in bits))


if __name__ == "__main__":
    main()
