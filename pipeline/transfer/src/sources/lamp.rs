//! Emitting triangles as direct light.
//!
//! A receiver chooses triangles by what each would send it if nothing stood in the way, to first
//! order, and directions on the chosen one by solid angle. A lamp that lies on the surface is
//! thus no harder than one far away.

use super::numbers::Numbers;
use super::triangle::SeenTriangle;
use crate::lights::{DirectLight, IncidentLight, Receiver, ReceiverId};
use crate::tracing::Stream;
use glam::Vec3;
use rrf_lights::AreaLight;
use rrf_scene::Scene;
use std::hash::{DefaultHasher, Hasher};

/// Samples a point.
const SAMPLES: u32 = 4;
/// Shadow rays end this share of their length before the lamp.
const SHORT: f32 = 2e-4;

/// A patch is at most this share of its distance to a lamp.
const SHARE_OF_DISTANCE: f32 = 0.5;
/// Distance below which a lamp asks for no finer patches, relative to `edge`.
const NEAREST: f32 = 0.25;

/// A size field for patches whose common edge is `edge` \[m\]: finer where lamps of the scene are near, whose
/// light falls steeply there.
pub fn finer_near_lamps(scene: &Scene, edge: f32) -> impl Fn(Vec3) -> f32 + Sync + use<> {
    let mut places = Vec::new();
    for (corners, &light) in scene.triangles.iter().zip(&scene.triangle_light) {
        if scene.area_lights.get(light as usize).is_some() {
            let [a, b, c] = corners.map(|v| scene.positions[v as usize]);
            places.extend([
                (a + b + c) / 3.0,
                a,
                b,
                c,
                (a + b) / 2.0,
                (b + c) / 2.0,
                (c + a) / 2.0,
            ]);
        }
    }
    move |at: Vec3| {
        let nearest = places.iter().map(|p| p.distance_squared(at));
        let distance = nearest.fold(f32::INFINITY, f32::min).sqrt();
        (SHARE_OF_DISTANCE * distance / edge).clamp(NEAREST, 1.0)
    }
}

/// A group of triangles that shine.
pub struct Lamp {
    triangles: Vec<Shining>,
    numbers: Numbers,
}

struct Shining {
    corners: [Vec3; 3],
    centre: Vec3,
    /// Normal times area.
    area: Vec3,
    /// Longest edge, squared.
    edge2: f32,
    light: AreaLight,
    /// Share of the lamp's radiance: below 1 where a picture says so.
    share: Vec3,
}

impl Lamp {
    /// The triangles of those of a scene's area lights that `wanted` names by their ids.
    pub fn new(scene: &Scene, wanted: impl Fn(u32) -> bool, stream: Stream) -> Lamp {
        let mut triangles = Vec::new();
        let columns = scene.triangles.iter().zip(&scene.triangle_light);
        for (id, (corners, &light)) in (0..).zip(columns) {
            let Some(area_light) = scene.area_lights.get(light as usize) else {
                continue;
            };
            let corners = corners.map(|v| scene.positions[v as usize]);
            let [a, b, c] = corners;
            let area = 0.5 * (b - a).cross(c - a);
            if !wanted(light) || area == Vec3::ZERO || area_light.radiance == Vec3::ZERO {
                continue;
            }
            let edges = [b - a, c - b, a - c].map(Vec3::length_squared);
            let share = scene.mean_share(id);
            triangles.push(Shining {
                corners,
                centre: (a + b + c) / 3.0,
                area,
                edge2: edges.into_iter().fold(0.0, f32::max),
                // a picture by its mean over the triangle
                light: AreaLight {
                    radiance: area_light.radiance * share,
                    ..*area_light
                },
                share,
            });
        }
        Lamp {
            triangles,
            numbers: Numbers::new(stream, SAMPLES),
        }
    }

    /// The same lamp with that many samples a point.
    #[must_use]
    pub fn with_samples(mut self, samples: u32) -> Lamp {
        self.numbers.each = samples.max(1);
        self
    }

    /// Whether nothing shines.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }
}

/// Lamps of one light's name and one radiance, in white.
pub(crate) struct WhiteLamp {
    pub(crate) lamp: Lamp,
    /// Radiance [W/(sr m²)].
    pub(crate) colour: Vec3,
    /// Tells its places and sides from those of other lamps.
    pub(crate) key: u64,
}

