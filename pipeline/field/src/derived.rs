//! Inputs computed from the raw columns, a block of rows at a time.

use crate::columns::{self, Columns};
use multiversion::multiversion;

/// Rows of a block. The activations of two 20-unit layers fill a third of a 32 KiB L1 cache.
pub const BLOCK: usize = 64;

/// How many derived inputs there are; they follow the raw columns in [`crate::model::INPUTS`].
pub const DERIVED: usize = 7;

/// One block of one column, aligned to a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Lane(pub [f32; BLOCK]);

impl Lane {
    /// All zeros.
    pub const ZERO: Lane = Lane([0.0; BLOCK]);
}

/// The raw columns of a block.
pub type RawBlock = [Lane; columns::COUNT];

/// The derived inputs of a block.
pub type DerivedBlock = [Lane; DERIVED];

/// The derived inputs of one row, in the order of `INPUTS[18..]`:
/// d (3), 1/‖l−p‖, (mirror direction of v about n)·d, n·d, n·v, with d = (l−p)/‖l−p‖.
/// A light on the point itself has d = 0 and inverse distance 0.
///
/// Plain multiplies and adds, never fused: training and rendering see the same bits.
#[inline(always)]
pub fn derive(p: [f32; 3], n: [f32; 3], v: [f32; 3], l: [f32; 3]) -> [f32; DERIVED] {
    let to = [l[0] - p[0], l[1] - p[1], l[2] - p[2]];
    let distance = dot(to, to).sqrt();
    let inverse = if distance > 0.0 { 1.0 / distance } else { 0.0 };
    let d = [to[0] * inverse, to[1] * inverse, to[2] * inverse];
    let (n_d, n_v, v_d) = (dot(n, d), dot(n, v), dot(v, d));
    [d[0], d[1], d[2], inverse, 2.0 * n_v * n_d - v_d, n_d, n_v]
}

/// [`derive`] for every row of a block.
#[inline(always)]
pub fn derive_block(raw: &RawBlock, out: &mut DerivedBlock) {
    for r in 0..BLOCK {
        let vec3 = |c: usize| [raw[c].0[r], raw[c + 1].0[r], raw[c + 2].0[r]];
        let row = derive(
            vec3(columns::P),
            vec3(columns::N),
            vec3(columns::V),
            vec3(columns::L),
        );
        for (out, value) in out.iter_mut().zip(row) {
            out.0[r] = value;
        }
    }
}

/// Derived input `which` (0 the first) of all rows, appended to `out`.
#[multiversion(targets("x86_64+avx+avx2+avx512f+avx512vl", "x86_64+avx+avx2"))]
pub fn derive_column(which: usize, rows: &Columns, out: &mut Vec<f32>) {
    let (mut raw, mut derived) = ([Lane::ZERO; columns::COUNT], [Lane::ZERO; DERIVED]);
    let count = rows.len();
    for start in (0..count).step_by(BLOCK) {
        let end = (start + BLOCK).min(count);
        for (lane, column) in raw.iter_mut().zip(&rows.columns[..columns::GEOMETRY]) {
            lane.0[..end - start].copy_from_slice(&column[start..end]);
        }
        derive_block(&raw, &mut derived);
        out.extend_from_slice(&derived[which].0[..end - start]);
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derived_inputs_follow_their_definitions() {
        // p at the origin, n = z, v at 45 degrees towards x; the light straight in v's mirror
        // direction at distance 2: d = (-1, 0, 1)/sqrt(2), mirror cosine 1.
        let h = 0.5f32.sqrt();
        let got = derive(
            [0.0; 3],
            [0.0, 0.0, 1.0],
            [h, 0.0, h],
            [-2.0 * h, 0.0, 2.0 * h],
        );
        let want = [-h, 0.0, h, 0.5, 1.0, h, h];
        for (got, want) in got.iter().zip(want) {
            assert!((got - want).abs() < 4.0 * f32::EPSILON, "{got} {want}");
        }
    }

    #[test]
    fn a_light_on_the_point_gives_finite_inputs() {
        let got = derive([1.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0; 3]);
        assert_eq!(got, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    }
}
