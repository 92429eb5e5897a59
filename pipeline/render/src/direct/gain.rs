//! How much faster than those of independent rays the errors of evenly spread rays fall.

/// The variance of a mean of n rays is taken to be that of one over n^(1 + exponent), with an exponent
/// from 0 (independent rays) to this.
const MOST: f64 = 1.0;

/// Differences between means of two independent sets of rays, block by block.
#[derive(Clone, Debug, Default)]
pub(super) struct SpreadGain {
    blocks: Vec<Differences>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Differences {
    pixels: f64,
    /// Sum of squared differences.
    squares: f64,
    /// Sum of the squares that independent rays would have, and that times the logarithm of the number of rays.
    independent: f64,
    logarithms: f64,
}

impl SpreadGain {
    /// Forgets everything.
    pub(super) fn begin(&mut self, blocks: usize) {
        self.blocks.clear();
        self.blocks.resize(blocks, Differences::default());
    }

    /// Learns the difference of two means of a pixel of a block, of `rays` each in each of its rows.
    pub(super) fn note(&mut self, block: usize, difference: f32, independent: f32, rays: f32) {
        let sums = &mut self.blocks[block];
        sums.pixels += 1.0;
        sums.squares += f64::from(difference * difference);
        sums.independent += f64::from(independent);
        sums.logarithms += f64::from(independent) * f64::from(rays).ln();
    }

    /// The exponent of a block. One pixel more, without gain, stands for what few pixels cannot tell.
    pub(super) fn exponent(&self, block: usize) -> f32 {
        let sums = self.blocks[block];
        if sums.logarithms <= 0.0 {
            return 0.0;
        }
        let pixel = sums.independent / sums.pixels;
        let ratio = (sums.squares + pixel) / (sums.independent + pixel);
        let logarithm = sums.logarithms / sums.independent;
        (-ratio.ln() / logarithm).clamp(0.0, MOST) as f32
    }
}

/// Rays that bring the variance of their mean down to a bound, where `independent` ones would.
pub(super) fn rays(independent: f32, exponent: f32) -> f32 {
    independent.max(0.0).powf(1.0 / (1.0 + exponent)).ceil()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Differences whose variance falls by n^(1 + e) give back e, within what one pixel without gain
    /// takes off.
    #[test]
    fn exponents_are_found() {
        for exponent in [0.0f32, 0.3, 0.8] {
            let mut gain = SpreadGain::default();
            gain.begin(2);
            for pixel in 0..1000 {
                let rays = 20.0 + (pixel % 7) as f32;
                let independent = 2.0 / rays;
                let difference = (independent * rays.powf(-exponent)).sqrt();
                gain.note(1, difference, independent, rays);
            }
            let found = gain.exponent(1);
            assert!((found - exponent).abs() < 0.01, "{found}, {exponent}");
            assert_eq!(gain.exponent(0), 0.0);
            // 400 independent ones
            let n = rays(400.0, found);
            let reached = n.powf(1.0 + exponent);
            assert!((reached / 400.0 - 1.0).abs() < 0.15, "{n}: {reached}");
        }
    }

    /// More noise than that of independent rays is no reason for fewer of them.
    #[test]
    fn there_is_no_loss() {
        let mut gain = SpreadGain::default();
        gain.begin(1);
        gain.note(0, 1.0, 0.1, 30.0);
        assert_eq!(gain.exponent(0), 0.0);
        assert_eq!(rays(0.0, 0.5), 0.0);
    }
}
