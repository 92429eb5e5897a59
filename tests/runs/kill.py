#!/usr/bin/env python3
"""Kills `rrf bake` (SIGKILL, its whole process group) again and again and resumes it each time.

A bake that comes to its end must have the bytes of one that was never killed, and no file more.
Half of the kills come after a random time, half while a file is being written: after a random
number of unfinished files has been seen. At every kill, `samples/` must hold whole parts only.

    python3 tests/runs/kill.py --kills 100
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import runs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    dice = random.Random(options.seed)
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="rrf-kill-") as folder:
        tally = kills(Path(folder), options.kills, dice)
    took = time.monotonic() - start
    print(
        f"{tally['time']} kills at random times, {tally['write']} while a file was written, "
        f"{tally['bakes']} bakes ended with the same bytes, {tally['unfinished']} unfinished "
        f"files lay about at kills, {took:.0f} s"
    )
    print(f"{options.kills} passed, 0 failed")


def kills(folder, wanted, dice):
    """Bakes and kills until that many kills have hit and the last bake has ended."""
    whole = folder / "whole"
    start = time.monotonic()
    runs.call(*runs.bake(whole))
    seconds = time.monotonic() - start
    expected = runs.digests(whole)
    tally = {"time": 0, "write": 0, "bakes": 0, "unfinished": 0}
    while True:
        hits = tally["time"] + tally["write"]
        kind = ("time", "write")[hits % 2] if hits < wanted else None
        run = folder / f"killed-{tally['bakes']}"
        if attempt(run, kind, seconds, dice):
            tally[kind] += 1
            tally["unfinished"] += sum(1 for _ in run.rglob("*.tmp"))
            check("a stray file in samples/", runs.strays(run))
            continue
        check("files differ from the unkilled bake's", runs.differences(runs.digests(run), expected))
        tally["bakes"] += 1
        if kind is None:
            return tally


def attempt(run, kind, seconds, dice):
    """Starts or resumes a bake; whether it was killed before its end."""
    process = subprocess.Popen(
        [str(c) for c in runs.bake(run)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    if kind == "time":
        wait_time(process, dice.uniform(0, seconds / 2))
    if kind == "write":
        wait_write(process, run, dice.randrange(12))
    if kind and process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
    _, errors = process.communicate()
    if kind and process.returncode == -signal.SIGKILL:
        return True
    if process.returncode != 0:
        sys.exit(f"{run}: exit code {process.returncode}\n{errors.decode()}")
    return False


def wait_time(process, seconds):
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        pass


def wait_write(process, run, skip):
    """Until an unfinished file is there, after `skip` others, or the process has ended."""
    seen = set()
    while process.poll() is None:
        seen.update(unfinished(run))
        if len(seen) > skip:
            return
        # shorter than a file's writing and syncing, and most of a core left to the bake
        time.sleep(0.0005)


def unfinished(run):
    """Unfinished files by inode, where they can be: staging/, model/, the rounds."""
    folders = [run, run / "staging", run / "model", *run.glob("rounds/*"), *run.glob("rounds/*/fits/*")]
    for folder in folders:
        try:
            with os.scandir(folder) as entries:
                yield from [entry.inode() for entry in entries if entry.name.endswith(".tmp")]
        except FileNotFoundError:
            pass


def check(what, names):
    if names:
        sys.exit(f"{what}: {', '.join(names)}")


if __name__ == "__main__":
    main()
