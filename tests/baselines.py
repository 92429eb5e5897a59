"""What simpler methods make of a run's own rows: python3 tests/baselines.py RUN...

Trained on the rows that the nets were trained on, judged by the same held-out rows, by the same measure
(noise-free relative error, weighted by the cells' measure). The nets' line is what the run says of itself.

- nearest: mean of the 8 nearest rows, weighted by inverse squared distance, columns p n v l and material in
  shares of their spread (v left out where all is Lambertian); all rows of the run;
- linear, quadratic: weighted regression of radiance a cell on the same columns (squares and products too);
- mean: one colour a cell;
- probes (Lambertian scenes): a grid of irradiance probes, spherical harmonics up to the second order of the normal at
  6 x 6 x 6 places, each for 4 x 4 x 4 places of the light, trilinear in both; coefficients by least squares on at
  most 150,000 rows, the best of three ridges.

Needs numpy, pyarrow and scipy (`sh tests/peers/setup.sh`). All of them but the mean as whole bakes are
`rrf bake --method`.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import lsmr
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parent / "python"))
import rrf_truth  # noqa: E402
from split import held_out  # noqa: E402

GEOMETRY = [a + b for a in "pnvl" for b in "xyz"]
NEIGHBOURS, QUERIES = 8, 20_000
ROWS, PLACES, LIGHTS = 150_000, 6, 4


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


def corners(x, low, high, count):
    """The eight grid points around each place and their trilinear weights, [rows, 8]."""
    at = np.clip((x - low) / np.maximum(high - low, 1e-9), 0, 1) * (count - 1)
    first = np.minimum(at.astype(int), count - 2)
    share = at - first
    ids, weights = [], []
    for corner in np.ndindex(2, 2, 2):
        place = first + corner
        ids.append((place[:, 0] * count + place[:, 1]) * count + place[:, 2])
        weights.append(np.where(corner, share, 1 - share).prod(1))
    return np.stack(ids, 1), np.stack(weights, 1)


def harmonics(n):
    """Real spherical harmonics up to the second order, but for their constants, [rows, 9]."""
    x, y, z = n.T
    return np.stack([x * 0 + 1, x, y, z, x * y, y * z, x * z, x * x - y * y, 3 * z * z - 1], 1)


def probes(x, y, queries, epsilon):
    """Radiance over base colour from a grid of probes; the predictions of each ridge."""
    column = lambda v, name: v[:, GEOMETRY.index(name) : GEOMETRY.index(name) + 3]
    some = np.random.default_rng(1).permutation(len(x))[:ROWS]
    x, y = x[some], y[some]
    base, lit = (np.maximum(v[:, 12:15], 1e-6) for v in (x, queries))
    bounds = [(column(x, a).min(0), column(x, a).max(0)) for a in ("px", "lx")]

    def matrix(v):
        (p, u), (l, w) = (corners(column(v, a), *b, c) for a, b, c in zip(("px", "lx"), bounds, (PLACES, LIGHTS)))
        ids = (p[:, :, None] * LIGHTS**3 + l[:, None, :])[..., None] * 9 + np.arange(9)
        values = (u[:, :, None] * w[:, None, :])[..., None] * harmonics(column(v, "nx"))[:, None, None, :]
        rows = np.arange(0, ids.size + 1, 8 * 8 * 9)
        shape = (len(v), PLACES**3 * LIGHTS**3 * 9)
        return csr_matrix((values.astype(np.float32).ravel(), ids.astype(np.int32).ravel(), rows), shape)

    weight = base / rrf_truth.level(y, epsilon)[:, None]
    design, asked, found = matrix(x), matrix(queries), {}
    for ridge in (0.1, 0.3, 1.0):
        p = np.zeros((len(queries), 3))
        for c in range(3):
            scaled = diags(weight[:, c].astype(np.float32)) @ design
            p[:, c] = asked @ lsmr(scaled, weight[:, c] * y[:, c] / base[:, c], damp=ridge, maxiter=60)[0]
        found[f"probes, ridge {ridge}"] = p * lit
    return found


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
    w = 1 / rrf_truth.level(y, epsilon)[:, None]
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
        lambert = all(json.loads((run / "rounds/000/plan.json").read_text())["lambert"])
        if lambert:
            x[:, [GEOMETRY.index(n) for n in ("vx", "vy", "vz")]] = 0
        held, mean = held_out(seed, index), y.mean(0)
        count = dict(zip(*np.unique(cell[held], return_counts=True)))
        weight = np.array([measure[c] / count.get(c, 1) for c in cell])
        epsilon = rrf_truth.EPSILON_SHARE * (weight * mean.mean(1))[held].sum() / weight[held].sum()
        some = np.flatnonzero(held)
        some = some[:: max(1, len(some) // QUERIES)]
        train = ~held
        predictions = {"nearest rows": nearest(x[train], mean[train], x[some])}
        if lambert:
            predictions |= probes(x[train], mean[train], x[some], epsilon)
        for degree, name in enumerate(("mean of the cell", "linear regression", "quadratic regression")):
            p = np.zeros((len(some), 3))
            for c in np.unique(cell):
                here, asked = train & (cell == c), cell[some] == c
                if asked.any():
                    p[asked] = regression(x[here], mean[here], x[some][asked], degree, epsilon)
            predictions[name] = p
        print(f"{run}: {len(measure)} cells, {train.sum():,} rows trained on, {len(some):,} held-out rows asked")
        print(f"  nets                  {judged['relative_error']:.2%} ± {judged['relative_error_se']:.2%}")
        level = rrf_truth.level(mean[some], epsilon)
        for name, p in predictions.items():
            error, se = rrf_truth.error(rrf_truth.by_halves(p, y[:, some], level), weight[some])
            print(f"  {name:<21} {error:.2%} ± {se:.2%}")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
