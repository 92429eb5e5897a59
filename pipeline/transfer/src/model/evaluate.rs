//! Indirect radiance of points, cell by cell.

use super::light::LightCoefficients;
use super::transfer::TransferModel;
use crate::query::TransferQuery;
use glam::Vec3;
use rayon::prelude::*;
use rrf_scene::INVALID;

/// Points that one thread answers at a time.
const BATCH: usize = 1024;
/// Deviations by which a point may lie outside of what its net was fitted to.
const MARGIN: f32 = 0.5;

/// A model's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferAnswer {
    /// Indirect radiance toward the viewer [W/(sr m^2)], a channel; not clamped.
    pub radiance: Vec3,
    /// Cell, or `rrf_scene::INVALID` where no cell knows the surface.
    pub cell: u32,
    /// Whether the cell's error is small enough and the point within what it was fitted to.
    pub trusted: bool,
}

impl TransferAnswer {
    /// No light, no cell.
    pub const NONE: TransferAnswer = TransferAnswer {
        radiance: Vec3::ZERO,
        cell: INVALID,
        trusted: false,
    };
}

impl TransferModel {
    /// Indirect radiance at points under a light. A point's bits depend on the point and
    /// the light alone.
    pub fn evaluate(
        &self,
        light: &LightCoefficients,
        queries: &[TransferQuery],
    ) -> Vec<TransferAnswer> {
        let cells: Vec<u32> = queries
            .par_iter()
            .map(|query| self.tree.find(query).unwrap_or(INVALID))
            .collect();
        let mut order: Vec<u32> = (0..queries.len() as u32).collect();
        order.sort_by_key(|&i| cells[i as usize]);
        let answered: Vec<Vec<TransferAnswer>> = order
            .par_chunks(BATCH)
            .map(|batch| {
                let answer = |&i: &u32| self.answer(light, &queries[i as usize], cells[i as usize]);
                batch.iter().map(answer).collect()
            })
            .collect();
        let mut answers = vec![TransferAnswer::NONE; queries.len()];
        for (&i, answer) in order.iter().zip(answered.into_iter().flatten()) {
            answers[i as usize] = answer;
        }
        answers
    }

    fn answer(
        &self,
        light: &LightCoefficients,
        query: &TransferQuery,
        cell: u32,
    ) -> TransferAnswer {
        let Some(own) = self.cells.get(cell as usize) else {
            return TransferAnswer::NONE;
        };
        let part = |k: usize| own.parts[k].evaluate(query, light.of(cell, k));
        let [base, constant] = (self.reflectances).at(query.surface.material, query.facing());
        let inside = |k: usize| own.parts[k].is_inside(query, MARGIN);
        TransferAnswer {
            radiance: query.base_color * part(0) * base + part(1) * constant,
            cell,
            trusted: own.error <= self.trust && inside(0) && inside(1),
        }
    }
}
