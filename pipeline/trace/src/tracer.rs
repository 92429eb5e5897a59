//! A scene made ready for rays: checked once, then only indexed.

use crate::TraceError;
use crate::check::check;
use crate::facets::Facet;
use crate::light_set::LightSet;
use crate::mirrors::Mirrors;
use crate::rays::{self, Hits, Rays};
use crate::walk::{Found, Ray, Stack, Wide};
use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;
use rrf_materials::Bsdf;
use rrf_scene::Scene;
use std::time::Duration;

/// A scene with a hierarchy over its triangles and what hits and samples need at hand.
///
/// Triangles without an area are left out: they can neither be hit nor sampled.
pub struct Tracer<'s> {
    pub(crate) scene: &'s Scene,
    /// The binary tree, for searches by place; its primitives index `kept`.
    pub(crate) bvh: Bvh2,
    /// Scene ids of the triangles in the hierarchy.
    pub(crate) kept: Vec<u32>,
    /// That tree, eight wide, for rays.
    pub(crate) wide: Wide,
    /// One row a scene triangle.
    pub(crate) facets: Vec<Facet>,
    /// One row a material, textures left out.
    pub(crate) materials: Vec<Bsdf>,
    /// Cumulative area of the scene's triangles, metres squared.
    pub(crate) area_cdf: Vec<f64>,
    /// Its area lights, shining as in the scene.
    pub(crate) lamps: LightSet,
    /// Whether some triangle encloses a solid that light travels in.
    pub(crate) encloses: bool,
    /// Whether light goes straight through some triangle.
    pub(crate) passes: bool,
    /// Its flat glossy surfaces.
    pub(crate) mirrors: Mirrors,
    /// Corners of the box about its triangles.
    pub(crate) bounds: [Vec3; 2],
    /// Whether to give up.
    halt: Option<&'s (dyn Fn() -> bool + Sync)>,
}

impl<'s> Tracer<'s> {
    /// Checks every id and coordinate of the scene and builds the hierarchy.
    pub fn new(scene: &'s Scene) -> Result<Tracer<'s>, TraceError> {
        check(scene)?;
        let count = scene.triangles.len();
        let (mut facets, mut area_cdf) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut areas = Vec::with_capacity(count);
        let (mut kept, mut corners, mut total) = (Vec::new(), Vec::new(), 0.0);
        for id in 0..count {
            let (facet, area) = Facet::new(scene, id);
            facets.push(facet);
            areas.push(area);
            total += area;
            area_cdf.push(total);
            if area > 0.0 {
                kept.push(id as u32);
                corners.push(scene.triangles[id].map(|v| scene.positions[v as usize]));
            }
        }
        if kept.is_empty() {
            return Err(TraceError::NoTriangles);
        }
        let bvh = build(&corners);
        let all = corners.as_flattened();
        let bounds = [
            all.iter().copied().fold(Vec3::INFINITY, Vec3::min),
            all.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max),
        ];
        Ok(Tracer {
            scene,
            wide: Wide::new(&bvh, &corners, &kept),
            bvh,
            bounds,
            kept,
            mirrors: Mirrors::new(scene, &facets, &areas),
            encloses: facets.iter().any(|facet| facet.encloses),
            passes: facets.iter().any(|facet| facet.passes),
            facets,
            materials: scene.materials.iter().map(Bsdf::of).collect(),
            lamps: LightSet::new(scene, &area_cdf, scene.area_lights.clone(), []),
            area_cdf,
            halt: None,
        })
    }

    /// A tracer that gives up soon after `halt` says so: estimates then end with
    /// [`TraceError::Halted`]. Once it has said so it must not change its mind.
    pub fn until(self, halt: &'s (dyn Fn() -> bool + Sync)) -> Tracer<'s> {
        Tracer {
            halt: Some(halt),
            ..self
        }
    }

    /// Whether it has been told to give up. Cheap enough for every thousand rays.
    pub fn is_halted(&self) -> bool {
        self.halt.is_some_and(|halt| halt())
    }

    /// # Errors
    /// [`TraceError::Halted`] where it has been told to give up.
    pub fn unless_halted<T>(&self, result: T) -> Result<T, TraceError> {
        match self.is_halted() {
            true => Err(TraceError::Halted),
            false => Ok(result),
        }
    }

    /// The scene that is traced.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// Whether flat glossy surfaces are looked at on purpose, which takes its time.
    pub fn has_mirrors(&self) -> bool {
        !self.mirrors.is_empty()
    }

    /// The closest triangle of every ray, into `hits`. Rays pass where an alpha mask lets more than
    /// half of the light through.
    pub fn closest(&self, rays: &Rays, hits: &mut Hits) {
        if !self.passes {
            return rays::closest_columns(&self.wide, rays, hits);
        }
        let skip = |ray: &Ray, found: &mut Found, stack: &mut Stack| {
            self.skip_holes(ray, found, stack);
        };
        rays::closest_columns_by(&self.wide, rays, hits, skip);
    }

    /// Whether no light passes along each ray, into `blocked`.
    pub fn occluded(&self, rays: &Rays, blocked: &mut Vec<bool>) {
        rays::occluded_columns(&self.wide, rays, blocked);
        if self.passes {
            let mut shares = Vec::new();
            self.transmitted(rays, &mut shares);
            blocked.clear();
            blocked.extend(shares.iter().map(|share| *share == Vec3::ZERO));
        }
    }

    /// Share of light that passes along each ray, into `shares`: 1 where nothing lies on it, 0 where
    /// it is blocked, and the product of the transmittances of thin panes and alpha masks between.
    pub fn transmitted(&self, rays: &Rays, shares: &mut Vec<Vec3>) {
        let mut blocked = Vec::new();
        rays::occluded_columns(&self.wide, rays, &mut blocked);
        let (mut stack, mut hits) = (self.wide.stack(), Vec::new());
        shares.clear();
        for (ray, blocked) in rays.rows().zip(blocked) {
            shares.push(match (blocked, self.passes) {
                (false, _) => Vec3::ONE,
                (true, false) => Vec3::ZERO,
                (true, true) => self.transmittance(&ray, &mut stack, &mut hits),
            });
        }
    }

    /// A ray's origin just off a triangle, on the side that `direction` leaves to.
    #[inline]
    pub fn lift(&self, triangle: u32, position: Vec3, direction: Vec3) -> Vec3 {
        let facet = &self.facets[triangle as usize];
        let back = facet.normal.dot(direction) < 0.0;
        position + facet.normal * if back { -facet.lift } else { facet.lift }
    }
}

fn build(corners: &[[Vec3; 3]]) -> Bvh2 {
    let triangles: Vec<Triangle> = corners
        .iter()
        .map(|&[v0, v1, v2]| Triangle {
            v0: v0.into(),
            v1: v1.into(),
            v2: v2.into(),
        })
        .collect();
    let parameters = BvhBuildParams {
        // A split triangle would stand in several leaves.
        pre_split: false,
        // The collapse to eight children chooses the leaves.
        max_prims_per_leaf: 1,
        ..BvhBuildParams::slow_build()
    };
    build_bvh2_from_tris(&triangles, parameters, &mut Duration::default())
}
