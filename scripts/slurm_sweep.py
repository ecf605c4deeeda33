#!/usr/bin/env python3
"""Runs a sweep through a real Slurm, kills its node twice and its controller once, and compares it with an undisturbed one.

    sudo python3 scripts/slurm_sweep.py [--taxel target/release/taxel] [--trials 200] [--chunk 5]

Needs Debian's slurm-wlm and munge; installs nothing. Starts munged, slurmctld and slurmd (22.05 was tried) in a
temporary folder on 127.0.0.1, and ends only what it started. Killing the node is SIGKILL to slurmd and to
all its descendants. Exit code 0: every trial has one result, and all bytes
are those of `taxel sweep run`; 1: not.
"""

import argparse
import ctypes
import os
import pathlib
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from kill_sweep import collect, compare, plan, sweep

CONF = """
ClusterName=taxel
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,sched_min_interval=0,bf_interval=2,requeue_delay=1
ReturnToService=2
SlurmdTimeout=15
SlurmctldTimeout=10
KillWait=5
MaxArraySize=1001
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for own in sockets:
        own.bind(("127.0.0.1", 0))
    ports = [own.getsockname()[1] for own in sockets]
    for own in sockets:
        own.close()
    return ports


def parents():
    """The parent of every process."""
    found = {}
    for path in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if fields[0] != "Z":
            found[int(path.parent.name)] = int(fields[1])
    return found


def below(roots):
    """All processes that `roots` have started, and theirs."""
    found, known = set(roots), parents()
    while True:
        more = {pid for pid, parent in known.items() if parent in found} - found
        if not more:
            return found & set(known)
        found |= more


class Cluster:
    """One node and its controller."""

    def __init__(self, folder):
        self.folder = folder
        for name in ("state", "spool", "log"):
            (folder / name).mkdir()
        conf = folder / "slurm.conf"
        conf.write_text(CONF.format(host=socket.gethostname(), folder=folder, ports=free_ports(2)))
        (folder / "cgroup.conf").write_text("CgroupAutomount=no\n")
        self.environment = dict(os.environ, SLURM_CONF=str(conf))
        key = folder / "munge.key"
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o400)
        paths = {"socket": "munge.socket", "key-file": "munge.key", "pid-file": "munged.pid", "log-file": "log/munged", "seed-file": "munge.seed"}
        self.munged = self.start("munged", "--foreground", "--force", *(f"--{name}={folder / path}" for name, path in paths.items()))
        self.controller = self.start("slurmctld", "-D")
        self.node = self.start("slurmd", "-D")

    def start(self, *words):
        log = open(self.folder / "log" / f"{words[0]}.out", "ab")
        return subprocess.Popen(words, env=self.environment, stdout=log, stderr=log, stdin=subprocess.DEVNULL, start_new_session=True)

    def said(self, *words):
        return subprocess.run(words, env=self.environment, capture_output=True, text=True).stdout.strip()

    def state(self):
        return self.said("sinfo", "--noheader", "--format=%T")

    def wait_for(self, states, seconds):
        begin = time.monotonic()
        while time.monotonic() - begin < seconds:
            if self.state() in states:
                return time.monotonic() - begin
            time.sleep(0.5)
        sys.exit(f"the node is {self.state()}, not one of {states}, after {seconds} s; see {self.folder}/log")

    def kill_node(self):
        """Kills slurmd and all that it started; what lost its parent has become ours, as init's would on a node."""
        mine = {self.munged.pid, self.controller.pid}
        victims = below({os.getpid()}) - below(mine) - {os.getpid()}
        for pid in victims:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.node.wait()
        return len(victims)

    def start_node(self):
        self.node = self.start("slurmd", "-D")

    def kill_controller(self):
        self.controller.kill()
        self.controller.wait()
        time.sleep(2)
        self.controller = self.start("slurmctld", "-D")
        # What it knows may be older than what the node has done: the node says so when it is asked.
        for _ in range(60):
            if subprocess.run(["scontrol", "reconfigure"], env=self.environment, capture_output=True).returncode == 0:
                return
            time.sleep(0.5)

    def see_to_it(self):
        """What an operator does after a crash: a controller that forgot a task has started it twice, drained the node and held the task."""
        if "drain" in self.state():
            self.said("scontrol", "update", f"nodename={socket.gethostname()}", "state=resume")
        for line in self.said("squeue", "--noheader", "--array", "--format=%A %r").splitlines():
            job, _, reason = line.partition(" ")
            if "Held" in reason or "held" in reason:
                self.said("scontrol", "release", job)
            elif reason == "BeginTime":
                # A task of a node that failed waits for two minutes otherwise.
                self.said("scontrol", "update", f"jobid={job}", "starttime=now")

    def end(self):
        self.kill_node()
        for process in (self.controller, self.munged):
            process.kill()
            process.wait()


