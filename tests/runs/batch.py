#!/usr/bin/env python3
"""A night of six bakes: three fine, one of a broken scene, one that misses its target, one killed.

What is told has to be what happened: the exit code, summary.json, rounds.jsonl, log.txt, the file for
monitoring, and the command that runs at the end; and again after the killed batch is rerun.

    python3 tests/runs/batch.py
"""

import json
import re
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import runs

BATCH = """
output = "runs"
on_finish = 'echo "$RRF_EXIT_CODE $RRF_SUMMARY $RRF_METRICS" >> finished.txt'
metrics = "node/rrf.prom"

[defaults]
method = "nets"
light_box = [-0.6, 1.3, -0.6, 0.6, 1.8, 0.6]
rows = 8000
cells = 4
most_cells = 6
paths = 8
rounds = 3
target = "60%"

[matrix]
scenes = {{ box = "{scene}" }}
presets = ["preview", "standard"]
seeds = [1]

[[bake]]
name = "plain"
scene = "{scene}"

[[bake]]
name = "broken"
scene = "broken.pbrt"

[[bake]]
name = "strict"
scene = "{scene}"
settings = {{ target = 0.0001, rounds = 1 }}

[[bake]]
name = "long"
scene = "{scene}"
time_limit = 600
settings = {{ rows = 600000, paths = 64, rounds = 1, seeds = [7], target = "90%" }}
"""
ISO = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")
FINE = ["plain-1", "box-preview-1", "box-standard-1"]
# in the order of the file, those of the matrix last
ORDER = ["plain-1", "broken", "strict-1", "long-7", "box-preview-1", "box-standard-1"]


def main():
    with tempfile.TemporaryDirectory(prefix="rrf-batch-") as folder:
        folder = Path(folder)
        (folder / "node").mkdir()
        (folder / "broken.pbrt").write_text('WorldBegin\nShape "sphere" "float radius"\n')
        file = folder / "batch.toml"
        file.write_text(BATCH.format(scene=runs.SCENE))
        refused(file)
        killed(folder, file)
        # less work for the rest of the test; the run is renewed
        file.write_text(file.read_text().replace("rows = 600000, paths = 64", "rows = 6000, paths = 8"))
        rerun(folder, file)
        stopped(folder, file)
    print("4 passed, 0 failed")


def command(file, *more):
    return [str(runs.program()), "run", str(file), *more]


def expect(condition, *told):
    if not condition:
        raise SystemExit(" ".join(map(str, told)))


def refused(file):
    """Without --keep-going a broken scene stops the batch before it begins."""
    done = subprocess.run(command(file), capture_output=True, text=True)
    expect(done.returncode == 2 and "broken" in done.stderr and "--keep-going" in done.stderr, done)
    expect(not (file.parent / "runs").exists(), "a refused batch left files")


