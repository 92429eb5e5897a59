"""Where the method stops being usable: .venv-peers/bin/python tests/failure_map.py [--rrf F] [--work DIR] [--scale S]

Two kinds of bakes, by their test rows: one round of fixed settings (--rounds 1), one of which is
varied, and whole bakes, the standard preset for two minutes at the most. Writes
docs/science/failure-map.md with a chart each:

- roughness of every surface of the glossy room, 1.0 to 0.05, both kinds;
- paths a row and cells, in the Cornell box with lights anywhere in the room, one round;
- distance of the light to the nearest surface, by fresh rows of that scene, both kinds.

--scale below 1 shrinks rows and time, to try the script; nothing is written to docs/ then.
tests/peers/setup.sh makes .venv-peers.
"""

import argparse
import json
import struct
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "rrf"
import matplotlib.pyplot as plt  # noqa: E402

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "python"))
import rrf_truth  # noqa: E402

CORNELL = HERE.parent / "scenes/cornell-box/scene.pbrt"
GLOSSY = HERE.parent / "scenes/cornell-glossy/cornell-glossy.glb"
OVERHEAD, FREE = "-0.6,1.3,-0.6,0.6,1.8,0.6", "-0.8,0.2,-0.8,0.8,1.8,0.8"
ROUGHNESS = [1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.1, 0.05]
PATHS = [16, 32, 64, 128, 256, 512]
CELLS = [4, 8, 16, 32, 64, 128]
# the middle of the sweeps
CELLS_FIXED, ROWS, PATHS_FIXED = 32, 80_000, 128
DISTANCES = [0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.45, 0.7]
LIMIT = 0.15
# whole bakes
SECONDS = 120
ONE, WHOLE = "one round", f"whole bake, {SECONDS} s"
CONSEQUENCES = """## What the program then does

`bake` says that the target was missed and by how many cells. `metrics.arrow` and `rrf report` name these cells.

`render` and the page of `rrf view` warn of a light outside the light box. They also warn of one that is nearer to a surface than
2.5 % of the box's diagonal, 0.07 m in the room above. `render` refuses a light inside a solid, unless `--anyway` is given.

Answers that cannot be trusted are marked: by `trusted` in tables, by the layer `trust` in frames. They are points outside of what a
cell was trained on, and cells with an error above `--trust-error` (50 %). `render --fallback trace` path-traces such pixels,
and `rrf trace` the whole frame.

Sharp reflections are not for nets of this size. Below a roughness of some 0.2 a whole bake leaves 15 % and more: path-trace there."""
GEOMETRY = [a + b for a in ("p", "n", "v", "l") for b in "xyz"]


def run(command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr[-2000:]}")


def test_error(folder):
    """Relative error on test rows of the run's last round, and its standard error."""
    judged = sorted((folder / "rounds").glob("*/judged.json"))[-1]
    test = json.loads(judged.read_text())["judgement"]["test"]
    return test["relative_error"], test["relative_error_se"]


def bake(args, name, scene, box, options):
    """The run of a bake, and its error on test rows; a run that is there is read."""
    folder = args.work / name
    if not (folder / "model" / "weights.arrow").exists():
        run([args.rrf, "bake", scene, "-o", folder, "--method", "nets", f"--light-box={box}", "-q", *options])
    return folder, test_error(folder)


def one_round(args, name, scene, box, **settings):
    chosen = {"cells": CELLS_FIXED, "rows": ROWS, "paths": PATHS_FIXED} | settings
    chosen["rows"] = max(int(chosen["rows"] * args.scale), 1000)
    options = [x for key, value in chosen.items() for x in (f"--{key}", value)]
    return bake(args, "-".join([name, *map(str, chosen.values())]), scene, box, ["--rounds", 1, *options])


def whole(args, name, scene, box):
    seconds = max(SECONDS * args.scale, 10)
    return bake(args, f"{name}-whole-{seconds:g}", scene, box, ["--time-limit", seconds])


