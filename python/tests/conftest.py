"""What the tests share: grasps, a model, the command line."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

import taxel

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def grasps():
    """60 grasps [60, 5, 50] of three classes."""
    return taxel.simulate("fingertip", 60, seed=0)


@pytest.fixture(scope="session")
def mlp(grasps):
    return taxel.Classifier("mlp", recipe={"epochs": 3}).fit(grasps.x, grasps.y)


@pytest.fixture(scope="session")
def command():
    """Runs the command line; what it printed. The binary is TAXEL_BIN, or the release build."""
    binary = os.environ.get("TAXEL_BIN") or ROOT / "target/release/taxel"
    assert shutil.which(binary), f"{binary} is not there: cargo build --release, or set TAXEL_BIN"

    def run(*arguments, cwd=None):
        done = subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True, cwd=cwd)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run
