use super::*;
use crate::Stage;

/// First points of `scipy.stats.qmc.Sobol(10, scramble=False).random(8)` (SciPy 1.17), an
/// implementation of the same Joe-Kuo tables by other people. SciPy walks in Gray-code order,
/// which permutes each block of 8.
#[test]
fn unscrambled_points_equal_scipys() {
    let scipy: &str = include_str!("../../../../tests/data/sobol_scipy.csv");
    for (i, line) in (0u32..).zip(scipy.lines()) {
        let gray = i ^ (i >> 1);
        for (d, theirs) in line.split(',').enumerate() {
            let theirs: f64 = theirs.parse().unwrap();
            let ours = reversed(gray, d).reverse_bits();
            assert_eq!(f64::from(ours) / 4_294_967_296.0, theirs, "{i}, {d}");
        }
    }
}

/// The first points of the published sequence (Joe and Kuo, new-joe-kuo-6.21201).
#[test]
fn first_points_are_the_published_ones() {
    let published = [
        [0.0, 0.0, 0.0, 0.0],
        [0.5, 0.5, 0.5, 0.5],
        [0.75, 0.25, 0.25, 0.25],
        [0.25, 0.75, 0.75, 0.75],
        [0.375, 0.375, 0.625, 0.875],
        [0.875, 0.875, 0.125, 0.375],
        [0.625, 0.125, 0.875, 0.625],
        [0.125, 0.625, 0.375, 0.125],
    ];
    for (i, row) in (0u32..).zip(&published) {
        let gray = i ^ (i >> 1);
        for (d, x) in row.iter().enumerate() {
            let found = unit(reversed(gray, d).reverse_bits());
            assert_eq!(found, *x, "point {i}, dimension {d}");
        }
    }
}

/// Of 2^m consecutive points, every dimension has one in each of 2^m equal intervals, and the
/// first two have one in each elementary rectangle; scrambling keeps that.
#[test]
fn points_are_stratified_scrambled_or_not() {
    let table = Table::new(256);
    let words = Stream::new(1, Stage::Test, 0).block(0, 0, 0);
    for [seed, shift] in [[0, 0], [words[0], words[1]], [words[2], words[3]]] {
        let by = |d: usize| [seed.wrapping_add(d as u32 * 77), shift];
        let place = |i: usize, d: usize, bits: u32| {
            let plain = unit(table.reversed(i)[d].reverse_bits());
            let scrambled = scramble(table.reversed(i)[d], by(d));
            let x = if seed == 0 { plain } else { scrambled };
            (x * (1u32 << bits) as f32) as usize
        };
        for d in 0..DIMENSIONS {
            let mut seen = [0; 256];
            (0..256).for_each(|i| seen[place(i, d, 8)] += 1);
            assert!(seen.iter().all(|&n| n == 1), "dimension {d}");
        }
        for bits in 0..=8 {
            let mut seen = [0; 256];
            for i in 0..256 {
                seen[place(i, 0, bits) << (8 - bits) | place(i, 1, 8 - bits)] += 1;
            }
            assert!(seen.iter().all(|&n| n == 1), "{bits} bits of the first");
        }
    }
}

/// One point, many scrambles: every value as often as any other. Chi-square over 64 bins; the
/// 99.9999 % point for 63 degrees of freedom is 130.4.
#[test]
fn scrambled_points_are_uniform() {
    for i in [0, 1, 5] {
        let mut bins = [0u32; 64];
        for k in 0..65_536 {
            let words = Stream::new(2, Stage::Test, 0).block(k, 0, 0);
            let x = scramble(reversed(i, 3), [words[0], words[1]]);
            bins[(x * 64.0) as usize] += 1;
        }
        let square = |&n: &u32| (f64::from(n) - 1024.0).powi(2) / 1024.0;
        let chi2: f64 = bins.iter().map(square).sum();
        assert!(chi2 < 130.4, "point {i}: {chi2}");
    }
}

/// Owen scrambling keeps the net: every dyadic interval of a block of 2^k holds one point.
#[test]
fn sequences_stay_stratified() {
    let sequence = Sequence::new(99);
    for d in 0..Sequence::DIMENSIONS {
        let mut seen = [false; 256];
        for i in 0..256 {
            let interval = (sequence.point(i)[d] * 256.0) as usize;
            assert!(!seen[interval], "dimension {d}, interval {interval} twice");
            seen[interval] = true;
        }
    }
}

/// The means of independent sequences are unbiased: a z-test over 400 seeds of the mean of x*y
/// over 64 points, whose expectation is 1/4 (two-sided, 1e-5).
#[test]
fn sequences_are_unbiased() {
    for (a, b) in [(0, 1), (3, 4), (5, 7), (2, 6)] {
        let mean = |seed: u64| {
            let sequence = Sequence::new(seed);
            let product = |p: [f32; Sequence::DIMENSIONS]| f64::from(p[a]) * f64::from(p[b]);
            (0..64).map(|i| product(sequence.point(i))).sum::<f64>() / 64.0
        };
        let means: Vec<f64> = (0..400).map(mean).collect();
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let var = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let z = (mean - 0.25) / (var / n).sqrt();
        assert!(z.abs() < 4.42, "dimensions {a}, {b}: z = {z}");
    }
}
