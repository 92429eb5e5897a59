#!/usr/bin/env python3
"""A Ray cluster of 3 nodes on loopback bakes a scene and loses a node on the way.

The node that is killed (SIGKILL, raylet, workers and the `rrf task` that runs there) is one that
has a task in hand. The bake must end with the bytes of `rrf bake` on one machine.

    .venv-engines/bin/python tests/engines/ray_cluster.py
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "runs"))

import runs
from ray.cluster_utils import Cluster

ENGINE = runs.ROOT / "pipeline/engines/ray_bake.py"
NODE = {"num_cpus": 1, "memory": 2 << 30, "object_store_memory": 80 << 20}
PATIENCE = 300


def main():
    with tempfile.TemporaryDirectory(prefix="rrf-ray-") as folder:
        folder = Path(folder)
        runs.call(*runs.bake(folder / "whole"))
        seconds = scattered(folder / "ray")
        differing = runs.differences(
            runs.digests(folder / "ray"), runs.digests(folder / "whole")
        )
    if differing:
        sys.exit(f"files differ from one machine's: {', '.join(differing)}")
    print(f"3 nodes, 1 killed with a task in hand: the same bytes, {seconds:.0f} s")
    print("1 passed, 0 failed")


def scattered(run):
    """Bakes on 3 nodes, of which one is killed; the seconds that the bake took."""
    cluster = Cluster(initialize_head=True, head_node_args={**NODE, "include_dashboard": False})
    try:
        victims = [cluster.add_node(**NODE) for _ in range(2)]
        cluster.wait_for_nodes()
        start = time.monotonic()
        command = [sys.executable, ENGINE, runs.SCENE, "-o", run, "--address", cluster.address]
        command += ["--rrf", runs.program(), "--", *runs.SETTINGS]
        bake = subprocess.Popen([str(c) for c in command])
        kill_a_busy_one(bake, victims)
        if bake.wait(PATIENCE) != 0:
            sys.exit(f"ray_bake.py: exit code {bake.returncode}")
        return time.monotonic() - start
    finally:
        cluster.shutdown()


def kill_a_busy_one(bake, victims):
    """Waits until one of the nodes fits a net, and kills all its processes."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and bake.poll() is None:
        for node in victims:
            raylet = node.all_processes["raylet"][0].process.pid
            family = descendants(raylet)
            if any(is_task(pid) for pid in family):
                for pid in [raylet, *family]:
                    kill(pid)
                print(f"killed a node: {len(family) + 1} processes, a task among them", flush=True)
                return
        time.sleep(0.005)
    sys.exit("no node had a task in hand: nothing was tested")


def descendants(pid):
    """All processes below one, as they are now."""
    parents = {}
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            # "pid (name) state parent ...": the name may hold anything
            parents[int(entry.parent.name)] = int(entry.read_text().rpartition(")")[2].split()[1])
        except (FileNotFoundError, ProcessLookupError):
            pass
    found = [pid]
    for parent in found:
        found += [child for child, its in parents.items() if its == parent]
    return found[1:]


def is_task(pid):
    try:
        command = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except (FileNotFoundError, ProcessLookupError):
        return False
    return b"task" in command and command[0] == str(runs.program()).encode()


def kill(pid):
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


if __name__ == "__main__":
    main()
