//! Sobol points with nested uniform (Owen) scrambling.
//!
//! Direction numbers: Joe and Kuo, *Constructing Sobol sequences with better two-dimensional
//! projections*, SIAM J. Sci. Comput. 2008. Scrambling by hashing: Laine and Karras, EGSR 2011,
//! constants of Burley, *Practical Hash-based Owen Scrambling*, JCGT 2020; a random digital shift
//! on top makes every point exactly uniform whatever the quality of the hash.

/// How many dimensions there are.
pub const DIMENSIONS: usize = 12;

/// Degree, polynomial and first direction numbers of dimensions 2 to 12.
const JOE_KUO: [(usize, u32, [u32; 5]); DIMENSIONS - 1] = [
    (1, 0, [1, 0, 0, 0, 0]),
    (2, 1, [1, 3, 0, 0, 0]),
    (3, 1, [1, 3, 1, 0, 0]),
    (3, 2, [1, 1, 1, 0, 0]),
    (4, 1, [1, 1, 3, 3, 0]),
    (4, 4, [1, 3, 5, 13, 0]),
    (5, 2, [1, 1, 5, 5, 17]),
    (5, 4, [1, 1, 5, 5, 5]),
    (5, 7, [1, 1, 7, 11, 19]),
    (5, 11, [1, 1, 5, 1, 1]),
    (5, 13, [1, 1, 1, 3, 11]),
];

/// The first points of the plain sequence, bits reversed (the first digit lowest), as the
/// scrambling wants them.
#[derive(Clone, Debug)]
pub struct Table {
    points: Vec<[u32; DIMENSIONS]>,
}

/// What scrambles one dimension: a seed of the hash and a digital shift, both random.
pub type Scramble = [u32; 2];

impl Table {
    /// The first `count` points.
    pub fn new(count: usize) -> Table {
        let directions: [[u32; 32]; DIMENSIONS] = std::array::from_fn(directions);
        let point = |index: usize| {
            std::array::from_fn(|d| {
                let digits = directions[d].iter().enumerate();
                let used = digits.filter(|(bit, _)| index >> bit & 1 == 1);
                used.fold(0u32, |x, (_, direction)| x ^ direction)
                    .reverse_bits()
            })
        };
        Table {
            points: (0..count).map(point).collect(),
        }
    }

    /// Point `index`, unscrambled and bits reversed; past the end it starts again.
    #[inline(always)]
    pub fn reversed(&self, index: usize) -> &[u32; DIMENSIONS] {
        const ZERO: [u32; DIMENSIONS] = [0; DIMENSIONS];
        self.points
            .get(index % self.points.len().max(1))
            .unwrap_or(&ZERO)
    }
}

/// A coordinate in [0, 1) from a reversed one: each digit is flipped by a hash of the digits
/// above it.
#[inline(always)]
pub fn scramble(reversed: u32, [seed, shift]: Scramble) -> f32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    crate::rng::unit(x.reverse_bits() ^ shift)
}

fn directions(d: usize) -> [u32; 32] {
    let Some(&(degree, polynomial, first)) = d.checked_sub(1).and_then(|d| JOE_KUO.get(d)) else {
        return std::array::from_fn(|i| 1 << (31 - i));
    };
    let mut v = [0u32; 32];
    for i in 0..32 {
        v[i] = if i < degree {
            first[i] << (31 - i)
        } else {
            let feedback = (1..degree).filter(|k| polynomial >> (degree - 1 - k) & 1 == 1);
            feedback.fold(v[i - degree] ^ (v[i - degree] >> degree), |x, k| {
                x ^ v[i - k]
            })
        };
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    /// Of 2^m consecutive points, every dimension has one in each of 2^m equal intervals, and
    /// the first two have one in each elementary rectangle; scrambling keeps that.
    #[test]
    fn points_are_stratified_scrambled_or_not() {
        let table = Table::new(256);
        let words = Stream::new(1, 0, 0).block(0, 0, 0);
        for [seed, shift] in [[0, 0], [words[0], words[1]], [words[2], words[3]]] {
            let by = |d: usize| [seed.wrapping_add(d as u32 * 77), shift];
            let place = |i: usize, d: usize, bits: u32| {
                let plain = crate::rng::unit(table.reversed(i)[d].reverse_bits());
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
                assert!(
                    seen.iter().all(|&n| n == 1),
                    "{bits} bits of the first dimension"
                );
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
        // The table is in the order of the index, the published one in that of its Gray code.
        let table = Table::new(8);
        for (i, row) in published.iter().enumerate() {
            let gray = i ^ (i >> 1);
            for (d, x) in row.iter().enumerate() {
                let found = crate::rng::unit(table.reversed(gray)[d].reverse_bits());
                assert_eq!(found, *x, "point {i}, dimension {d}");
            }
        }
    }

    /// One point, many scrambles: every value as often as any other. Chi-square over 64 bins;
    /// the 99.9999 % point for 63 degrees of freedom is 130.4.
    #[test]
    fn scrambled_points_are_uniform() {
        let table = Table::new(8);
        for i in [0, 1, 5] {
            let mut bins = [0u32; 64];
            for k in 0..65_536 {
                let words = Stream::new(2, 0, 0).block(k, 0, 0);
                let x = scramble(table.reversed(i)[3], [words[0], words[1]]);
                bins[(x * 64.0) as usize] += 1;
            }
            let square = |&n: &u32| (f64::from(n) - 1024.0).powi(2) / 1024.0;
            let chi2: f64 = bins.iter().map(square).sum();
            assert!(chi2 < 130.4, "point {i}: {chi2}");
        }
    }
}
