"""One definition of every error that Python tells, as pipeline/metrics has it in Rust, and of the limits of tests.

Rows are radiance in three channels, arrays of shape [rows, 3]: p the answer, m the truth or its estimate. Squares are
one number a row, `error` makes one figure of them.
"""

import json
from statistics import NormalDist

import numpy as np

EPSILON_SHARE = 0.05
FORMULA = "sqrt(mean((p - m)² / max(c(m), ε)²)), c the mean of the three channels, ε = 5 % of the mean of c"


def channel_mean(rgb) -> np.ndarray:
    """The mean of the three channels, shape [rows]."""
    return rgb.mean(-1)


def level(m, epsilon=None) -> np.ndarray:
    """max(c(m), ε) of each row, which its errors are divided by, shape [rows]; ε of these rows unless given."""
    c = channel_mean(m)
    return np.maximum(c, EPSILON_SHARE * c.mean() if epsilon is None else epsilon)


def by_halves(p, halves, level) -> np.ndarray:
    """Squared relative errors against two independent half estimates, [2, rows, 3], free of their noise."""
    return channel_mean((p - halves[0]) * (p - halves[1])) / level**2


def less_variance(p, m, se) -> np.ndarray:
    """Squared relative errors against estimates with known standard errors, free of their noise."""
    return channel_mean((p - m) ** 2 - se**2) / level(m) ** 2


def noise_of_halves(halves, level) -> np.ndarray:
    """Squared relative noise of the mean of two halves, [2, rows, 3]: half their difference has its variance."""
    return channel_mean(((halves[0] - halves[1]) / 2) ** 2) / level**2


def error(squares, weights=None) -> tuple[float, float]:
    """The root of the mean of squares, 0 where noise makes it negative, and its standard error to first order.

    `weights`: what each row counts; alike unless given."""
    if weights is None:
        square, se = squares.mean(), squares.std(ddof=1) / len(squares) ** 0.5
    else:
        w = weights / weights.sum()
        square = (w * squares).sum()
        se = (w**2 * (squares - square) ** 2).sum() ** 0.5
    root = max(float(square), 0.0) ** 0.5
    return root, float(se) / max(2 * root, 1e-9)


def relative_error(p, m, se) -> tuple[float, float]:
    """The relative error against estimates with standard errors `se`, their noise taken out, and its standard error."""
    return error(less_variance(p, m, se))


def worst_share(squares, share=0.01) -> float:
    """The share of the squared error that the worst rows make, 1 % of them unless another share is given."""
    return np.sort(squares)[::-1][: -int(-len(squares) * share // 1)].sum() / squares.sum()


def measures(comparison: str) -> dict[str, float]:
    """The figures of `rrf compare --json`, by name."""
    return {m["name"]: m["value"] for m in json.loads(comparison)["measures"]}


def shown(picture, stops) -> np.ndarray:
    """Linear [0, 1] that a display emits: exposure, clip. What `rrf compare` judges."""
    return np.clip(picture * 2.0**stops, 0, 1)


def srgb(linear) -> np.ndarray:
    """sRGB encoding (IEC 61966-2-1) of linear values in [0, 1]."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-12) ** (1 / 2.4) - 0.055)


def z_limit(tests: int, significance: float = 1e-4) -> float:
    """Two-sided normal limit for the largest of `tests` |z|, Sidak-corrected."""
    each = 1 - (1 - significance) ** (1 / tests)
    return NormalDist().inv_cdf(1 - each / 2)
