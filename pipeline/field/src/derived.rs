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

/// The derived inputs of one row, which the columns are tested against, in the order of
/// `INPUTS[18..]`:
/// d (3), 1/‖l−p‖, (mirror direction of v about n)·d, n·d, n·v, with d = (l−p)/‖l−p‖.
/// A light on the point itself has d = 0 and inverse distance 0.
///
/// Plain multiplies and adds, never fused: training and rendering see the same bits.
#[cfg(test)]
pub fn derive(p: [f32; 3], n: [f32; 3], v: [f32; 3], l: [f32; 3]) -> [f32; DERIVED] {
    let to = [l[0] - p[0], l[1] - p[1], l[2] - p[2]];
    let distance = dot(to, to).sqrt();
    let inverse = if distance > 0.0 { 1.0 / distance } else { 0.0 };
    let d = [to[0] * inverse, to[1] * inverse, to[2] * inverse];
    let (n_d, n_v, v_d) = (dot(n, d), dot(n, v), dot(v, d));
    [d[0], d[1], d[2], inverse, 2.0 * n_v * n_d - v_d, n_d, n_v]
}

/// Which derived inputs are wanted; the others keep what an earlier block left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Direction and inverse distance to the light.
    pub light: bool,
    /// Those that the normal or the viewer enters.
    pub angles: bool,
}

impl Wanted {
    /// Everything.
    pub const ALL: Wanted = Wanted {
        light: true,
        angles: true,
    };

    /// What the inputs (places in [`crate::model::INPUTS`]) need.
    pub fn of(inputs: &[u8]) -> Wanted {
        const ANGLES: usize = columns::COUNT + 4;
        let derived = |&i: &usize| i >= columns::COUNT;
        let places = || inputs.iter().map(|&i| usize::from(i)).filter(derived);
        Wanted {
            light: places().next().is_some(),
            angles: places().any(|i| i >= ANGLES),
        }
    }
}

/// Rows that are derived together: the widest registers.
const TOGETHER: usize = 16;

/// [`derive`] for the first `rows` rows of a block (and some beyond).
///
/// Column by column: [`derive`]'s rows of seven are not turned into vector instructions.
#[inline(always)]
pub fn derive_block(raw: &RawBlock, rows: usize, wanted: Wanted, out: &mut DerivedBlock) {
    let rows = rows.next_multiple_of(TOGETHER).min(BLOCK);
    let [dx, dy, dz, inverse, mirror, cos_light, cos_view] = out;
    let [px, py, pz, nx, ny, nz, vx, vy, vz, lx, ly, lz, ..] = raw;
    if wanted.light {
        for r in 0..rows {
            let (x, y, z) = (lx.0[r] - px.0[r], ly.0[r] - py.0[r], lz.0[r] - pz.0[r]);
            let distance = (x * x + y * y + z * z).sqrt();
            let over = if distance > 0.0 { 1.0 / distance } else { 0.0 };
            dx.0[r] = x * over;
            dy.0[r] = y * over;
            dz.0[r] = z * over;
            inverse.0[r] = over;
        }
    }
    if wanted.angles {
        for r in 0..rows {
            let (n, v) = ([nx.0[r], ny.0[r], nz.0[r]], [vx.0[r], vy.0[r], vz.0[r]]);
            let d = [dx.0[r], dy.0[r], dz.0[r]];
            let (n_d, n_v, v_d) = (dot(n, d), dot(n, v), dot(v, d));
            mirror.0[r] = 2.0 * n_v * n_d - v_d;
            cos_light.0[r] = n_d;
            cos_view.0[r] = n_v;
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
        derive_block(&raw, end - start, Wanted::ALL, &mut derived);
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