def killed(folder, file):
    """Killed in the long bake: the summary on disk says what is done and that more was to come."""
    process = subprocess.Popen(
        command(file, "--keep-going", "--require-target"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    log, end = folder / "runs/log.txt", time.monotonic() + 300
    while not (log.exists() and "long-7: begun" in log.read_text()):
        expect(process.poll() is None and time.monotonic() < end, "the long bake is never begun")
        time.sleep(0.05)
    time.sleep(1)
    process.send_signal(signal.SIGKILL)
    process.wait()
    summary = json.loads((folder / "runs/summary.json").read_text())
    expect(summary["unfinished"] and summary["code"] is None, summary)
    expect([Path(run["run"]).name for run in summary["runs"]] == ORDER[:3], summary)
    expect(not (folder / "runs/finished.txt").exists(), "on_finish ran before the end")


def rerun(folder, file):
    """The same command again does the rest, and tells all of it."""
    done = subprocess.run(command(file, "--keep-going", "--require-target", "--json"), capture_output=True, text=True)
    # 2 for the broken scene goes before 3 for the missed target
    expect(done.returncode == 2, done.returncode, done.stderr)
    summary = json.loads((folder / "runs/summary.json").read_text())
    expect(json.loads(done.stdout.splitlines()[-1]) == summary, "--json prints another summary")
    expect(summary["code"] == 2 and not summary["unfinished"] and ISO.fullmatch(summary["started"]), summary)
    found = {Path(run["run"]).name: run for run in summary["runs"]}
    expect(list(found) == ORDER, list(found))
    for name in [*FINE, "long-7"]:
        run = found[name]
        expect(run["code"] == 0 and run["state"] == "done" and run["target_met"] is True, run)
        expect(run["relative_error"] < run["target"] and run["rounds"] >= 1 and run["cells"] >= 4, run)
        expect(run["bytes"] > run["model_bytes"] > 0 and run["work_seconds"] > 0, run)
        expect(run["forecast_core_seconds"] > 0 and ISO.fullmatch(run["started"]) and "stopped" in run["stop"], run)
    expect(found["box-preview-1"]["preset"] == "preview" and found["long-7"]["seed"] == 7, found)
    broken, strict = found["broken"], found["strict-1"]
    expect((broken["code"], broken["state"]) == (2, "bad_input") and "broken.pbrt" in broken["message"], broken)
    expect((strict["code"], strict["state"], strict["target_met"]) == (3, "target_missed", False), strict)
    rounds = [json.loads(line) for line in (folder / "runs/rounds.jsonl").read_text().splitlines()]
    # a round that was done before the kill is told once, by the command that did it
    names = {(line["run"], line["round"]) for line in rounds}
    expect(len(names) == len(rounds) and {name for name, _ in names} == set(ORDER) - {"broken"}, rounds)
    for line in rounds:
        expect(line["target_met"] == (line["run"] != "strict-1") or line["round"] == 0, line)
    printed = [json.loads(line) for line in done.stdout.splitlines()[:-1]]
    expect(printed == [line for line in rounds if line in printed], "--json prints other rounds")
    metrics = (folder / "node/rrf.prom").read_text()
    value = lambda name, run: float(re.search(rf'^{name}{{run="{run}",.*}} (\S+)$', metrics, re.MULTILINE).group(1))
    for name, run in found.items():
        expect(value("rrf_run_exit_code", name) == run["code"], name)
    expect(value("rrf_run_target_met", "strict-1") == 0 and value("rrf_run_target_met", "plain-1") == 1, metrics)
    expect(abs(value("rrf_run_relative_error", "plain-1") - found["plain-1"]["relative_error"]) < 1e-12, metrics)
    expect("\nrrf_batch_exit_code 2\n" in metrics and metrics.endswith("# EOF\n"), metrics)
    log = (folder / "runs/log.txt").read_text().splitlines()
    expect(all(ISO.fullmatch(line.split(" ", 1)[0]) for line in log), log)
    expect(log[-1].endswith(f"4 of 6 runs done, exit code 2: {folder / 'runs/summary.json'}"), log[-1])
    for name in ORDER:
        expect(any(f"/{name}: " in line for line in log), name)
    code, *paths = (folder / "runs/finished.txt").read_text().split()
    expect(code == "2" and [Path(path).name for path in paths] == ["summary.json", "rrf.prom"], code, paths)


def stopped(folder, file):
    """The first SIGTERM ends the batch; what was not begun is said to be so, with exit code 1."""
    changed = file.read_text().replace("rows = 6000, paths = 8", "rows = 600000, paths = 64")
    file.write_text(changed)
    process = subprocess.Popen(
        command(file, "--keep-going"), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    log, end = folder / "runs/log.txt", time.monotonic() + 300
    while log.read_text().count("long-7: begun") < 3:
        expect(process.poll() is None and time.monotonic() < end, "the long bake is never begun")
        time.sleep(0.05)
    time.sleep(1)
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=30)
    expect(process.returncode == 1, process.returncode, errors)
    summary = json.loads((folder / "runs/summary.json").read_text())
    states = [run["state"] for run in summary["runs"]]
    expect(states == ["done", "bad_input", "target_missed", "stopped", "not_begun", "not_begun"], states)
    # without --require-target a missed target is no failure
    expect([run["code"] for run in summary["runs"]] == [0, 2, 0, 1, 1, 1], summary)


if __name__ == "__main__":
    main()
