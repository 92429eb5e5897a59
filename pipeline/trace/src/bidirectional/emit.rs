//! The lights' end of a path: its point or direction, what it sends, and how dense that is.

use super::beams::Beams;
use crate::openings::{Openings, aim, aim_density};
use crate::tracer::Tracer;
use crate::wave::{Part, Row, Source};
use glam::Vec3;
use rrf_lights::{DistantLight, EmittingPoint, LightSource, about, uniform_sphere};
use rrf_materials::cosine_hemisphere;
use std::f32::consts::FRAC_1_PI;

/// Lights that are chosen among each other. A path asks each group on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// Points of light.
    Points,
    /// Triangles that emit.
    Lamps,
    /// Lights from afar.
    Far,
}

/// The end of a path on a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub(super) group: Group,
    /// Which light of the group.
    source: u32,
    /// Position; of light from afar, the unit direction to it.
    pub(super) at: Vec3,
    /// Where on a lamp, its geometric normal, and the lift of its rays.
    place: EmittingPoint,
    outward: Vec3,
    lift: f32,
    /// Density with which light subpaths begin here: a probability, or that times a density with
    /// respect to area or solid angle.
    pub(super) emit: f32,
}

/// Light that arrives at a point from an end of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sent {
    /// Unit direction from the point to the light.
    pub(super) toward: Vec3,
    /// Of a light that is chosen with the density of its end: irradiance on a surface that faces it.
    pub(super) irradiance: Vec3,
    /// Density of its own ray to the point with respect to area on a surface that faces it.
    pub(super) leave: f32,
    /// Squared distance over the cosine at the light: area there an angle here; 1 from afar.
    pub(super) area_per_angle: f32,
}

/// Lights of a row, and where their subpaths begin.
pub(super) struct Lights<'a> {
    tracer: &'a Tracer<'a>,
    source: Source<'a>,
    /// The row's own point or sun.
    place: Vec3,
    own_sun: LightSource,
    /// How light from afar comes in.
    beams: Beams<'a>,
}

