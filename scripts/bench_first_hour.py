#!/usr/bin/env python3
"""Times the whole way from a cable to decisions on a page, step by step, with a stand-in for a sensor.

    TAXEL=... python3 scripts/bench_first_hour.py FOLDER

FOLDER must not exist; it gets what a newcomer's folder has in the end. The page is docs/benchmarks/first-hour.md.
The sensor is a pseudo-terminal with four channels at 200 Hz. A person is a second one, who presses Enter when asked.
The page says how busy the machine was.
"""

import argparse
import json
import math
import os
import pathlib
import pty
import random
import subprocess
import termios
import threading
import time
import urllib.request

from program import ROOT, TAXEL

PAGE = ROOT / "docs" / "benchmarks" / "first-hour.md"
LABELS = {"sponge": 2.2, "eraser": 3.1}
COUNT = 15
RATE = 200.0


class Sensor:
    """A sensor that presses what is held, again and again, harder or less hard each time."""

    def __init__(self):
        self.master, slave = pty.openpty()
        settings = termios.tcgetattr(slave)
        settings[3] &= ~(termios.ECHO | termios.ICANON)
        termios.tcsetattr(slave, termios.TCSANOW, settings)
        self.port, self.held, self.stopped = os.ttyname(slave), next(iter(LABELS)), False
        os.close(slave)
        os.set_blocking(self.master, False)
        threading.Thread(target=self.send, daemon=True).start()

    def send(self):
        draw, begin, phase, strength = random.Random(0), time.time(), 0.0, 1.0
        for step in range(10**9):
            if self.stopped:
                return
            time.sleep(max(0.0, begin + step / RATE - time.time()))
            phase += LABELS[self.held] / RATE
            if phase > 1:
                phase, strength = 0.0, draw.uniform(0.6, 1.4)
            force = 60 * strength * math.sin(math.pi * phase) ** 2
            values = [100 + force * share + draw.gauss(0, 3) for share in (1.0, 0.8, -0.5, 0.1)]
            line = json.dumps({f"taxel-{i}": round(value, 2) for i, value in enumerate(values)})
            try:
                os.write(self.master, (line + "\r\n").encode())
            except OSError:
                pass  # Nobody listens: the readings are lost, as those of a device are.


def record(sensor, folder, count):
    """Records as a person does, until each label has so many."""
    master, slave = pty.openpty()
    words = [TAXEL, "record", "--serial", sensor.port, *(f"--label={label}" for label in LABELS), "--seconds", "2", "--pause", "1", "--count", str(count), "--output", "skin"]
    done = subprocess.Popen(words, cwd=folder, stdin=slave, stdout=slave, stderr=slave)
    os.close(slave)
    heard = ""
    while True:
        try:
            heard += os.read(master, 4096).decode(errors="replace")
        except OSError:
            break
        while "\n" in heard:
            line, heard = heard.split("\n", 1)
            if ". Enter starts" in line:
                sensor.held = line.split(": ")[1].split(".")[0].split(" ")[0]
                os.write(master, b"\n")
    if done.wait() != 0:
        raise SystemExit(f"record ended with {done.returncode}: {heard}")


def shown(sensor, folder):
    """Streams with the live page, until it has shown a decision."""
    words = [TAXEL, "stream", "skin.safetensors", "--serial", sensor.port, "--serve", "127.0.0.1:0"]
    done = subprocess.Popen(words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    address = next(line.split("live page: ")[1].strip() for line in done.stderr if "live page: " in line)
    with urllib.request.urlopen(address + "events") as events:
        next(line for line in events if line.startswith(b"event: decision"))
    done.kill()
    done.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--budget", default="10m")
    args = parser.parse_args()
    args.folder.mkdir(parents=True)
    sensor, rows = Sensor(), []

    def step(name, act):
        print(f"== {name}", flush=True)
        begin = time.time()
        act()
        rows.append((name, time.time() - begin))

    def call(*words):
        return lambda: subprocess.run(words, cwd=args.folder, check=True)

    first = COUNT // 2
    step(f"`record`, first session: {first} of each of {len(LABELS)} labels, 2 s each", lambda: record(sensor, args.folder, first))
    step(f"`record`, second session: {COUNT - first} more of each", lambda: record(sensor, args.folder, COUNT))
    step("`data check`", call(TAXEL, "data", "check", "skin"))
    step(f"`run skin --budget {args.budget}`", call(TAXEL, "run", "skin", "--budget", args.budget))
    step("`report`", call(TAXEL, "report", "runs/skin"))
    step("`fit`", call(TAXEL, "fit", "runs/skin", "--network", "mini-rocket", "--output", "skin.safetensors"))
    step("`export --format c`", call(TAXEL, "export", "skin.safetensors", "--format", "c", "--name", "skin", "--output", "firmware"))
    step("`cc` and 200 samples of its test", lambda: [call("cc", "-std=c99", "-O2", "firmware/test/check.c", "-o", "check")(), call("./check")()])
    step("`stream --serve`, until a decision is on the page", lambda: shown(sensor, args.folder))
    sensor.stopped = True
    write(rows, args.folder)


def write(rows, folder):
    machine = json.loads((folder / "runs" / "skin" / "environment.json").read_text())
    total = sum(seconds for _, seconds in rows)
    lines = [
        "# The first hour, step by step",
        "",
        f"From a cable to decisions on a page: **{total / 60:.1f} minutes**, all of them without a line of code. *Simulated*: the sensor is a",
        "pseudo-terminal with four channels at 200 Hz, and the person who presses Enter never hesitates.",
        "`scripts/bench_first_hour.py` took these times and wrote this page.",
        "",
        "| step | s |",
        "|---|---:|",
        *(f"| {name} | {seconds:.1f} |" for name, seconds in rows),
        f"| all | {total:.1f} |",
        "",
        f"taxel {machine['commit'][:9]} on {machine['cpu']}; at the end {os.getloadavg()[2]:.1f} programs ran at a time in the last 15 minutes, on {os.cpu_count()} cores.",
    ]
    PAGE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
