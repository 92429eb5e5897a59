//! Which part of a visible point's material is followed, and by how many rays.

use glam::Vec3;
use rrf_materials::{Bsdf, INVALID, Material};
use rrf_scene::Scene;

/// Density [1/sr] from which on a lobe is narrower than a pixel: one ray is enough. Of a lobe of GGX
/// alpha a that is seen head on the density is 1/(4 π a²); this is a roughness of 0.05.
const SHARP: f32 = 1e4;
/// Rays of a pixel into a lobe that is not sharp.
pub(crate) const RAYS: u32 = 4;
/// Roughness up to which broad lobes send rays for the sake of lamps, and how many.
const GLOSSY_ROUGHNESS: f32 = 0.5;
const GLOSSY_RAYS: u32 = 2;
/// Halvings that find the share of a reflection.
const BISECTIONS: u32 = 20;
/// The centre of a lobe, by the numbers that choose a direction in it.
const CENTRE: [f32; 2] = [0.0, 0.0];

/// What a frame needs of the rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Following {
    /// Narrow parts are followed for all light, since no net answers for them.
    pub(crate) narrow: bool,
    /// Lamps or a sky shine, which rays can meet.
    pub(crate) lamps: bool,
    /// Rays of a pixel into a lobe that is not sharp.
    pub(crate) rays: u32,
}

/// What rays bring back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Brings {
    /// All light.
    All,
    /// The emission of lamps and sky.
    Lamps,
    /// All light but that emission.
    Surfaces,
}

/// A part of a visible point's material that sends rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FollowedPart {
    /// The part, as a material of its own.
    pub(crate) bsdf: Bsdf,
    /// The rest of the material, if there is any.
    pub(crate) rest: Option<Bsdf>,
    /// Rays of each row.
    pub(crate) rays: u32,
    /// Whether the lobe is narrower than a pixel. Shadow rays do not ask for lamps in it.
    pub(crate) is_sharp: bool,
    /// What the rays bring back.
    pub(crate) brings: Brings,
}

impl Following {
    /// The part of a material that is followed from a point that sends the share `throughput` of its
    /// light to the eye; `first` if the eye sees it itself, by one of `camera_rays` rays a pixel.
    pub(crate) fn part(
        self,
        material: &Bsdf,
        (normal, viewer): (Vec3, Vec3),
        throughput: f32,
        camera_rays: Option<u32>,
    ) -> Option<FollowedPart> {
        let several = |most: f32| match camera_rays {
            Some(rays) => ((most / rays as f32).ceil() as u32).max(1),
            None => 1,
        };
        if let Some(bsdf) = material.narrow() {
            if !self.narrow && !self.lamps {
                return None;
            }
            let middle = bsdf.sample(normal, viewer, [0.5, CENTRE[0], CENTRE[1]]);
            let is_sharp = middle.pdf >= SHARP;
            let share = (throughput * middle.weight.max_element()).min(1.0);
            return Some(FollowedPart {
                bsdf,
                rest: material.broad(),
                rays: match is_sharp {
                    true => 1,
                    false => several(self.rays as f32 * share.sqrt()),
                },
                is_sharp,
                brings: match self.narrow {
                    true => Brings::All,
                    false => Brings::Lamps,
                },
            });
        }
        (self.lamps && is_glossy(material)).then(|| FollowedPart {
            bsdf: *material,
            rest: None,
            rays: several(GLOSSY_RAYS as f32),
            is_sharp: false,
            brings: Brings::Lamps,
        })
    }
}

/// Whether a material has a lobe that lamps are looked for in.
fn is_glossy(material: &Bsdf) -> bool {
    let lobe = (material.kind.lobe)(material);
    lobe.is_some_and(|lobe| lobe.alpha < GLOSSY_ROUGHNESS * GLOSSY_ROUGHNESS)
}

/// Whether a surface of the scene may have a part that is followed.
pub(crate) fn has_lobes(scene: &Scene) -> bool {
    let has_lobe = |material: &Material| {
        let constants = Bsdf::of(material);
        let textured = (material.own.iter()).any(|parameter| parameter.texture != INVALID);
        let lobed = (material.kind.lobe)(&constants).is_some();
        let varies = textured || material.roughness_metallic_texture != INVALID;
        constants.narrow().is_some() || lobed && (varies || is_glossy(&constants))
    };
    scene.materials.iter().any(has_lobe)
}

impl FollowedPart {
    /// It without the emission of lamps and sky, where that is all left to shadow rays.
    pub(crate) fn without_emission(self) -> Option<FollowedPart> {
        (self.brings == Brings::All).then_some(FollowedPart {
            brings: Brings::Surfaces,
            ..self
        })
    }

    /// The part of a material that is gathered over: all but the narrow one.
    pub(crate) fn gather(material: &Bsdf, rays: u32) -> Option<FollowedPart> {
        Some(FollowedPart {
            bsdf: material.broad()?,
            rest: None,
            rays,
            is_sharp: false,
            brings: Brings::Surfaces,
        })
    }

    /// Whether its rays bring the emission of lamps and sky.
    pub(crate) fn brings_emission(&self) -> bool {
        self.brings != Brings::Surfaces
    }

    /// f cos θ toward `l`, less what the rays bring, where shadow rays of density `shadow_density` ask
    /// for a lamp.
    pub(crate) fn value_beside_rays(
        &self,
        (normal, viewer, l): (Vec3, Vec3, Vec3),
        shadow_density: f32,
    ) -> Vec3 {
        let rest = self
            .rest
            .map_or(Vec3::ZERO, |rest| rest.eval(normal, viewer, l));
        if self.is_sharp {
            return rest;
        }
        let own = self.rays as f32 * self.bsdf.pdf(normal, viewer, l);
        let weight = shadow_density / (shadow_density + own).max(f32::MIN_POSITIVE);
        rest + weight * self.bsdf.eval(normal, viewer, l)
    }

    /// Share of the sharp reflection of a surface that also lets light through, as clear glass does:
    /// one ray each for reflection and refraction then leave no noise. `None` for one direction, or
    /// many.
    pub(crate) fn branch(&self, normal: Vec3, viewer: Vec3) -> Option<f32> {
        if !self.is_sharp || !self.bsdf.kind.transmits {
            return None;
        }
        let reflects = |lobe: f32| {
            let u = self.place([lobe, 0.0, 0.0]);
            self.bsdf.sample(normal, viewer, u).l.dot(normal) > 0.0
        };
        let (mut low, mut high) = (0.0, 1.0 - 0.5 * f32::EPSILON);
        if reflects(low) == reflects(high) {
            return None;
        }
        // the sampler takes reflection below some number, and that is its share
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if reflects(middle) == reflects(0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(0.5 * (low + high))
    }

    /// The numbers that choose a ray's direction: those of a sharp lobe's centre, else the given ones.
    pub(crate) fn place(&self, u: [f32; 3]) -> [f32; 3] {
        match self.is_sharp {
            true => [u[0], CENTRE[0], CENTRE[1]],
            false => u,
        }
    }
}
