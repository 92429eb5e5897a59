#!/usr/bin/env python3
"""Bakes a scene on a Slurm cluster: every round is job arrays, and a job that submits the next.

    python3 submit.py --scene scene.pbrt --run RUN [-- --method nets and other settings of rrf bake]

Round after round: arrays for the extractions, arrays for the fits that wait for them, and a job
that waits for those (however they ended), commits and submits the next round. Tasks that are
missing then, whatever became of their jobs, are submitted again, as long as that gets any of them
done. RUN must be at the same path on every node (a shared file system). Logs and lists are in
RUN.slurm; `cat RUN.slurm/log` tells how it stands. Cut off, the same command goes on.
"""

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

ENGINE = Path(__file__).resolve().parent
# a commit reads the metrics and nets of every cell
COMMIT_MEMORY_MB = 1024


def main():
    options = parse()
    options.logs.mkdir(parents=True, exist_ok=True)
    if options.scene:
        rrf(options, "plan", options.scene, "-o", options.run, "--resume", "--json", *options.settings)
    permanent = options.logs / "permanent"
    if options.scene:
        # someone asks again: the cause may be gone
        permanent.unlink(missing_ok=True)
    if permanent.exists():
        stop(options, f"a task cannot succeed, see {options.logs}: {permanent.read_text().strip()}")
    plan = missing(options)
    if not plan["ended"] and not plan["tasks"]:
        rrf(options, "commit", options.run, "--json")
        plan, options.before, options.tries = missing(options), None, 0
    if plan["ended"]:
        log(options, "the bake has ended")
        return
    left = len(plan["tasks"])
    options.tries = 0 if left != options.before else options.tries + 1
    if options.tries >= options.patience:
        stop(options, f"{left} tasks are still missing after {options.tries} more tries")
    submit_round(options, plan)


def missing(options):
    """The round to do, with the tasks that are not done."""
    return rrf(options, "plan", options.run, "--missing", "--json")


def submit_round(options, plan):
    """Arrays for both stages, and the job that goes on after them."""
    waits_for = []
    for stage in ("extract", "train"):
        tasks = [task for task in plan["tasks"] if task["stage"] == stage]
        # however the extractions ended: a fit that misses one says "try again"
        waits_for = submit_stage(options, plan, stage, tasks, waits_for) or waits_for
    arguments = ["--run", options.run, "--rrf", options.rrf, "--seconds", options.seconds]
    arguments += ["--before", len(plan["tasks"]), "--tries", options.tries]
    arguments += ["--patience", options.patience, f"--sbatch={options.sbatch}"]
    environment = {"ENGINE": ENGINE, "ARGUMENTS": shlex.join(str(a) for a in arguments)}
    sbatch(options, "next", environment, waits_for, f"--mem={COMMIT_MEMORY_MB}M")
    log(options, f"round {plan['round']}: {len(plan['tasks'])} tasks submitted")


def submit_stage(options, plan, stage, tasks, waits_for):
    """A stage as arrays of at most as many elements as the cluster allows; their job ids."""
    lines = elements(tasks, options.seconds)
    path = options.logs / f"round-{plan['round']:03}-{stage}.tasks"
    path.write_text("".join(" ".join(map(str, line)) + "\n" for line in lines))
    memory = max((task["memory"] for task in tasks), default=0) * 5 // 4 + (64 << 20)
    chunk = array_limit()
    jobs = []
    for first in range(0, len(lines), chunk):
        environment = {
            "RRF": options.rrf,
            "PLAN": Path(plan["plan"]).resolve(),
            "LIST": path,
            "FIRST": first,
            "PERMANENT": options.logs / "permanent",
        }
        last = min(chunk, len(lines) - first) - 1
        resources = (f"--array=0-{last}", f"--mem={memory >> 20}M")
        jobs.append(sbatch(options, "task", environment, waits_for, *resources))
    return jobs


def elements(tasks, seconds):
    """Tasks in groups that should take that long: a job has to be worth its start."""
    groups, filled = [], 0.0
    for task in tasks:
        if not groups or filled + task["seconds"] > seconds:
            groups.append([])
            filled = 0.0
        groups[-1].append(task["task_id"])
        filled += task["seconds"]
    return groups


def array_limit():
    """MaxArraySize: indices have to stay below it."""
    config = run("scontrol", "show", "config")
    return int(re.search(r"^MaxArraySize\s*=\s*(\d+)", config, re.MULTILINE).group(1))


def sbatch(options, template, environment, waits_for, *resources):
    """Submits a template; the job's id."""
    export = ",".join(["ALL", *environment])
    command = ["sbatch", "--parsable", f"--export={export}", f"--output={options.logs}/%x-%A-%a.out"]
    command += [f"--job-name=rrf-{template}", *resources, *shlex.split(options.sbatch)]
    if waits_for:
        command.append("--dependency=afterany:" + ":".join(waits_for))
    job = run(*command, ENGINE / f"{template}.sbatch", environment=environment)
    return job.strip().split(";")[0]


def rrf(options, *arguments):
    """The JSON that a command of rrf prints."""
    return json.loads(run(options.rrf, "--quiet", *arguments))


def run(*command, environment=None):
    full = {**os.environ, **{name: str(value) for name, value in (environment or {}).items()}}
    words = [str(word) for word in command]
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, env=full)
    if done.returncode != 0:
        print(f"{shlex.join(words)}: exit code {done.returncode}", file=sys.stderr)
        sys.exit(done.returncode if done.returncode in (1, 2) else 1)
    return done.stdout


def log(options, text):
    print(text)
    with open(options.logs / "log", "a", encoding="utf-8") as file:
        file.write(text + "\n")


def stop(options, why):
    log(options, f"given up: {why}")
    sys.exit(2)


def parse():
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0], epilog="What follows -- are settings of rrf bake; --method nets or a baseline, which have tasks."
    )
    parser.add_argument("--run", required=True, type=lambda p: Path(p).absolute())
    parser.add_argument("--scene", help="begin a bake of this scene, or go on with it")
    parser.add_argument("--rrf", default="rrf", help="the program, at the same path on every node")
    parser.add_argument("--seconds", type=float, default=300, help="of work an array element")
    parser.add_argument("--patience", type=int, default=3, help="tries that get nothing done")
    parser.add_argument("--sbatch", default="", help="options of sbatch, --sbatch=\"--partition=P --time=60\"")
    parser.add_argument("--before", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--tries", type=int, default=0, help=argparse.SUPPRESS)
    words = sys.argv[1:]
    split = words.index("--") if "--" in words else len(words)
    options = parser.parse_args(words[:split])
    options.settings = words[split + 1 :]
    options.logs = options.run.with_name(options.run.name + ".slurm")
    return options


if __name__ == "__main__":
    main()
