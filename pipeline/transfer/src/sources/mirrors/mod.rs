//! Light that flat mirrors throw straight on a surface: the image of a light of any kind.
//!
//! A point x behind a mirror's plane at its own image x' sees the light as x sees it in the mirror.
//! So a light's arrivals at x', folded back, are those by way of the mirror: exact for every kind
//! of light, and paths need not find a lobe that is narrower than any patch's directions.

mod find;
mod plane;

use super::numbers::Numbers;
use crate::lights::{DirectLight, IncidentLight, Leg, Receiver, ReceiverId};
use crate::rows::RowPoint;
use crate::tracing::{Rays, Tracer};
use glam::Vec3;
use plane::Mirror;
use rayon::prelude::*;

/// Samples of a surrounding light a mirror.
const SURROUNDING: u32 = 4;

/// The flat mirrors of a scene.
pub struct FlatMirrors<'a> {
    tracer: &'a Tracer<'a>,
    mirrors: Vec<Mirror>,
    /// Distance from a plane below which a point lies on it, metres.
    clear: f32,
    numbers: Numbers,
}

impl<'a> FlatMirrors<'a> {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.mirrors.is_empty()
    }

    /// A light, and its images in the mirrors. Mirrors themselves receive nothing: what they show
    /// is the image.
    pub fn of<'m, L: DirectLight>(&'m self, light: L) -> Mirrored<'m, L> {
        Mirrored {
            mirrors: self,
            light,
        }
    }

    /// Whether a place on a surface of that normal lies on one of them.
    pub(crate) fn has(&self, position: Vec3, normal: Vec3) -> bool {
        self.mirrors.iter().any(|m| {
            m.height(position).abs() < 0.5 * self.clear && m.normal.dot(normal).abs() > 0.9999
        })
    }

    fn is_on_mirror(&self, at: &Receiver) -> bool {
        self.has(at.position, at.geometric)
    }

    /// Arrivals by way of the mirrors alone.
    pub fn images(
        &self,
        light: &dyn DirectLight,
        at: &Receiver,
        id: ReceiverId,
        arrive: &mut dyn FnMut(IncidentLight),
    ) {
        let bounds = light.bounds();
        for mirror in &self.mirrors {
            let height = mirror.height(at.position);
            if height.abs() < self.clear || !mirror.is_above(at) {
                continue;
            }
            if light.surrounding(mirror.normal).is_some() {
                self.surroundings(mirror, light, at, id, arrive);
                continue;
            }
            if bounds.is_some_and(|bounds| !mirror.may_show(bounds, at.position)) {
                continue;
            }
            let fold = |v: Vec3| mirror.fold(v);
            let image = Receiver {
                position: at.position - 2.0 * height * mirror.normal,
                geometric: fold(at.geometric),
                shading: fold(at.shading),
            };
            light.arrivals(&image, id, &mut |incident| {
                let direction = fold(incident.direction);
                let way = -height / mirror.normal.dot(direction);
                // from the front, and the light farther than the mirror
                let rest = incident.distance - way;
                if way > 0.0 && way.is_finite() && rest > 0.0 {
                    let bent = IncidentLight {
                        direction,
                        distance: rest,
                        ..incident
                    };
                    self.send(mirror, at, way, bent, arrive);
                }
            });
        }
    }

    /// A light from all around, by directions to the mirror: the light's own would mostly miss it.
    fn surroundings(
        &self,
        mirror: &Mirror,
        light: &dyn DirectLight,
        at: &Receiver,
        id: ReceiverId,
        arrive: &mut dyn FnMut(IncidentLight),
    ) {
        let set = self.numbers.of(id);
        for k in 0..SURROUNDING {
            let u = set.take(k, 7);
            let Some((direction, way, angle)) = mirror.sample(self.tracer.scene(), at.position, u)
            else {
                continue;
            };
            let radiance = light
                .surrounding(mirror.fold(direction))
                .unwrap_or(Vec3::ZERO);
            if radiance != Vec3::ZERO && at.shading.dot(direction) > 0.0 {
                let irradiance = radiance * (angle / SURROUNDING as f32);
                let incident = IncidentLight::straight(direction, f32::INFINITY, irradiance);
                self.send(mirror, at, way, incident, arrive);
            }
        }
    }

    /// Hands on light that comes by way of a place on the mirror's plane, `way` metres off; its distance
    /// is that from the mirror.
    fn send(
        &self,
        mirror: &Mirror,
        at: &Receiver,
        way: f32,
        incident: IncidentLight,
        arrive: &mut dyn FnMut(IncidentLight),
    ) {
        let direction = incident.direction;
        let place = at.position + direction * way;
        if at.geometric.dot(direction) <= 0.0 {
            return;
        }
        let Some(reflectance) = mirror.reflectance(self.tracer, place, direction) else {
            return;
        };
        let side = mirror.height(at.position).signum();
        let off = mirror.normal * (0.25 * self.clear * side);
        arrive(IncidentLight {
            direction,
            distance: way - 0.25 * self.clear,
            normal_irradiance: incident.normal_irradiance * reflectance,
            beyond: Some(Leg {
                origin: place + off,
                direction: mirror.fold(direction),
                distance: incident.distance,
            }),
        });
    }

    /// Radiance [W/(sr m²)] that rows send to their viewers by way of a mirror and their own
    /// surface: two reflections, of which none is a patch's. Row i has the name `first + i`.
    pub fn at_rows(&self, light: &dyn DirectLight, rows: &[RowPoint], first: u64) -> Vec<Vec3> {
        self.at_rows_in(self.tracer, false, light, rows, first)
    }

    /// [`FlatMirrors::at_rows`] where triangles are those of `tracer`'s scene, which may have more lamps,
    /// by the whole of their own surfaces or by its broad part alone.
    pub fn at_rows_in(
        &self,
        tracer: &Tracer,
        broad: bool,
        light: &dyn DirectLight,
        rows: &[RowPoint],
        first: u64,
    ) -> Vec<Vec3> {
        if self.is_empty() {
            return vec![Vec3::ZERO; rows.len()];
        }
        let indices = (0..rows.len()).into_par_iter();
        let one = |i: usize| self.at_row(light, (tracer, broad), &rows[i], first + i as u64);
        indices.map(one).collect()
    }

    fn at_row(
        &self,
        light: &dyn DirectLight,
        (tracer, broad): (&Tracer, bool),
        row: &RowPoint,
        owner: u64,
    ) -> Vec3 {
        let point = &row.point;
        let back = point.normal.dot(row.viewer) < 0.0;
        let (shading, bsdf) = tracer.shading_at(point, row.viewer);
        let bsdf = if broad { bsdf.broad() } else { Some(bsdf) };
        let Some(bsdf) = bsdf else {
            return Vec3::ZERO;
        };
        let at = Receiver {
            position: point.position,
            geometric: if back { -point.normal } else { point.normal },
            shading,
        };
        if self.is_on_mirror(&at) {
            return Vec3::ZERO;
        }
        let (mut near, mut far, mut values) = (Rays::default(), Rays::default(), Vec::new());
        self.images(
            light,
            &at,
            ReceiverId { owner, point: 0 },
            &mut |incident| {
                let Some(leg) = incident.beyond else { return };
                let value = bsdf.eval(shading, row.viewer, incident.direction);
                if value != Vec3::ZERO {
                    let origin =
                        (self.tracer).lift(point.triangle, point.position, incident.direction);
                    near.push(origin, incident.direction, incident.distance);
                    far.push(leg.origin, leg.direction, leg.distance);
                    values.push(value * incident.normal_irradiance);
                }
            },
        );
        let mut blocked = [Vec::new(), Vec::new()];
        self.tracer.occluded(&near, &mut blocked[0]);
        self.tracer.occluded(&far, &mut blocked[1]);
        let free = |i: &usize| !blocked[0][*i] && !blocked[1][*i];
        (0..values.len()).filter(free).map(|i| values[i]).sum()
    }
}

/// A light with its images in flat mirrors.
pub struct Mirrored<'a, L> {
    mirrors: &'a FlatMirrors<'a>,
    light: L,
}

impl<L: DirectLight> DirectLight for Mirrored<'_, L> {
    fn arrivals(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        if self.mirrors.is_on_mirror(at) {
            return;
        }
        self.light.arrivals(at, id, arrive);
        self.mirrors.images(&self.light, at, id, arrive);
    }
}
