//! Where rows are traced.

use super::config::TransferConfig;
use crate::TransferError;
use crate::patches::Patches;
use crate::query::{SurfaceKey, TransferQuery};
use crate::row_config::RowConfig;
use crate::rows::{RowPoint, trace_rows};
use crate::tracing::{Rays, Stream, Tracer, unless_halted};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Offers surface points and viewers, as the eyes of a scene come to see them.
pub trait PointDraw: Sync {
    /// The points `first..first + count` of a sequence that never changes; fewer where some of
    /// them see nothing.
    fn draw(&self, first: u64, count: usize) -> Vec<RowPoint>;
}

impl<F> PointDraw for F
where
    F: Fn(u64, usize) -> Vec<RowPoint> + Sync,
{
    fn draw(&self, first: u64, count: usize) -> Vec<RowPoint> {
        self(first, count)
    }
}

/// Points that were chosen.
pub(crate) struct Chosen {
    pub(crate) points: Vec<RowPoint>,
    /// Others, spread as eyes see.
    pub(crate) even: Vec<RowPoint>,
}

/// Paths of a look.
const LOOK: RowConfig = RowConfig {
    paths: 16,
    keep: 0.5,
    broad: false,
};
/// Distances below this are alike, metres.
const NEAREST: f32 = 0.02;
/// Viewers at a smaller cosine see nothing to speak of.
const GRAZING: f32 = 0.02;
/// Cosine between normals of points of one face.
const ALIKE: f32 = 0.5;
/// Tries of a point beside another.
const TRIES: u32 = 8;
/// Heights of ways between neighbouring points, relative to how far apart they may be.
const HEIGHTS: [f32; 3] = [1.0, 0.25, 0.06];
/// Share of the rows that are spread evenly over what is seen.
const EVEN: f32 = 0.3;

/// Chooses points where light falls steeply more often: as 1 / the squared harmonic mean of the
/// distances around them (Ward, Rubinstein, Clear 1988), and as often as `least_rows` asks on
/// faces that are seldom seen.
pub(crate) fn choose(
    tracer: &Tracer,
    patches: &Patches,
    draw: &dyn PointDraw,
    config: &TransferConfig,
    stream: Stream,
) -> Result<Chosen, TransferError> {
    let pool = draw.draw(0, (config.rows as f32 * config.pool.max(1.0)) as usize);
    unless_halted(tracer)?;
    if pool.is_empty() || config.rows == 0 {
        return Err(TransferError::NoRows);
    }
    let keys: Vec<(SurfaceKey, u8)> = (pool.par_iter())
        .map(|point| face(&TransferQuery::of_row(tracer, point)))
        .collect();
    let mut seen: BTreeMap<(SurfaceKey, u8), Vec<u32>> = BTreeMap::new();
    for (i, &key) in keys.iter().enumerate() {
        seen.entry(key).or_default().push(i as u32);
    }
    unless_halted(tracer)?;
    let numbers = stream.part(3);
    let unit = |i: usize, block: u32| numbers.units(i as u64, 0, block);
    let share = config.rows as f32 * config.candidates.max(1.0) / pool.len() as f32;
    let rare = |i: usize| {
        seen.get(&keys[i])
            .is_some_and(|of| of.len() < config.least_rows)
    };
    let looked: Vec<usize> = (0..pool.len())
        .filter(|&i| unit(i, 0)[0] < share || rare(i))
        .collect();
    unless_halted(tracer)?;
    let mut wanted = steep(tracer, patches, &pool, &looked, config, stream)?;
    for members in seen.values() {
        let least = config.least_rows as f32 / members.len() as f32;
        let few = members.iter().filter(|&&i| unit(i as usize, 0)[1] < least);
        few.for_each(|&i| wanted[i as usize] = true);
    }
    let mut points: Vec<RowPoint> = (0..pool.len())
        .filter(|&i| wanted[i])
        .map(|i| pool[i])
        .collect();
    for members in seen.values() {
        for k in members.len()..config.least_rows {
            let like = &pool[members[k % members.len()] as usize];
            points.extend(beside(
                tracer,
                like,
                unit(members[0] as usize, 1 + k as u32),
            ));
        }
    }
    let even = looked.iter().map(|&i| pool[i]).collect();
    Ok(Chosen { points, even })
}

/// Which of the points that are looked at become rows.
fn steep(
    tracer: &Tracer,
    patches: &Patches,
    pool: &[RowPoint],
    looked: &[usize],
    config: &TransferConfig,
    stream: Stream,
) -> Result<Vec<bool>, TransferError> {
    let points: Vec<RowPoint> = looked.iter().map(|&i| pool[i]).collect();
    let rows = trace_rows(tracer, patches, &points, &LOOK, stream.part(2), 0)?;
    let near: Vec<f32> = rows.distance.iter().map(|d| 1.0 / d.max(NEAREST)).collect();
    let mean = near.iter().sum::<f32>() / near.len().max(1) as f32;
    let most = config.candidates.max(1.0);
    let chance = |k: usize| (EVEN + (1.0 - EVEN) * (near[k] / mean).powi(2)).min(most);
    let total: f32 = (0..looked.len()).map(chance).sum();
    let by = config.rows as f32 / total;
    let mut wanted = vec![false; pool.len()];
    for (k, &i) in looked.iter().enumerate() {
        wanted[i] = stream.part(3).units(i as u64, 0, 0)[2] < by * chance(k);
    }
    Ok(wanted)
}

