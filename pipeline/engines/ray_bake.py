#!/usr/bin/env python3
"""Bakes a scene on a Ray cluster: every task of every round is a Ray task.

    pip install ray
    python3 ray_bake.py scene.pbrt -o RUN [--address auto|HOST:6379] [-- --method nets and other settings of rrf bake]

Plan, extract, train, commit, and again, until `rrf commit` says that the bake has ended. A task
is a process, `rrf task`, with one CPU and the memory that the plan estimates; its exit code
decides: 0 done, 1 tried again, 2 permanent, the bake stops. A task whose node dies is started
on another one. The run folder must be at the same path on every node (a shared file system).
Cut off, the same command goes on: tasks that are done are not started.
"""

import argparse
import json
import subprocess
import sys

import ray

PERMANENT = 2
# tasks that Ray knows of at once
IN_HAND = 4096


class Failed(Exception):
    """A task that may succeed when tried again."""


class Permanent(Exception):
    """A task that cannot succeed."""


@ray.remote(num_cpus=1)
def run_task(rrf, plan, index):
    """Does one task of a plan; the same bytes wherever and how often it is done."""
    command = [rrf, "--threads", "1", "task", "--plan", plan, "--index", str(index)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == PERMANENT:
        raise Permanent(f"task {index}: {done.stderr.strip()}")
    if done.returncode != 0:
        raise Failed(f"task {index}: exit code {done.returncode}: {done.stderr.strip()}")


def main():
    options = parse()
    ray.init(address=options.address, log_to_driver=False)
    try:
        bake(options)
    except Permanent as error:
        print(error, file=sys.stderr)
        sys.exit(PERMANENT)
    # what is done stays: the same command goes on
    except (Failed, ray.exceptions.RayError) as error:
        print(error, file=sys.stderr)
        sys.exit(1)
    finally:
        ray.shutdown()


def bake(options):
    """All rounds of a bake."""
    plan = ("plan", options.scene, "-o", options.output, "--resume", "--json", *options.settings)
    ended = call(options.rrf, *plan)["ended"]
    while not ended:
        ended = bake_round(options)


def bake_round(options):
    """One round; whether it was the last."""
    for stage in ("extract", "train"):
        plan = call(options.rrf, "plan", options.output, "--missing", "--json")
        tasks = [task for task in plan["tasks"] if task["stage"] == stage]
        perform(options, plan["plan"], tasks)
        print(f"round {plan['round']}: {len(tasks)} {stage} tasks done", flush=True)
    report = call(options.rrf, "commit", options.output, "--json")
    print(f"round {report['round']}: relative error {report['relative_error']}", flush=True)
    return report["ended"]


def perform(options, plan, tasks):
    """Tasks of one stage, the long ones first; the first that fails for good ends the bake."""
    waiting = sorted(tasks, key=lambda task: (task["seconds"], task["task_id"]))
    running = []
    while waiting or running:
        while waiting and len(running) < IN_HAND:
            task = waiting.pop()
            resources = run_task.options(
                memory=task["memory"], max_retries=options.retries, retry_exceptions=[Failed]
            )
            running.append(resources.remote(options.rrf, plan, task["task_id"]))
        done, running = ray.wait(running)
        ray.get(done)


def call(rrf, *arguments):
    """The JSON that a command of rrf prints."""
    done = subprocess.run([rrf, "--quiet", *arguments], stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        kind = Permanent if done.returncode == PERMANENT else Failed
        raise kind(f"rrf {arguments[0]}: exit code {done.returncode}")
    return json.loads(done.stdout)


def parse():
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0], epilog="What follows -- are settings of rrf bake; --method nets or a baseline, which have tasks."
    )
    parser.add_argument("scene")
    parser.add_argument("-o", "--output", required=True, metavar="RUN")
    parser.add_argument("--address", help="a running cluster's; without it one is made here")
    parser.add_argument("--rrf", default="rrf", help="the program, at the same path on every node")
    parser.add_argument("--retries", type=int, default=5, help="of a task, lost nodes included")
    words = sys.argv[1:]
    split = words.index("--") if "--" in words else len(words)
    options = parser.parse_args(words[:split])
    options.settings = words[split + 1 :]
    return options


if __name__ == "__main__":
    main()
