//! Indirect radiance of points, cell by cell.

use super::block::{PartAnswer, answer_block};
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

/// How much larger a cell's error may be where its answers are some of many that are averaged: one further ray in
/// their place is noisier.
const AVERAGED: f32 = 4.0;

/// A model's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferAnswer {
    /// Indirect radiance toward the viewer [W/(sr m^2)], a channel; not clamped.
    pub radiance: Vec3,
    /// Cell, or `rrf_scene::INVALID` where no cell knows the surface.
    pub cell: u32,
    /// Whether the cell's error is small enough and the point within what it was fitted to.
    pub trusted: bool,
    /// Whether it is for an answer that is averaged with those of other cells, whose errors differ.
    pub trusted_on_average: bool,
}

impl TransferAnswer {
    /// No light, no cell.
    pub const NONE: TransferAnswer = TransferAnswer {
        radiance: Vec3::ZERO,
        cell: INVALID,
        trusted: false,
        trusted_on_average: false,
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
                let mut answers = Vec::with_capacity(batch.len());
                let (mut asked, mut parts) = (Vec::new(), Vec::new());
                for run in batch.chunk_by(|&a, &b| cells[a as usize] == cells[b as usize]) {
                    asked.clear();
                    asked.extend(run.iter().map(|&i| &queries[i as usize]));
                    let cell = cells[run[0] as usize];
                    self.answer(light, cell, &asked, &mut parts, &mut answers);
                }
                answers
            })
            .collect();
        let mut answers = vec![TransferAnswer::NONE; queries.len()];
        for (&i, answer) in order.iter().zip(answered.into_iter().flatten()) {
            answers[i as usize] = answer;
        }
        answers
    }

    /// Appends the answers for points of one cell.
    fn answer(
        &self,
        light: &LightCoefficients,
        cell: u32,
        queries: &[&TransferQuery],
        parts: &mut Vec<PartAnswer>,
        answers: &mut Vec<TransferAnswer>,
    ) {
        let Some(own) = self.cells.get(cell as usize) else {
            answers.resize(answers.len() + queries.len(), TransferAnswer::NONE);
            return;
        };
        parts.clear();
        answer_block(
            &own.parts,
            [light.of(cell, 0), light.of(cell, 1)],
            queries,
            parts,
        );
        let is_fit = own.error <= self.trust;
        let is_fit_on_average = own.error <= AVERAGED * self.trust;
        answers.extend(queries.iter().zip(parts.iter()).map(|(query, found)| {
            let [base, constant] = (self.reflectances).at(query.surface.material, query.facing());
            let [p, q] = found.parts;
            TransferAnswer {
                radiance: query.base_color * p * base + q * constant,
                cell,
                trusted: is_fit && found.beyond <= MARGIN,
                trusted_on_average: is_fit_on_average && found.beyond <= MARGIN,
            }
        }));
    }
}
