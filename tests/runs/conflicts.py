#!/usr/bin/env python3
"""Begins conflicting work on one run folder at the same moment, again and again.

Pairs: two bakes of different seeds, settings or methods in a new folder, two bakes of the same settings, a
resume beside a resume, a commit beside a commit, a resume beside a commit, tasks beside a commit, two
transfers of different settings, two of the same.
Whatever wins, a folder never holds files of two runs: one process at least ends with 0, a loser
ends with 1 (or 2 where it finds another's finished run), and what stands in the folder afterwards,
resumed, has the bytes of a bake alone.

    python3 tests/runs/conflicts.py --pairs 100
"""

import argparse
import json
import random
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import runs

# the settings of two bakes
BAKES = {
    "seeds": (runs.SETTINGS, [*runs.SETTINGS, "--seed", "2"]),
    "settings": (runs.SETTINGS, [w if w != "8000" else "6000" for w in runs.SETTINGS]),
    "same": (runs.SETTINGS, runs.SETTINGS),
    "methods": (runs.SETTINGS, runs.TRANSFER),
    "transfers": (runs.TRANSFER, [*runs.TRANSFER, "--seed", "2"]),
    "same-transfers": (runs.TRANSFER, runs.TRANSFER),
}
KINDS = (*BAKES, "resumes", "commits", "resume-commit", "tasks-commit")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    dice = random.Random(options.seed)
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="rrf-conflicts-") as folder:
        pairs = Pairs(Path(folder), dice)
        for number in range(options.pairs):
            pairs.attempt(KINDS[number % len(KINDS)], Path(folder) / f"run-{number}")
    took = time.monotonic() - start
    print(f"exit codes {dict(sorted(pairs.codes.items()))}, {took:.0f} s")
    print(f"{options.pairs} passed, 0 failed")


def bake(run, settings, resume=False):
    """The command of a bake."""
    return [runs.program(), "bake", "--quiet", runs.SCENE, "-o", run, *settings, *["--resume"] * resume]


class Pairs:
    """The bakes alone that results are compared with, and what the pairs ended with."""

    def __init__(self, folder, dice):
        self.folder, self.dice, self.codes = folder, dice, {}
        self.alone = {}
        self.planned = folder / "planned"
        runs.call(runs.program(), "plan", runs.SCENE, "-o", self.planned, *runs.SETTINGS)
        for index in json.loads(runs.call(runs.program(), "plan", self.planned, "--json"))["tasks"]:
            plan = self.planned / "rounds/000/tasks.parquet"
            runs.call(runs.program(), "task", "--plan", plan, "--index", str(index["task_id"]))

    def expected(self, kind, run):
        """The settings of the bake that a run is of, and digests of that bake alone."""
        for settings in BAKES.get(kind, [runs.SETTINGS]):
            alone = self.folder / f"alone-{hash(tuple(settings))}"
            if alone not in self.alone:
                runs.call(*bake(alone, settings))
                self.alone[alone] = runs.digests(alone)
            if (alone / "run.json").read_bytes() == (run / "run.json").read_bytes():
                return settings, self.alone[alone]
        raise SystemExit(f"{kind}: run.json is of neither bake")

    def attempt(self, kind, run):
        commands = self.commands(kind, run)
        begun = []
        for command in commands:
            begun.append(subprocess.Popen([str(c) for c in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True))
            time.sleep(self.dice.choice((0, 0, 0.002, 0.02, 0.2)))
        ended = [(process, process.communicate()[1]) for process in begun]
        codes = [process.returncode for process, _ in ended]
        for code in codes:
            self.codes[code] = self.codes.get(code, 0) + 1
        messages = "\n".join(message for _, message in ended)
        if not set(codes) <= {0, 1, 2} or "panicked" in messages:
            raise SystemExit(f"{kind}: exit codes {codes}\n{messages}")
        if 2 in codes and not any(word in messages for word in ("already", "other", "--resume", "not a run")):
            raise SystemExit(f"{kind}: a lost race ends with 2\n{messages}")
        if 0 not in codes and kind not in ("commits", "tasks-commit", "resume-commit"):
            raise SystemExit(f"{kind}: nobody won, {codes}\n{messages}")
        settings, expected = self.expected(kind, run)
        runs.call(*bake(run, settings, resume=True))
        different = runs.differences(runs.digests(run), expected)
        if different:
            raise SystemExit(f"{kind}: mixed contents: {different[:5]}\n{messages}")
        shutil.rmtree(run)

    def commands(self, kind, run):
        if kind in BAKES:
            pair = [bake(run, settings) for settings in BAKES[kind]]
            self.dice.shuffle(pair)
            return pair
        shutil.copytree(self.planned, run)
        resume, commit = bake(run, runs.SETTINGS, resume=True), [runs.program(), "commit", run]
        plan = run / "rounds/000/tasks.parquet"
        tasks = [[runs.program(), "task", "--plan", plan, "--index", str(i)] for i in range(3)]
        return {
            "resumes": [resume, resume],
            "commits": [commit, commit],
            "resume-commit": [resume, commit],
            "tasks-commit": [*tasks, commit],
        }[kind]


if __name__ == "__main__":
    main()
