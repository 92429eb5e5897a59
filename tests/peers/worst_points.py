"""What a table of another renderer can tell, and where it errs:

    sh tests/peers/setup.sh
    .venv-peers/bin/python tests/peers/worst_points.py [free|overhead|glossy] [--paths N]

Traces the table's rows twice by connected paths and judges them as a model is judged (tests/data/oracle/judge_points.py: the
table's stated noise taken out): an exact answer would come to as much. Then the rows that make most of that error, once more by
next-event estimation alone with N paths each, by rrf and, in the Cornell box, by Mitsuba (`llvm_ad_rgb`): the same
estimator as the table's, with more paths.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ORACLE = ROOT / "tests/data/oracle"
sys.path.insert(0, str(HERE))

from efficiency import ERROR, RADIANCE, Points, columns, rrf_truth  # noqa: E402
from pbrt_room import read_room  # noqa: E402

CORNELL = ROOT / "scenes/cornell-box/scene.pbrt"
GLOSSY = ROOT / "scenes/cornell-glossy/cornell-glossy.glb"
SCENES = {"overhead": CORNELL, "free": CORNELL, "glossy": GLOSSY}
RUNS = 16


def traced(args, table, out, paths, seed, estimator):
    """Mean radiance of each row over the channels, and its standard error, by rrf; the file stays in `out`."""
    command = [args.rrf, "trace", SCENES[args.table], "--points", table, "-o", out, "--quiet"]
    command += ["--estimator", estimator, "--spp", paths, "--seed", seed]
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL)
    return both(pq.read_table(out))


def both(table):
    return columns(table, RADIANCE).mean(1), columns(table, ERROR).mean(1)


def mitsuba(args, scene, table):
    """The same by Mitsuba: mean and standard error over RUNS runs."""
    library = ROOT / ".venv-peers/libllvm"
    if "DRJIT_LIBLLVM_PATH" not in os.environ and library.is_file():
        os.environ["DRJIT_LIBLLVM_PATH"] = library.read_text().strip()
    import mitsuba_rays as peer  # after the library is named

    program = peer.WholeTable(read_room(scene), Points.read(table), "independent", args.paths // RUNS)
    runs = np.array([program.run(seed) for seed in range(1, RUNS + 1)]).mean(2)
    return runs.mean(0), runs.std(0, ddof=1) / RUNS**0.5


def squares(table, answer):
    """What each row adds to the squared relative error of `answer`, the table's stated noise taken out."""
    return rrf_truth.less_variance(columns(answer, RADIANCE), columns(table, RADIANCE), columns(table, ERROR))


def error(table, answer):
    root, se = rrf_truth.error(squares(table, answer))
    return f"{root:.2%} ± {se:.2%}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", nargs="?", default="free", choices=SCENES)
    parser.add_argument("--rrf", default=ROOT / "target/release/rrf")
    parser.add_argument("--rows", type=int, default=20)
    parser.add_argument("--paths", type=int, default=1 << 22)
    args = parser.parse_args()
    file, scene = ORACLE / f"cornell_{args.table}.parquet", SCENES[args.table]
    table = pq.read_table(file)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        names = [folder / f"connected-{seed}.parquet" for seed in (1, 2)]
        connected = [traced(args, file, out, 4096, k + 1, "connected") for k, out in enumerate(names)]
        one, two = (pq.read_table(name) for name in names)
        print(f"{args.table}: {len(table)} rows, 4,096 connected paths")
        print(f"  against the table {error(table, one)}, by another seed {error(table, two)}")
        print(f"  one seed against the other {error(two, one)}")
        of_row = squares(table, one)
        worst = np.argsort(-of_row)[: args.rows]
        print(f"  {args.rows} rows make {of_row[worst].sum() / of_row.sum():.0%} of that\n")
        some = folder / "worst.parquet"
        pq.write_table(table.take(worst), some)
        found = {"table": [x[worst] for x in both(table)]}
        out = folder / "next-event.parquet"
        found[f"rrf, {args.paths:,}"] = traced(args, some, out, args.paths, 1, "next-event")
        if scene == CORNELL:
            found[f"Mitsuba, {args.paths:,}"] = mitsuba(args, scene, some)
        found["rrf, connected, 4,096"] = [x[worst] for x in connected[0]]
    print("| row | " + " | ".join(found) + " |\n|---" + "|---" * len(found) + "|")
    for k, row in enumerate(worst):
        cells = [f"{mean[k]:.4g} ± {se[k]:.1g}" for mean, se in found.values()]
        print(f"| {row} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
