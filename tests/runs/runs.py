"""What the tests of killed and scattered runs share: the scene, the program, how runs compare."""

import hashlib
import os
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/cornell-box/scene.pbrt"
# nets: two rounds and one that trims, a few seconds of one core
SETTINGS = (
    "--method nets --light-box=-0.6,1.3,-0.6,0.6,1.8,0.6 --rows 8000 --cells 4 --paths 8 --rounds 4 --target 0.29 "
    "--most-cells 6"
).split()
# the transfer of the same scene, less than a second of one core
TRANSFER = "--preset preview --rows 1000 --paths 32".split()
PART = re.compile(r"cell=\d{6}/part-\d{5}\.parquet")


def program():
    """The rrf to test: $RRF, or the release build."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return Path(os.environ.get("RRF", target / "release/rrf")).resolve()


def bake(run, settings=SETTINGS):
    """The command that bakes `run`, or goes on with it."""
    return [program(), "bake", "--quiet", SCENE, "-o", run, "--resume", *settings]


def call(*command, codes=(0,)):
    """Runs a command; its standard output. Any exit code but those expected is an error."""
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode not in codes:
        raise SystemExit(f"{command}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


def digests(run):
    """blake2b of every file of a run, by its path, but for the one with wall times."""
    files = (p for p in sorted(run.rglob("*")) if p.is_file() and p.name != "seconds.json")
    return {
        str(path.relative_to(run)): hashlib.blake2b(path.read_bytes()).hexdigest() for path in files
    }


def differences(found, expected):
    """Names of files that differ, or that only one of two runs has."""
    return sorted(
        name for name in found.keys() | expected.keys() if found.get(name) != expected.get(name)
    )


def strays(run):
    """Files in samples/ that are no parts of cells."""
    samples = run / "samples"
    files = (path for path in samples.rglob("*") if path.is_file())
    names = (str(path.relative_to(samples)) for path in files)
    return sorted(name for name in names if not PART.fullmatch(name))
