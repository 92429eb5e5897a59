//! What a cell gets wrong of rows and lights that it was not fitted to.

use super::batch::Batch;
use super::directions::Directions;
use super::level::judged_levels;
use crate::model::{PartAnswer, PartFit, answer_block};
use crate::query::TransferQuery;
use crate::reflectance::Reflectances;
use crate::regression::RowTable;
use glam::Vec3;

/// Rows that the fits' own word counts for beside those that were not fitted to.
const BELIEF: f64 = 8.0;

/// A cell's error on rows that it was not fitted to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Judged {
    /// Mean square of the relative error over rows and lights, the rows' noise taken out; infinite
    /// where no row judges, so that the next cell's fits decide nothing.
    pub(crate) square: f64,
    /// Its standard error over rows.
    pub(crate) deviation: f64,
}

impl Judged {
    /// The error that a cell states: one standard error is added, since few and noisy rows may
    /// say too little by chance.
    pub(crate) fn stated(&self) -> f32 {
        (self.square.max(0.0) + self.deviation).sqrt() as f32
    }

    /// Whether this is better than another by so much.
    pub(crate) fn beats(&self, other: &Judged, patience: f32) -> bool {
        self.square.max(0.0) * f64::from(patience).powi(2) < other.square
    }

    /// From each row's mean over lights.
    fn of(rows: &[f64]) -> Judged {
        let count = rows.len() as f64;
        let square = rows.iter().sum::<f64>() / count;
        let scatter: f64 = rows.iter().map(|row| (row - square).powi(2)).sum();
        Judged {
            square: if rows.is_empty() {
                f64::INFINITY
            } else {
                square
            },
            deviation: match rows.len() {
                0 | 1 => f64::INFINITY,
                _ => (scatter / (count - 1.0) / count).sqrt(),
            },
        }
    }
}

/// Relative error over rows that judge and lights that judge.
pub(crate) fn judged_error(
    parts: &[PartFit; 2],
    batch: &Batch,
    judges: &[u32],
    lights: &[Vec<Vec3>],
    reflectances: &Reflectances,
) -> Judged {
    let queries = judges.iter();
    let queries: Vec<&TransferQuery> = queries
        .map(|&row| &batch.table.queries[row as usize])
        .collect();
    let mut sums = vec![0.0f64; judges.len()];
    let mut found: Vec<PartAnswer> = Vec::new();
    for (l, light) in lights.iter().enumerate() {
        let contracted = [0, 1].map(|part: usize| parts[part].contract(light));
        let contracted = [0, 1].map(|part: usize| contracted[part].as_slice());
        found.clear();
        answer_block(parts, contracted, &queries, &mut found);
        let levels = judged_levels(batch, judges, l);
        let rows = judges.iter().zip(levels).zip(&mut sums);
        for (((&row, level), sum), (query, found)) in rows.zip(queries.iter().zip(&found)) {
            let judged = &batch.table.judged[row as usize];
            let Some(halves) = judged.get(6 * l..6 * l + 6) else {
                continue;
            };
            let [base, constant] = reflectances.at(query.surface.material, query.facing());
            let [p, q] = found.parts;
            let found = query.base_color * p * base + q * constant;
            let (a, b) = (Vec3::from_slice(halves), Vec3::from_slice(&halves[3..]));
            let off = (found - a) * (found - b);
            *sum += f64::from(off.element_sum() / 3.0) / (level * level * lights.len() as f64);
        }
    }
    Judged::of(if lights.is_empty() { &[] } else { &sums })
}

/// How far rows that were not fitted to bear out each direction, in either part: the weak ones are
/// noise in part, which a light that stands near what they see would bring out.
pub(crate) fn borne_out(
    parts: &[PartFit; 2],
    table: &RowTable,
    judges: &[u32],
    shares: &[[Vec3; 2]],
    directions: &Directions,
) -> [Vec<f32>; 2] {
    let queries = judges.iter();
    let queries: Vec<&TransferQuery> = queries.map(|&row| &table.queries[row as usize]).collect();
    let made = [0, 1].map(|part: usize| {
        let own = judges.iter();
        own.map(|&row| directions.made(table.part(row as usize, part)))
            .collect::<Vec<_>>()
    });
    let weight = |share: &Vec3| f64::from(share.element_sum() / 3.0).powi(2);
    let mut factors = parts.each_ref().map(|part| match part {
        PartFit::Nothing => vec![0.0f32; directions.rank],
        _ => vec![1.0; directions.rank],
    });
    let mut found = Vec::new();
    for k in 0..directions.rank {
        let mut unit = vec![Vec3::ZERO; directions.rank];
        unit[k] = Vec3::ONE;
        let contracted = [0, 1].map(|part: usize| parts[part].contract(&unit));
        let contracted = [0, 1].map(|part: usize| contracted[part].as_slice());
        found.clear();
        answer_block(parts, contracted, &queries, &mut found);
        for (part, factors) in factors.iter_mut().enumerate() {
            let (mut both, mut own) = (0.0f64, 0.0f64);
            for ((found, made), shares) in found.iter().zip(&made[part]).zip(shares) {
                let weight = weight(&shares[part]);
                let fitted = found.parts[part];
                let row = Vec3::from_slice(&made[3 * k..]);
                both += weight * f64::from(fitted.dot(row));
                own += weight * f64::from(fitted.length_squared());
            }
            let belief = BELIEF / judges.len().max(1) as f64 * own;
            if own > 0.0 {
                factors[k] = ((both + belief) / (own + belief)).clamp(0.0, 1.0) as f32;
            }
        }
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No row says nothing, one says what it is and nothing of how sure that is; many agree.
    #[test]
    fn stated_errors_rise_where_few_rows_judge() {
        assert_eq!(Judged::of(&[]).stated(), f32::INFINITY);
        assert_eq!(Judged::of(&[0.01]).square, 0.01);
        assert_eq!(Judged::of(&[0.01]).stated(), f32::INFINITY);
        let rows = [0.03, -0.01, 0.02, 0.0];
        let few = Judged::of(&rows);
        let many = Judged::of(&rows.repeat(25));
        assert!((few.square - 0.01).abs() < 1e-12 && (many.square - 0.01).abs() < 1e-12);
        assert!(0.1 < many.stated() && many.stated() < few.stated());
        assert!(Judged::of(&[0.005; 3]).beats(&few, 1.1));
        assert!(!few.beats(&many, 1.1));
    }
}
