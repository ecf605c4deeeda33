"""Calls taxel for the scripts that try it: TAXEL=/path/to/taxel, or target/release/taxel."""

import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[1]
TAXEL = os.environ.get("TAXEL", str(ROOT / "target" / "release" / "taxel"))


def taxel(folder, *words):
    """Runs taxel in a folder; what it printed."""
    done = subprocess.run([TAXEL, *words], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"taxel {' '.join(words)}: {done.stderr}")
    return done.stdout
