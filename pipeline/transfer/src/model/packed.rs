//! Rows of weights in 8 bits a number.
//!
//! What a row adds to an answer counts as a whole, so that each row has one scale and its weights are
//! off by at most half of a 127th of the largest of them.

use glam::Vec3;

/// Largest of a row's numbers.
const MOST: f32 = 127.0;
/// Bits of a scale that are 0: scales are rounded up to 8 bits, which compress.
const ZERO_BITS: u32 = 16;

/// A matrix, each row as 8-bit numbers times a scale of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedRows {
    /// Numbers of a row.
    pub width: usize,
    /// One a row.
    pub scales: Vec<f32>,
    /// Shape [rows, width] row-major, from -127 to 127.
    pub values: Vec<i8>,
}

impl PackedRows {
    /// Rounds rows of `width` numbers.
    pub fn pack(rows: &[f32], width: usize) -> PackedRows {
        let mut packed = PackedRows {
            width,
            scales: Vec::with_capacity(rows.len() / width.max(1)),
            values: Vec::with_capacity(rows.len()),
        };
        for row in rows.chunks_exact(width.max(1)) {
            let largest = row.iter().fold(0.0f32, |most, x| most.max(x.abs()));
            let scale = rounded_up(largest / MOST);
            let by = if scale > 0.0 { 1.0 / scale } else { 0.0 };
            packed.scales.push(scale);
            let number = |x: &f32| (x * by).round().clamp(-MOST, MOST) as i8;
            packed.values.extend(row.iter().map(number));
        }
        packed
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.scales.len()
    }

    /// Bytes of its numbers.
    pub fn bytes(&self) -> usize {
        self.values.len() + 4 * self.scales.len()
    }

    /// Each row's sum of weights times coefficients.
    pub fn combine(&self, coefficients: &[Vec3]) -> Vec<Vec3> {
        let rows = self.values.chunks_exact(self.width.max(1));
        let sum = |row: &[i8]| -> Vec3 {
            let pairs = row.iter().zip(coefficients);
            pairs.map(|(&w, c)| *c * f32::from(w)).sum()
        };
        (rows.zip(&self.scales))
            .map(|(row, scale)| sum(row) * *scale)
            .collect()
    }
}

/// The least number of 8 significant bits that is not below x >= 0.
fn rounded_up(x: f32) -> f32 {
    let low = (1u32 << ZERO_BITS) - 1;
    f32::from_bits(x.to_bits().saturating_add(low) & !low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::{Stage, Stream};

    /// No number is off by more than half a step of its row; empty and black rows stay what they are.
    #[test]
    fn numbers_are_off_by_half_a_step() {
        let stream = Stream::new(4, Stage::Test, 3);
        let number = |i: u64| {
            let [a, b, ..] = stream.units(i, 0, 0);
            (a - 0.5) * 10f32.powf(20.0 * b - 10.0)
        };
        let mut rows: Vec<f32> = (0..700).map(number).collect();
        rows[7..14].fill(0.0);
        let packed = PackedRows::pack(&rows, 7);
        assert_eq!((packed.rows(), packed.values.len()), (100, 700));
        for (k, row) in rows.chunks(7).enumerate() {
            let largest = row.iter().fold(0.0f32, |m, x| m.max(x.abs()));
            for (x, &q) in row.iter().zip(&packed.values[7 * k..]) {
                let off = (x - packed.scales[k] * f32::from(q)).abs();
                assert!(off <= 0.504 / 127.0 * largest, "{row:?}");
            }
        }
        assert_eq!(packed.scales[1], 0.0);
        assert_eq!(PackedRows::pack(&[], 3).rows(), 0);
    }

    #[test]
    fn scales_have_eight_bits() {
        for x in [0.0, 1.0, 0.3, 1e-30, 7.1e9] {
            let up = rounded_up(x);
            assert!(up >= x && up <= x * 1.008 && up.to_bits() & 0xffff == 0);
        }
    }
}
