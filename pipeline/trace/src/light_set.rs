//! Lights that shine together, and the choice among them.

use crate::lamps::{emission, emitting_triangles};
use crate::openings::{Openings, aim_density};
use glam::Vec3;
use rrf_lights::{Arrival, EmittingTriangles, LightSource};
use rrf_sampling::warp::{by_weight, by_weight_probability};
use rrf_scene::{AreaLight, Scene};

/// Lights that shine on a scene together: surfaces that emit, points, and lights from afar.
///
/// A path asks each of the three groups on its own, so that a sky does not take the rays of a
/// lamp. Within a group lights are chosen by their power.
#[derive(Clone, Debug, Default)]
pub struct LightSet {
    /// One for each area light of the scene; black where it does not shine.
    pub(crate) areas: Vec<AreaLight>,
    pub(crate) triangles: EmittingTriangles,
    pub(crate) points: LightGroup,
    pub(crate) far: LightGroup,
    /// Where its skies are seen, if that was looked for ([`crate::Tracer::find_openings`]).
    pub(crate) openings: Option<Openings>,
}

impl LightSet {
    /// `areas` are the scene's area lights, dimmed or not; `area_cdf` is the cumulative area of
    /// its triangles. Lights without power are left out.
    pub(crate) fn new(
        scene: &Scene,
        area_cdf: &[f64],
        areas: Vec<AreaLight>,
        sources: impl IntoIterator<Item = LightSource>,
    ) -> LightSet {
        let (points, far) = sources
            .into_iter()
            .partition(|source: &LightSource| source.position().is_some());
        LightSet {
            triangles: emitting_triangles(scene, area_cdf, &areas),
            areas,
            points: LightGroup::new(points),
            far: LightGroup::new(far),
            openings: None,
        }
    }

    /// Whether nothing shines.
    pub fn is_dark(&self) -> bool {
        self.triangles.is_empty() && self.points.is_empty() && self.far.is_empty()
    }

    /// Whether light comes from all around.
    pub fn has_sky(&self) -> bool {
        self.far.sources.iter().any(LightSource::is_sky)
    }

    /// Radiance [W/(sr m²)] that a ray meets that leaves the scene in direction `toward`.
    pub fn radiance_from_afar(&self, toward: Vec3) -> Vec3 {
        self.far.sources.iter().map(|s| s.radiance(toward)).sum()
    }

    /// Radiance [W/(sr m²)] that a triangle emits toward `v` at a point by its barycentrics;
    /// `outward` is its geometric normal.
    #[inline]
    pub(crate) fn emission(
        &self,
        scene: &Scene,
        at: (u32, [f32; 2]),
        outward: Vec3,
        v: Vec3,
    ) -> Vec3 {
        emission(scene, &self.areas, at, outward, v)
    }
}

/// The largest number that a choice takes.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

/// Lights that are chosen by their power.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightGroup {
    sources: Vec<LightSource>,
    /// Cumulative power, channels together, up to a common factor.
    cdf: Vec<f64>,
    /// Those that a ray can meet, with the probability of their choice.
    visible: Vec<(u32, f32)>,
}

impl LightGroup {
    fn new(sources: Vec<LightSource>) -> LightGroup {
        let mut group = LightGroup::default();
        let mut total = 0.0;
        for source in sources {
            // all lights from afar shine through a sphere of any one radius
            let power = f64::from(source.power(1.0).element_sum());
            if power > 0.0 {
                total += power;
                group.cdf.push(total);
                group.sources.push(source);
            }
        }
        for (k, source) in (0u32..).zip(&group.sources) {
            if source.is_visible() {
                let probability = by_weight_probability(&group.cdf, k as usize);
                group.visible.push((k, probability as f32));
            }
        }
        group
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.sources.is_empty()
    }

    pub(crate) fn source(&self, index: u32) -> Option<&LightSource> {
        self.sources.get(index as usize)
    }

    /// Those that a ray can meet, with the probability of their choice.
    pub(crate) fn visible(&self) -> &[(u32, f32)] {
        &self.visible
    }

    /// Probability of [`LightGroup::choose`] to choose a light.
    pub(crate) fn probability(&self, index: u32) -> f32 {
        by_weight_probability(&self.cdf, index as usize) as f32
    }

    /// A light by a number in [0, 1): which one, and the probability.
    pub(crate) fn choose(&self, u: f32) -> (u32, f32) {
        let index = by_weight(&self.cdf, u);
        let probability = by_weight_probability(&self.cdf, index) as f32;
        (index as u32, probability)
    }

    /// A light by a number in [0, 1): which one, and the number's place among those that choose it,
    /// again in [0, 1).
    pub(crate) fn choose_within(&self, u: f32) -> (u32, f32) {
        let (index, probability) = self.choose(u);
        let before = match index.checked_sub(1).and_then(|k| self.cdf.get(k as usize)) {
            Some(before) => before / self.cdf.last().copied().unwrap_or(1.0),
            None => 0.0,
        };
        let within = (f64::from(u) - before) / f64::from(probability);
        (index, (within as f32).clamp(0.0, BELOW_ONE))
    }

    /// Light that arrives at `at` from one of them, by three numbers in [0, 1), skies by
    /// way of openings too: its irradiance is over the probability of the choice, its density times it.
    pub(crate) fn sample(
        &self,
        at: Vec3,
        u: [f32; 3],
        openings: Option<&Openings>,
    ) -> Option<Arrival> {
        let (index, probability) = self.choose(u[0]);
        let source = self.source(index)?;
        let arrival = match openings.filter(|_| source.is_sky()) {
            None => source.sample(at, [u[1], u[2]])?,
            Some(openings) => {
                let (_, within) = self.choose_within(u[0]);
                openings.arrival(source, at, [within, u[1], u[2]])?
            }
        };
        Some(Arrival {
            irradiance: arrival.irradiance / probability,
            density: arrival.density.map(|density| density * probability),
            ..arrival
        })
    }

    /// Radiance [W/(sr m²)] from direction `toward`, each light's by the balance heuristic of a
    /// direction of density `density` against [`LightGroup::sample`] at `at`.
    pub(crate) fn met(
        &self,
        at: Vec3,
        toward: Vec3,
        density: f32,
        openings: Option<&Openings>,
    ) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for &(index, probability) in &self.visible {
            if let Some(source) = self.source(index) {
                sum += shared((source, probability), at, toward, density, openings);
            }
        }
        sum
    }
}

/// Radiance of a light from direction `toward` by the balance heuristic of a direction of density
/// `density` against the light's own sampler, chosen with a probability, and its openings.
pub(crate) fn shared(
    (source, probability): (&LightSource, f32),
    at: Vec3,
    toward: Vec3,
    density: f32,
    openings: Option<&Openings>,
) -> Vec3 {
    let radiance = source.radiance(toward);
    if radiance == Vec3::ZERO {
        return radiance;
    }
    let other = probability * aim_density(source, openings, at, toward);
    radiance * (density / (density + other))
}
