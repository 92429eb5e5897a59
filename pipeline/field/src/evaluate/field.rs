//! A field ready for evaluation: rows grouped by cell, nets over blocks of rows.

use super::kernel::{self, Begin, Scratch};
use super::packed::Packed;
use super::walk::{Groups, Walk};
use crate::baseline::Baseline;
use crate::columns::{self, Columns};
use crate::error::FieldError;
use crate::inputs::COUNT;
use crate::inputs::block::{Block, derive_all};
use crate::inputs::lane::{BLOCK, Lane};
use crate::model::CellModel;
use crate::tree::Tree;
use multiversion::{multiversion, target::match_target};

/// A kd-tree and the model of each of its cells.
///
/// Evaluation gives what the nets say, negative radiance included: whoever shows a picture
/// decides what becomes of it.
#[derive(Clone, Debug)]
pub struct Field {
    tree: Tree,
    models: Vec<CellModel>,
    pub(crate) walk: Walk,
    pub(crate) ready: Vec<Ready>,
    pub(crate) width: usize,
}

/// A cell's model, laid out for evaluation.
#[derive(Clone, Debug)]
pub(crate) enum Ready {
    Net(Box<Packed>),
    Baseline(Box<Baseline>),
}

impl Ready {
    fn new(model: &CellModel) -> Ready {
        match Baseline::new(model) {
            Some(baseline) => Ready::Baseline(Box::new(baseline)),
            None => Ready::Net(Box::new(Packed::new(model))),
        }
    }

    fn width(&self) -> usize {
        match self {
            Ready::Net(packed) => packed.width(),
            Ready::Baseline(_) => 0,
        }
    }
}

impl Field {
    /// Checks that tree and models agree; `models[c]` is the model of cell c.
    pub fn new(tree: Tree, models: Vec<CellModel>) -> Result<Field, FieldError> {
        let walk = Walk::new(&tree)?;
        let cells = tree.cells();
        if cells != models.len() {
            let models = models.len();
            return Err(FieldError::Count { cells, models });
        }
        for (cell, model) in models.iter().enumerate() {
            let fault = match model.cell as usize == cell {
                true => model.fault(),
                false => Some("it names another cell".into()),
            };
            if let Some(reason) = fault {
                return Err(FieldError::Model { cell, reason });
            }
        }
        let ready: Vec<Ready> = models.iter().map(Ready::new).collect();
        let width = ready.iter().map(Ready::width).max().unwrap_or(0);
        Ok(Field {
            tree,
            models,
            walk,
            ready,
            width,
        })
    }

    /// The tree.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The models by cell id.
    pub fn models(&self) -> &[CellModel] {
        &self.models
    }

    /// The cell of each row.
    pub fn cells(&self, rows: &Columns, cells: &mut Vec<u32>) -> Result<(), FieldError> {
        check_rows(rows)?;
        cells.clear();
        cells.resize(rows.len(), u32::MAX);
        let mut groups = Groups::default();
        self.walk.groups(rows, None, &mut groups);
        for (cell, ids, _) in groups.iter() {
            mark(cells, ids, cell);
        }
        Ok(())
    }

    /// Indirect radiance [W·sr⁻¹·m⁻²] of each row for a light of 1 W/sr at the row's own light
    /// position, channel by channel, and each row's cell. A row's bits do not depend on the
    /// other rows of the batch.
    pub fn evaluate(
        &self,
        rows: &Columns,
        out: &mut [Vec<f32>; 3],
        cells: &mut Vec<u32>,
    ) -> Result<(), FieldError> {
        self.prepare(rows, out, cells)?;
        let mut scratch = Scratch::default();
        scratch.widen(self.width);
        let mut groups = Groups::default();
        self.walk.groups(rows, None, &mut groups);
        for (cell, ids, _) in groups.iter() {
            mark(cells, ids, cell);
            self.evaluate_cell(cell, rows, ids, &mut scratch, out);
        }
        Ok(())
    }

