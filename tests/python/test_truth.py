"""The helper of errors and limits against closed forms and something dumber."""

import numpy as np

import rrf_truth as truth


def test_z_limit_is_a_family_limit():
    """With 200 true tests a family, the largest |z| is beyond a 5 % limit in 5 % of the families:
    binomial, in its normal limit, two-sided at 1e-6."""
    rng = np.random.default_rng(5)
    families = 4000
    beyond = (abs(rng.normal(size=(families, 200))).max(1) > truth.z_limit(200, 0.05)).sum()
    assert abs(beyond - 0.05 * families) < 4.9 * (families * 0.05 * 0.95) ** 0.5


def test_relative_error_takes_noise_out():
    """A model off by 10 %, a table with noise of 5 %: 10 % comes out, and not the 11 % of both.

    The noise is in the denominator too: to first order it adds 0.4 E[n mean(n)] / 4 = 3.3e-4 to the
    square of 0.01, 1.7 % of the error."""
    rng = np.random.default_rng(6)
    m = np.full((40_000, 3), 2.0)
    noise = np.full_like(m, 0.1)
    noisy = m + rng.normal(0, noise)
    error, se = truth.relative_error(1.1 * m, noisy, noise)
    assert abs(error - 0.1 * 1.017) < 5 * se + 0.1 * 0.005
    assert truth.relative_error(1.1 * m, noisy, 0 * noise)[0] > 0.11


def test_srgb_is_the_standards():
    """Continuous at the joint, and colour's values at 0, 0.5, 1."""
    assert np.allclose(truth.srgb(np.array([0.0, 0.5, 1.0])), [0, 0.7353569830524495, 1])
    below, above = truth.srgb(np.array([0.0031308 - 1e-9, 0.0031308 + 1e-9]))
    assert abs(above - below) < 1e-6


def test_halves_give_the_error_and_the_noise():
    """An answer off by a tenth of a truth of 1, halves with uniform noise of a variance of 1/12."""
    rng = np.random.default_rng(7)
    halves = 0.5 + rng.uniform(size=(2, 40_000, 3))
    level = np.ones(40_000)
    squares = truth.by_halves(np.full((40_000, 3), 1.1), halves, level)
    error, se = truth.error(squares)
    assert abs(error - 0.1) < 5 * se
    assert abs(truth.error(squares, np.full(40_000, 3.0))[0] - error) < 1e-12
    # the mean of the halves has half of a half's variance; 5 standard errors of 120,000 numbers
    noise = truth.noise_of_halves(halves, level)
    assert abs(noise.mean() - 1 / 24) < 5 * noise.std() / len(noise) ** 0.5


def test_dark_rows_count_by_epsilon():
    """Greys 1 and 0.01, below ε = 0.05 · 0.505, off by 0.1 and 0.02: the formula by hand."""
    m, p = np.array([[1.0] * 3, [0.01] * 3]), np.array([[1.1] * 3, [0.03] * 3])
    wanted = ((0.1**2 + (0.02 / 0.02525) ** 2) / 2) ** 0.5
    assert abs(truth.relative_error(p, m, 0 * m)[0] - wanted) < 1e-12


def test_worst_rows_have_their_share():
    """The two worst of 200 rows with errors 0.01 to 2.00."""
    squares = (0.01 * np.arange(1, 201)) ** 2
    assert abs(truth.worst_share(squares) - (2.0**2 + 1.99**2) / squares.sum()) < 1e-12
