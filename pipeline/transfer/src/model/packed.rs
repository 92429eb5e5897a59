//! Rows of weights in 8 or 16 bits a number.
//!
//! What a row adds to an answer counts as a whole, so that each row has one scale. Sums over many nodes forgive
//! 8 bits; outputs of a net's units cancel each other, and ask for 16.

use glam::Vec3;

/// A whole number that stands for a weight.
pub trait PackedNumber: Copy + Into<f32> {
    /// The largest of a row.
    const MOST: f32;

    /// The nearest of at most [`PackedNumber::MOST`].
    fn nearest(x: f32) -> Self;
}

impl PackedNumber for i8 {
    const MOST: f32 = 127.0;

    fn nearest(x: f32) -> i8 {
        x.round().clamp(-Self::MOST, Self::MOST) as i8
    }
}

impl PackedNumber for i16 {
    const MOST: f32 = 32_767.0;

    fn nearest(x: f32) -> i16 {
        x.round().clamp(-Self::MOST, Self::MOST) as i16
    }
}

/// Bits of a scale that are 0: scales are rounded up to 8 bits, which compress.
const ZERO_BITS: u32 = 16;

/// A matrix, each row as whole numbers times a scale of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedRows<T = i8> {
    /// Numbers of a row.
    pub width: usize,
    /// One a row.
    pub scales: Vec<f32>,
    /// Shape [rows, width] row-major.
    pub values: Vec<T>,
}

impl<T: PackedNumber> PackedRows<T> {
    /// Rounds rows of `width` numbers.
    pub fn pack(rows: &[f32], width: usize) -> PackedRows<T> {
        let mut packed = PackedRows {
            width,
            scales: Vec::with_capacity(rows.len() / width.max(1)),
            values: Vec::with_capacity(rows.len()),
        };
        for row in rows.chunks_exact(width.max(1)) {
            let largest = row.iter().fold(0.0f32, |most, x| most.max(x.abs()));
            let scale = rounded_up(largest / T::MOST);
            let by = if scale > 0.0 { 1.0 / scale } else { 0.0 };
            packed.scales.push(scale);
            packed.values.extend(row.iter().map(|x| T::nearest(x * by)));
        }
        packed
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.scales.len()
    }

    /// Bytes of its numbers.
    pub fn bytes(&self) -> usize {
        size_of::<T>() * self.values.len() + 4 * self.scales.len()
    }

    /// Each row's sum of weights times coefficients.
    pub fn combine(&self, coefficients: &[Vec3]) -> Vec<Vec3> {
        let rows = self.values.chunks_exact(self.width.max(1));
        let sum = |row: &[T]| -> Vec3 {
            let pairs = row.iter().zip(coefficients);
            pairs.map(|(&w, c)| *c * w.into()).sum()
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
        let (packed, finer): (PackedRows, PackedRows<i16>) =
            (PackedRows::pack(&rows, 7), PackedRows::pack(&rows, 7));
        assert_eq!((packed.rows(), packed.values.len()), (100, 700));
        for (k, row) in rows.chunks(7).enumerate() {
            let largest = row.iter().fold(0.0f32, |m, x| m.max(x.abs()));
            for (x, &q) in row.iter().zip(&packed.values[7 * k..]) {
                let off = (x - packed.scales[k] * f32::from(q)).abs();
                assert!(off <= 0.504 / 127.0 * largest, "{row:?}");
            }
            for (x, &q) in row.iter().zip(&finer.values[7 * k..]) {
                let off = (x - finer.scales[k] * f32::from(q)).abs();
                assert!(off <= 0.504 / 32_767.0 * largest, "{row:?}");
            }
        }
        assert_eq!(packed.scales[1], 0.0);
        assert_eq!(PackedRows::<i8>::pack(&[], 3).rows(), 0);
    }

    #[test]
    fn scales_have_eight_bits() {
        for x in [0.0, 1.0, 0.3, 1e-30, 7.1e9] {
            let up = rounded_up(x);
            assert!(up >= x && up <= x * 1.008 && up.to_bits() & 0xffff == 0);
        }
    }
}
