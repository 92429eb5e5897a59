//! Owen-scrambled Sobol points: evenly spread in every dimension and every pair.
//!
//! Direction numbers: Joe and Kuo, *Constructing Sobol sequences with better
//! two-dimensional projections*, SIAM J. Sci. Comput. 2008. Nested uniform scrambling by
//! hashing: Laine and Karras 2011, with the constants of Burley, *Practical hash-based Owen
//! scrambling*, JCGT 2020.

/// How many dimensions there are.
pub const DIMENSIONS: usize = 8;

/// Degree, polynomial and first direction numbers of dimensions 2 to 8.
const JOE_KUO: [(usize, u32, [u32; 5]); DIMENSIONS - 1] = [
    (1, 0, [1, 0, 0, 0, 0]),
    (2, 1, [1, 3, 0, 0, 0]),
    (3, 1, [1, 3, 1, 0, 0]),
    (3, 2, [1, 1, 1, 0, 0]),
    (4, 1, [1, 1, 3, 3, 0]),
    (4, 4, [1, 3, 5, 13, 0]),
    (5, 2, [1, 1, 5, 5, 17]),
];

/// A scrambled sequence in [`DIMENSIONS`] dimensions; one seed, one sequence.
#[derive(Clone, Debug)]
pub struct Sobol {
    directions: [[u32; 32]; DIMENSIONS],
    seeds: [u32; DIMENSIONS],
    shuffle: u32,
}

impl Sobol {
    /// The sequence of `seed`.
    pub fn new(seed: u64) -> Sobol {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z ^ (z >> 31)) as u32
        };
        Sobol {
            directions: std::array::from_fn(directions),
            seeds: std::array::from_fn(|_| next()),
            shuffle: next(),
        }
    }

    /// Point `index`, each coordinate in [0, 1).
    pub fn point(&self, index: u32) -> [f32; DIMENSIONS] {
        let index = scramble(index, self.shuffle);
        std::array::from_fn(|d| unit(scramble(self.raw(index, d), self.seeds[d])))
    }

    /// Coordinate `d` of the unscrambled sequence as a 32-bit binary fraction.
    fn raw(&self, index: u32, d: usize) -> u32 {
        let mut bits = index;
        let mut x = 0;
        for direction in &self.directions[d] {
            if bits & 1 == 1 {
                x ^= direction;
            }
            bits >>= 1;
        }
        x
    }
}

/// 24 bits of a binary fraction, so that the result stays below 1 in f32.
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

fn directions(d: usize) -> [u32; 32] {
    let mut v = [0u32; 32];
    if d == 0 {
        for (i, v) in v.iter_mut().enumerate() {
            *v = 1 << (31 - i);
        }
        return v;
    }
    let (degree, polynomial, first) = JOE_KUO[d - 1];
    for i in 0..32 {
        v[i] = if i < degree {
            first[i] << (31 - i)
        } else {
            let mut x = v[i - degree] ^ (v[i - degree] >> degree);
            for k in 1..degree {
                if polynomial >> (degree - 1 - k) & 1 == 1 {
                    x ^= v[i - k];
                }
            }
            x
        };
    }
    v
}

/// Nested uniform scramble of a binary fraction: a digit's flip depends on the digits above it.
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First points of `scipy.stats.qmc.Sobol(10, scramble=False).random(8)` (SciPy 1.17),
    /// an implementation of the same Joe-Kuo tables by other people.
    /// SciPy walks in Gray-code order, which permutes each block of 8.
    #[test]
    fn unscrambled_points_equal_scipys() {
        let scipy: &str = include_str!("../../../tests/data/sobol_scipy.csv");
        let theirs: Vec<Vec<f64>> = scipy
            .lines()
            .map(|l| l.split(',').map(|x| x.parse().unwrap()).collect())
            .collect();
        let sobol = Sobol::new(1);
        for (i, theirs) in theirs.iter().enumerate() {
            let gray = (i ^ (i >> 1)) as u32;
            for (d, &theirs) in theirs.iter().enumerate().take(DIMENSIONS) {
                let ours = f64::from(sobol.raw(gray, d)) / 4_294_967_296.0;
                assert_eq!(ours, theirs, "point {i}, dimension {d}");
            }
        }
    }

    /// Owen scrambling keeps the net: every dyadic interval of a block of 2^k holds one point.
    #[test]
    fn each_dimension_stays_stratified() {
        let sobol = Sobol::new(99);
        for d in 0..DIMENSIONS {
            let mut seen = [false; 256];
            for i in 0..256 {
                let cell = (sobol.point(i)[d] * 256.0) as usize;
                assert!(!seen[cell], "dimension {d}, interval {cell} twice");
                seen[cell] = true;
            }
        }
    }

    /// The means of independent scrambles are unbiased: a z-test over 400 seeds of the mean of
    /// x*y over 64 points, whose expectation is 1/4 (two-sided, 1e-5).
    #[test]
    fn scrambles_are_unbiased() {
        for (a, b) in [(0, 1), (3, 4), (5, 7), (2, 6)] {
            let means: Vec<f64> = (0..400)
                .map(|seed| {
                    let sobol = Sobol::new(seed);
                    (0..64)
                        .map(|i| {
                            let p = sobol.point(i);
                            f64::from(p[a]) * f64::from(p[b])
                        })
                        .sum::<f64>()
                        / 64.0
                })
                .collect();
            let n = means.len() as f64;
            let mean = means.iter().sum::<f64>() / n;
            let var = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let z = (mean - 0.25) / (var / n).sqrt();
            assert!(z.abs() < 4.42, "dimensions {a}, {b}: z = {z}");
        }
    }
}
