//! One set of rows under many lights: s+ = Σ_k c_k ∘ Φ(x_p, v, l_k, n, a) (Ren et al. 2013, sect. 3).
//!
//! Once a frame, each light's position is worked into the first layer's biases of every cell that
//! it reaches. What a cell computes from p, n, v and a serves all the lights that reach it.

use super::field::{Field, Ready, gather, mark, run};
use super::kernel::{self, Begin, Scratch};
use super::packed::Packed;
use super::timings::{EvaluationTimings, Stopwatch};
use super::walk::Groups;
use crate::columns::{self, Columns};
use crate::error::FieldError;
use crate::inputs::COUNT;
use crate::inputs::block::{Block, derive_all};
use crate::inputs::lane::{BLOCK, Lane};
use crate::light::Light;
use multiversion::{multiversion, target::match_target};

/// A field under lights that stay where they are for a frame.
#[derive(Clone, Debug)]
pub struct LitField<'a> {
    field: &'a Field,
    lights: Vec<Light>,
    positions: Vec<[f32; 3]>,
    /// Where in `biases` those of a light and a cell begin: `[light][cell]`; 0 where the light
    /// does not reach the cell.
    starts: Vec<usize>,
    biases: Vec<f32>,
}

/// Working memory of [`LitField::evaluate`], of one thread, used batch after batch.
#[derive(Clone, Debug)]
pub struct Workspace {
    groups: Groups,
    scratch: Scratch,
    block: Block,
    stopwatch: Stopwatch,
    reaching: Vec<Reaching>,
}

/// A light of a cell: its place in the list of biases, its position and intensity.
#[derive(Clone, Copy, Debug)]
struct Reaching {
    light: Light,
    start: usize,
}

impl Default for Workspace {
    fn default() -> Workspace {
        Workspace {
            groups: Groups::default(),
            scratch: Scratch::default(),
            block: [Lane::ZERO; COUNT],
            stopwatch: Stopwatch::default(),
            reaching: Vec::new(),
        }
    }
}

impl Field {
    /// The field under `lights`.
    pub fn under(&self, lights: &[Light]) -> LitField<'_> {
        let cells = self.models().len();
        let mut starts = vec![0; lights.len() * cells];
        let (mut biases, mut reached) = (Vec::new(), Vec::new());
        for (light, starts) in lights.iter().zip(starts.chunks_mut(cells.max(1))) {
            self.walk.cells_under(light.position, &mut reached);
            for &cell in &reached {
                starts[cell as usize] = biases.len();
                if let Ready::Net(packed) = &self.ready[cell as usize] {
                    packed.biases(light.position, &mut biases);
                }
            }
        }
        LitField {
            field: self,
            lights: lights.to_vec(),
            positions: lights.iter().map(|light| light.position).collect(),
            starts,
            biases,
        }
    }

    /// [`LitField::evaluate`] once.
    pub fn evaluate_lights(
        &self,
        rows: &Columns,
        lights: &[Light],
        out: &mut [Vec<f32>; 3],
        cells: &mut Vec<u32>,
    ) -> Result<(), FieldError> {
        let mut work = Workspace::default();
        self.under(lights)
            .evaluate(rows, &mut work, out, cells, None)
    }
}

