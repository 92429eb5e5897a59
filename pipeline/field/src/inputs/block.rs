//! Inputs of a block of rows: a column of each, side by side.

use super::lane::{BLOCK, Lane};
use super::reads::{derivation, reads};
use super::registry::{COUNT, RAW, derive};
use crate::columns::Columns;
use multiversion::multiversion;

/// Every input of a block's rows; those that nobody asked for keep what an earlier block left.
pub type Block = [Lane; COUNT];

/// Rows that are derived together: the widest registers.
const TOGETHER: usize = 16;

/// Computes derived inputs, as [`derivation`] lists them, of the first `rows` rows (and some
/// beyond).
#[inline(always)]
pub fn derive_all(inputs: &[u8], rows: usize, block: &mut Block) {
    let rows = rows.next_multiple_of(TOGETHER).min(BLOCK);
    for &input in inputs {
        derive(usize::from(input), rows, block);
    }
}

/// A derived input of all rows, appended to `out`.
#[multiversion(targets("x86_64+avx+avx2+avx512f+avx512vl", "x86_64+avx+avx2"))]
pub fn append(input: u8, rows: &Columns, out: &mut Vec<f32>) {
    let (derived, reads) = (derivation(&[input]), reads(input));
    let mut block: Block = [Lane::ZERO; COUNT];
    for start in (0..rows.len()).step_by(BLOCK) {
        let end = (start + BLOCK).min(rows.len());
        for raw in (0..RAW).filter(|&raw| reads.contains(raw)) {
            block[raw].0[..end - start].copy_from_slice(&rows.columns[raw][start..end]);
        }
        derive_all(&derived, end - start, &mut block);
        out.extend_from_slice(&block[usize::from(input)].0[..end - start]);
    }
}