def with_roughness(roughness, to):
    """The glossy room with one roughness everywhere."""
    data = GLOSSY.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    scene, rest = json.loads(data[20 : 20 + length]), data[20 + length :]
    for material in scene["materials"]:
        material.setdefault("pbrMetallicRoughness", {})["roughnessFactor"] = roughness
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + len(rest))
    to.write_bytes(head + struct.pack("<I4s", len(text), b"JSON") + text + rest)
    return to


def fresh_rows(args):
    """Rows that no net was trained on: another seed's samples."""
    rows = max(int(40_000 * args.scale), 1000)
    folder = args.work / f"fresh-{rows}"
    if not folder.exists():
        command = [args.rrf, "extract", CORNELL, "-o", folder, f"--light-box={FREE}", "--seed", 2]
        run([*command, "--cells", 1, "--rows", rows, "--paths", 128, "-q"])
    files = sorted((folder / "samples").rglob("*.parquet"))
    return pa.concat_tables([pq.read_table(f, partitioning=None) for f in files])


def triangles(args):
    """Corners of the scene's triangles, shape [n, 3, 3], from the pbrt file's meshes."""
    numbers = {"P": [], "indices": []}
    found = []
    text = CORNELL.read_text()
    for shape in text.split('Shape "')[1:]:
        for key, kind in (("P", "point"), ("indices", "integer")):
            part = shape.split(f'"{kind} {key}"')[1]
            part = part[part.index("[") + 1 : part.index("]")]
            numbers[key] = [float(x) for x in part.split()]
        points = np.array(numbers["P"]).reshape(-1, 3)
        found.append(points[np.array(numbers["indices"], int).reshape(-1, 3)])
    return np.concatenate(found)


def distance_to(points, corners):
    """Distance of each point to the nearest triangle (Ericson 2005, section 5.1.5, by clamping)."""
    best = np.full(len(points), np.inf)
    for a, b, c in corners:
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        height = (points - a) @ normal
        flat = points - height[:, None] * normal
        inside = np.ones(len(points), bool)
        edge = np.full(len(points), np.inf)
        for p, q in ((a, b), (b, c), (c, a)):
            along = q - p
            inside &= ((flat - p) @ np.cross(normal, along)) >= 0
            t = np.clip(((points - p) @ along) / (along @ along), 0, 1)
            edge = np.minimum(edge, np.linalg.norm(points - p - t[:, None] * along, axis=1))
        best = np.minimum(best, np.where(inside, abs(height), edge))
    return best


def by_distance(args, baked):
    """Relative error of a run by the light's distance to the nearest surface."""
    table = fresh_rows(args)
    points, answers = args.work / "fresh.parquet", args.work / "answers.parquet"
    pq.write_table(table.select(GEOMETRY), points)
    run([args.rrf, "query", baked, "--points", points, "-o", answers])
    stack = lambda t, names: np.stack([t[n].to_numpy() for n in names], 1).astype(float)
    p = stack(pq.read_table(answers), "rgb")
    y = [stack(table, [f"y{h}_{c}" for c in "rgb"]) for h in (0, 1)]
    light = stack(table, ["lx", "ly", "lz"])
    square = rrf_truth.by_halves(p, y, rrf_truth.level((y[0] + y[1]) / 2))
    distance = distance_to(light, triangles(args))
    found = []
    for low, high in zip(DISTANCES, DISTANCES[1:]):
        e = square[(low <= distance) & (distance < high)]
        if len(e) <= 30:
            sys.exit(f"{len(e)} fresh rows between {low} and {high} m: --scale {args.scale} is too small")
        found.append(((low + high) / 2, *rrf_truth.error(e)))
    return found


