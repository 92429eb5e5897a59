#!/usr/bin/env python3
"""A disk that fills up, and one that vanishes, in the middle of a bake.

Each time the bake must end with exit code 1 and say what it could not do and where, leave whole
parts only in `samples/`, and, with room again, go on to the bytes of an undisturbed bake. Full is a
tmpfs of a few hundred kilobytes (mounted in a user namespace of its own, so that no rights are
needed), or where that is refused a limit on the size of a file (RLIMIT_FSIZE). Vanished is the run
folder moved away under the bake, and put back.

    python3 tests/runs/full_disk.py
"""

import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import runs

# inside the namespace: the mount goes when the bake ends, so what it holds is copied out
MOUNTED = """
mount -t tmpfs -o size=$1 tmpfs "$2" && cp -a "$3"/. "$2"/ || exit 99
shift 3
RUN=$1 KEEP=$2
shift 2
"$@"
code=$?
cp -a "$RUN"/. "$KEEP"/
exit $code
"""


def main():
    with tempfile.TemporaryDirectory(prefix="rrf-full-") as folder:
        folder = Path(folder)
        runs.call(*runs.bake(folder / "whole"))
        expected = runs.digests(folder / "whole")
        if can_mount():
            for kilobytes in (8, 200, 600):
                full(folder / f"full-{kilobytes}", kilobytes, expected)
        else:
            print("no tmpfs can be mounted here: a limit on the size of files in its place")
            for kilobytes in (1, 8, 60):
                limited(folder / f"limited-{kilobytes}", kilobytes, expected)
        for parts in (1, 4):
            vanished(folder / f"vanished-{parts}", parts, expected)
            vanished(folder / f"unmounted-{parts}", parts, expected, Path.mkdir)
    print("passed, 0 failed")


def can_mount():
    with tempfile.TemporaryDirectory() as place:
        words = ["unshare", "--user", "--map-root-user", "--mount", "mount", "-t", "tmpfs", "tmpfs", place]
        return shutil.which("unshare") and subprocess.run(words, capture_output=True).returncode == 0


def full(run, kilobytes, expected):
    """A bake on a disk of that size, then on a larger one."""
    mount, keep = run.with_suffix(".mount"), run
    mount.mkdir()
    keep.mkdir()
    words = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", MOUNTED, "sh"]
    words += [f"{kilobytes}k", mount, keep, mount, keep, *runs.bake(mount)]
    refused(subprocess.run([str(w) for w in words], capture_output=True, text=True), "No space left")
    resumed(keep, expected, f"a disk of {kilobytes} kB")


def limited(run, kilobytes, expected):
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (kilobytes << 10, kilobytes << 10))

    words = [str(w) for w in runs.bake(run)]
    refused(subprocess.run(words, capture_output=True, text=True, preexec_fn=limit), "too large")
    resumed(run, expected, f"files of at most {kilobytes} kB")


def vanished(run, parts, expected, left=lambda run: run.write_text("")):
    """The folder is moved away when it has that many parts; left is a file, below which nothing
    can be made, or the empty folder that a disk is mounted at."""
    away = run.with_suffix(".away")
    words = [str(w) for w in runs.bake(run)]
    bake = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while bake.poll() is None and len(list(run.glob("samples/*/*.parquet"))) < parts:
        time.sleep(0.001)
    os.rename(run, away)
    left(run)
    _, errors = bake.communicate()
    refused(subprocess.CompletedProcess(words, bake.returncode, "", errors), "is gone")
    shutil.rmtree(run) if run.is_dir() else run.unlink()
    os.rename(away, run)
    resumed(run, expected, f"the disk gone after {parts} parts")


def refused(done, words):
    if done.returncode != 1 or words not in done.stderr:
        sys.exit(f"{done.args}: exit code {done.returncode}, not 1 with {words!r}\n{done.stderr}")
    print(f"exit code 1: {done.stderr.strip().splitlines()[-1]}")


def resumed(run, expected, what):
    strays = runs.strays(run)
    if strays:
        sys.exit(f"{what}: strays in samples/: {strays}")
    runs.call(*runs.bake(run))
    found = runs.differences(runs.digests(run), expected)
    if found:
        sys.exit(f"{what}: resumed, and other bytes: {', '.join(found)}")
    print(f"{what}: resumed, the same bytes")


if __name__ == "__main__":
    main()
