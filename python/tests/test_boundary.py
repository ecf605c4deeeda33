"""At the edge of the two languages: Ctrl-C, other threads, memory, no copies."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import taxel

# Ignored, and so inherited, where the tests run in the background of a shell.
BEFORE = signal.getsignal(signal.SIGINT)
INTERRUPTED = """
import os, signal, threading, time, taxel
signal.signal(signal.SIGINT, signal.default_int_handler)
x = taxel.simulate("fingertip", 200)
threading.Timer({after}, os.kill, (os.getpid(), signal.SIGINT)).start()
start = time.time()
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", time.time() - start)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
@pytest.mark.parametrize(
    "work",
    [
        'taxel.Classifier("resnet8-lite-1d", recipe={"epochs": 100000}).fit(x)',
        'taxel.cross_validate("resnet8-lite-1d", x, recipe={"epochs": 100000})',
    ],
)
def test_control_c_ends_a_training(work):
    code = INTERRUPTED.format(after=1.5, work=work)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout.startswith("interrupted"), done.stderr
    assert done.returncode == 0


def test_other_threads_run_while_a_network_is_trained(grasps):
    # Long enough for hundreds of ticks: a training that kept the lock would let through one or two.
    ticks, done = [], threading.Event()

    def count():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    counting = threading.Thread(target=count)
    counting.start()
    taxel.Classifier("resnet8-lite-1d", recipe={"epochs": 500}, n_jobs=1).fit(grasps)
    done.set()
    counting.join()
    assert len(ticks) > 20


def test_trainings_and_answers_from_several_threads_are_alike(mlp, grasps):
    said, models = [], []
    ask = lambda: said.append(mlp.model_.predict_proba(grasps.x).tobytes())
    fit = lambda: models.append(taxel.Classifier("mlp", recipe={"epochs": 3}).fit(grasps.x, grasps.y).model_.to_bytes())
    threads = [threading.Thread(target=work) for work in (ask, fit, ask, fit, ask)]
    [own.start() for own in threads]
    [own.join() for own in threads]
    assert len(set(said)) == 1 and len(set(models)) == 1 and len(models) == 2


MEMORY = """
import numpy as np, resource, taxel
model = taxel.load({path!r})
values = 256 << 20
x = np.zeros((values // 4 // 250, 5, 50), np.float32) + 1
model.predict_proba(x[:4096])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
said = model.predict_proba(x)
grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) << 10
assert said.shape == (len(x), 3)
print(grown / x.nbytes)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="ru_maxrss is in KiB on Linux")
def test_a_float32_array_is_not_copied(mlp, tmp_path):
    mlp.save(tmp_path / "own.safetensors")
    code = MEMORY.format(path=str(tmp_path / "own.safetensors"))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    # Probabilities are 3 of 250 values; pieces of 16 MiB are encoded at a time, of 256.
    assert float(done.stdout) < 0.25, done.stdout


def test_a_panic_is_an_exception_and_nothing_is_printed(capfd, monkeypatch):
    monkeypatch.delenv("RUST_BACKTRACE", raising=False)
    with pytest.raises(RuntimeError, match="failed inside: on purpose .*this is a defect"):
        taxel._taxel.fail("on purpose")
    assert capfd.readouterr().err == ""
    assert taxel.zoo()


def test_no_progress_is_printed_where_there_is_no_terminal(grasps, capfd):
    taxel.Classifier("mlp", recipe={"epochs": 2}).fit(grasps)
    assert capfd.readouterr() == ("", "")
    taxel.Classifier("mlp", recipe={"epochs": 2}, verbose=True).fit(grasps)
    assert "100 %" in capfd.readouterr().err


def test_what_is_read_is_read_while_python_waits(mlp, grasps):
    x = grasps.x.copy()
    before = mlp.model_.predict_proba(x)
    x[0] += 500
    assert (mlp.model_.predict_proba(x)[1:] == before[1:]).all()
    assert (mlp.model_.predict_proba(x)[0] != before[0]).any()


def test_nothing_leaks(mlp, grasps):
    import resource

    for _ in range(50):
        mlp.model_.predict_proba(grasps.x)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(2000):
        mlp.model_.predict_proba(grasps.x)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 8 << 10
    assert np.isfinite(grasps.x).all() and signal.getsignal(signal.SIGINT) is BEFORE
