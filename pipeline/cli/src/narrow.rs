//! Narrow parts of queried points: traced to the next surface, where the nets answer.

use crate::baked::{Baked, BakedNets};
use crate::points;
use crate::transfer_rows::RowAnswers;
use glam::Vec3;
use rrf_field::columns;
use rrf_render::{AnswerMet, MetPoints, NarrowQueries, RenderError, narrow_light};
use rrf_store::points::PointsTable;
use rrf_trace::{Rays, SurfacePoint, Tracer};

/// Rays of each point into a lobe that is not as sharp as a mirror's.
const RAYS: u32 = 64;

/// Completes the nets' answers at a table's points, each lit by its own point light: the nets count
/// where a surface has a broad part, and what the narrow part shows is added. A point is trusted if
/// every net that was asked is.
pub fn complete(
    baked: &Baked,
    nets: &BakedNets,
    tracer: &Tracer,
    (table, located): (&PointsTable, &[SurfacePoint]),
    answers: &mut RowAnswers,
) -> anyhow::Result<()> {
    let (radiance, trusted) = (&mut answers.radiance, &mut answers.trusted);
    let viewers = points::vectors(table, columns::V);
    let lights = points::vectors(table, columns::L);
    let mut narrow: Vec<usize> = Vec::new();
    for (row, (point, &viewer)) in located.iter().zip(&viewers).enumerate() {
        let (_, material) = tracer.shading_at(point, viewer);
        if material.narrow().is_some() {
            narrow.push(row);
        }
        if material.broad().is_none() {
            radiance.iter_mut().for_each(|channel| channel[row] = 0.0);
            trusted[row] = true;
        }
    }
    let pick = |of: &[Vec3]| -> Vec<Vec3> { narrow.iter().map(|&row| of[row]).collect() };
    let places: Vec<SurfacePoint> = narrow.iter().map(|&row| located[row]).collect();
    let (own_viewers, own_lights) = (pick(&viewers), pick(&lights));
    let queries = NarrowQueries {
        points: &places,
        viewers: &own_viewers,
        rays: RAYS,
        seed: baked.manifest.seed,
    };
    let mut known = vec![true; narrow.len()];
    let model = (baked, nets);
    let answer: &mut AnswerMet = &mut |met| answer(model, tracer, met, &own_lights, &mut known);
    let found = narrow_light(tracer, queries, answer)?;
    for ((&row, found), known) in narrow.iter().zip(found).zip(known) {
        for (channel, x) in radiance.iter_mut().zip(found.to_array()) {
            channel[row] += x;
        }
        trusted[row] &= known;
    }
    Ok(())
}

/// Direct light and the nets' answers at points that rays met, each under its query's light of
/// 1 W/sr.
fn answer(
    (baked, nets): (&Baked, &BakedNets),
    tracer: &Tracer,
    met: &MetPoints,
    lights: &[Vec3],
    known: &mut [bool],
) -> Result<Vec<Vec3>, RenderError> {
    let mut rows = met.rows.clone();
    let of_light = || met.query.iter().map(|&query| lights[query as usize]);
    for (axis, column) in rows.columns[columns::L..].iter_mut().take(3).enumerate() {
        *column = of_light().map(|light| light[axis]).collect();
    }
    let (mut learned, mut cells): ([Vec<f32>; 3], _) = (Default::default(), Vec::new());
    nets.field.evaluate(&rows, &mut learned, &mut cells)?;
    let trusted = baked.trusted(&rows);
    let (mut rays, mut blocked) = (Rays::default(), Vec::new());
    let mut sums = Vec::with_capacity(met.points.len());
    for (row, (point, &viewer)) in met.points.iter().zip(met.viewers).enumerate() {
        let query = met.query[row] as usize;
        let (normal, material) = tracer.shading_at(point, viewer);
        let is_learned = material.broad().is_some_and(|broad| !broad.is_black());
        known[query] &= trusted[row] || !is_learned;
        let broad = Vec3::from_array([0, 1, 2].map(|c: usize| learned[c][row]));
        let to = lights[query] - point.position;
        let squared = to.length_squared().max(f32::MIN_POSITIVE);
        let is_above = point.normal.dot(to) * point.normal.dot(viewer) > 0.0;
        let direct = match is_above {
            true => material.eval(normal, viewer, to / squared.sqrt()) / squared,
            false => Vec3::ZERO,
        };
        let origin = tracer.lift(point.triangle, point.position, viewer);
        rays.push(origin, lights[query] - origin, 1.0);
        sums.push((if is_learned { broad } else { Vec3::ZERO }, direct));
    }
    tracer.occluded(&rays, &mut blocked);
    let whole = sums.into_iter().zip(blocked);
    Ok(whole
        .map(|((broad, direct), blocked)| broad + if blocked { Vec3::ZERO } else { direct })
        .collect())
}
