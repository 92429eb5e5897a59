//! Points, spots, the sun and the sky as direct light.
//!
//! A light of single directions needs no choice. The sky is sampled in two ways, by its own light
//! and by the receiver's cosine, weighted by the balance heuristic (Veach and Guibas 1995): the
//! one finds what is bright, the other what a window leaves.

use super::numbers::Numbers;
use crate::lights::{DirectLight, IncidentLight, Receiver, ReceiverId};
use crate::tracing::Stream;
use glam::Vec3;
use rrf_lights::{LightSource, about};
use rrf_materials::{cosine_hemisphere, cosine_hemisphere_pdf};

/// Samples of the sky a point.
const SKY_SAMPLES: u32 = 32;

/// A light source that sends straight light.
pub struct SourceLight<'a> {
    source: &'a LightSource,
    numbers: Numbers,
}

impl<'a> SourceLight<'a> {
    /// With as many samples a point as the kind of light asks for.
    pub fn new(source: &'a LightSource, stream: Stream) -> SourceLight<'a> {
        let samples = match source {
            LightSource::Environment(_) => SKY_SAMPLES,
            LightSource::Distant(_) => 1,
            LightSource::Point(_) | LightSource::Goniometric(_) | LightSource::Spot(_) => 0,
        };
        SourceLight::with_samples(source, stream, samples)
    }

    /// With that many samples a point; 0 and 1 are the same for a light of single directions.
    pub fn with_samples(source: &'a LightSource, stream: Stream, samples: u32) -> SourceLight<'a> {
        SourceLight {
            source,
            numbers: Numbers::new(stream, samples),
        }
    }

    /// Half of the samples by the sky's light, half by the cosine.
    fn sky(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        let set = self.numbers.of(id);
        let by_cosine = self.numbers.each / 2;
        let by_light = self.numbers.each - by_cosine;
        let mut send = |toward: Vec3, radiance: Vec3, density: f32| {
            let cosine = at.shading.dot(toward);
            let both = by_light as f32 * density + by_cosine as f32 * cosine_hemisphere_pdf(cosine);
            if radiance != Vec3::ZERO && cosine > 0.0 && both > 0.0 {
                arrive(IncidentLight::straight(
                    toward,
                    f32::INFINITY,
                    radiance / both,
                ));
            }
        };
        for k in 0..by_light {
            let arrival = self.source.sample(at.position, set.take(k, 0));
            if let Some((arrival, density)) = arrival.and_then(|a| Some((a, a.density?))) {
                send(arrival.toward, arrival.irradiance * density, density);
            }
        }
        for k in 0..by_cosine {
            let toward = about(at.shading, cosine_hemisphere(set.take(k, 2)));
            let density = self.source.density(at.position, toward);
            send(toward, self.source.radiance(toward), density);
        }
    }
}

impl DirectLight for SourceLight<'_> {
    fn arrivals(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        if self.source.is_sky() {
            return self.sky(at, id, arrive);
        }
        let samples = self.numbers.each.max(1);
        let set = (self.numbers.each > 0).then(|| self.numbers.of(id));
        for k in 0..samples {
            let u = set.as_ref().map_or([0.5; 2], |set| set.take(k, 0));
            if let Some(arrival) = self.source.sample(at.position, u) {
                arrive(IncidentLight::straight(
                    arrival.toward,
                    arrival.distance,
                    arrival.irradiance / samples as f32,
                ));
            }
        }
    }

    fn bounds(&self) -> Option<[Vec3; 2]> {
        self.source.position().map(|position| [position; 2])
    }

    fn surrounding(&self, toward: Vec3) -> Option<Vec3> {
        self.source.is_sky().then(|| self.source.radiance(toward))
    }
}
