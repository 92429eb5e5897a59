//! Direct irradiance of every patch.
//!
//! Each patch is asked at a few fixed points, stratified by area; what arrives there is the mean
//! over them. Small patches, which send on little, are asked at fewer. The points never change, so that a light which moves a little changes the
//! irradiance a little, and what stands still stays the same to the bit.

use crate::lights::{DirectLight, IncidentLight, Receiver, ReceiverId};
use crate::patches::Patches;
use crate::tracing::{Rays, Stream, Table, Tracer};
use glam::Vec3;
use rayon::prelude::*;

/// Patches asked together: their shadow rays are one batch.
const BATCH: usize = 64;
/// Points of a patch at least, if as many are asked for.
const LEAST: u32 = 4;

/// The fixed points of one side of a patch.
#[derive(Clone, Debug)]
pub(crate) struct Side {
    pub(crate) patch: u32,
    pub(crate) back: bool,
    pub(crate) points: Vec<Receiver>,
    pub(crate) triangles: Vec<u32>,
}

/// Light that reaches a point of a side.
struct Arrival {
    /// The side's number among those that are asked together, and the point's.
    side: u32,
    point: u32,
    column: u32,
    /// What it adds to the mean over the side's points [W/m^2].
    share: Vec3,
}

/// Asks for the direct irradiance of patches, always at the same points.
pub struct Receivers<'a> {
    tracer: &'a Tracer<'a>,
    patches: &'a Patches,
    sides: Vec<Side>,
}

