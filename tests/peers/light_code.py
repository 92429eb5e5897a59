"""What a light code would bring as an input: python3 tests/peers/light_code.py RUN [CELLS]

RUN is a finished bake of the Cornell box. The code of a light: square roots of the irradiance that it throws, shadows
included, on 256 probe points (of the second oracle table), projected on their first principal components over the lights of
all cells. CELLS (14) cells, drawn in proportion to what they add to the error, are fitted anew from their own rows by
examples/race (linear outputs, 40 steps, two starts, as many hidden units as the bake's), with the code and without. Told is
the error on rows kept back at its lowest, the noise of their targets taken out.

Needs `cargo build --release -p rrf-train --examples`, the program, and `sh tests/peers/setup.sh`.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np
import pyarrow.parquet as pq

from export_cells import rows_of
from training_task import ROOT, rrf_truth, write

mi.set_variant("llvm_ad_rgb")
PROBES, STEPS, STARTS = 256, 40, (2, 3)
# components over all lights; "own": of the cell's own lights
VARIANTS = {"none": 0, "2": 2, "4": 4, "8": 8, "own 4": 4}


def scene(folder):
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    room = ROOT / "scenes/cornell-box/scene.pbrt"
    subprocess.run([target / "release/rrf", "export", room, "--mitsuba", folder, "-q"], check=True)
    return mi.load_file(str(Path(folder) / "scene.xml"))


def probes():
    table = pq.read_table(ROOT / "tests/data/oracle/cornell_free.parquet")
    p, n = (np.stack([table[a + b].to_numpy() for b in "xyz"], 1).astype(float) for a in "pn")
    some = np.random.default_rng(5).permutation(len(p))[:PROBES]
    return p[some], n[some]


def seen(room, lights):
    """Square roots of the irradiance on each probe, [lights, probes]."""
    out = np.zeros((len(lights), PROBES))
    for j, (p, n) in enumerate(zip(*probes())):
        origin = p + 1e-4 * n
        way = lights - origin
        distance = np.linalg.norm(way, axis=1)
        way /= distance[:, None]
        ray = mi.Ray3f(mi.Point3f(*origin.tolist()), mi.Vector3f(*[mi.Float(w) for w in way.T.astype("<f4")]))
        ray.maxt = mi.Float((0.9999 * distance).astype("<f4"))
        free = ~np.array(room.ray_test(ray))
        out[:, j] = free * np.maximum(way @ n, 0) / distance**2
    return np.sqrt(out)


def fitted(rows, code, file):
    """Lowest mean squared relative error on the rows kept back, mean of the starts, without their noise."""
    base = rows[:, 12:15]
    halves = [rows[:, at : at + 3] / base for at in (18, 21)]
    y = sum(halves) / 2
    s = base / rrf_truth.level(base * y)[:, None]
    offset = (s**2 * y).sum(0) / (s**2).sum(0)
    scale = np.sqrt((s**2 * (y - offset) ** 2).sum(0) / (s**2).sum(0))
    x = np.hstack([rows[:, 0:3], rows[:, 3:6], rows[:, 9:12], code])
    x = x[:, x.std(0) > 1e-5]
    order = np.random.default_rng(1).permutation(len(x))
    train = len(x) * 7 // 10
    kept = order[train:]
    noise = ((s * (halves[0] - halves[1]) / 2) ** 2)[kept].mean()
    x, y, s = x[order], ((y - offset) / scale)[order], (s * scale)[order]
    x = (x - x[:train].mean(0)) / x[:train].std(0)
    sizes, errors = [x.shape[1], 20, 10, 3], []
    for start in STARTS:
        random = np.random.default_rng(start)
        layers = [
            np.hstack([random.uniform(-1, 1, (m, 1)), np.sqrt(3 / n) * random.uniform(-1, 1, (m, n))])
            for n, m in zip(sizes, sizes[1:])
        ]
        write(dict(x=x, y=y, s=s, train=train, w=np.concatenate([l.ravel() for l in layers])), file)
        target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
        command = [target / "release/examples/race", file, str(STEPS), "accelerate", "single"]
        lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
        errors.append(min(float(line.split()[2]) for line in lines) / (3 * len(kept)))
    return np.mean(errors) - noise


def main(run, count="14"):
    run = Path(run)
    last = sorted((run / "rounds").glob("*/judged.json"))[-1]
    cells = json.loads(last.read_text())["judgement"]["cells"]
    share = np.array([cell["measure"] * max(cell["square_error"], 0) for cell in cells])
    drawn = np.random.default_rng(9).choice(len(cells), int(count), replace=False, p=share / share.sum())
    load = lambda cell: rows_of(run / f"samples/cell={cell['cell']:06d}").astype(float)
    errors = {name: [] for name in VARIANTS}
    with tempfile.TemporaryDirectory() as folder:
        room = scene(folder)
        everywhere = seen(room, np.concatenate([load(cell)[:60, 9:12] for cell in cells]))
        mean = everywhere.mean(0)
        axes = np.linalg.svd(everywhere - mean, full_matrices=False)[2]
        for k in drawn:
            rows = load(cells[k])
            rows = rows[(rows[:, 12:15] > 0).all(1)]
            e = seen(room, rows[:, 9:12])
            own = np.linalg.svd(e - e.mean(0), full_matrices=False)[2]
            for name, parts in VARIANTS.items():
                code = (e - e.mean(0)) @ own[:parts].T if name == "own 4" else (e - mean) @ axes[:parts].T
                errors[name].append(fitted(rows, code, Path(folder) / "problem.bin"))
            line = " ".join(f"{name}: {max(e[-1], 0) ** 0.5:.2%}" for name, e in errors.items())
            print(f"cell {cells[k]['cell']}, {len(rows)} rows, {line}", flush=True)
    without = np.array(errors["none"])
    for name, found in errors.items():
        print(f"{name}: {np.sum(found) / without.sum():.3f} of the squared error, median cell {np.median(found / without):.3f}")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(*sys.argv[1:])
