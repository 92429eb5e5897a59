#!/usr/bin/env python3
"""Bakes more samples than `--memory` holds and compares the peak with the bound.

The samples are `--times` times the memory, counted as the program holds them (112 bytes a row:
18 columns, two halves, index, material, paths). `--cells 1` puts all of them into one cell, whose
fit then keeps its rows in a file. The peak is the kernel's (VmHWM, by wait4's ru_maxrss), of the
whole process. With `--same` the bake is done again without a bound: the bytes must be the same.

    python3 tests/runs/memory.py                                     short: 2 s of one core
    python3 tests/runs/memory.py --memory 64 --times 10 --cells 16   full
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import runs

ROW = 112
ALLOWED = 1.1


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--memory", type=int, default=64, help="MiB")
    parser.add_argument("--times", type=float, default=1.0)
    parser.add_argument("--cells", type=int, default=1)
    parser.add_argument("--paths", type=int, default=2)
    parser.add_argument("--method", default="linear-regression", help="quick fits by default")
    parser.add_argument("--same", action="store_true", help="compare with a bake without a bound")
    options = parser.parse_args()
    rows = int(options.times * (options.memory << 20) / ROW)
    settings = (
        f"--light-box=-0.6,1.3,-0.6,0.6,1.8,0.6 --rows {rows} --cells {options.cells} "
        f"--most-cells {options.cells} --paths {options.paths} --rounds 1 --method {options.method}"
    ).split()
    with tempfile.TemporaryDirectory(prefix="rrf-memory-") as folder:
        bounded, free = Path(folder) / "bounded", Path(folder) / "free"
        peak, seconds = bake(bounded, [*settings, "--memory", f"{options.memory}MiB"])
        stored = sum(p.stat().st_size for p in (bounded / "samples").rglob("*.parquet"))
        print(
            f"{rows} rows in {options.cells} cells: {rows * ROW >> 20} MiB held, {stored >> 20} MiB "
            f"stored; --memory {options.memory} MiB: peak {peak >> 20} MiB, "
            f"{peak / (options.memory << 20):.2f} times it, {seconds:.0f} s"
        )
        if options.same:
            unbounded, seconds = bake(free, settings)
            differing = runs.differences(runs.digests(bounded), runs.digests(free))
            print(f"without a bound: peak {unbounded >> 20} MiB, {seconds:.0f} s, {len(differing)} files differ")
            if differing:
                sys.exit(f"files differ: {', '.join(differing)}")
        if peak > ALLOWED * (options.memory << 20):
            sys.exit(f"the peak is above {ALLOWED} times --memory")
    print("1 passed, 0 failed")


def bake(run, settings):
    """Bakes; peak resident bytes of the process and its seconds."""
    words = [runs.program(), "bake", "--quiet", runs.SCENE, "-o", run, "--resume", *settings]
    start = time.monotonic()
    process = subprocess.Popen(
        [str(w) for w in words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{run}: exit code {process.returncode}\n{errors}")
    return usage.ru_maxrss << 10, time.monotonic() - start


if __name__ == "__main__":
    main()