impl LitField<'_> {
    /// The field.
    pub fn field(&self) -> &Field {
        self.field
    }

    /// The lights.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Indirect radiance [W·sr⁻¹·m⁻²] of each row under all the lights, channel by channel, and
    /// each row's cell under the first light (`u32::MAX` without any); adds what time it took to
    /// `timings`.
    /// The rows' own light columns are not read (but must be as long as the others).
    /// A row's bits depend on the row and the list of lights only.
    pub fn evaluate(
        &self,
        rows: &Columns,
        work: &mut Workspace,
        out: &mut [Vec<f32>; 3],
        cells: &mut Vec<u32>,
        timings: Option<&mut EvaluationTimings>,
    ) -> Result<(), FieldError> {
        work.stopwatch.start(timings.is_some());
        self.field.prepare(rows, out, cells)?;
        work.scratch.widen(self.field.width);
        let mut groups = std::mem::take(&mut work.groups);
        self.field
            .walk
            .groups(rows, Some(&self.positions), &mut groups);
        work.stopwatch.end_lookup();
        for (cell, ids, lights) in groups.iter() {
            if lights.contains(&0) {
                mark(cells, ids, cell);
            }
            self.reaching(cell, lights, &mut work.reaching);
            match &self.field.ready[cell as usize] {
                Ready::Net(packed) => {
                    evaluate_cell_lights(packed, &self.biases, rows, ids, work, out);
                }
                Ready::Baseline(baseline) => {
                    let lights = work.reaching.iter().map(|reaching| &reaching.light);
                    lights.for_each(|light| baseline.add(rows, ids, Some(light), out));
                }
            }
        }
        work.groups = groups;
        let took = work.stopwatch.end();
        if let Some(timings) = timings {
            timings.add(&took);
        }
        Ok(())
    }

    /// The lights `ids` of a cell, in the order of the list.
    fn reaching(&self, cell: u32, ids: &[u32], reaching: &mut Vec<Reaching>) {
        let cells = self.field.models().len();
        reaching.clear();
        reaching.extend(ids.iter().map(|&k| Reaching {
            light: self.lights[k as usize],
            start: self.starts[k as usize * cells + cell as usize],
        }));
    }
}

/// The rows `ids`, all of one cell for every one of the lights; added to `out`.
#[multiversion(targets(
    "x86_64+avx+avx2+fma+avx512f+avx512vl+avx512dq+avx512bw",
    "x86_64+avx+avx2+fma"
))]
fn evaluate_cell_lights(
    packed: &Packed,
    biases: &[f32],
    rows: &Columns,
    ids: &[u32],
    work: &mut Workspace,
    out: &mut [Vec<f32>; 3],
) {
    match_target! {
        "x86_64+avx512f" => with::<true, 32, 16>(packed, biases, rows, ids, work, out),
        "x86_64+fma" => with::<true, 16, 8>(packed, biases, rows, ids, work, out),
        "aarch64" => with::<true, 8, 8>(packed, biases, rows, ids, work, out),
        _ => with::<false, 8, 8>(packed, biases, rows, ids, work, out),
    }
}

#[inline(always)]
fn with<const FUSED: bool, const LANES: usize, const HALF: usize>(
    packed: &Packed,
    biases: &[f32],
    rows: &Columns,
    ids: &[u32],
    work: &mut Workspace,
    out: &mut [Vec<f32>; 3],
) {
    let Workspace {
        scratch,
        block,
        stopwatch,
        reaching,
        ..
    } = work;
    let one = reaching.len() == 1;
    let mut result = [Lane::ZERO; 3];
    for ids in ids.chunks(BLOCK) {
        stopwatch.block();
        gather::<false>(packed, rows, ids, block);
        let mut sum = [Lane::ZERO; 3];
        for (k, Reaching { light, start }) in reaching.iter().enumerate() {
            // What the light does not change is derived, scaled and summed for the first light only.
            let (derived, first) = match k {
                0 => (&packed.derived, 0),
                _ => (&packed.relit, packed.fixed),
            };
            if !packed.relit.is_empty() {
                for (lane, x) in block[columns::L..].iter_mut().zip(light.position) {
                    lane.0.fill(x);
                }
            }
            derive_all(derived, ids.len(), block);
            let scaled = &mut scratch.scaled;
            kernel::scale(packed, first..packed.varying, ids.len(), block, scaled);
            stopwatch.end_inputs();
            let biases = &biases[*start..];
            let (span, begin) = if one {
                (0..packed.varying, Begin::At(biases))
            } else {
                if k == 0 {
                    kernel::fixed_sums::<FUSED, LANES, HALF>(packed, ids.len(), scratch);
                }
                (packed.fixed..packed.varying, Begin::AfterSums(biases))
            };
            kernel::net::<FUSED, LANES, HALF>(
                packed,
                ids.len(),
                span,
                begin,
                block,
                scratch,
                &mut result,
            );
            for (sum, (y, c)) in sum.iter_mut().zip(result.iter().zip(light.intensity)) {
                for (sum, y) in sum.0.iter_mut().zip(&y.0) {
                    *sum += c * y;
                }
            }
            stopwatch.end_nets();
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
