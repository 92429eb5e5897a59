#!/usr/bin/env python3
"""Long work stops soon: on the first SIGTERM, and when the time limit is over, within a task too.

A closed room that absorbs next to nothing, one cell of very many paths, one long fit, a picture of 2048 by 2048
paths, and the page's pass of that size. Each has to end within --seconds of being told.

    python3 tests/runs/halt.py
"""

import argparse
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import page
import runs

LIGHT_BOX = "--light-box=-0.6,1.3,-0.6,0.6,1.8,0.6"
ONE_CELL = ["--method", "nets", "--cells", "1", "--most-cells", "1", "--rounds", "1"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=2.0, help="allowed from the signal to the end")
    options = parser.parse_args()
    passed = 0
    with tempfile.TemporaryDirectory(prefix="rrf-halt-") as folder:
        folder = Path(folder)
        for name, check in CHECKS:
            seconds, end = check(folder / name.replace(" ", "-"))
            print(f"{name}: ended after {seconds:.2f} s with {end}")
            if seconds > options.seconds:
                raise SystemExit(f"{name}: more than {options.seconds} s")
            passed += 1
    print(f"{passed} passed, 0 failed")


def bake(scene, run, *more):
    return [runs.program(), "bake", "--quiet", scene, "-o", run, *ONE_CELL, *more]


def told(command, after, code, words):
    """Seconds from SIGTERM to the end of a command that has run for `after` seconds, and its code."""
    process = subprocess.Popen(
        [str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    time.sleep(after)
    if process.poll() is not None:
        raise SystemExit(f"{command}: ended before it was told to: {process.stderr.read()}")
    return ended(process, code, words, lambda: process.send_signal(signal.SIGTERM))


def ended(process, code, words, tell):
    start = time.monotonic()
    tell()
    try:
        _, errors = process.communicate(timeout=30)
    except subprocess.TimeoutExpired:
        process.kill()
        raise SystemExit("hangs for 30 s after the first SIGTERM") from None
    if process.returncode != code or words not in errors:
        raise SystemExit(f"exit code {process.returncode} in place of {code}: {errors}")
    return time.monotonic() - start, f"exit code {code}"


def limited(command, limit):
    """Seconds beyond the time limit that a command takes."""
    start = time.monotonic()
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=60)
    if done.returncode != 1 or "time limit" not in done.stderr:
        raise SystemExit(f"exit code {done.returncode}: {done.stderr}")
    return time.monotonic() - start - limit, "exit code 1"


def white_room(run):
    case = runs.ROOT / "tests/data/cases/bake/white"
    # one that loses nothing is refused
    refused = [*bake(case / "a.obj", run), "--rows", "4000"]
    runs.call(*refused, codes=(2,))
    folder = run.with_suffix(".scene")
    folder.mkdir()
    (folder / "a.obj").write_text((case / "a.obj").read_text())
    material = (case / "m.mtl").read_text()
    (folder / "m.mtl").write_text(material.replace("Kd 1 1 1", "Kd 0.998 0.998 0.998"))
    if "0.998" not in (folder / "m.mtl").read_text():
        raise SystemExit(f"the case has changed: {material}")
    return told(bake(folder / "a.obj", run, "--rows", "400000", "--paths", "64"), 3, 1, "stopped by a signal")


def many_paths(run):
    command = bake(runs.SCENE, run, LIGHT_BOX, "--rows", "40000", "--paths", "65536")
    return told(command, 3, 1, "stopped by a signal")


def long_fit(run):
    settings = [LIGHT_BOX, "--rows", "240000", "--paths", "2", "--hidden", "32,16"]
    runs.call(*[word if word != "bake" else "extract" for word in bake(runs.SCENE, run, *settings)])
    return told([runs.program(), "train", "--quiet", run], 3, 1, "stopped by a signal")


def time_limit_in_a_draw(run):
    command = bake(runs.SCENE, run, LIGHT_BOX, "--rows", "40000", "--paths", "65536", "--time-limit", "3")
    return limited(command, 3)


def time_limit_in_a_fit(run):
    settings = ["--rows", "240000", "--paths", "2", "--hidden", "32,16", "--time-limit", "6"]
    return limited(bake(runs.SCENE, run, LIGHT_BOX, *settings), 6)


def transfer_rows(run):
    """Rows of very many paths."""
    command = [runs.program(), "bake", "--quiet", runs.SCENE, "-o", run]
    return told([*command, "--rows", "40000", "--paths", "65536"], 3, 1, "stopped by a signal")


def transfer_fits(run):
    """Very many rows of few paths."""
    command = [runs.program(), "bake", "--quiet", runs.SCENE, "-o", run]
    return limited([*command, "--rows", "100000", "--paths", "2", "--time-limit", "8"], 8)


def large_picture(run):
    view = ["--eye=0,1,3.4", "--look-at=0,1,0", "--light=0,1.5,0", "--size=2048x2048", "--spp=64"]
    command = [runs.program(), "trace", "--quiet", runs.SCENE, *view, "-o", run.with_suffix(".exr")]
    # nothing but the picture is to be lost: the signal may end the program at once
    return told(command, 3, -signal.SIGTERM, "")


def pass_of_the_page(run):
    runs.call(*runs.bake(run))
    with page.served(run) as (process, address, token):
        frames = page.WebSocket(address, token, "/frames")
        hello = frames.text()["hello"]
        trace = page.WebSocket(address, token, "/trace")
        ask = page.question(hello, size=[2048, 2048])
        trace.send({"begin": ask})
        time.sleep(4)
        return ended(process, 0, "", lambda: process.send_signal(signal.SIGTERM))


CHECKS = [
    ("closed room of albedo 0.998", white_room),
    ("many paths", many_paths),
    ("long fit", long_fit),
    ("time limit in a draw", time_limit_in_a_draw),
    ("time limit in a fit", time_limit_in_a_fit),
    ("rows of a transfer", transfer_rows),
    ("time limit in a transfer", transfer_fits),
    ("large picture", large_picture),
    ("pass of the page", pass_of_the_page),
]


if __name__ == "__main__":
    main()
