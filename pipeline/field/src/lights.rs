//! One set of rows under many lights: s+ = Σ_k c_k ∘ Φ(x_p, v, l_k, n, a) (Ren et al. 2013, sect. 3).
//!
//! Rows and lights go down the kd-tree together: a split of a surface column parts the rows,
//! a split of a light column parts the lights. What a cell computes from p, n, v and a
//! serves all the lights that reach it.

use crate::columns::{self, Columns};
use crate::derived::{self, BLOCK, DERIVED, DerivedBlock, Lane, RawBlock};
use crate::error::FieldError;
use crate::evaluate::{Field, gather};
use crate::kernel::{self, Scratch};
use crate::packed::Packed;
use multiversion::{multiversion, target::match_target};

/// An isotropic point light: position [m, world] and radiant intensity a channel [W/sr].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// World position.
    pub position: [f32; 3],
    /// Radiant intensity a channel.
    pub intensity: [f32; 3],
}

/// A node still to be visited, the rows (a range of the row ids) and the lights that reach it.
struct Visit {
    node: u32,
    rows: std::ops::Range<usize>,
    /// Places in the list of lights, ascending.
    lights: Vec<usize>,
}

impl Field {
    /// Indirect radiance [W·sr⁻¹·m⁻²] of each row under all the lights, channel by channel, and
    /// each row's cell under the first light (`u32::MAX` without any).
    /// The rows' own light columns are not read (but must be as long as the others).
    /// A row's bits depend on the row and the list of lights only.
    pub fn evaluate_lights(
        &self,
        rows: &Columns,
        lights: &[Light],
        out: &mut [Vec<f32>; 3],
        cells: &mut Vec<u32>,
    ) -> Result<(), FieldError> {
        self.prepare(rows, out)?;
        cells.clear();
        cells.resize(rows.len(), u32::MAX);
        let mut ids: Vec<u32> = (0..rows.len() as u32).collect();
        let mut right = Vec::new();
        let mut scratch = Scratch::new(self.width);
        let mut stack = vec![Visit {
            node: 0,
            rows: 0..ids.len(),
            lights: (0..lights.len()).collect(),
        }];
        while let Some(visit) = stack.pop() {
            if visit.rows.is_empty() || visit.lights.is_empty() {
                continue;
            }
            if let Some(cell) = self.walk.leaf(visit.node) {
                let packed = &self.packed[cell as usize];
                let ids = &ids[visit.rows];
                let reaching: Vec<Light> = visit.lights.iter().map(|&k| lights[k]).collect();
                evaluate_cell_lights(packed, rows, ids, &reaching, &mut scratch, out);
                if visit.lights[0] == 0 {
                    ids.iter().for_each(|&id| cells[id as usize] = cell);
                }
                continue;
            }
            let (axis, threshold, left) = self.walk.split(visit.node);
            stack.extend(if (columns::L..columns::L + 3).contains(&axis) {
                let above = |k: usize| lights[k].position[axis - columns::L] >= threshold;
                part_lights(visit, left, above)
            } else {
                let column = &rows.columns[axis];
                part_rows(visit, column, threshold, left, &mut ids, &mut right)
            });
        }
        Ok(())
    }
}

fn part_lights(visit: Visit, left: u32, above: impl Fn(usize) -> bool) -> [Visit; 2] {
    let (above, below) = visit.lights.into_iter().partition(|&k| above(k));
    [(left, below), (left + 1, above)].map(|(node, lights)| Visit {
        node,
        rows: visit.rows.clone(),
        lights,
    })
}

/// Parts the row ids in place, both parts in their old order.
fn part_rows(
    visit: Visit,
    column: &[f32],
    threshold: f32,
    left: u32,
    ids: &mut [u32],
    right: &mut Vec<u32>,
) -> [Visit; 2] {
    let range = visit.rows;
    right.clear();
    let mut kept = range.start;
    for at in range.clone() {
        let id = ids[at];
        if column[id as usize] >= threshold {
            right.push(id);
        } else {
            ids[kept] = id;
            kept += 1;
        }
    }
    ids[kept..range.end].copy_from_slice(right);
    [
        Visit {
            node: left,
            rows: range.start..kept,
            lights: visit.lights.clone(),
        },
        Visit {
            node: left + 1,
            rows: kept..range.end,
            lights: visit.lights,
        },
    ]
}

/// The rows `ids`, all of one cell for every one of the lights; added to `out`.
#[multiversion(targets(
    "x86_64+avx+avx2+fma+avx512f+avx512vl+avx512dq+avx512bw",
    "x86_64+avx+avx2+fma"
))]
fn evaluate_cell_lights(
    packed: &Packed,
    rows: &Columns,
    ids: &[u32],
    lights: &[Light],
    scratch: &mut Scratch,
    out: &mut [Vec<f32>; 3],
) {
    match_target! {
        "x86_64+avx512f" => with::<true, 32>(packed, rows, ids, lights, scratch, out),
        "x86_64+fma" => with::<true, 16>(packed, rows, ids, lights, scratch, out),
        "aarch64" => with::<true, 8>(packed, rows, ids, lights, scratch, out),
        _ => with::<false, 8>(packed, rows, ids, lights, scratch, out),
    }
}

#[inline(always)]
fn with<const FUSED: bool, const LANES: usize>(
    packed: &Packed,
    rows: &Columns,
    ids: &[u32],
    lights: &[Light],
    scratch: &mut Scratch,
    out: &mut [Vec<f32>; 3],
) {
    let mut raw: RawBlock = [Lane::ZERO; columns::COUNT];
    let mut derived: DerivedBlock = [Lane::ZERO; DERIVED];
    let mut result = [Lane::ZERO; 3];
    for ids in ids.chunks(BLOCK) {
        gather(packed, rows, ids, &mut raw);
        let mut sum = [Lane::ZERO; 3];
        for (k, light) in lights.iter().enumerate() {
            for (lane, x) in raw[columns::L..].iter_mut().zip(light.position) {
                lane.0.fill(x);
            }
            if packed.derived {
                derived::derive_block(&raw, &mut derived);
            }
            // What the light does not change is scaled and summed for the first light only.
            let first = if k == 0 { 0 } else { packed.fixed };
            let range = first..packed.sizes[0];
            kernel::scale(packed, range, &raw, &derived, &mut scratch.scaled);
            if k == 0 {
                kernel::fixed_sums::<FUSED, LANES>(packed, scratch);
            }
            kernel::net::<FUSED, LANES>(packed, true, &raw, scratch, &mut result);
            for (sum, (y, c)) in sum.iter_mut().zip(result.iter().zip(light.intensity)) {
                for (sum, y) in sum.0.iter_mut().zip(&y.0) {
                    *sum += c * y;
                }
            }
        }
        for (out, sum) in out.iter_mut().zip(&sum) {
            for (&id, value) in ids.iter().zip(sum.0) {
                out[id as usize] += value;
            }
        }
    }
}
