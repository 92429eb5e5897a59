#!/usr/bin/env python3
"""Builds the fuzz targets and runs them for a stated CPU time; the figures of fuzz/README.md.

Needs a C++ compiler and RUSTC_BOOTSTRAP=1, which it sets for the flags of a nightly compiler; not the tool
cargo-fuzz, which adds the same flags.
Inputs come from `seeds/` and `kept/TARGET.zip`, new ones go to `corpus/`; `--keep` makes the archive of a
smallest set of inputs that covers what all of them cover, long ones left out. A crash, a hang of 20 s or a request for
more than 512 MB leaves the input in `artifacts/` and ends the target.

    python3 fuzz/run.py --minutes 30
    python3 fuzz/run.py --minutes 30 --keep pbrt gltf
"""

import argparse
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCENES = ["pbrt", "gltf", "obj", "exr"]
TARGETS = [*SCENES, "parquet", "arrow", "small"]
LONGEST = {"parquet": 131072, "arrow": 65536}
# bytes of an input that is kept, and of all that are kept
KEPT, ARCHIVE = 80_000, 300_000
TRIPLE = "x86_64-unknown-linux-gnu"
COVERAGE = ["level=4", "inline-8bit-counters", "pc-table", "trace-compares"]
FLAGS = [
    "-Cpasses=sancov-module",
    *[f"-Cllvm-args=-sanitizer-coverage-{word}" for word in COVERAGE],
    "-Cllvm-args=-simplifycfg-branch-fold-threshold=0",
    "-Zsanitizer=address",
    "-Cdebug-assertions",
    "-Ccodegen-units=1",
    "--cfg=fuzzing",
]
# decoders have threads whose own lists outlive an input, which count as leaks; one allocation and all of
# them; the sanitizer's own memory is some three times the program's
LIMITS = ["-detect_leaks=0", "-timeout=20", "-malloc_limit_mb=512", "-rss_limit_mb=2048"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=30, help="CPU time of each target")
    parser.add_argument("--keep", action="store_true", help="minimise the corpus into kept/")
    parser.add_argument("--no-build", action="store_true")
    parser.add_argument("targets", nargs="*", default=TARGETS)
    options = parser.parse_args()
    if not options.no_build:
        build(options.targets)
    failed = 0
    for target in options.targets:
        failed += fuzz(target, 60 * options.minutes)
        if options.keep:
            keep(target)
    sys.exit(failed)


def folder():
    return Path(os.environ.get("CARGO_TARGET_DIR", HERE / "target"))


def build(targets):
    environment = {**os.environ, "RUSTFLAGS": " ".join(FLAGS), "CARGO_TARGET_DIR": str(folder())}
    environment["RUSTC_BOOTSTRAP"] = "1"
    words = ["cargo", "build", "--release", "--target", TRIPLE]
    words += [word for target in targets for word in ("--bin", target)]
    if set(targets) <= set(SCENES):
        words += ["--no-default-features", "--features", "no-tables"]
    subprocess.run(words, cwd=HERE, env=environment, check=True)


def program(target):
    return folder() / TRIPLE / "release" / target


def inputs(target):
    """Where new inputs go, with those of earlier runs, and the seeds."""
    corpus = HERE / "corpus" / target
    corpus.mkdir(parents=True, exist_ok=True)
    kept = HERE / "kept" / f"{target}.zip"
    if kept.exists():
        with zipfile.ZipFile(kept) as archive:
            archive.extractall(corpus)
    return corpus, [HERE / "seeds" / target]


def fuzz(target, seconds):
    """Runs a target until it has used that much CPU time; 1 where it found something."""
    corpus, given = inputs(target)
    artifacts = HERE / "artifacts" / target
    artifacts.mkdir(parents=True, exist_ok=True)
    log = HERE / "artifacts" / f"{target}.log"
    words = [program(target), *LIMITS, f"-max_len={LONGEST.get(target, 16384)}", "-print_final_stats=1"]
    words += [f"-artifact_prefix={artifacts}/", corpus, *given]
    start, used, executions, found = time.monotonic(), 0.0, 0, False
    text, state = "", [("0",) * 4]
    while used < seconds and not found:
        before = set(artifacts.iterdir())
        with log.open("w") as out:
            process = subprocess.Popen([str(w) for w in words], stdout=out, stderr=out)
            here = 0.0
            while process.poll() is None and used + here < seconds:
                time.sleep(1)
                here = cpu_seconds(process.pid) or here
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            else:
                new = sorted(set(artifacts.iterdir()) - before)
                found = not all(starved(target, path) for path in new) or not new
            process.wait()
        used += here
        text = log.read_text(errors="replace")
        state = re.findall(r"#(\d+)\s+\w+\s+cov: (\d+) ft: (\d+) corp: (\d+)/", text) or [("0",) * 4]
        executions += int(state[-1][0])
    _, edges, features, kept = state[-1]
    peak = re.findall(r"stat::peak_rss_mb:\s+(\d+)", text)
    print(
        f"{target}: {'ended by a finding after ' if found else ''}{used / 60:.1f} CPU minutes, "
        f"{time.monotonic() - start:.0f} s, {executions} executions, {edges} edges, {features} "
        f"features, {kept} inputs, peak {peak[-1] if peak else '?'} MB",
        flush=True,
    )
    return int(found)


def starved(target, path):
    """Whether an input that took too long by the clock takes less than 20 s of CPU time: the machine had
    other work. Such an input is no finding, and goes."""
    if not path.name.startswith(("timeout-", "slow-unit-")):
        return False
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([program(target), path], capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    fine = done.returncode == 0 and after.ru_utime - before.ru_utime < 20
    if fine:
        path.unlink()
    return fine


def cpu_seconds(pid):
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    except FileNotFoundError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def keep(target):
    corpus, given = inputs(target)
    with tempfile.TemporaryDirectory() as least:
        # what is longer than max_len would be cut, not left out
        longest = f"-max_len={LONGEST.get(target, 16384)}"
        words = [program(target), "-merge=1", longest, least, corpus, *given]
        subprocess.run([str(w) for w in words], check=True, stderr=subprocess.DEVNULL)
        # shortest first, until the archive is as large as a repository should bear
        files = [path for path in Path(least).iterdir() if path.stat().st_size <= KEPT]
        files.sort(key=lambda path: (path.stat().st_size, path.name))
        archive = HERE / "kept" / f"{target}.zip"
        archive.parent.mkdir(exist_ok=True)
        count = 0
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as out:
            for path in files:
                if archive.stat().st_size > ARCHIVE:
                    break
                out.writestr(zipfile.ZipInfo(path.name), path.read_bytes(), zipfile.ZIP_DEFLATED)
                count += 1
    print(f"{target}: {count} of {len(files)} inputs kept, {archive.stat().st_size} bytes")


if __name__ == "__main__":
    main()