    /// The rows `ids` by one cell's model.
    fn evaluate_cell(
        &self,
        cell: u32,
        rows: &Columns,
        ids: &[u32],
        scratch: &mut Scratch,
        out: &mut [Vec<f32>; 3],
    ) {
        match &self.ready[cell as usize] {
            Ready::Net(packed) => evaluate_cell(packed, rows, ids, scratch, out),
            Ready::Baseline(baseline) => baseline.add(rows, ids, None, out),
        }
    }

    /// [`Field::evaluate`] by the cells given, whichever the rows lie in.
    pub(crate) fn evaluate_as(
        &self,
        rows: &Columns,
        cells: &[u32],
        out: &mut [Vec<f32>; 3],
    ) -> Result<(), FieldError> {
        self.prepare(rows, out, &mut Vec::new())?;
        let mut scratch = Scratch::default();
        scratch.widen(self.width);
        let mut order: Vec<u32> = (0..rows.len() as u32).collect();
        order.sort_by_key(|&row| cells[row as usize]);
        for ids in order.chunk_by(|&a, &b| cells[a as usize] == cells[b as usize]) {
            let cell = ids.first().map_or(0, |&row| cells[row as usize]);
            self.evaluate_cell(cell, rows, ids, &mut scratch, out);
        }
        Ok(())
    }

    /// Checks the rows and makes `out` and `cells` as long, zeros and no cell.
    pub(crate) fn prepare(
        &self,
        rows: &Columns,
        out: &mut [Vec<f32>; 3],
        cells: &mut Vec<u32>,
    ) -> Result<(), FieldError> {
        check_rows(rows)?;
        cells.clear();
        cells.resize(rows.len(), u32::MAX);
        for channel in out.iter_mut() {
            channel.clear();
            channel.resize(rows.len(), 0.0);
        }
        Ok(())
    }
}

/// Notes the cell of the rows `ids`.
pub(crate) fn mark(cells: &mut [u32], ids: &[u32], cell: u32) {
    for &id in ids {
        cells[id as usize] = cell;
    }
}

/// The rows `ids`, all of one cell.
#[multiversion(targets(
    "x86_64+avx+avx2+fma+avx512f+avx512vl+avx512dq+avx512bw",
    "x86_64+avx+avx2+fma"
))]
fn evaluate_cell(
    packed: &Packed,
    rows: &Columns,
    ids: &[u32],
    scratch: &mut Scratch,
    out: &mut [Vec<f32>; 3],
) {
    match_target! {
        "x86_64+avx512f" => evaluate_with::<true, 32, 16>(packed, rows, ids, scratch, out),
        "x86_64+fma" => evaluate_with::<true, 16, 8>(packed, rows, ids, scratch, out),
        "aarch64" => evaluate_with::<true, 8, 8>(packed, rows, ids, scratch, out),
        _ => evaluate_with::<false, 8, 8>(packed, rows, ids, scratch, out),
    }
}

#[inline(always)]
fn evaluate_with<const FUSED: bool, const LANES: usize, const HALF: usize>(
    packed: &Packed,
    rows: &Columns,
    ids: &[u32],
    scratch: &mut Scratch,
    out: &mut [Vec<f32>; 3],
) {
    let mut block: Block = [Lane::ZERO; COUNT];
    let mut result = [Lane::ZERO; 3];
    for ids in ids.chunks(BLOCK) {
        gather::<true>(packed, rows, ids, &mut block);
        derive_all(&packed.derived, ids.len(), &mut block);
        let (all, count) = (0..packed.sizes[0], ids.len());
        let scaled = &mut scratch.scaled;
        kernel::scale(packed, all.clone(), count, &block, scaled);
        kernel::net::<FUSED, LANES, HALF>(
            packed,
            count,
            all,
            Begin::Own,
            &block,
            scratch,
            &mut result,
        );
        for (out, result) in out.iter_mut().zip(&result) {
            match run(ids) {
                Some(run) => out[run].copy_from_slice(&result.0[..ids.len()]),
                None => {
                    for (&id, value) in ids.iter().zip(result.0) {
                        out[id as usize] = value;
                    }
                }
            }
        }
    }
}

