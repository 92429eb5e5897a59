//! Lights to be sampled, in groups.

use super::emitter::Emitter;
use super::light_tree::{Descent, LightTree};
use crate::tile::VisiblePoints;
use glam::Vec3;
use rrf_lights::{Arrival, LightSource};
use rrf_materials::Bsdf;
use rrf_metrics::color::luminance;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{Openings, SurfacePoint, Tracer};

/// Roughness from which on a lobe counts as even.
const BROAD: f32 = 0.7;
/// Base level of surfaces, for lobes beside it.
const LEAST_BASE: f32 = 0.05;
/// Shadow rays that a row is taken to have.
const USUAL_RAYS: f32 = 16.0;

/// The least share of a sky that is taken to arrive, however few of the pilot's rays did.
const LEAST_ARRIVING: f32 = 0.01;

/// Lights to be sampled: those with a place, and those from afar.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampledLights<'f> {
    pub(crate) emitters: Vec<Emitter>,
    pub(crate) tree: LightTree,
    pub(crate) far: Vec<&'f LightSource>,
    /// Irradiance of each light from afar, by luminance.
    far_level: Vec<f32>,
    /// Where skies are seen, if that was looked for.
    openings: Option<Openings>,
}

impl<'f> SampledLights<'f> {
    pub(crate) fn new(emitters: Vec<Emitter>, far: Vec<&'f LightSource>) -> SampledLights<'f> {
        // through a sphere of cross section 1; a surface gets a quarter of what comes from all around
        let radius = (1.0 / std::f32::consts::PI).sqrt();
        let level = |source: &&LightSource| match source {
            LightSource::Environment(_) => 0.25 * luminance(source.power(radius)),
            _ => luminance(source.power(radius)),
        };
        SampledLights {
            tree: LightTree::new(&emitters),
            emitters,
            far_level: far.iter().map(level).collect(),
            far,
            openings: None,
        }
    }

    /// Aims at the openings that skies are seen through from some points by unit directions to their
    /// viewers, and from what these see.
    pub(crate) fn aim_at_openings(
        &mut self,
        tracer: &Tracer,
        seen: (&[SurfacePoint], &[Vec3]),
        seed: u64,
    ) {
        // the last of the stages' cells, which count surfaces
        let stream = Stream::new(seed, Stage::Direct, u32::MAX);
        self.openings = tracer.openings_of(&self.far, seen, stream);
        // Or a hidden sky would take nearly all rays from lamps. Where it is seen it is seen far better
        // than on average: the root lies between the two.
        let Some(openings) = &self.openings else {
            return;
        };
        let arriving = openings.arriving().max(LEAST_ARRIVING).sqrt();
        for (level, light) in self.far_level.iter_mut().zip(&self.far) {
            if light.is_sky() {
                *level *= arriving;
            }
        }
    }

    /// Light that arrives from one of those from afar, by three numbers in [0, 1).
    fn arrival(&self, far: usize, at: Vec3, [u, x, y]: [f32; 3]) -> Option<Arrival> {
        let light = self.far.get(far)?;
        match self.openings(light) {
            Some(openings) => openings.arrival(light, at, [u, x, y]),
            None => light.sample(at, [x, y]),
        }
    }

    /// Density of [`SampledLights::arrival`] with respect to solid angle [1/sr].
    fn density(&self, light: &LightSource, at: Vec3, toward: Vec3) -> f32 {
        match self.openings(light) {
            Some(openings) => openings.density(light, at, toward),
            None => light.density(at, toward),
        }
    }

    fn openings(&self, light: &LightSource) -> Option<&Openings> {
        self.openings.as_ref().filter(|_| light.is_sky())
    }

    /// How much light could arrive at a point whose surface faces `side`: what the choice among
    /// lights is made by, material left out.
    pub(crate) fn level_at(&self, at: Vec3, side: Vec3) -> f32 {
        let groups = (0..self.tree.groups()).map(|group| self.tree.reach(group, at, side).0);
        groups.chain(self.far_level.iter().copied()).sum()
    }

    /// About the density [1/sr] of a row's shadow rays to a lamp of some level, where lights of
    /// [`SampledLights::level_at`] arrive. The weights of shadow rays and of the rays that meet lamps
    /// by themselves follow from it; an approximation does no harm, since they sum to one.
    pub(crate) fn shadow_density(level: f32, all: f32) -> f32 {
        USUAL_RAYS * level / all.max(f32::MIN_POSITIVE)
    }

    /// Radiance that a ray brings from afar; `rival` as in [`crate::follow::Carried`].
    pub(crate) fn far_beside_shadow_rays(&self, at: Vec3, toward: Vec3, rival: f32) -> Vec3 {
        let lights = self.far.iter().zip(&self.far_level);
        let weighted = lights.map(|(light, level)| {
            let density = level * self.density(light, at, toward).max(f32::MIN_POSITIVE);
            light.radiance(toward) / (1.0 + rival * density)
        });
        weighted.sum()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.emitters.is_empty() && self.far.is_empty()
    }

    /// Lights, each by itself.
    pub(crate) fn count(&self) -> usize {
        self.emitters.len() + self.far.len()
    }

    /// Groups of lights: those of the tree, then each light from afar.
    pub(crate) fn groups(&self) -> usize {
        self.tree.groups() + self.far.len()
    }

    /// How much of each group's light could leave a visible point by `material`, in proportion,
    /// appended.
    pub(crate) fn reach(
        &self,
        seen: &VisiblePoints,
        row: usize,
        material: &Bsdf,
        reach: &mut Vec<f32>,
    ) {
        if !seen.is_asked(row) {
            reach.extend(std::iter::repeat_n(0.0, self.groups()));
            return;
        }
        let (point, v, normal) = (&seen.points[row], seen.viewers[row], seen.normals[row]);
        let side = seen.side(row);
        let base = luminance(material.base_color).max(LEAST_BASE) / std::f32::consts::PI;
        // beside an even lobe, the light of the group's middle alone where the lobe is another
        let lobe = |l: Vec3| {
            let cosine = normal.dot(l);
            match material.roughness >= BROAD || cosine <= 0.0 {
                true => 0.0,
                false => luminance(material.eval(normal, v, l)) / cosine,
            }
        };
        for group in 0..self.tree.groups() {
            let (bound, middle) = self.tree.reach(group, point.position, side);
            let factor = match bound > 0.0 {
                true => base + lobe((middle - point.position).normalize_or_zero()),
                false => 0.0,
            };
            reach.push(bound * factor);
        }
        reach.extend(self.far_level.iter().map(|level| level * base));
    }
}

/// A point of a light that a shadow ray goes to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    /// Unit direction to it.
    pub(crate) toward: Vec3,
    /// Where the ray ends; light from afar has no place.
    pub(crate) place: Option<Vec3>,
    /// Unoccluded irradiance on a surface square to it [W/m²].
    pub(crate) irradiance: Vec3,
    /// Level of the lamp, times its own density if it is afar; `None` for points, which rays do not
    /// meet.
    pub(crate) level: Option<f32>,
}

