use super::*;

/// Small integers: products and their sums are exact in every kind of number.
fn lanes(n: usize, times: usize) -> Vec<TileLane> {
    let value = |j: usize, i: usize| ((j * 31 + i) * times % 17) as f64 - 8.0;
    (0..n)
        .map(|j| std::array::from_fn(|i| value(j, i)))
        .collect()
}

/// Every factor against the loop that it stands for, for widths around those of whole vectors.
fn equal_their_loops<T: Real + Into<f64>>() {
    let room = |ld: usize| vec![T::default(); ld * TILE_ROWS + STEP];
    let check = |out: &[T], ld: usize, at: usize, row: usize, expected: f64| {
        assert_eq!(out[row * ld + at].into(), expected);
    };
    for (n, m) in [
        (1, 3),
        (7, 8),
        (11, 16),
        (16, 9),
        (21, 10),
        (33, 17),
        (50, 5),
    ] {
        let (y, z) = (lanes(n, 3), lanes(m, 5));
        let pack = |lanes: &[TileLane]| {
            let mut packed = Packed::<T>::new(lanes.len() + 1).with_ones();
            packed.set(1, lanes);
            packed
        };
        let (by, bz) = (pack(&y), pack(&z));
        let with_one = |lanes: &[TileLane], j: usize, row: usize| {
            if j == 0 { 1.0 } else { lanes[j - 1][row] }
        };
        let ld = (n + 1) * (m + 1);
        let mut out = room(ld);
        T::outer((&by, n + 1), (&bz, m + 1), TILE_ROWS, ld, &mut out);
        for row in 0..TILE_ROWS {
            for at in 0..ld {
                let (j, k) = (at / (m + 1), at % (m + 1));
                check(
                    &out,
                    ld,
                    at,
                    row,
                    with_one(&y, j, row) * with_one(&z, k, row),
                );
            }
        }
        let pairs: Vec<_> = (0..=n).flat_map(|j| (j..=n).map(move |k| (j, k))).collect();
        let mut out = room(pairs.len());
        T::upper(&by, n + 1, TILE_ROWS, pairs.len(), &mut out);
        for row in 0..TILE_ROWS {
            for (at, &(j, k)) in pairs.iter().enumerate() {
                check(
                    &out,
                    pairs.len(),
                    at,
                    row,
                    with_one(&y, j, row) * with_one(&y, k, row),
                );
            }
        }
        check_channels::<T>(n, m);
    }
}

fn check_channels<T: Real + Into<f64>>(n: usize, m: usize) {
    let (y, z) = (lanes(CHANNELS * n, 3), lanes(CHANNELS * m, 5));
    let pack = |lanes: &[TileLane]| {
        let mut packed = Packed::<T>::new(lanes.len());
        packed.set(0, lanes);
        packed
    };
    let all: Vec<_> = (0..n).flat_map(|j| (0..m).map(move |k| (j, k))).collect();
    let upper: Vec<_> = (0..n).flat_map(|j| (j..n).map(move |k| (j, k))).collect();
    for (pairs, z, m, triangular) in [(all, &z, m, false), (upper, &y, n, true)] {
        let ld = pairs.len();
        let mut out = vec![T::default(); ld * TILE_ROWS + STEP];
        T::over_channels(
            (&pack(&y), n),
            (&pack(z), m),
            triangular,
            TILE_ROWS,
            ld,
            &mut out,
        );
        for row in 0..TILE_ROWS {
            for (at, &(j, k)) in pairs.iter().enumerate() {
                let product = |c: usize| y[c * n + j][row] * z[c * m + k][row];
                let expected: f64 = (0..CHANNELS).map(product).sum();
                assert_eq!(out[row * ld + at].into(), expected);
            }
        }
    }
}

#[test]
fn factors_equal_their_loops() {
    equal_their_loops::<f64>();
    equal_their_loops::<f32>();
}