def finished(path):
    folder = path / "results"
    return sum(not own.name.endswith(".timing.json") for own in folder.glob("*.json")) if folder.is_dir() else 0


def submit(args, cluster, path):
    print(sweep(args, "emit", "slurm", path, "--count", args.chunk).splitlines()[0])
    subprocess.run(["sh", str(path / "slurm" / "submit.sh")], env=cluster.environment, check=True)


def through_slurm(args, cluster, path):
    cluster.wait_for(("idle",), 60)
    submit(args, cluster, path)
    kills = [(0.22, "node"), (0.46, "controller"), (0.67, "node")]
    begin, rounds = time.monotonic(), 1
    while finished(path) < args.trials or cluster.said("squeue", "--noheader"):
        if kills and finished(path) >= kills[0][0] * args.trials:
            _, which = kills.pop(0)
            if which == "node":
                count = cluster.kill_node()
                print(f"{finished(path)} results: node killed, {count} processes", flush=True)
                seconds = cluster.wait_for(("down", "down*"), 120)
                print(f"  noticed after {seconds:.0f} s; node started again", flush=True)
                cluster.start_node()
            else:
                cluster.kill_controller()
                print(f"{finished(path)} results: controller killed and started again", flush=True)
        elif not cluster.said("squeue", "--noheader") and finished(path) < args.trials and cluster.state() in ("idle", "mixed"):
            rounds += 1
            print(f"{finished(path)} results and an empty queue: what is missing is submitted again", flush=True)
            submit(args, cluster, path)
        cluster.see_to_it()
        if time.monotonic() - begin > args.limit:
            print(cluster.said("squeue"), cluster.said("sinfo", "--long", "--Node", "--reason"), sep="\n")
            for name in ("slurmctld", "slurmd"):
                print(*(cluster.folder / "log" / f"{name}.out").read_text(errors="replace").splitlines()[-20:], sep="\n")
            sys.exit(f"only {finished(path)} results after {args.limit} s")
        time.sleep(0.2)
    print(f"{args.trials} trials in {time.monotonic() - begin:.0f} s, {rounds} submission(s)")
    assert not kills, "the sweep was over before all kills"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taxel", default="target/release/taxel")
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--chunk", type=int, default=5)
    parser.add_argument("--epochs", type=int, default=200)
    parser.add_argument("--limit", type=float, default=900, help="seconds")
    args = parser.parse_args()
    args.taxel = str(pathlib.Path(args.taxel).resolve())
    missing = [name for name in ("munged", "slurmctld", "slurmd", "sbatch") if not shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin")]
    if missing:
        sys.exit(f"{', '.join(missing)} not found: install slurm-wlm and munge (Debian)")
    os.environ["PATH"] += ":/usr/sbin"
    # What loses its parent becomes a child of this process: nothing that it started gets out of sight.
    subreaper = 36
    ctypes.CDLL(None).prctl(subreaper, 1, 0, 0, 0)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        alone, slurm = (plan(args, folder, name, "seed", range(args.trials), args.epochs) for name in ("alone", "slurm"))
        sweep(args, "run", alone, "--jobs", 2, "--quiet")
        cluster = Cluster(folder)
        try:
            through_slurm(args, cluster, slurm)
            page = (slurm / "collected" / "index.html").is_file()
            print("the dependent job has collected" if page else "NOT COLLECTED by the dependent job")
        finally:
            cluster.end()
        collect(args, slurm)
        equal = compare(alone, slurm, args.trials)
    sys.exit(0 if equal and page else 1)


if __name__ == "__main__":
    main()