def chart(path, title, axis, ticks, series):
    """Error, linear, against the thing varied, logarithmic; bars are one standard error."""
    figure, axes = plt.subplots(figsize=(6.4, 3.4))
    for name, rows in series.items():
        x, error, se = (np.array([row[k] for row in rows], float) for k in range(3))
        axes.errorbar(x, 100 * error, 100 * se, marker="o", markersize=4, capsize=2, label=name)
    axes.axhline(100 * LIMIT, color="#c33", linestyle="--", linewidth=1)
    axes.set(xscale="log", xlabel=axis, ylabel="relative error [%]", title=title)
    axes.set_ylim(bottom=0)
    axes.set_xticks(list(ticks), [f"{tick:g}" for tick in ticks])
    axes.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axes.grid(True, alpha=0.25)
    if len(series) > 1:
        axes.legend()
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def section(folder, name, title, axis, labels, ticks, series, text):
    """Lines of the page: what is shown, the chart, and its numbers; series of (x, error, its standard error)."""
    chart(folder / f"failure-{name}.svg", title, axis, ticks, series)
    page = [f"## {title}", "", text, "", f"![{title}](failure-{name}.svg)", ""]
    page += [f"| {axis} | {' | '.join(series)} |", "|---" * (1 + len(series)) + "|"]
    for k, label in enumerate(labels):
        found = (rows[k][1:] for rows in series.values())
        cells = [f"{error:.1%} ± {se:.1%}" + (", beyond use" if error > LIMIT else "") for error, se in found]
        page.append(f"| {label} | {' | '.join(cells)} |")
    return [*page, ""]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rrf", default=HERE.parent / "target" / "release" / "rrf")
    parser.add_argument("--work", type=Path, default=HERE.parent / "target" / "failure-map")
    parser.add_argument("--scale", type=float, default=1.0)
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    folder = HERE.parent / "docs" / "science" if args.scale == 1 else args.work
    page = ["# Failure map", "", "Where radiance regression with the light as an input (`--method nets`) stops being usable. "]
    page[-1] += "Made by `.venv-peers/bin/python tests/failure_map.py`.\n\n"
    page[-1] += f"*One round*: {CELLS_FIXED} cells, {ROWS:,} rows of {PATHS_FIXED} paths unless a section varies them. "
    page[-1] += f"*Whole bake*: the standard preset, target 5 %, {SECONDS} s at most on two cores. "
    page[-1] += "Errors are relative errors on test rows, ± their standard error. "
    page[-1] += f"Beyond {LIMIT:.0%} (dashed) a frame shows the error at a glance."
    page.append("")

    rough = {ONE: [], WHOLE: []}
    for r in ROUGHNESS:
        scene = with_roughness(r, args.work / f"rough-{r}.glb")
        for kind, make in ((ONE, one_round), (WHOLE, whole)):
            rough[kind].append((r, *make(args, f"rough-{r}", scene, OVERHEAD)[1]))
    text = "The glossy room with one roughness on every surface. Back wall and tall box are metal."
    page += section(folder, "roughness", "Roughness", "roughness", ROUGHNESS, ROUGHNESS, rough, text)

    rows = [(n, *one_round(args, "free", CORNELL, FREE, paths=n)[1]) for n in PATHS]
    text = "The Cornell box, lights anywhere. Up to some 32 paths a row the samples' noise limits the error. "
    text += "Beyond, a net limits it, by what it can do with a cell of this size."
    page += section(folder, "paths", "Paths a row", "paths a row", PATHS, PATHS, {ONE: rows}, text)

    rows = [(n, *one_round(args, "free", CORNELL, FREE, cells=n)[1]) for n in CELLS]
    text = "The same rows shared out to more and more cells. Neither cells nor paths are enough alone. The rounds of a "
    text += "bake put both where the error is. In 5½ minutes they reach 5.3 % here ([Report](report.md))."
    page += section(folder, "cells", "Cells", "cells", CELLS, CELLS, {ONE: rows}, text)

    kinds = ((ONE, one_round), (WHOLE, whole))
    found = {kind: by_distance(args, make(args, "free", CORNELL, FREE)[0]) for kind, make in kinds}
    labels = [f"{low:g} to {high:g} m" for low, high in zip(DISTANCES, DISTANCES[1:])]
    text = "Fresh rows of the same scene. A light at a surface makes that surface a second light."
    page += section(folder, "distance", "Light and nearest surface", "distance of the light [m]", labels, DISTANCES[1:], found, text)

    page.append(CONSEQUENCES)
    (folder / "failure-map.md").write_text("\n".join(page) + "\n")
    print(folder / "failure-map.md")


if __name__ == "__main__":
    main()
