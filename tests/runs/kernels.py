#!/usr/bin/env python3
"""Bakes have the same bytes whatever kernels OpenBLAS would choose, and whatever vectors the processor has.

OPENBLAS_CORETYPE asks for kernels of other processors; `--emulate` names a program that emulates a processor with AVX2 and
FMA but without AVX-512, such as QEMU (minutes; valgrind does not do, its x87 has 64 bits, and OpenBLAS takes norms by
x87). Needs a processor with AVX2.

    python3 tests/runs/kernels.py
    python3 tests/runs/kernels.py --emulate 'qemu-x86_64 -cpu Haswell'
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import runs

CHOICES = ["Prescott", "Nehalem", "Zen", "SkylakeX", "none of them"]
BAKES = {
    "nets": "--method nets --light-box=-0.6,1.3,-0.6,0.6,1.8,0.6 --rows 1000 --cells 2 --most-cells 2 --paths 4 --rounds 1".split(),
    "transfer": "--preset preview --rows 500 --paths 16".split(),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--emulate", metavar="PROGRAM", help="with its options")
    options = parser.parse_args()
    if "SSE2" in runs.call(runs.program(), "doctor"):
        print("left out: the processor has no AVX2")
        return
    passed = 0
    with tempfile.TemporaryDirectory(prefix="rrf-kernels-") as folder:
        for method, settings in BAKES.items():
            expected = bake(Path(folder) / method, settings)
            others = {name: {"OPENBLAS_CORETYPE": name} for name in CHOICES}
            for name, environment in others.items():
                same(f"{method}, {name}", bake(Path(folder) / f"{method}-{name}", settings, environment), expected)
                passed += 1
            if options.emulate:
                found = bake(Path(folder) / f"{method}-emulated", settings, before=options.emulate.split())
                same(f"{method}, emulated", found, expected)
                passed += 1
    print(f"{passed} passed, 0 failed")


def bake(run, settings, environment=(), before=()):
    """Digests of a bake's files, but for the manifest, which names the vectors that the processor has."""
    words = [*before, runs.program(), "bake", "--quiet", runs.SCENE, "-o", run, *settings]
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_CORETYPE"} | dict(environment)
    done = subprocess.run([str(word) for word in words], env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{words}: exit code {done.returncode}\n{done.stderr}")
    return {name: digest for name, digest in runs.digests(run).items() if name not in ("run.json", "lock")}


def same(what, found, expected):
    different = runs.differences(found, expected)
    if different or not found:
        sys.exit(f"{what}: other bytes: {different}")
    print(f"{what}: the same bytes in {len(found)} files", flush=True)


if __name__ == "__main__":
    main()
