#!/usr/bin/env python3
"""1, 2 and 3 workers do the tasks of a bake as processes of their own, in random order.

Every worker goes through all tasks of a stage in an order of its own, so that tasks are done
twice, at the same time too; the bytes must be those of `rrf bake`. Trained before extracted, a
task must say "try again" (exit code 1); one that no plan has, "permanent" (2).

    python3 tests/runs/workers.py
"""

import json
import random
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import runs


def main():
    with tempfile.TemporaryDirectory(prefix="rrf-workers-") as folder:
        folder = Path(folder)
        runs.call(*runs.bake(folder / "whole"))
        expected = runs.digests(folder / "whole")
        for workers in (1, 2, 3):
            run = folder / f"workers-{workers}"
            tasks = scattered(run, workers, random.Random(workers))
            differing = runs.differences(runs.digests(run), expected)
            if differing:
                sys.exit(f"{workers} workers: files differ: {', '.join(differing)}")
            print(f"{workers} workers: {tasks} tasks each, the same bytes")
    print("3 passed, 0 failed")


def scattered(run, workers, dice):
    """A whole bake by that many workers; how many tasks it had."""
    runs.call(runs.program(), "plan", runs.SCENE, "-o", run, *runs.SETTINGS)
    count, ended = 0, False
    while not ended:
        plan = json.loads(runs.call(runs.program(), "plan", run, "--json"))
        table, tasks = plan["plan"], plan["tasks"]
        if count == 0:
            refused(table, tasks)
        for stage in ("extract", "train"):
            ids = [task["task_id"] for task in tasks if task["stage"] == stage]
            orders = [dice.sample(ids, len(ids)) for _ in range(workers)]
            # the first of all of them is the same: done by all at once
            orders = [[ids[0], *(i for i in order if i != ids[0])] for order in orders]
            with ThreadPoolExecutor(workers) as pool:
                list(pool.map(lambda order: [task(table, i) for i in order], orders))
        count += len(tasks)
        ended = json.loads(runs.call(runs.program(), "commit", run, "--json"))["ended"]
    return count


def task(table, index, codes=(0,)):
    runs.call(runs.program(), "task", "--plan", table, "--index", index, codes=codes)


def refused(table, tasks):
    train = next(task["task_id"] for task in tasks if task["stage"] == "train")
    task(table, train, codes=(1,))
    task(table, len(tasks), codes=(2,))


if __name__ == "__main__":
    main()
