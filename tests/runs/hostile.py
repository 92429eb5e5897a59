#!/usr/bin/env python3
"""Hostile command lines under an address-space limit: none may panic, hang or abort.

Each ends within 30 seconds with 0, 1 or 2 (never a signal, never 101), says something where it
fails, and leaves the files of others alone. Run at 1 GiB and 4 GiB of address space; some in far less.

    python3 tests/runs/hostile.py
"""

import argparse
import gzip
import os
import resource
import struct
import subprocess
import tempfile
import time
from pathlib import Path

import runs

SECONDS = 30
# MiB of address space in which no more than a message fits (OpenBLAS asked for more for ever), up to
# what is just enough: memory runs out in the midst of work
NARROW = range(100, 1000, 50)
BAKE = ["bake", "--quiet", "--rounds", "1", "--time-limit", "5"]
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--limits", type=int, nargs="*", default=[1, 4], metavar="GiB")
    options = parser.parse_args()
    passed, start, slowest = 0, time.monotonic(), (0.0, "")
    with tempfile.TemporaryDirectory(prefix="rrf-hostile-") as folder:
        folder = Path(folder)
        run = folder / "run"
        runs.call(*runs.bake(run))
        runs.call(*runs.bake(folder / "transfer", runs.TRANSFER))
        inputs(folder)
        for limit in options.limits:
            for line in lines(folder, run):
                seconds = attempt(folder, line, limit << 30)
                slowest = max(slowest, (seconds, " ".join(map(str, line))))
                passed += 1
        for limit in NARROW:
            for line in (
                ["--version"], ["doctor"], ["verify", run], [*BAKE, runs.SCENE, "-o", "narrow"],
                [*BAKE, runs.SCENE, "-o", "narrow-nets", "--method", "nets"],
            ):
                slowest = max(slowest, (attempt(folder, line, limit << 20), " ".join(map(str, line))))
                passed += 1
        others = folder / "letter"
        if others.read_text() != "dear":
            raise SystemExit("a file of another was changed")
    print(f"slowest: {slowest[0]:.1f} s: {slowest[1][:200]}")
    print(f"{passed} passed, 0 failed, {time.monotonic() - start:.0f} s")


def attempt(folder, line, limit):
    """Runs one line; the seconds that it took."""
    output = subprocess.PIPE
    if line[-1] == ">/dev/full":
        line, output = line[:-1], open("/dev/full", "wb")
    command = [str(runs.program()), *(str(word) for word in line)]
    limited = lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    start = time.monotonic()
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.PIPE, cwd=folder,
            timeout=SECONDS, preexec_fn=limited,
        )
    except subprocess.TimeoutExpired:
        raise SystemExit(f"hangs: {' '.join(command)}") from None
    said = done.stderr.decode(errors="replace")
    if done.returncode not in (0, 1, 2) or "panicked" in said or (done.returncode and not said.strip()):
        raise SystemExit(f"exit code {done.returncode} at {limit >> 20} MiB: {' '.join(command)}\n{said[-2000:]}")
    return time.monotonic() - start