impl SampledLights<'_> {
    /// A point of a light, counted over all of them, by three numbers in [0, 1).
    pub(crate) fn end_of(
        &self,
        seen: &VisiblePoints,
        row: usize,
        light: u32,
        [aim, u0, u1]: [f32; 3],
    ) -> Option<End> {
        let (x, u) = (seen.points[row].position, [u0, u1]);
        let Some(emitter) = self.emitters.get(light as usize) else {
            let far = (light as usize).checked_sub(self.emitters.len())?;
            let arrival = self.arrival(far, x, [aim, u0, u1])?;
            return Some(End {
                toward: arrival.toward,
                place: None,
                irradiance: arrival.irradiance,
                level: arrival.density.map(|density| density * self.far_level[far]),
            });
        };
        let place = emitter.place(u);
        Some(End {
            toward: (place - x).normalize_or_zero(),
            place: Some(emitter.before(place, x)),
            irradiance: emitter.arriving(place, x),
            level: (emitter.level > 0.0).then_some(emitter.level),
        })
    }

    /// A point of a light of a group, and the light's probability in it.
    pub(crate) fn end_in_group(
        &self,
        seen: &VisiblePoints,
        row: usize,
        (group, left): (u32, f32),
        [u0, u1]: [f32; 2],
        descent: &mut Descent,
    ) -> Option<(End, f32)> {
        let Some(far) = (group as usize).checked_sub(self.tree.groups()) else {
            let (point, side) = (&seen.points[row], seen.side(row));
            let (light, share) =
                self.tree
                    .choose(group as usize, (point.position, side), left, descent)?;
            return Some((self.end_of(seen, row, light, [0.0, u0, u1])?, share));
        };
        let light = (self.emitters.len() + far) as u32;
        let end = self.end_of(seen, row, light, [left, u0, u1])?;
        Some((end, 1.0))
    }
}
