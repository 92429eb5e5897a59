"""What simpler methods make of a run's own rows: python3 tests/baselines.py RUN...

Trained on the rows that the nets were trained on, judged by the same held-out rows, by the same measure
(noise-free relative error, weighted by the cells' measure). The nets' line is what the run says of itself.

- nearest: mean of the 8 nearest rows, weighted by inverse squared distance, columns p n v l and material in
  shares of their spread (v left out where all is Lambertian); all rows of the run;
- linear, quadratic: weighted regression of radiance a cell on the same columns (squares and products too);
- mean: one colour a cell.

Needs numpy, pyarrow and scipy. Linear outputs, one global net and linear regression as whole bakes are
`rrf bake --method`.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parent / "python"))
from split import held_out  # noqa: E402

GEOMETRY = [a + b for a in "pnvl" for b in "xyz"]
NEIGHBOURS, QUERIES, FLOOR = 8, 20_000, 0.05


def load(run):
    material = ["base_r", "base_g", "base_b", "roughness", "metallic", "specular"]
    names = ["cell_id", "sample_index", *GEOMETRY, *material]
    names += [f"y{h}_{c}" for h in (0, 1) for c in "rgb"]
    files = sorted((run / "samples").rglob("*.parquet"))
    table = pa.concat_tables([pq.ParquetFile(f).read(names) for f in files])
    stack = lambda names: np.stack([table[n].to_numpy() for n in names], 1).astype(float)
    y = np.stack([stack([f"y{h}_{c}" for c in "rgb"]) for h in (0, 1)])
    return table["cell_id"].to_numpy(), table["sample_index"].to_numpy(), stack(GEOMETRY + material), y


def nearest(x, y, queries):
    spread = x.std(0)
    keep = spread > 1e-6
    tree = cKDTree(x[:, keep] / spread[keep])
    distance, rows = tree.query(queries[:, keep] / spread[keep], NEIGHBOURS, eps=0.5)
    weight = 1 / (distance**2 + 1e-9)
    return (weight[..., None] * y[rows]).sum(1) / weight.sum(1)[:, None]


def terms(x, degree):
    columns = [np.ones(len(x))]
    if degree >= 1:
        columns += list(x.T)
    if degree == 2:
        columns += [x[:, i] * x[:, j] for i in range(x.shape[1]) for j in range(i, x.shape[1])]
    return np.stack(columns, 1)


def regression(x, y, queries, degree, epsilon):
    low, spread = x.mean(0), x.std(0)
    keep = spread > 1e-6
    a, b = (terms((v[:, keep] - low[keep]) / spread[keep], degree) for v in (x, queries))
    w = 1 / np.maximum(y.mean(1), epsilon)[:, None]
    matrix = (a * w).T @ (a * w)
    matrix[np.diag_indices(len(matrix))] += 1e-6 * np.trace(matrix) / len(matrix)
    return b @ np.linalg.solve(matrix, (a * w).T @ (y * w))


def main(runs):
    for run in map(Path, runs):
        seed = json.loads((run / "run.json").read_text())["seed"]
        last = sorted((run / "rounds").glob("*/judged.json"))[-1]
        judged = json.loads(last.read_text())["judgement"]
        measure = {c["cell"]: c["measure"] for c in judged["cells"]}
        cell, index, x, y = load(run)
        if all(json.loads((run / "rounds/000/plan.json").read_text())["lambert"]):
            x[:, [GEOMETRY.index(n) for n in ("vx", "vy", "vz")]] = 0
        held, mean = held_out(seed, index), y.mean(0)
        count = dict(zip(*np.unique(cell[held], return_counts=True)))
        weight = np.array([measure[c] / count.get(c, 1) for c in cell])
        epsilon = FLOOR * (weight * mean.mean(1))[held].sum() / weight[held].sum()
        some = np.flatnonzero(held)
        some = some[:: max(1, len(some) // QUERIES)]
        train = ~held
        predictions = {"nearest rows": nearest(x[train], mean[train], x[some])}
        for degree, name in enumerate(("mean of the cell", "linear regression", "quadratic regression")):
            p = np.zeros((len(some), 3))
            for c in np.unique(cell):
                here, asked = train & (cell == c), cell[some] == c
                if asked.any():
                    p[asked] = regression(x[here], mean[here], x[some][asked], degree, epsilon)
            predictions[name] = p
        print(f"{run}: {len(measure)} cells, {train.sum():,} rows trained on, {len(some):,} held-out rows asked")
        print(f"  nets                  {judged['relative_error']:.2%} ± {judged['relative_error_se']:.2%}")
        w = weight[some] / weight[some].sum()
        divisor = np.maximum(mean[some].mean(1), epsilon)
        for name, p in predictions.items():
            e = ((p - y[0][some]) * (p - y[1][some])).mean(1) / divisor**2
            square, se = (w * e).sum(), (w**2 * (e - (w * e).sum()) ** 2).sum() ** 0.5
            root = max(square, 0) ** 0.5
            print(f"  {name:<21} {root:.2%} ± {se / max(2 * root, 1e-9):.2%}")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