/// The rows' columns that the cell reads; those of the light where rows bring their own (`OWN`).
/// Rows beyond `ids` keep what an earlier block left.
#[inline(always)]
pub(crate) fn gather<const OWN: bool>(
    packed: &Packed,
    rows: &Columns,
    ids: &[u32],
    block: &mut Block,
) {
    let run = run(ids);
    for &c in &packed.columns {
        let c = usize::from(c);
        if !OWN && (columns::L..columns::L + 3).contains(&c) {
            continue;
        }
        let (lane, column) = (&mut block[c].0, &rows.columns[c]);
        match &run {
            Some(run) => lane[..ids.len()].copy_from_slice(&column[run.clone()]),
            None => {
                for (x, &id) in lane.iter_mut().zip(ids) {
                    *x = column[id as usize];
                }
            }
        }
    }
}

/// The range that ascending ids make up, if they leave nothing out.
#[inline(always)]
pub(crate) fn run(ids: &[u32]) -> Option<std::ops::Range<usize>> {
    let (first, last) = (*ids.first()? as usize, *ids.last()? as usize);
    (last - first + 1 == ids.len()).then_some(first..last + 1)
}

fn check_rows(rows: &Columns) -> Result<(), FieldError> {
    let expected = rows.len();
    if expected >= u32::MAX as usize {
        return Err(FieldError::TooManyRows { rows: expected });
    }
    for (column, values) in columns::NAMES.iter().zip(&rows.columns) {
        if values.len() != expected {
            return Err(FieldError::Ragged {
                column,
                expected,
                found: values.len(),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Kind;
    use crate::model::net::Shape;
    use rrf_sampling::{Stage, Stream};

    /// What each kind of processor computes, whatever this one is.
    #[test]
    fn every_register_shape_gives_the_same() {
        let mut random = Stream::new(3, Stage::Test, 0).dimensions(0);
        let mut number = || 2.0 * random.next_f32() - 1.0;
        let mut rows = Columns::default();
        for _ in 0..150 {
            rows.push(std::array::from_fn(|_| number()));
        }
        let shape = Shape {
            sizes: vec![15, 21, 10, 3],
        };
        let packed = Packed::new(&CellModel {
            cell: 0,
            kind: Kind::Net,
            inputs: (5..20).collect(),
            input_offset: (0..15).map(|_| number()).collect(),
            input_scale: (0..15).map(|_| number()).collect(),
            weights: (0..shape.weights()).map(|_| number()).collect(),
            shape,
            output_scale: [1.0; 3],
            output_offset: [0.0; 3],
            divide_base: false,
            exponential: true,
        });
        let ids: Vec<u32> = (0..150).filter(|id| id % 11 != 3).collect();
        type Evaluate = fn(&Packed, &Columns, &[u32], &mut Scratch, &mut [Vec<f32>; 3]);
        let run = |with: Evaluate| {
            let mut out = [(); 3].map(|()| vec![0.0f32; 150]);
            let mut scratch = Scratch::default();
            scratch.widen(packed.width());
            with(&packed, &rows, &ids, &mut scratch, &mut out);
            out
        };
        let plain = run(evaluate_with::<false, 8, 8>);
        let fused = run(evaluate_with::<true, 8, 8>);
        assert_eq!(fused, run(evaluate_with::<true, 16, 8>));
        assert_eq!(fused, run(evaluate_with::<true, 32, 16>));
        assert_eq!(plain, run(evaluate_with::<false, 32, 16>));
        let dispatched = run(evaluate_cell);
        assert!(dispatched == fused || dispatched == plain);
        for (plain, fused) in plain.iter().zip(&fused) {
            for (row, (a, b)) in plain.iter().zip(fused).enumerate() {
                // Outputs are exponentials of sums of eleven terms of size about one: what
                // rounding adds to the sum is a relative error of the output.
                assert!((a - b).abs() <= 1e-5 * a.abs());
                assert_eq!(*a == 0.0, row % 11 == 3);
            }
        }
    }
}
