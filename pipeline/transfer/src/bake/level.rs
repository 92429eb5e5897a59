//! Levels that rows' errors under a light are relative to.

use super::batch::Batch;

/// Levels below this share of the mean row's count as if they were as bright.
const FLOOR: f64 = 0.05;

/// A level a judging row under a judging light.
///
/// A row's own halves are too noisy to be relative to: where few of its paths meet a light, most rows
/// would count as dark and their errors as large. So a level is the rows' mean under the light, in
/// proportion to what each row gets of all lights.
pub(crate) fn judged_levels(batch: &Batch, judges: &[u32], light: usize) -> Vec<f64> {
    let table = &batch.table;
    let (mut under, mut of_all, mut count) = (0.0f64, 0.0f64, 0usize);
    for &row in judges {
        let judged = &table.judged[row as usize];
        if let Some(halves) = judged.get(6 * light..6 * light + 6) {
            under += f64::from(halves.iter().sum::<f32>() / 6.0);
            of_all += f64::from(table.levels[row as usize]);
            count += 1;
        }
    }
    let level = |row: u32| match of_all > 0.0 {
        true => under * f64::from(table.levels[row as usize]) / of_all,
        false => under / count.max(1) as f64,
    };
    judges.iter().map(|&row| level(row).max(FLOOR)).collect()
}