def inputs(folder):
    """Files that claim too much, never end, or are none."""
    write = lambda name, content: (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    write("letter", "dear")
    write("a.obj", OBJ)
    write("empty.obj", "")
    write("nan.obj", OBJ.replace("v 1 0 0", "v nan 0 0"))
    write("huge.obj", OBJ.replace("v 1 0 0", "v 1e38 0 0"))
    write("index.obj", OBJ.replace("f 1 2 3", "f 1 2 2147483647"))
    write("corners.obj", OBJ + "f " + "1 2 3 " * 20_000 + "\n")
    write("self.obj", "mtllib self.obj\n" + OBJ)
    write("bomb.obj.gz", gzip.compress(b"#" * (64 << 20) + b"\n" + OBJ.encode()))
    write("cut.obj.gz", gzip.compress(OBJ.encode())[:-9])
    write("deep.pbrt", "WorldBegin\n" + "AttributeBegin\n" * 200_000)
    write("loop.pbrt", 'WorldBegin\nInclude "loop.pbrt"\n')
    write("many.pbrt", 'WorldBegin\nShape "sphere" "float radius" 1e300\n')
    write("text.pbrt", b"WorldBegin \x00\xff")
    write("open.gltf", '{"asset":{"version":"2.0"}')
    write("deep.gltf", '{"a":' * 100_000)
    write("big.gltf", '{"asset":{"version":"2.0"},"buffers":[{"byteLength":9007199254740991}]}')
    write("short.glb", b"glTF\x02\0\0\0\xff\xff\xff\xff")
    write("scene.usd", "no")
    write("points.parquet", b"PAR1" + b"\0" * 100 + struct.pack("<I", 2**31 - 1) + b"PAR1")
    write("points.arrow", b"ARROW1\0\0" + b"\xff" * 100 + b"ARROW1")
    write("batch.toml", "output = 'out'\n[[bake]]\nname='a'\nscene='a.obj'\n[bake.settings]\nrounds = 0\n")
    write("seeds.toml", "output = 'out'\n[[bake]]\nname='a'\nscene='a.obj'\n[bake.settings]\nseeds = []\n")
    write("twice.toml", "output = 'out'\n[[bake]]\nname='a'\nscene='a.obj'\n[bake.settings]\nseeds = [1, 1]\n")
    write("none.toml", "output = 'out'\n[[bake]]\nname='a'\nscene='a.obj'\n[bake.settings]\nmost_cells = 0\n")
    write("path.csv", "eye_x,eye_y\n1,2\n")
    case = runs.ROOT / "tests/data/cases/exr/base.exr"
    write("base.exr", case.read_bytes())
    claimed = bytearray(case.read_bytes())
    for name in (b"dataWindow\0box2i\0", b"displayWindow\0box2i\0"):
        at = claimed.find(name) + len(name) + 4 + 8
        claimed[at : at + 8] = struct.pack("<ii", 99_998, 99_998)
    write("claimed.exr", bytes(claimed))
    write("cut.exr", case.read_bytes()[:500])
    os.mkfifo(folder / "pipe")
    (folder / "taken").mkdir()
    (folder / "taken/lock").symlink_to(folder / "letter")
    (folder / "link.exr").symlink_to(folder / "letter")
    (folder / "circle.exr").symlink_to("circle.exr")


def lines(folder, run):
    """The command lines."""
    cornell, bake = runs.SCENE, BAKE
    scenes = [path.name for path in sorted(folder.iterdir()) if path.suffix in (".obj", ".gz", ".pbrt", ".gltf", ".glb", ".usd")]
    yield from (["scene", name] for name in scenes)
    yield from (["scene", name] for name in ("pipe", "/dev/zero", "/dev/null", ".", "nowhere.obj", ""))
    yield from ([*bake, name, "-o", "new"] for name in ("empty.obj", "nan.obj", "huge.obj", "pipe", "."))
    for option in (
        "--rows=0", "--rows=4294967295", "--rows=-1", "--paths=0", "--paths=1", "--paths=4294967294",
        "--paths=20000000", "--cells=0", "--cells=4294967295", "--most-cells=0", "--rounds=0",
        "--hidden=256,256", "--hidden=0", "--hidden=1,2,3", "--hidden=99999999999", "--target=nan",
        "--target=0", "--target=-1", "--target=inf", "--seed=-1", "--seed=18446744073709551616",
        "--light-box=0,0,0,0,0", "--light-box=nan,0,0,1,1,1", "--light-box=9,9,9,1,1,1",
        "--light-box=100,100,100,101,101,101", "--eye-box=inf,0,0,1,1,1", "--inputs=nothing",
        "--time-limit=0", "--time-limit=nan", "--memory=0", "--memory=1", "--memory=64XB",
        "--memory=99999999999GiB", "--threads=0", "--threads=999999999", "--default-albedo=2",
        "--default-albedo=nan", "--preset=best",
    ):
        yield [*bake, cornell, "-o", "new", "--method", "nets", option]
    yield [*bake, cornell, "-o", "new", "--method=magic"]
    yield [*bake, cornell, "-o", "taken"]
    yield [*bake, cornell, "-o", "letter"]
    yield [*bake, cornell, "-o", "letter/run"]
    yield from ([*bake, cornell, "-o", run, *method] for method in ([], ["--method", "nets"]))
    view = ["--eye=0,1,3", "--look-at=0,1,0"]
    outputs = (
        "none/a.exr", "/proc/a.exr", "circle.exr", ".", "", "a.jpg", "/dev/full", "/dev/null/a.png", "taken.exr/",
    )
    for command in (["render", run, "--size=8x8"], ["trace", cornell, "--spp=1", "--size=8x8"]):
        yield from ([*command, *view, "--light=0,1.5,0", "-o", name] for name in outputs)
        for option in (
            "--size=0x0", "--size=16384x16384x1", "--size=99999999x1", "--size=-1x1", "--fov=nan",
            "--fov=180", "--fov=0", "--exposure=nan", "--exposure=inf", "--exposure=1e39", "--aa=0",
            "--aa=4294967295", "--light=nan,0,0", "--light=0,0,0,-1,0,0", "--light=1,2", "--eye=inf,0,0",
            "--look-at=0,1,3", "--up=0,0,0",
        ):
            yield [*command, *view, "-o", "a.exr", option]
    yield ["trace", cornell, "--size=8x8", "--spp=0", "-o", "a.exr"]
    yield ["trace", cornell, "--size=16384x16384", "--spp=1", "-o", "a.exr"]
    yield ["render", run, "--size=16384x16384", "--light=0,1.5,0", "-o", "a.exr"]
    for name in ("pipe", "/dev/zero", "path.csv", "letter", "nowhere.csv", "."):
        yield ["render", run, "--path", name, "-o", "frames", "--light=0,1.5,0"]
    for name in ("pipe", "/dev/zero", "points.parquet", "points.arrow", "letter", "nowhere.parquet", "base.exr"):
        yield ["query", run, "--points", name, "-o", "out.parquet"]
        yield ["trace", cornell, "--points", name, "--spp=16", "-o", "out.parquet"]
    for pair in (
        ("claimed.exr", "base.exr"), ("base.exr", "claimed.exr"), ("cut.exr", "base.exr"), ("pipe", "base.exr"),
        ("/dev/zero", "base.exr"), ("letter", "base.exr"), (".", "base.exr"), ("base.exr", "nowhere.exr"),
    ):
        yield ["compare", *pair]
    yield ["compare", "base.exr", "base.exr", "--exposure=nan"]
    yield ["compare", "base.exr", "base.exr", "--part=9"]
    yield ["compare", "base.exr", "base.exr", "--layer=none"]
    yield from (["run", name] for name in ("batch.toml", "seeds.toml", "twice.toml", "none.toml", "pipe", "/dev/zero", "letter"))
    yield from (["verify", name] for name in (run, folder, "letter", "pipe", "nowhere", "/dev/zero"))
    for name in ("none/a.safetensors", "/dev/full", ".", "/proc/a"):
        yield ["export", run, "--safetensors", name]
        yield ["export", run, "--onnx", name]
    yield ["export", run, "--mitsuba", "letter"]
    yield ["export", "a.obj", "--mitsuba", "letter/deeper"]
    yield ["task", "--plan", "letter", "--index", "0"]
    yield ["task", "--plan", run / "rounds/000/tasks.parquet", "--index", "4294967295"]
    yield from (["commit", name] for name in ("letter", "nowhere", "pipe"))
    yield from ([*words, ">/dev/full"] for words in (["--help"], ["--version"], ["doctor"], ["scene", "a.obj"], ["verify", run], ["compare", "base.exr", "base.exr"]))
    yield from transfers(cornell)
    for words in (["inspect", run], ["chart", run, "-o", "charts"], ["completions", "bash"]):
        yield words
        yield [*words, ">/dev/full"]
    yield from (["man", name] for name in ("letter", "letter/deeper", "/dev/full", "manual"))
    yield from (["completions", name] for name in ("", "sh", "/dev/zero"))
    yield ["query", run, "--points", runs.ROOT / "tests/data/cases/data/empty.parquet", "-o", "none.parquet"]


def transfers(cornell):
    """Those of a run of a transfer."""
    bake = ["bake", "--quiet", cornell, "--time-limit", "5"]
    for option in (
        "--rows=0", "--rows=100000000", "--rows=4294967296", "--paths=0", "--paths=3", "--paths=4294967294", "--cells=2",
        "--hidden=3", "--memory=1GiB", "--rounds=0", "--target=nan", "--light-box=9,9,9,10,10,10",
        "--eye-box=9,9,9,10,10,10", "--threads=0", "--seed=-1",
    ):
        yield [*bake, "-o", "new-transfer", option]
    yield from ([*bake, "-o", name] for name in ("taken", "letter", "letter/run", "transfer", "run"))
    yield [*bake, "-o", "run", "--resume"]
    yield [*bake, "-o", "transfer", "--resume", "--method", "nets"]
    for words in (
        ["verify"], ["verify", "--json"], ["train"], ["plan"], ["commit"], ["inspect"], ["chart", "-o", "charts"],
        ["report", "-o", "page.html"], ["export", "--onnx", "a.onnx"], ["export", "--parquet", "letter"],
        ["query", "--points", "points.parquet", "-o", "out.parquet"], ["query", "--points", "pipe", "-o", "out.parquet"],
        ["render", "--size=8x8", "-o", "none/a.exr"], ["render", "--size=16384x16384", "-o", "a.exr"],
        ["render", "--size=8x8", "--light=nan,0,0", "-o", "a.exr"], ["render", "--size=8x8", "-o", "/dev/full"],
        ["render", "--size=8x8", "-o", "link.exr/a.exr"],
    ):
        yield [words[0], "transfer", *words[1:]]
    yield ["verify", "transfer", ">/dev/full"]


if __name__ == "__main__":
    main()