impl<'a> Lights<'a> {
    pub(super) fn new(part: &Part<'a>, row: &Row, openings: Option<&'a Openings>) -> Lights<'a> {
        let bounds = part.tracer.bounds;
        Lights {
            tracer: part.tracer,
            source: part.source,
            place: row.light,
            own_sun: DistantLight::sun(row.light, Vec3::ONE).into(),
            beams: Beams {
                center: 0.5 * (bounds[0] + bounds[1]),
                radius: 0.5 * (bounds[1] - bounds[0]).length() * (1.0 + 1e-5),
                openings,
            },
        }
    }

    /// The groups that have a light.
    pub(super) fn groups(&self) -> impl Iterator<Item = Group> + use<> {
        let points = self.source.has_points().then_some(Group::Points);
        let lamps = self.source.triangles().map(|_| Group::Lamps);
        let far = self.source.has_far().then_some(Group::Far);
        [points, lamps, far].into_iter().flatten()
    }

    /// A light from afar by a number in [0, 1), and what the choice leaves of the number.
    fn far(&self, u: f32) -> Option<(u32, &LightSource, f32)> {
        match self.source {
            Source::Set { set, .. } => {
                let (index, within) = set.far.choose_within(u);
                Some((index, set.far.source(index)?, within))
            }
            _ => Some((0, &self.own_sun, u)),
        }
    }

    fn far_source(&self, index: u32) -> Option<(&LightSource, f32)> {
        match self.source {
            Source::Set { set, .. } => {
                let probability = set.far.probability(index);
                set.far.source(index).map(|source| (source, probability))
            }
            _ => Some((&self.own_sun, 1.0)),
        }
    }

    /// Lights from afar that a ray can meet, by their numbers.
    pub(super) fn visible_from_afar(&self) -> impl Iterator<Item = u32> + '_ {
        let set = match self.source {
            Source::Set { set, .. } => set.far.visible(),
            _ => &[(0, 1.0)],
        };
        set.iter().map(|&(index, _)| index)
    }

    /// An end of a path by three numbers in [0, 1), for light that is to arrive at `at`, or, without a
    /// point, to begin a light subpath: its density there is [`Lights::choice`], here [`End::emit`].
    pub(super) fn end(&self, group: Group, at: Option<Vec3>, u: [f32; 3]) -> Option<End> {
        match group {
            Group::Points => {
                let (source, position, emit) = match self.source {
                    Source::Set { set, .. } => {
                        let (index, probability) = set.points.choose(u[0]);
                        let position = set.points.source(index)?.position()?;
                        (index, position, probability)
                    }
                    _ => (0, self.place, 1.0),
                };
                Some(End {
                    emit,
                    ..End::at(group, source, position)
                })
            }
            Group::Lamps => {
                let (_, triangles) = self.source.triangles()?;
                let place = triangles.sample(u)?;
                Some(self.on_lamp(place, triangles.density(place.triangle)))
            }
            Group::Far => {
                let (index, source, within) = self.far(u[0])?;
                let toward = match at {
                    Some(at) => aim(source, self.beams.openings, at, [within, u[1], u[2]])?,
                    None => self.beams.toward(source, [within, u[1], u[2]])?,
                };
                Some(self.far_end(index, toward))
            }
        }
    }

    /// The end on a lamp that a ray has met.
    pub(super) fn met_lamp(&self, triangle: u32, barycentrics: [f32; 2]) -> Option<End> {
        let (_, triangles) = self.source.triangles()?;
        let density = triangles.density(triangle);
        let place = EmittingPoint {
            triangle,
            barycentrics,
        };
        (density > 0.0).then(|| self.on_lamp(place, density))
    }

    fn on_lamp(&self, place: EmittingPoint, emit: f32) -> End {
        let facet = &self.tracer.facets[place.triangle as usize];
        End {
            place,
            outward: facet.normal,
            lift: facet.lift,
            emit,
            ..End::at(Group::Lamps, 0, facet.position(place.barycentrics))
        }
    }

    /// The end in a direction to a light from afar.
    pub(super) fn far_end(&self, index: u32, toward: Vec3) -> End {
        let mut end = End::at(Group::Far, index, toward);
        if let Some((source, probability)) = self.far_source(index) {
            end.emit = probability * self.beams.direction_density(source, toward);
        }
        end
    }

    /// Density with which [`Lights::end`] chooses an end for light that arrives at `at`.
    pub(super) fn choice(&self, end: &End, at: Vec3) -> f32 {
        if end.group != Group::Far {
            return end.emit;
        }
        let Some((source, probability)) = self.far_source(end.source) else {
            return 0.0;
        };
        match source.is_visible() {
            true => probability * aim_density(source, self.beams.openings, at, end.at),
            false => probability,
        }
    }

    /// Light that arrives at a point from an end, if any.
    pub(super) fn sent(&self, end: &End, to: Vec3) -> Option<Sent> {
        match end.group {
            Group::Points => {
                let apart = end.at - to;
                let distance2 = apart.length_squared();
                let toward = apart.try_normalize()?;
                let (intensity, density) = match self.source {
                    Source::Set { set, .. } => {
                        let source = set.points.source(end.source)?;
                        (
                            source.intensity_toward(-toward),
                            source.leave_density(-toward),
                        )
                    }
                    _ => (Vec3::ONE, 0.25 * FRAC_1_PI),
                };
                (distance2 > 0.0).then(|| Sent {
                    toward,
                    irradiance: intensity / distance2,
                    leave: density / distance2,
                    area_per_angle: 0.0,
                })
            }
            Group::Lamps => {
                let (set, _) = self.source.triangles()?;
                let apart = end.at - to;
                let distance2 = apart.length_squared();
                let toward = apart.try_normalize()?;
                let place = (end.place.triangle, end.place.barycentrics);
                let radiance = set.emission(self.tracer.scene, place, end.outward, -toward);
                let cosine = end.outward.dot(toward).abs();
                let per_area = cosine / distance2;
                let shines = (cosine > 0.0) & (distance2 > 0.0) & (radiance != Vec3::ZERO);
                shines.then(|| Sent {
                    toward,
                    irradiance: radiance * per_area,
                    leave: per_area * FRAC_1_PI / self.sides(end),
                    area_per_angle: 1.0 / per_area,
                })
            }
            Group::Far => {
                let (source, _) = self.far_source(end.source)?;
                let radiance = match source.is_visible() {
                    true => source.radiance(end.at),
                    false => source.sample(to, [0.5, 0.5])?.irradiance,
                };
                Some(Sent {
                    toward: end.at,
                    irradiance: radiance,
                    leave: self.beams.density(source, to, end.at),
                    area_per_angle: f32::from(u8::from(source.is_visible())),
                })
            }
        }
    }

    /// Sides that a lamp shines from.
    fn sides(&self, end: &End) -> f32 {
        let scene = self.tracer.scene;
        let id = scene.triangle_light[end.place.triangle as usize];
        let two = scene
            .area_lights
            .get(id as usize)
            .is_some_and(|light| light.two_sided);
        if two { 2.0 } else { 1.0 }
    }

    /// The first ray of a light subpath, by three numbers in [0, 1): origin and unit direction, as
    /// dense as [`Sent::leave`] says.
    pub(super) fn leave(&self, end: &End, u: [f32; 3]) -> Option<(Vec3, Vec3)> {
        match end.group {
            Group::Points => {
                let u = [u[0], u[1]];
                let direction = match self.source {
                    Source::Set { set, .. } => set.points.source(end.source)?.leave(u)?.direction,
                    _ => uniform_sphere(u),
                };
                Some((end.at, direction))
            }
            Group::Lamps => {
                let back = self.sides(end) > 1.0 && u[2] < 0.5;
                let normal = if back { -end.outward } else { end.outward };
                let direction = about(normal, cosine_hemisphere([u[0], u[1]]));
                Some((end.at + normal * end.lift, direction))
            }
            Group::Far => {
                let (source, _) = self.far_source(end.source)?;
                let from = self.beams.leave(source, end.at, u)?;
                Some((from, -end.at))
            }
        }
    }

    /// Where a shadow ray from `origin` goes, and how far.
    pub(super) fn shadow(&self, end: &End, origin: Vec3) -> (Vec3, f32) {
        match end.group {
            Group::Points => (end.at - origin, 1.0),
            Group::Lamps => {
                let front = end.outward.dot(origin - end.at) > 0.0;
                let lift = if front { end.lift } else { -end.lift };
                (end.at + end.outward * lift - origin, 1.0)
            }
            Group::Far => (end.at, f32::INFINITY),
        }
    }
}

impl End {
    fn at(group: Group, source: u32, at: Vec3) -> End {
        End {
            group,
            source,
            at,
            place: EmittingPoint {
                triangle: 0,
                barycentrics: [0.0; 2],
            },
            outward: Vec3::Z,
            lift: 0.0,
            emit: 0.0,
        }
    }
}
