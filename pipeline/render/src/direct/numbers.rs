//! Random numbers of a row's shadow rays, evenly spread over its lights and over each light's places.

use rrf_sampling::sobol::{Scramble, reversed, scramble};
use rrf_sampling::{Stream, unit};

/// Numbers of the shadow rays of one row in one round.
///
/// The first number goes through [0, 1) in equal steps, so that rays come sorted by light, and those of
/// one light are consecutive. The other two are Sobol points: any run of consecutive ones is evenly
/// spread. The rows of a pixel share one sequence and divide each other's steps; every number by itself is
/// uniform, since offset and scrambles are random.
pub(super) struct RayNumbers {
    scrambles: [Scramble; 2],
    offset: f32,
    before: u32,
    count: u32,
}

/// Place of a row among those of its pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AmongRows {
    /// Number of the row, and how many there are.
    pub(super) row: u32,
    pub(super) rows: u32,
    /// Rays of the rows before.
    pub(super) rays: u32,
}

impl RayNumbers {
    /// Those of a round of a row of a pixel.
    pub(super) fn new(
        (stream, pixel): (&Stream, u64),
        round: u32,
        among: AmongRows,
        count: u32,
    ) -> RayNumbers {
        let words = stream.block(pixel, round, 0);
        let shift = unit(stream.block(pixel, round, 1)[0]);
        RayNumbers {
            scrambles: [[words[0], words[1]], [words[2], words[3]]],
            offset: (shift + among.row as f32 / among.rows.max(1) as f32).fract(),
            before: among.rays,
            count,
        }
    }

    /// Three numbers in [0, 1) of a ray.
    pub(super) fn of(&self, ray: u32) -> [f32; 3] {
        let index = self.before + ray;
        let [x, y] = [0, 1].map(|d| scramble(reversed(index, d), self.scrambles[d]));
        let step = (ray as f32 + self.offset) / self.count.max(1) as f32;
        [step.min(1.0 - 0.5 * f32::EPSILON), x, y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::Stage;

    /// Any consecutive rays of a light are spread over its places: of 64 from anywhere, each of 16 squares
    /// gets two to six, where independent ones leave squares empty.
    #[test]
    fn consecutive_rays_are_spread() {
        let stream = Stream::new(3, Stage::Test, 0);
        for pixel in 0..40 {
            let among = AmongRows {
                row: 1,
                rows: 4,
                rays: 100,
            };
            let numbers = RayNumbers::new((&stream, pixel), 1, among, 200);
            let mut squares = [0; 16];
            for ray in 0..64 {
                let [_, x, y] = numbers.of(37 + ray);
                squares[(4.0 * x) as usize * 4 + (4.0 * y) as usize] += 1;
            }
            assert!(squares.iter().all(|n| (2..=6).contains(n)), "{squares:?}");
        }
    }

    /// Over pixels each number of a ray is uniform: chi-square of 10 bins, 9 degrees of freedom, below
    /// its quantile at 1e-4, 33.7.
    #[test]
    fn numbers_are_uniform() {
        let stream = Stream::new(5, Stage::Test, 0);
        let among = AmongRows {
            row: 2,
            rows: 4,
            rays: 14,
        };
        for (ray, dimension) in (0..7).flat_map(|ray| (0..3).map(move |d| (ray, d))) {
            let mut bins = [0.0f64; 10];
            for pixel in 0..20_000 {
                let numbers = RayNumbers::new((&stream, pixel), 0, among, 7);
                let u = match dimension {
                    // where in its step
                    0 => (7.0 * numbers.of(ray)[0]).fract(),
                    _ => numbers.of(ray)[dimension],
                };
                bins[(10.0 * u) as usize] += 1.0;
            }
            let chi: f64 = bins.iter().map(|n| (n - 2000.0).powi(2) / 2000.0).sum();
            assert!(chi < 33.7, "ray {ray}, number {dimension}: {bins:?}");
        }
    }
}
