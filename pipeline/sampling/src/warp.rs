//! Samplers of no material or light in particular, each beside its density.

/// Barycentrics of the second and third corner, uniform over a triangle's area: the square root
/// map of the unit square (Turk, *Graphics Gems*, 1990).
#[inline]
pub fn uniform_triangle(u: [f32; 2]) -> [f32; 2] {
    let root = u[0].sqrt();
    [root * (1.0 - u[1]), root * u[1]]
}

/// Density of [`uniform_triangle`] on a triangle of that area, with respect to area [1/m²].
#[inline]
pub fn uniform_triangle_pdf(area: f32) -> f32 {
    1.0 / area
}

/// One of several things in proportion to its weight, by the running sum of the weights; 0 where
/// there are none. What weighs nothing is never chosen.
#[inline]
pub fn by_weight(cumulative: &[f64], u: f32) -> usize {
    let target = f64::from(u) * cumulative.last().copied().unwrap_or(0.0);
    let at = cumulative.partition_point(|&upto| upto <= target);
    at.min(cumulative.len().saturating_sub(1))
}

/// Probability of [`by_weight`] to choose `index`.
#[inline]
pub fn by_weight_probability(cumulative: &[f64], index: usize) -> f64 {
    let upto = |index: usize| cumulative.get(index).copied().unwrap_or(0.0);
    let before = index.checked_sub(1).map_or(0.0, upto);
    (upto(index) - before) / cumulative.last().copied().unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Stage, Stream};

    /// Counts in the 64 equal triangles that three cuts by edge middles make, against the
    /// density times their area; 63 degrees of freedom, 99.9999 % point 130.4.
    #[test]
    fn triangle_follows_its_density() {
        const N: u32 = 65_536;
        const SIDE: f32 = 8.0;
        let stream = Stream::new(3, Stage::Test, 0);
        let mut bins = [0u32; 64];
        for index in 0..u64::from(N) {
            let [u, v, ..] = stream.units(index, 0, 0);
            let [a, b] = uniform_triangle([u, v]).map(|x| x * SIDE);
            assert!(a >= 0.0 && b >= 0.0 && a + b <= SIDE * 1.000_001);
            let (row, column) = ((a as usize).min(7), (b as usize).min(7));
            // a square of side 1 below the diagonal holds two small triangles
            let upper = a.fract() + b.fract() > 1.0;
            bins[small_triangle(row, column, upper)] += 1;
        }
        let area = 0.5;
        let expected = f64::from(N) * f64::from(uniform_triangle_pdf(area) * area / 64.0);
        let square = |&n: &u32| (f64::from(n) - expected).powi(2) / expected;
        let chi2: f64 = bins.iter().map(square).sum();
        assert!(chi2 < 130.4, "chi-square {chi2}");
    }

    /// Weights of every size, zeros among them; 7 degrees of freedom, 99.9999 % point 41.4.
    #[test]
    fn choices_follow_their_probabilities() {
        const N: u64 = 65_536;
        let weights = [0.0, 3.0, 0.5, 0.0, 10.0, 1.0, 4.0, 0.25, 2.0, 0.1, 0.0];
        let running = |sum: &mut f64, w: &f64| {
            *sum += w;
            Some(*sum)
        };
        let cumulative: Vec<f64> = weights.iter().scan(0.0, running).collect();
        let stream = Stream::new(4, Stage::Test, 0);
        let mut counts = [0u32; 11];
        (0..N).for_each(|i| counts[by_weight(&cumulative, stream.f32(i, 0))] += 1);
        let mut chi2 = 0.0;
        for (index, &count) in counts.iter().enumerate() {
            let expected = N as f64 * by_weight_probability(&cumulative, index);
            if weights[index] == 0.0 {
                assert_eq!((count, expected), (0, 0.0));
            } else {
                chi2 += (f64::from(count) - expected).powi(2) / expected;
            }
        }
        assert!(chi2 < 41.4, "chi-square {chi2}");
        assert_eq!(by_weight(&[], 0.5), 0);
    }

    /// Row `row` has the numbers from the sum of the earlier rows' 2 (8 - row) - 1.
    fn small_triangle(row: usize, column: usize, upper: bool) -> usize {
        let before: usize = (0..row).map(|r| 2 * (8 - r) - 1).sum();
        (before + 2 * column + usize::from(upper)).min(63)
    }
}
