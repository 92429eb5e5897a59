#!/usr/bin/env python3
"""What a round costs that has very many cells: the figures of docs/science/scale.md.

Blows the first plan of the Cornell box up to that many cells, each with a draw of its own, and
measures by CPU time: the table of tasks, one task of each stage, the list of what is missing.

    python3 tests/runs/scale.py --cells 100000
"""

import argparse
import json
import resource
import tempfile
from pathlib import Path

import runs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=100_000)
    parser.add_argument("--rows", type=int, default=2000, help="of a cell")
    parser.add_argument("--paths", type=int, default=64, help="of a row")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rrf-scale-") as folder:
        run = Path(folder) / "run"
        runs.call(runs.program(), "plan", runs.SCENE, "-o", run, *runs.SETTINGS)
        blow_up(run / "rounds/000/plan.json", options)
        measure(run)


def blow_up(path, options):
    """A balanced tree over the first coordinate, and a draw and a part for every leaf."""
    plan = json.loads(path.read_text())
    axis, threshold, left, cell = [], [], [], []
    levels = [(0, options.cells)]
    while levels:
        below = []
        for first, count in levels:
            # a node's children follow those of the nodes before it
            inner = count > 1
            axis.append(0 if inner else -1)
            threshold.append(2 * (first + count // 2) / options.cells - 1 if inner else 0.0)
            left.append(0)
            cell.append(2**32 - 1 if inner else first)
            below += [(first, count // 2), (first + count // 2, count - count // 2)] if inner else []
        levels = below
    children = 1
    for node, split in enumerate(axis):
        if split == 0:
            left[node], children = children, children + 2
    plan["tree"] = {"axis": axis, "threshold": threshold, "left": left, "cell": cell}
    leaves = sorted((cell[node], node) for node in range(len(axis)) if axis[node] < 0)
    plan["draws"] = [
        {"node": node, "rows": options.rows, "paths": options.paths} for _, node in leaves
    ]
    part = {"part": 0, "from": None}
    plan["cells"] = [
        {
            **plan["cells"][0],
            "cell": id,
            "measure": 1 / options.cells,
            "parts": [{**part, "draw": id}],
        }
        for id in range(options.cells)
    ]
    path.write_text(json.dumps(plan, separators=(",", ":")))


def measure(run):
    table = run / "rounds/000/tasks.parquet"
    report("the table of tasks", runs.program(), "plan", run)
    cells = len(json.loads((run / "rounds/000/plan.json").read_text())["cells"])
    middle = cells // 2
    for what, index in (("extract", middle), ("train", cells + middle), ("done", middle)):
        report(f"a task: {what}", runs.program(), "--threads", 1, "task", "--plan", table, "--index", index)
    report("what is missing", runs.program(), "plan", run, "--missing")
    chapters = sorted((run / "rounds/000/tasks").iterdir())
    print(f"{chapters[0].stat().st_size:>12} bytes  the first of {len(chapters)} files of tasks")
    for path in sorted(path for path in run.rglob("*") if path.is_file() and path not in chapters):
        print(f"{path.stat().st_size:>12} bytes  {path.relative_to(run)}")


def report(what, *command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    runs.call(*command)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    # the greatest of all children so far
    print(f"{seconds:>9.3f} s CPU, {after.ru_maxrss >> 10:>5} MiB at the most so far: {what}", flush=True)


if __name__ == "__main__":
    main()