/// Columns that some paths from the points meet.
pub(crate) fn met(
    tracer: &Tracer,
    patches: &Patches,
    points: &[RowPoint],
    stream: Stream,
) -> Result<Vec<bool>, TransferError> {
    Ok(trace_rows(tracer, patches, points, &LOOK, stream.part(8), 0)?.used())
}

/// Another point of the same triangle, seen from the same direction.
fn beside(tracer: &Tracer, like: &RowPoint, u: [f32; 4]) -> Option<RowPoint> {
    let barycentrics = rrf_sampling::warp::uniform_triangle([u[0], u[1]]);
    let point = tracer.point(like.point.triangle, barycentrics);
    let facing = TransferQuery::new(tracer, &point, like.viewer).facing();
    (facing > GRAZING).then_some(RowPoint { point, ..*like })
}

/// Another point of the same surface around one; none where something parts the two, such as the
/// wall of a box that stands on the surface. Half of the tries are uniform over a disk in its
/// plane, the others over its triangle, which finds more on strips that are narrow beside the disk.
pub(crate) fn near(
    tracer: &Tracer,
    like: &RowPoint,
    radius: f32,
    numbers: &dyn Fn(u32) -> [f32; 4],
) -> Option<RowPoint> {
    (0..TRIES).find_map(|k| near_once(tracer, like, radius, numbers(k), k % 2 == 0))
}

fn near_once(
    tracer: &Tracer,
    like: &RowPoint,
    radius: f32,
    u: [f32; 4],
    in_disk: bool,
) -> Option<RowPoint> {
    let own = TransferQuery::of_row(tracer, like);
    let point = if in_disk {
        let (x, y) = own.geometric.any_orthonormal_pair();
        let (sin, cos) = (std::f32::consts::TAU * u[0]).sin_cos();
        let place = own.position + (x * cos + y * sin) * (radius * u[1].sqrt());
        tracer.locate(place, own.geometric)?
    } else {
        let barycentrics = rrf_sampling::warp::uniform_triangle([u[0], u[1]]);
        let point = tracer.point(like.point.triangle, barycentrics);
        let is_near = point.position.distance(own.position) <= radius;
        is_near.then_some(point)?
    };
    let other = TransferQuery::new(tracer, &point, like.viewer);
    let is_same = other.surface == own.surface && other.geometric.dot(own.geometric) > ALIKE;
    if !is_same || other.facing() <= GRAZING {
        return None;
    }
    // by way of a place above the one that eyes see: high up, or lower where that is in a gap
    let is_parted = |height: f32| {
        let above = own.position + own.geometric * height;
        let mut rays = Rays::default();
        for from in [&like.point, &point] {
            let origin = tracer.lift(from.triangle, from.position, above - from.position);
            rays.push(origin, above - origin, 1.0);
        }
        let mut blocked = Vec::new();
        tracer.occluded(&rays, &mut blocked);
        blocked.contains(&true)
    };
    let joined = HEIGHTS.iter().any(|height| !is_parted(height * radius));
    joined.then_some(RowPoint { point, ..*like })
}

/// A surface and which of six ways it faces there.
fn face(query: &TransferQuery) -> (SurfaceKey, u8) {
    let n = query.geometric;
    let axis = n.abs().max_position() as u8;
    (query.surface, 2 * axis + u8::from(n[axis as usize] < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracing::Hits;
    use glam::Vec3;
    use rrf_sampling::Stage;
    use rrf_scene::{LoadOptions, load};

    /// Rows beside rows of the Cornell box's floor never lie under its boxes, from where the ceiling, 2 m
    /// above, is not seen; and most are found.
    #[test]
    fn rows_beside_rows_stay_in_the_open() {
        let file = "/../../scenes/cornell-box/scene.pbrt";
        let path = format!("{}{file}", env!("CARGO_MANIFEST_DIR"));
        let scene = load(path.as_ref(), &LoadOptions::default())
            .unwrap()
            .unlit();
        let tracer = Tracer::new(&scene).unwrap();
        let is_open = |point: &crate::tracing::SurfacePoint| {
            let (mut rays, mut hits) = (Rays::default(), Hits::default());
            let origin = tracer.lift(point.triangle, point.position, Vec3::Y);
            rays.push(origin, Vec3::Y, f32::INFINITY);
            tracer.closest(&rays, &mut hits);
            let hit = tracer.point(hits.triangle[0], hits.barycentrics[0]);
            hit.position.y > 1.9
        };
        let stream = Stream::new(3, Stage::Test, 12);
        let (mut asked, mut found) = (0, 0);
        for i in 0..3_000 {
            let u = stream.units(i, 0, 0);
            let place = Vec3::new(1.8 * u[0] - 0.9, 0.0, 1.8 * u[1] - 0.9);
            let Some(point) = tracer.locate(place, Vec3::Y) else {
                continue;
            };
            if point.position.y > 0.01 || !is_open(&point) {
                continue;
            }
            let viewer = Vec3::new(0.3, 1.0, 0.2).normalize();
            let like = RowPoint { point, viewer };
            asked += 1;
            if let Some(other) = near(&tracer, &like, 0.3, &|k| stream.units(i, k, 1)) {
                assert!(is_open(&other.point), "{:?}", other.point);
                found += 1;
            }
        }
        assert!(asked > 1_000 && 3 * found > asked, "{found} of {asked}");
    }
}
