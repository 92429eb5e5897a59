//! Counts against expectations: chi-square at a stated significance.

/// P(X > x) of a chi-square variable with `k` degrees of freedom: the regularised upper
/// incomplete gamma function by series or continued fraction (Numerical Recipes, section 6.2).
pub fn chi_square_tail(x: f64, k: f64) -> f64 {
    let (a, x) = (0.5 * k, 0.5 * x);
    if x <= 0.0 {
        return 1.0;
    }
    let scale = (-x + a * x.ln() - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - sum * scale;
    }
    let (mut b, mut c) = (x + 1.0 - a, 1e300);
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..10_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    scale * h
}

/// Lanczos' approximation, g = 7.
fn ln_gamma(x: f64) -> f64 {
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    if x < 0.5 {
        let pi = std::f64::consts::PI;
        return (pi / (pi * x).sin()).ln() - ln_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let t = x + 7.5;
    let sum = (1..9).fold(C[0], |sum, i| sum + C[i] / (x + i as f64));
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// Asserts that counts follow their expectation, among `tests` such tests that together fail
/// by chance once in 10^5 runs. Cells that expect fewer than five are pooled.
pub fn assert_chi_square(name: &str, counts: &[f64], expected: &[f64], tests: usize) {
    let total: f64 = counts.iter().sum();
    let hoped: f64 = expected.iter().sum();
    assert!(
        (total / hoped - 1.0).abs() < 1e-3,
        "{name}: {total} counts, {hoped} expected"
    );
    let (mut statistic, mut cells) = (0.0, 0.0);
    let (mut pool_count, mut pool_expected) = (0.0, 0.0);
    for (&count, &expected) in counts.iter().zip(expected) {
        if expected < 5.0 {
            pool_count += count;
            pool_expected += expected;
        } else {
            statistic += (count - expected).powi(2) / expected;
            cells += 1.0;
        }
    }
    if pool_expected >= 5.0 {
        statistic += (pool_count - pool_expected).powi(2) / pool_expected;
        cells += 1.0;
    } else {
        // Too few for the normal limit: the exact Poisson bound for once in a million.
        assert!(
            pool_count <= 30.0,
            "{name}: {pool_count} where {pool_expected} are expected"
        );
    }
    let p = chi_square_tail(statistic, cells - 1.0);
    let limit = 1.0 - (1.0f64 - 1e-5).powf(1.0 / tests as f64);
    assert!(
        p > limit,
        "{name}: chi-square {statistic:.1} over {cells} cells, p = {p:.2e}"
    );
}
