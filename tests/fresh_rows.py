"""The error of baked models on rows that nobody trained on, stopped by or trimmed by:
python3 tests/fresh_rows.py [SCENE ...] [--rrf F] [--work DIR] [--rows N] [--paths N]

DIR/SCENE are finished runs, as `tests/accuracy.py` leaves them. Rows are drawn as a bake of one cell draws its own, with
another seed; their radiance is path-traced, two halves of N/2 paths. Held-out rows of a run have also chosen the weights
that are kept and what is trimmed, and may be kind to it: these cannot. Prints the relative error, Monte Carlo noise taken
out, and its standard error. Needs numpy and pyarrow.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from accuracy import HERE, SCENES, run

sys.path.insert(0, str(HERE / "python"))
import rrf_truth  # noqa: E402

POINT = [a + b for a in "pnvl" for b in "xyz"]
SEED = 2


def columns(table, names):
    return np.stack([table[name].to_numpy() for name in names], 1).astype(float)


def drawn(args, name):
    """The fresh rows of a scene, made where they are not there yet."""
    file, box, _, options = SCENES[name][:4]
    folder = args.work / f"{name}-fresh-{args.rows}-{args.paths}"
    if not folder.exists():
        eyes = [option for option in options if str(option).startswith("--eye-box")]
        draw = ["--method", "nets", "--cells", 1, "--rows", args.rows, "--paths", args.paths, "--seed", SEED]
        run([args.rrf, "extract", HERE.parent / file, "-o", folder, f"--light-box={box}", "-q", *draw, *eyes])
    parts = sorted((folder / "samples").rglob("*.parquet"))
    return pa.concat_tables([pq.ParquetFile(part).read() for part in parts]), folder


def judge(args, name, baked):
    rows, folder = drawn(args, name)
    points, answers = folder / "points.parquet", folder / "answers.parquet"
    pq.write_table(rows.select(POINT), points)
    run([args.rrf, "query", baked, "--points", points, "-o", answers, *args.query.split()])
    model = columns(pq.read_table(answers), "rgb")
    halves = [columns(rows, [f"y{half}_{c}" for c in "rgb"]) for half in (0, 1)]
    squares = rrf_truth.by_halves(model, halves, rrf_truth.level(sum(halves) / 2))
    error, se = rrf_truth.error(squares)
    worst = rrf_truth.worst_share(squares)
    print(f"{name}: {error:.2%} ± {se:.2%}, {len(squares)} rows, {worst:.0%} of its square in 1 % of them", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", default=list(SCENES))
    parser.add_argument("--rrf", default=HERE.parent / "target" / "release" / "rrf")
    parser.add_argument("--work", type=Path, default=HERE.parent / "target" / "accuracy")
    parser.add_argument("--run", type=Path, help="a run of the scene in place of DIR/SCENE")
    parser.add_argument("--query", default="", help="further options of rrf query, one text")
    parser.add_argument("--rows", type=int, default=30_000)
    parser.add_argument("--paths", type=int, default=4096)
    args = parser.parse_args()
    for name in args.scenes:
        judge(args, name, args.run or args.work / name)


if __name__ == "__main__":
    main()
