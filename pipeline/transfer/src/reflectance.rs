//! Directional albedos: a material's answer to light that is the same from all directions.
//!
//! The two parts of a row depend on the viewer mostly by how much of the light the
//! surface sends to it at all: Fresnel's factor, masking, Burley's retro-reflection. Divided by
//! these directional albedos, rows of different viewers are alike, and regression between them has
//! less to follow.

use crate::tracing::{Bsdf, Table, scramble};
use glam::Vec3;
use rayon::prelude::*;
use rrf_scene::{Material, Scene};

/// Cosines at which albedos are tabulated, from 0 to 1.
pub const COSINES: usize = 33;
/// Directions of light a cosine.
const DIRECTIONS: usize = 1024;
/// One fixed scramble a dimension: albedos are numbers, not estimates that differ.
const SCRAMBLES: [[u32; 2]; 3] = [
    [0x9e37_79b9, 0x7f4a_7c15],
    [0xf39c_c060, 0x5ced_c834],
    [0x1082_276b, 0xf3a2_7251],
];
/// Parts below this albedo are none.
pub(crate) const LEAST: f32 = 1e-5;

/// Directional albedos of the parts of each material: base part, constant part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reflectances {
    /// One a material and cosine, materials apart.
    pub albedos: Vec<[f32; 2]>,
}

impl Reflectances {
    /// Integrates every material of a scene, or its broad part alone, textures left out.
    pub fn new(scene: &Scene, broad: bool) -> Reflectances {
        let table = Table::new(DIRECTIONS);
        let albedos = (0..scene.materials.len() * COSINES).into_par_iter();
        let albedo = |i: usize| {
            let bsdf = answered(&scene.materials[i / COSINES], broad);
            let cosine = (i % COSINES) as f32 / (COSINES - 1) as f32;
            bsdf.map_or([0.0; 2], |bsdf| albedo(&bsdf, cosine.max(0.01), &table))
        };
        Reflectances {
            albedos: albedos.map(albedo).collect(),
        }
    }

    /// Albedos of a material's base and constant part for a viewer at this cosine.
    #[inline]
    pub fn at(&self, material: u32, facing: f32) -> [f32; 2] {
        let place = facing.clamp(0.0, 1.0) * (COSINES - 1) as f32;
        let low = (place as usize).min(COSINES - 2);
        let share = place - low as f32;
        let first = material as usize * COSINES + low;
        match self.albedos.get(first..first + 2) {
            Some([a, b]) => [0, 1].map(|k| a[k] + (b[k] - a[k]) * share),
            _ => [1.0, 0.0],
        }
    }

    /// Whether a material has a part at all.
    pub fn has(&self, material: u32, part: usize) -> bool {
        let first = material as usize * COSINES;
        let own = self.albedos.get(first..first + COSINES);
        own.is_some_and(|own| own.iter().any(|a| a[part] > LEAST))
    }
}

/// What rows are of a material; of one whose textures may give it a broad part, all of it.
fn answered(material: &Material, broad: bool) -> Option<Bsdf> {
    let whole = Bsdf::of(material);
    if !broad {
        return Some(whole);
    }
    whole.broad().or(material.varies().then_some(whole))
}

/// Mean of f cos / pdf, by the material's own sampler, for the two parts.
fn albedo(bsdf: &Bsdf, cosine: f32, table: &Table) -> [f32; 2] {
    let n = Vec3::Z;
    let v = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let coloured = |base_color| Bsdf {
        base_color,
        ..*bsdf
    };
    let (black, white) = (coloured(Vec3::ZERO), coloured(Vec3::ONE));
    let mut sums = [0.0f64; 2];
    for k in 0..DIRECTIONS {
        let point = table.reversed(k);
        let u = [0, 1, 2].map(|d: usize| scramble(point[d], SCRAMBLES[d]));
        let sampled = white.sample(n, v, u);
        if sampled.pdf > 0.0 {
            let constant = black.eval(n, v, sampled.l).x;
            let whole = white.eval(n, v, sampled.l).x;
            sums[0] += f64::from((whole - constant) / sampled.pdf);
            sums[1] += f64::from(constant / sampled.pdf);
        }
    }
    sums.map(|sum| (sum / DIRECTIONS as f64) as f32)
}
