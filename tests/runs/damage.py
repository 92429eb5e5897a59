#!/usr/bin/env python3
"""Damages copies of a finished run, and holds `rrf verify` and `rrf bake --resume` against it.

Bit flips, truncations, deletions, and files of another run in place of the own ones: every damage
that changes an answer (a table, a plan or an evaluation that no longer reads as it was written) is
named by `verify`, with a remedy, and after `--resume` the model has the bytes that it had, unless
`verify` says what else to do.

    python3 tests/runs/damage.py --damages 200
    python3 tests/runs/damage.py --damages 40 --method transfer
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

# wall times, an empty file, and the course of a fit for charts: no answer depends on them
UNANSWERED = {"seconds.json", "lock", "steps.arrow"}
# settings of a run, and the same with another target
METHODS = {
    "nets": (runs.SETTINGS, [w if w != "0.29" else "0.30" for w in runs.SETTINGS]),
    "transfer": (runs.TRANSFER, [*runs.TRANSFER, "--target", "0.30"]),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--damages", type=int, default=200)
    parser.add_argument("--resumes", type=int, default=40, help="how many damaged models are resumed")
    parser.add_argument("--method", choices=METHODS, default="nets")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    dice = random.Random(options.seed)
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="rrf-damage-") as folder:
        tally = damages(Path(folder), options, dice)
    print(f"{tally}, {time.monotonic() - start:.0f} s")
    print(f"{options.damages} passed, 0 failed")


def damages(folder, options, dice):
    """Damages one file at a time."""
    whole, other = folder / "whole", folder / "other"
    settings, others = METHODS[options.method]
    runs.call(*runs.bake(whole, settings))
    runs.call(*runs.bake(other, others))
    report, code = verify(whole)
    if code != 0 or report["damages"] or report["unknown"]:
        raise SystemExit(f"a whole run is called damaged: {report}")
    expected = runs.digests(whole / "model")
    files = [p.relative_to(whole) for p in sorted(whole.rglob("*")) if p.is_file() and p.name not in UNANSWERED]
    tally = {"flip": 0, "truncate": 0, "delete": 0, "swap": 0, "harmless": 0, "resumed": 0}
    for number in range(options.damages):
        kind = ("flip", "truncate", "delete", "swap")[number % 4]
        run = folder / "damaged"
        shutil.copytree(whole, run)
        path = pick(kind, files, run, other, dice)
        damage(kind, run / path, other / path, dice)
        report, code = verify(run)
        if (code, bool(report["damages"])) not in ((0, False), (2, True)):
            raise SystemExit(f"{kind} of {path}: exit code {code}, {report}")
        if code == 0 and kind == "flip" and reads_the_same(run / path, whole / path):
            tally["harmless"] += 1
        elif code == 0 and kind == "delete" and is_superseded(path, whole):
            tally["harmless"] += 1
        elif code == 0:
            raise SystemExit(f"{kind} of {path} is not found")
        else:
            tally[kind] += 1
            if not all(d["what"] and d["remedy"] for d in report["damages"]):
                raise SystemExit(f"{kind} of {path}: no remedy, {report}")
        if path.parts[0] == "model" and tally["resumed"] < options.resumes:
            runs.call(*runs.bake(run, settings))
            different = runs.differences(runs.digests(run / "model"), expected)
            if different:
                raise SystemExit(f"{kind} of {path}: --resume leaves {different}")
            tally["resumed"] += 1
        shutil.rmtree(run)
    return tally


def verify(run):
    """The report of `rrf verify`, and its exit code."""
    done = subprocess.run([str(runs.program()), "verify", str(run), "--json"], capture_output=True, text=True)
    if "not a run folder" in done.stderr:
        # without run.json there is nothing to verify
        lost = {"path": "run.json", "what": "it is gone", "remedy": done.stderr}
        return {"damages": [lost], "unknown": []}, done.returncode
    if "panicked" in done.stderr or not done.stdout:
        raise SystemExit(f"verify: exit code {done.returncode}\n{done.stderr}")
    return json.loads(done.stdout), done.returncode


def pick(kind, files, run, other, dice):
    """A file, often one of the model; for a swap one that the other run has with other bytes."""
    while True:
        path = dice.choice([f for f in files if f.parts[0] == "model"] if dice.random() < 0.3 else files)
        if kind != "swap":
            return path
        if (other / path).exists() and (other / path).read_bytes() != (run / path).read_bytes():
            return path


def damage(kind, path, foreign, dice):
    """Damages a file."""
    content = bytearray(path.read_bytes())
    if kind == "delete":
        path.unlink()
    elif kind == "swap":
        shutil.copyfile(foreign, path)
    elif kind == "truncate":
        path.write_bytes(content[: dice.randrange(len(content))])
    else:
        bit = dice.randrange(8 * len(content))
        content[bit // 8] ^= 1 << bit % 8
        path.write_bytes(content)


def is_superseded(path, whole):
    """Whether a later round has fitted the cell of a fit again: the model does not depend on it."""
    if "fits" not in path.parts:
        return False
    plan = json.loads(sorted((whole / "rounds").glob("*/plan.json"))[-1].read_text())
    fitted = {f"cell={cell['cell']:06d}": f"{cell['fitted']:03d}" for cell in plan["cells"]}
    return fitted.get(path.parts[3]) != path.parts[1]


def answers(path):
    """What a JSON file says, but for what no answer depends on: where the scene lies, since it may have moved, no file at the path
    is an error and another scene there has another hash; and the record of the kernels that a bake ran on."""
    told = json.loads(path.read_text())
    return {key: value for key, value in told.items() if key not in ("scene", "kernels")}


def reads_the_same(path, whole):
    """Whether a table has the values that it had: a flip in padding or in unused metadata."""
    import pyarrow
    import pyarrow.parquet

    if path.suffix == ".json":
        return answers(path) == answers(whole)
    if path.suffix == ".arrow":
        read = lambda p: pyarrow.ipc.open_file(str(p)).read_all()
    else:
        read = lambda p: pyarrow.parquet.read_table(p, partitioning=None)
    try:
        return read(path).equals(read(whole))
    except Exception:
        return True  # only another reader stumbles over it; this one reads what was written


if __name__ == "__main__":
    main()
