//! What a cell gets wrong of rows and lights that it was not fitted to.

use super::batch::Batch;
use super::level::judged_levels;
use crate::model::{PartAnswer, PartFit, answer_block};
use crate::query::TransferQuery;
use crate::reflectance::Reflectances;
use glam::Vec3;

/// Relative error over rows that judge and lights that judge, the rows' noise taken out;
/// infinite where no row judges, so that the next cell's fits decide nothing.
pub(crate) fn judged_error(
    parts: &[PartFit; 2],
    batch: &Batch,
    judges: &[u32],
    lights: &[Vec<Vec3>],
    reflectances: &Reflectances,
) -> f32 {
    let (mut sum, mut count) = (0.0f64, 0usize);
    let queries = judges.iter();
    let queries: Vec<&TransferQuery> = queries
        .map(|&row| &batch.table.queries[row as usize])
        .collect();
    let mut found: Vec<PartAnswer> = Vec::new();
    for (l, light) in lights.iter().enumerate() {
        let contracted = [0, 1].map(|part: usize| parts[part].contract(light));
        let contracted = [0, 1].map(|part: usize| contracted[part].as_slice());
        found.clear();
        answer_block(parts, contracted, &queries, &mut found);
        let levels = judged_levels(batch, judges, l);
        for (((&row, query), found), level) in
            judges.iter().zip(&queries).zip(&found).zip(levels)
        {
            let judged = &batch.table.judged[row as usize];
            let Some(halves) = judged.get(6 * l..6 * l + 6) else {
                continue;
            };
            let [base, constant] = reflectances.at(query.surface.material, query.facing());
            let [p, q] = found.parts;
            let found = query.base_color * p * base + q * constant;
            let (a, b) = (Vec3::from_slice(halves), Vec3::from_slice(&halves[3..]));
            let off = (found - a) * (found - b);
            sum += f64::from(off.element_sum() / 3.0) / (level * level);
            count += 1;
        }
    }
    if count == 0 {
        return f32::INFINITY;
    }
    (sum / count as f64).max(0.0).sqrt() as f32
}