impl<'a> Receivers<'a> {
    /// Places points on each side of each patch that has a column in `used`, or on all: `count` on
    /// the largest, on others as many as their area's share of that, but four or more. The
    /// error of the sum over patches is least so.
    pub fn new(
        tracer: &'a Tracer<'a>,
        patches: &'a Patches,
        count: u32,
        used: Option<&[bool]>,
        stream: Stream,
    ) -> Receivers<'a> {
        let table = Table::new(count as usize);
        let wanted = |patch: u32, back: bool| {
            let first = patches.first_column(patch, back) as usize;
            let columns = first..first + patches.directions(patch).pow(2) as usize;
            used.is_none_or(|used| used.get(columns).is_none_or(|c| c.contains(&true)))
        };
        let sides: Vec<(u32, bool)> = (0..patches.len() as u32)
            .flat_map(|patch| [(patch, false), (patch, true)])
            .filter(|&(patch, back)| wanted(patch, back))
            .collect();
        let largest = patches
            .area
            .iter()
            .copied()
            .fold(f32::MIN_POSITIVE, f32::max);
        let sides = sides.into_par_iter().map(|(patch, back)| {
            let share = patches.area[patch as usize] / largest;
            let wanted = (count as f32 * share).ceil() as u32;
            let own = wanted.clamp(LEAST.min(count), count);
            let points = patches.points(patch, own, stream, &table);
            Side {
                patch,
                back,
                triangles: points.iter().map(|p| p.triangle).collect(),
                points: (points.iter())
                    .map(|p| receiver(tracer, p.triangle, p.barycentrics, back))
                    .collect(),
            }
        });
        Receivers {
            tracer,
            patches,
            sides: sides.collect(),
        }
    }

    /// Sides of patches that are asked.
    pub fn sides(&self) -> usize {
        self.sides.len()
    }

    /// Points that are asked, all sides together.
    pub fn points(&self) -> usize {
        self.sides.iter().map(|side| side.points.len()).sum()
    }

    /// Sides and their points.
    pub(crate) fn each(&self) -> &[Side] {
        &self.sides
    }

    /// Sides and their points, for themselves.
    pub(crate) fn into_sides(self) -> Vec<Side> {
        self.sides
    }

    /// Direct irradiance of every column a channel [W/m^2]; of a glossy patch's directions, what
    /// arrives from each. Its bits do not depend on the number of threads.
    pub fn irradiance(&self, light: &dyn DirectLight) -> Vec<Vec3> {
        let batches: Vec<Vec<Arrival>> = self
            .sides
            .par_chunks(BATCH)
            .map(|sides| self.batch(sides, light))
            .collect();
        let mut columns = vec![Vec3::ZERO; self.patches.columns()];
        for arrival in batches.into_iter().flatten() {
            columns[arrival.column as usize] += arrival.share;
        }
        columns
    }

    /// Mean irradiance of each side [W/m^2], channels together, and its variance over the points.
    pub(crate) fn spreads(&self, light: &dyn DirectLight) -> Vec<[f32; 2]> {
        let batches = self.sides.par_chunks(BATCH).map(|sides| {
            let mut points: Vec<Vec<f32>> = (sides.iter())
                .map(|side| vec![0.0; side.points.len()])
                .collect();
            for arrival in self.batch(sides, light) {
                let own = &mut points[arrival.side as usize];
                // the share of one point is its value by their number
                own[arrival.point as usize] += arrival.share.element_sum() / 3.0 * own.len() as f32;
            }
            let spread = |points: Vec<f32>| {
                let count = points.len().max(1) as f32;
                let mean = points.iter().sum::<f32>() / count;
                let squares: f32 = points.iter().map(|x| (x - mean) * (x - mean)).sum();
                [mean, squares / (count - 1.0).max(1.0)]
            };
            points.into_iter().map(spread).collect::<Vec<[f32; 2]>>()
        });
        batches.flatten().collect()
    }

    /// What reaches the points of a few sides.
    fn batch(&self, sides: &[Side], light: &dyn DirectLight) -> Vec<Arrival> {
        let (mut rays, mut arriving) = (Rays::default(), Vec::new());
        // rays beyond mirrors, and which arrivals they belong to
        let (mut beyond, mut of_arrival) = (Rays::default(), Vec::new());
        if self.tracer.is_halted() {
            return Vec::new();
        }
        for (number, side) in (0..).zip(sides) {
            let share = 1.0 / side.points.len().max(1) as f32;
            for (k, (point, &triangle)) in side.points.iter().zip(&side.triangles).enumerate() {
                let id = ReceiverId {
                    owner: u64::from(side.patch) * 2 + u64::from(side.back),
                    point: k as u32,
                };
                light.arrivals(point, id, &mut |arrival: IncidentLight| {
                    let l = arrival.direction;
                    let cosine = point.shading.dot(l);
                    if cosine <= 0.0 || point.geometric.dot(l) <= 0.0 {
                        return;
                    }
                    let origin = self.tracer.lift(triangle, point.position, l);
                    let column = self.patches.column(side.patch, side.back, point.shading, l);
                    rays.push(origin, l, arrival.distance);
                    if let Some(leg) = arrival.beyond {
                        beyond.push(leg.origin, leg.direction, leg.distance);
                        of_arrival.push(arriving.len());
                    }
                    arriving.push(Arrival {
                        side: number,
                        point: k as u32,
                        column,
                        share: arrival.normal_irradiance * (cosine * share),
                    });
                });
            }
        }
        let (mut blocked, mut blocked_beyond) = (Vec::new(), Vec::new());
        self.tracer.occluded(&rays, &mut blocked);
        self.tracer.occluded(&beyond, &mut blocked_beyond);
        for (&arrival, beyond) in of_arrival.iter().zip(blocked_beyond) {
            blocked[arrival] |= beyond;
        }
        let free = arriving
            .into_iter()
            .zip(blocked)
            .filter(|(_, blocked)| !blocked);
        free.map(|(arrival, _)| arrival).collect()
    }
}

/// One side of a surface point.
fn receiver(tracer: &Tracer, triangle: u32, barycentrics: [f32; 2], back: bool) -> Receiver {
    let point = tracer.point(triangle, barycentrics);
    let geometric = if back { -point.normal } else { point.normal };
    Receiver {
        position: point.position,
        geometric,
        shading: tracer.normal_at(&point, geometric),
    }
}
