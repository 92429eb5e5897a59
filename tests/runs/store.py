"""A run in an object store: python3 tests/runs/store.py --server moto_server

Starts a server that speaks S3 on loopback (moto, from PyPI), and shows there
- a bake, killed and resumed, that ends with the bytes of a bake in a folder;
- a part that two writers store at the same time: one wins, the other finds it done;
- that another machine (an empty cache) answers queries from what is stored, and keeps no copy.
RRF is the program; --server names moto's command.
"""

import argparse
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

HERE = Path(__file__).resolve().parents[2]
SCENE = HERE / "scenes/cornell-box/scene.pbrt"
SETTINGS = (
    "--method nets --light-box -0.6,1.3,-0.6,0.6,1.8,0.6 --rows 8000 --cells 4 --paths 8 --rounds 4 --target 0.29 --most-cells 6"
).split()
RRF = os.environ.get("RRF", str(HERE / "target/release/rrf"))


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def environment(port, cache):
    return os.environ | {
        "AWS_ENDPOINT": f"http://127.0.0.1:{port}",
        "AWS_ALLOW_HTTP": "true",
        "AWS_ACCESS_KEY_ID": "testing",
        "AWS_SECRET_ACCESS_KEY": "testing",
        "AWS_REGION": "us-east-1",
        "RRF_CACHE": str(cache),
    }


def rrf(env, *args, check=True):
    done = subprocess.run([RRF, "-q", *map(str, args)], env=env, capture_output=True, text=True)
    if check and done.returncode:
        sys.exit(f"rrf {' '.join(map(str, args))}: {done.returncode}\n{done.stderr}")
    return done


def below(folder):
    """Bytes of a run's files, by their paths, but for the one with wall times."""
    files = (p for p in Path(folder).rglob("*") if p.is_file() and "staging" not in p.parts)
    files = (p for p in files if p.name != "seconds.json")
    return {str(p.relative_to(folder)): p.read_bytes() for p in files}


def the_only(folder):
    [run] = (path for path in Path(folder).iterdir() if path.suffix != ".lock")
    return run


def killed_and_resumed(work, port, run):
    """Kills at random moments until the bake ends by itself."""
    random.seed(11)
    kills = 0
    while True:
        # every try is another machine: nothing but the store remembers
        env = environment(port, work / f"cache-{kills}")
        resume = ["--resume"] if kills else []
        bake = subprocess.Popen([RRF, "-q", "bake", SCENE, "-o", run, *SETTINGS, *resume], env=env,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            out, err = bake.communicate(timeout=0.4 + random.random() * (0.6 + 0.4 * kills))
        except subprocess.TimeoutExpired:
            bake.send_signal(signal.SIGKILL)
            bake.communicate()
            kills += 1
            continue
        if bake.returncode == 2 and "no run" in err.lower():
            sys.exit(err)
        if bake.returncode:
            sys.exit(f"after {kills} kills: {bake.returncode}\n{err}")
        return kills, the_only(work / f"cache-{kills}")


def raced(work, port, run):
    """Two machines do the same task at the same time."""
    rrf(environment(port, work / "race-plan"), "plan", SCENE, "-o", run, *SETTINGS)
    task = [RRF, "-q", "task", "--plan", f"{run}/rounds/000/tasks.parquet", "--index", "0"]
    both = [subprocess.Popen(task, env=environment(port, work / f"race-{i}"), stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True) for i in range(2)]
    said = [p.communicate() for p in both]
    assert [p.returncode for p in both] == [0, 0], said
    assert all("done" in out for out, _ in said), said
    missing = rrf(environment(port, work / "race-plan"), "plan", run, "--missing").stdout.split()
    assert "0" not in missing and missing, missing
    stored = below(the_only(work / "race-plan"))
    assert [name for name in stored if name.startswith("samples/")] == ["samples/cell=000000/part-00000.parquet"]
    third = subprocess.run(task, env=environment(port, work / "race-3"), capture_output=True, text=True)
    assert "done already" in third.stdout, third


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", default="moto_server")
    server_command = parser.parse_args().server
    port = free_port()
    server = subprocess.Popen([server_command, "-H", "127.0.0.1", "-p", str(port)],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        for _ in range(300):
            try:
                request = urllib.request.Request(f"http://127.0.0.1:{port}/runs", method="PUT")
                urllib.request.urlopen(request, timeout=1)
                break
            except OSError:
                time.sleep(0.1)
        with tempfile.TemporaryDirectory(prefix="rrf-store-") as name:
            work = Path(name)
            whole = work / "whole"
            rrf(os.environ, "bake", SCENE, "-o", whole, *SETTINGS)
            kills, copy = killed_and_resumed(work, port, "s3://runs/box")
            assert kills > 0, "no kill hit: nothing was shown"
            assert below(copy) == below(whole), "the stored run has other bytes"
            print(f"{kills} kills, each on a new machine: the bytes of an unkilled bake")
            raced(work, port, "s3://runs/race")
            print("two writers of one part: one wins, the other finds it done")
            env = environment(port, work / "reader")
            points = HERE / "tests/data/oracle/cornell_overhead.parquet"
            answers = [work / "a.parquet", work / "b.parquet"]
            rrf(env, "query", "s3://runs/box", "--points", points, "-o", answers[0])
            rrf(env, "query", whole, "--points", points, "-o", answers[1])
            assert answers[0].read_bytes() == answers[1].read_bytes()
            assert not any((work / "reader").iterdir()), "a query left its copy behind"
            print("a query answers from the store, and leaves nothing behind")
            wrong = rrf(environment(free_port(), work / "none"), "query", "s3://runs/box", "--points", points,
                        "-o", answers[0], check=False)
            assert wrong.returncode == 1 and "cannot list" in wrong.stderr, wrong
    finally:
        server.kill()


if __name__ == "__main__":
    main()
