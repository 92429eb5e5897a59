//! One set of rows under many lights: s+ = Σ_k c_k ∘ Φ(x_p, v, l_k, n, a) (Ren et al. 2013, sect. 3).
//!
//! What a cell computes from p, n, v and a serves all the lights that reach it.

use crate::columns::{self, Columns};
use crate::derived::{self, BLOCK, DERIVED, DerivedBlock, Lane, RawBlock};
use crate::error::FieldError;
use crate::evaluate::{Field, gather, mark, run};
use crate::kernel::{self, Scratch};
use crate::packed::Packed;
use crate::spent::{Spent, Watch};
use multiversion::{multiversion, target::match_target};

/// An isotropic point light: position [m, world] and radiant intensity a channel [W/sr].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// World position.
    pub position: [f32; 3],
    /// Radiant intensity a channel.
    pub intensity: [f32; 3],
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
        self.evaluate_lights_timed(rows, lights, out, cells, None)
    }

    /// [`Field::evaluate_lights`]; adds what time it took to `spent`.
    pub fn evaluate_lights_timed(
        &self,
        rows: &Columns,
        lights: &[Light],
        out: &mut [Vec<f32>; 3],
        cells: &mut Vec<u32>,
        mut spent: Option<&mut Spent>,
    ) -> Result<(), FieldError> {
        let mut watch = Watch::new(spent.is_some());
        self.prepare(rows, out, cells)?;
        let mut scratch = Scratch::new(self.width);
        let positions: Vec<[f32; 3]> = lights.iter().map(|light| light.position).collect();
        let mut reaching = Vec::new();
        self.walk.groups(rows, Some(&positions), |group| {
            reaching.clear();
            reaching.extend(group.lights.iter().map(|&k| lights[k as usize]));
            if group.lights.first() == Some(&0) {
                mark(cells, group.rows, group.cell);
            }
            let packed = &self.packed[group.cell as usize];
            watch.end_lookup();
            evaluate_cell_lights(
                packed,
                rows,
                group.rows,
                &reaching,
                &mut scratch,
                out,
                &mut watch,
            );
        });
        watch.end_lookup();
        if let Some(spent) = &mut spent {
            spent.add(&watch.spent);
        }
        Ok(())
    }
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
    watch: &mut Watch,
) {
    match_target! {
        "x86_64+avx512f" => with::<true, 32>(packed, rows, ids, lights, scratch, out, watch),
        "x86_64+fma" => with::<true, 16>(packed, rows, ids, lights, scratch, out, watch),
        "aarch64" => with::<true, 8>(packed, rows, ids, lights, scratch, out, watch),
        _ => with::<false, 8>(packed, rows, ids, lights, scratch, out, watch),
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
    watch: &mut Watch,
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
            watch.end_inputs();
            if k == 0 {
                kernel::fixed_sums::<FUSED, LANES>(packed, ids.len(), scratch);
            }
            kernel::net::<FUSED, LANES>(packed, ids.len(), true, &raw, scratch, &mut result);
            for (sum, (y, c)) in sum.iter_mut().zip(result.iter().zip(light.intensity)) {
                for (sum, y) in sum.0.iter_mut().zip(&y.0) {
                    *sum += c * y;
                }
            }
            watch.end_nets();
        }
        for (out, sum) in out.iter_mut().zip(&sum) {
            match run(ids) {
                Some(run) => add(&mut out[run], &sum.0),
                None => {
                    for (&id, value) in ids.iter().zip(sum.0) {
                        out[id as usize] += value;
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn add(out: &mut [f32], values: &[f32]) {
    for (out, value) in out.iter_mut().zip(values) {
        *out += value;
    }
}