/// The lamps of a scene.
pub(crate) fn white_lamps(scene: &Scene, stream: Stream) -> Vec<WhiteLamp> {
    let mut kinds: Vec<(&str, [u32; 3])> = Vec::new();
    let kind = |id: usize| {
        let name = scene.area_light_names.get(id).map_or("", String::as_str);
        let radiance = scene.area_lights[id].radiance;
        (name, radiance.to_array().map(f32::to_bits))
    };
    for id in 0..scene.area_lights.len() {
        if !kinds.contains(&kind(id)) {
            kinds.push(kind(id));
        }
    }
    (kinds.into_iter())
        .map(|of| {
            let mut lamp = Lamp::new(scene, |id| kind(id as usize) == of, stream);
            let mut hasher = DefaultHasher::new();
            for triangle in &mut lamp.triangles {
                triangle.light.radiance = triangle.share;
                hasher.write_u8(u8::from(triangle.light.two_sided));
                let places = triangle.corners.iter().chain([&triangle.share]);
                let numbers = places.flat_map(|c| c.to_array());
                numbers.for_each(|x| hasher.write_u32(x.to_bits()));
            }
            WhiteLamp {
                lamp,
                colour: Vec3::from(of.1.map(f32::from_bits)),
                key: hasher.finish(),
            }
        })
        .filter(|white| !white.lamp.is_empty())
        .collect()
}

impl Shining {
    /// About what it sends to a point if nothing stands in the way, channels together; 0 only where it sends
    /// nothing.
    fn level(&self, at: &Receiver) -> f32 {
        let to = self.centre - at.position;
        let squared = to.length_squared();
        // by the plane, which is exact: all of a triangle turns its back or none
        let toward = -self.area.dot(to);
        if toward <= 0.0 && !self.light.two_sided {
            return 0.0;
        }
        let above = |c: &Vec3| (*c - at.position).dot(at.geometric) > 0.0;
        if !self.corners.iter().any(above) {
            return 0.0;
        }
        let angle = if squared > 4.0 * self.edge2 {
            toward.abs() / (squared * squared.sqrt())
        } else {
            SeenTriangle::new(self.corners, at.position).solid_angle as f32
        };
        // part of a near triangle may stand higher than its centre
        let reach = (self.edge2 / squared.max(f32::MIN_POSITIVE))
            .sqrt()
            .min(1.0);
        let cosine = at.shading.dot(to) / squared.sqrt().max(f32::MIN_POSITIVE);
        let cosine = (cosine.max(0.0) + 0.5 * reach + 0.01).min(1.0);
        self.light.radiance.element_sum() * angle * cosine
    }
}

impl DirectLight for Lamp {
    fn arrivals(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        let mut total = 0.0f64;
        let cumulative = self.triangles.iter().map(|t| {
            total += f64::from(t.level(at));
            total
        });
        let cumulative: Vec<f64> = cumulative.collect();
        if total <= 0.0 {
            return;
        }
        let set = self.numbers.of(id);
        let samples = self.numbers.each;
        for k in 0..samples {
            let [which, u, v] = set.take(k, 4);
            let chosen = rrf_sampling::warp::by_weight(&cumulative, which);
            let probability = rrf_sampling::warp::by_weight_probability(&cumulative, chosen);
            let Some(triangle) = self.triangles.get(chosen) else {
                continue;
            };
            let seen = SeenTriangle::new(triangle.corners, at.position);
            let Some((direction, distance, angle)) = seen.sample([u, v]) else {
                continue;
            };
            let radiance = triangle.light.emitted(triangle.area, -direction);
            let weight = angle / (samples as f32 * probability as f32);
            if radiance != Vec3::ZERO && at.shading.dot(direction) > 0.0 {
                let free = distance * (1.0 - SHORT);
                arrive(IncidentLight::straight(direction, free, radiance * weight));
            }
        }
    }

    fn bounds(&self) -> Option<[Vec3; 2]> {
        let corners = self.triangles.iter().flat_map(|t| t.corners);
        let start = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        (!self.is_empty()).then(|| corners.fold(start, |[a, b], c| [a.min(c), b.max(c)]))
    }
}
