//! Random numbers, chi-square and integrals over the sphere that tests decide by.

use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// Numbers in [0, 1) from a seed: SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn pair(&mut self) -> [f32; 2] {
        [self.unit(), self.unit()]
    }
}

/// P(X > x) of a chi-square variable with `k` degrees of freedom: Wilson and Hilferty's cube
/// root, good to a few hundredths at the hundreds of degrees used here.
pub fn chi_square_tail(x: f64, k: f64) -> f64 {
    let c = 2.0 / (9.0 * k);
    let z = ((x / k).cbrt() - (1.0 - c)) / c.sqrt();
    0.5 * erfc(z / std::f64::consts::SQRT_2)
}

/// Complementary error function by its continued fraction and series (Abramowitz and Stegun
/// 7.1.6 and 7.1.14).
fn erfc(x: f64) -> f64 {
    if x < 0.0 {
        return 2.0 - erfc(-x);
    }
    if x < 2.0 {
        let (mut term, mut sum) = (x, x);
        for n in 1..200 {
            term *= 2.0 * x * x / f64::from(2 * n + 1);
            sum += term;
        }
        return 1.0 - 2.0 / TAU.sqrt() * std::f64::consts::SQRT_2 * sum * (-x * x).exp();
    }
    let mut fraction = x;
    for n in (1..80).rev() {
        fraction = x + 0.5 * f64::from(n) / fraction;
    }
    (-x * x).exp() / fraction / (TAU / 2.0).sqrt()
}

pub const RINGS: usize = 32;
pub const SECTORS: usize = 64;

/// A part of the sphere as a box in (z, azimuth) about an axis.
#[derive(Clone, Copy)]
pub struct Patch {
    pub axis: Vec3,
    /// 1 - cos of the half angle that is covered; 2 for the whole sphere.
    pub spread: f64,
}

impl Patch {
    pub const SPHERE: Patch = Patch {
        axis: Vec3::Z,
        spread: 2.0,
    };

    /// A direction by 1 - z in units of the spread and a turn, both in [0, 1].
    fn direction(&self, drop: f64, turn: f64) -> Vec3 {
        let z = drop * self.spread;
        let radius = (z * (2.0 - z)).max(0.0).sqrt();
        let (sine, cosine) = (TAU * turn).sin_cos();
        let local = DVec3::new(radius * cosine, radius * sine, 1.0 - z);
        let (x, y) = self.axis.as_dvec3().any_orthonormal_pair();
        let w = x * local.x + y * local.y + self.axis.as_dvec3() * local.z;
        w.normalize().as_vec3()
    }

    fn cell(&self, d: Vec3) -> Option<usize> {
        let (d, axis) = (d.as_dvec3(), self.axis.as_dvec3());
        let (x, y) = axis.any_orthonormal_pair();
        let drop = 0.5 * (d - axis).length_squared() / self.spread;
        let turn = d.dot(y).atan2(d.dot(x)) / TAU;
        let ring = (drop * RINGS as f64) as usize;
        let sector = ((turn - turn.floor()) * SECTORS as f64) as usize;
        (ring < RINGS).then(|| ring * SECTORS + sector.min(SECTORS - 1))
    }

    /// Integral of a density over every cell by midpoints, `fine` a side.
    pub fn integrate(&self, fine: usize, density: impl Fn(Vec3) -> f64) -> Vec<f64> {
        let angle = self.spread * TAU / (RINGS * SECTORS * fine * fine) as f64;
        let cell = |ring: usize, sector: usize| -> f64 {
            let place = |k: usize, i: usize, n: usize| {
                (k as f64 + (i as f64 + 0.5) / fine as f64) / n as f64
            };
            let points = (0..fine * fine).map(|p| {
                let drop = place(ring, p / fine, RINGS);
                density(self.direction(drop, place(sector, p % fine, SECTORS)))
            });
            points.sum::<f64>() * angle
        };
        let cells = (0..RINGS).flat_map(|r| (0..SECTORS).map(move |s| (r, s)));
        cells.map(|(r, s)| cell(r, s)).collect()
    }
}

/// Draws directions and compares how often each cell is met with the density's integral over
/// it, cells of fewer than five expected pooled; significance 1e-6 a test, seed fixed. Gives the
/// density's integral over the patch.
pub fn chi_square(
    name: &str,
    patch: Patch,
    fine: usize,
    density: impl Fn(Vec3) -> f64,
    mut draw: impl FnMut([f32; 2]) -> Option<Vec3>,
) -> f64 {
    const DRAWS: usize = 200_000;
    let expected = patch.integrate(fine, density);
    let mut counts = vec![0.0; expected.len()];
    let (mut random, mut outside) = (Random(20), 0.0);
    for _ in 0..DRAWS {
        match draw(random.pair()).and_then(|d| patch.cell(d)) {
            Some(cell) => counts[cell] += 1.0,
            None => outside += 1.0,
        }
    }
    let total: f64 = expected.iter().sum();
    let mut pooled = [outside, (1.0 - total).max(0.0) * DRAWS as f64];
    let (mut sum, mut cells) = (0.0, 0.0);
    for (count, share) in counts.iter().zip(&expected) {
        let expected = share * DRAWS as f64;
        if expected < 5.0 {
            pooled = [pooled[0] + count, pooled[1] + expected];
        } else {
            sum += (count - expected) * (count - expected) / expected;
            cells += 1.0;
        }
    }
    if pooled[1] >= 5.0 {
        sum += (pooled[0] - pooled[1]) * (pooled[0] - pooled[1]) / pooled[1];
        cells += 1.0;
    } else {
        assert!(
            pooled[0] < 25.0,
            "{name}: {pooled:?} where nothing is expected"
        );
    }
    let p = chi_square_tail(sum, cells - 1.0);
    assert!(
        p > 1e-6,
        "{name}: chi-square {sum:.1} of {cells} cells, p {p:.1e}"
    );
    total
}

/// Mean and standard error of samples.
pub fn mean_se(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for v in values {
        n += 1.0;
        sum += v;
        squares += v * v;
    }
    let mean: f64 = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

#[test]
fn tails_are_those_of_tables() {
    // NIST/SEMATECH handbook, table 1.3.6.7.4: upper critical values at 0.001 and 0.05.
    for (x, k, p) in [
        (149.449, 100.0, 0.001),
        (124.342, 100.0, 0.05),
        (67.505, 50.0, 0.05),
    ] {
        assert!((chi_square_tail(x, k) / p - 1.0f64).abs() < 0.05, "{x} {k}");
    }
}
