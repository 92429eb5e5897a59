"""How good an estimator is for its time: variance x time at the rows of a points table.

For estimates X_k (k = 1..R, each one independent run of a program) of the radiance m_ic at row i,
channel c, and the median wall time T of a run,

    E = mean over i, c of  Var_k(X_kic) / level(m_i)^2  *  T      [s]

with level as in the relative error (tests/python/rrf_truth.py), m the table's own reference, Var the unbiased variance over runs. E is the time in which the program would reach a
relative variance of 1; it does not depend on the number of paths when those are independent.
Both programs are measured by the spread of their own runs, not by what they say of themselves.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
import rrf_truth  # noqa: E402

POSITION, NORMAL, LIGHT = ("px", "py", "pz"), ("nx", "ny", "nz"), ("lx", "ly", "lz")
VIEWER = ("vx", "vy", "vz")
RADIANCE, ERROR = ("r", "g", "b"), ("r_se", "g_se", "b_se")


def columns(table, names, dtype=np.float64) -> np.ndarray:
    """Columns side by side: shape [rows, len(names)]."""
    return np.stack([np.asarray(table[name], dtype) for name in names], axis=1)


@dataclass
class Points:
    """A points table with reference radiance; see schemas/ for units and frames."""

    path: Path
    position: np.ndarray  # [n, 3] float32
    normal: np.ndarray  # [n, 3] float32, on the viewer's side
    light: np.ndarray  # [n, 3] float32
    material: np.ndarray  # [n] names
    reference: np.ndarray  # [n, 3]
    reference_error: np.ndarray  # [n, 3], standard errors

    @classmethod
    def read(cls, path: Path) -> "Points":
        table = pq.read_table(path)
        sides = (columns(table, NORMAL) * columns(table, VIEWER)).sum(axis=1)
        if not (sides > 0).all():
            behind = (sides <= 0).sum()
            raise ValueError(f"{path}: {behind} rows have the viewer behind the surface")
        position, normal, light = (columns(table, c, np.float32) for c in (POSITION, NORMAL, LIGHT))
        material = np.asarray(table["material"].to_pylist())
        reference, error = columns(table, RADIANCE), columns(table, ERROR)
        return cls(path, position, normal, light, material, reference, error)

    def scale(self) -> np.ndarray:
        """The level of each row's relative error, shape [n, 1]."""
        return rrf_truth.level(self.reference)[:, None]


def relative_variance(runs: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Mean over the channels of Var / scale^2 a row: runs [R, n, 3], scale [n, 1], out [n]."""
    return (runs.var(axis=0, ddof=1) / scale**2).mean(axis=1)


def agreement(runs: np.ndarray, points: Points) -> dict:
    """z-tests of the runs' mean against the table: of the whole, and of groups of 10 rows or more.

    Groups are made by geometry alone (material x quadrant of the light), a test a channel: single
    rows are skewed, and their standard errors from few runs too rough. Passes when the largest
    |z| is below the two-sided normal quantile of 1e-4, Sidak-corrected for the number of tests.
    """
    difference = runs.mean(axis=0) - points.reference
    variance = runs.var(axis=0, ddof=1) / len(runs) + points.reference_error**2
    x, z = points.light[:, 0], points.light[:, 2]
    quadrant = 2 * (x > np.median(x)) + (z > np.median(z))
    parts = [np.full(len(x), True)]
    for name in np.unique(points.material):
        parts += [(points.material == name) & (quadrant == q) for q in range(4)]
    parts = [p for p in parts if p.sum() >= 10]
    scores = [difference[p].sum(axis=0) / np.sqrt(variance[p].sum(axis=0)) for p in parts]
    tests = 3 * len(scores)
    limit = rrf_truth.z_limit(tests)
    largest = float(np.abs(scores).max())
    bias = float(difference.sum() / points.reference.sum())
    return {"passes": largest < limit, "largest_z": largest, "limit": limit, "tests": tests,
            "whole_z": np.round(scores[0], 3).tolist(), "bias": bias}


def ratio_interval(ours, theirs, times, draws: int = 2000) -> tuple[float, float]:
    """95 % interval of mean(ours) / mean(theirs) * time ratio, bootstrapped over rows and runs.

    `ours`, `theirs`: relative variance a row; `times`: wall seconds of the runs, (ours, theirs).
    """
    rng = np.random.default_rng(1)
    ratios = np.empty(draws)
    for i in range(draws):
        rows = rng.integers(0, len(ours), len(ours))
        time = [np.median(rng.choice(t, len(t))) for t in times]
        ratios[i] = ours[rows].mean() / theirs[rows].mean() * time[0] / time[1]
    low, high = np.percentile(ratios, [2.5, 97.5])
    return float(low), float(high)
