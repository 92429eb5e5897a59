//! Candidate rows of one cell: a surface point, a side, a viewer direction, a light position.
//!
//! Candidate `k` of a draw is point `k` of a scrambled Sobol sequence seeded by (seed, stream):
//! the surface point is uniform over the area of the triangles that reach into the cell, the
//! viewer direction uniform over the hemisphere, the light uniform in the cell's part of the
//! light box. What falls outside the cell is rejected, so the accepted rows are uniform in it.

use crate::outlook::{Lookout, Outlook};
use crate::sobol::Sobol;
use crate::{Census, LightBox};
use glam::Vec3;
use rayon::prelude::*;
use rrf_field::columns::{self, Columns};
use rrf_field::tree::Domain;
use rrf_scene::{INVALID, MaterialKind, Scene};
use rrf_trace::{SurfacePoint, Tracer};

/// Why a candidate was left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// It lies in another cell.
    OtherCell,
    /// The light is inside a solid.
    LightInSolid,
    /// The point is inside a solid, or sealed under one.
    PointInSolid,
    /// No ray of the point's hemisphere hits anything: no indirect light can arrive.
    SeesNothing,
    /// The surface reflects nothing.
    Black,
}

/// One accepted row.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Raw columns.
    pub raw: [f32; columns::COUNT],
    /// Where the point lies.
    pub surface: SurfacePoint,
    /// Material id.
    pub material: u32,
}

/// Draws the candidates of one cell.
pub struct Proposal<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer<'a>,
    lookout: &'a Lookout<'a>,
    triangles: Vec<u32>,
    /// Running sum of the triangles' areas.
    area: Vec<f64>,
    domain: Domain,
    light: LightBox,
    sobol: Sobol,
}

impl<'a> Proposal<'a> {
    /// The candidates inside `domain`; none where no triangle or light reaches into it.
    pub fn new(
        scene: &'a Scene,
        tracer: &'a Tracer<'a>,
        lookout: &'a Lookout<'a>,
        domain: Domain,
        light_box: LightBox,
        seed: u64,
    ) -> Option<Proposal<'a>> {
        let light = light_box.within(&domain)?;
        let triangles: Vec<u32> = (0..scene.triangles.len() as u32)
            .filter(|&t| reaches(scene, t, &domain))
            .collect();
        let mut sum = 0.0;
        let area: Vec<f64> = triangles
            .iter()
            .map(|&t| {
                sum += scene.triangle_area(t as usize);
                sum
            })
            .collect();
        (sum > 0.0).then(|| Proposal {
            scene,
            tracer,
            lookout,
            triangles,
            area,
            domain,
            light,
            sobol: Sobol::new(seed),
        })
    }

    /// Area of the triangles proposed from, both sides counted, times the volume of lights.
    pub fn measure(&self) -> f64 {
        2.0 * self.area.last().copied().unwrap_or(0.0) * self.light.volume()
    }

    /// Candidate `k`.
    pub fn draw(&self, k: u32) -> Result<Row, Rejection> {
        let u = self.sobol.point(k);
        let surface = self.surface(u);
        let side = if u[3] < 0.5 {
            surface.normal
        } else {
            -surface.normal
        };
        let light = self.light.at([u[6], u[7], u[8]]);
        let view = hemisphere(side, u[4], u[5]);
        let normal = self.tracer.normal_at(&surface, view);
        let material = self.tracer.material_at(&surface);
        let mut raw = [0.0; columns::COUNT];
        raw[columns::P..columns::N].copy_from_slice(&surface.position.to_array());
        raw[columns::N..columns::V].copy_from_slice(&normal.to_array());
        raw[columns::V..columns::L].copy_from_slice(&view.to_array());
        raw[columns::L..columns::BASE].copy_from_slice(&light.to_array());
        raw[columns::BASE..columns::ROUGHNESS].copy_from_slice(&material.base_color.to_array());
        raw[columns::ROUGHNESS] = material.roughness;
        raw[columns::METALLIC] = material.metallic;
        raw[columns::SPECULAR] = material.specular;
        if !self.domain.contains(&raw) {
            return Err(Rejection::OtherCell);
        }
        if material.kind == MaterialKind::Lambert && material.base_color == Vec3::ZERO {
            return Err(Rejection::Black);
        }
        if self.lookout.inside_solid(light) {
            return Err(Rejection::LightInSolid);
        }
        match self.lookout.from_surface(&surface, side) {
            Outlook::InsideSolid => return Err(Rejection::PointInSolid),
            Outlook::Nothing => return Err(Rejection::SeesNothing),
            Outlook::Open => {}
        }
        let material = self.scene.triangle_material[surface.triangle as usize];
        Ok(Row {
            raw,
            surface,
            material,
        })
    }

    /// A point uniform over the area.
    fn surface(&self, u: [f32; crate::sobol::DIMENSIONS]) -> SurfacePoint {
        let total = self.area[self.area.len() - 1];
        let at = f64::from(u[0]) * total;
        let place = self
            .area
            .partition_point(|&sum| sum <= at)
            .min(self.area.len() - 1);
        // square to triangle (Heitz 2019): keeps the stratification of the square
        let (a, b) = (u[1], u[2]);
        let (b0, b1) = if b > a {
            (a * 0.5, b - a * 0.5)
        } else {
            (a - b * 0.5, b * 0.5)
        };
        self.tracer.point(self.triangles[place], [b0, b1])
    }
}

/// Whether a triangle's box, and either of its sides, can lie in the domain.
/// Vertex normals may bend the normal away from the plane: then only the box decides.
fn reaches(scene: &Scene, triangle: u32, domain: &Domain) -> bool {
    let ids = scene.triangles[triangle as usize];
    let p = ids.map(|v| scene.positions[v as usize]);
    let (low, high) = (p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2]));
    let overlaps = (0..3).all(|i| {
        high[i] >= domain.minimum[columns::P + i] && low[i] < domain.maximum[columns::P + i]
    });
    let material = &scene.materials[scene.triangle_material[triangle as usize] as usize];
    let bent = material.normal_texture != INVALID
        || ids
            .iter()
            .any(|&v| scene.normals[v as usize] != scene.normals[ids[0] as usize]);
    if !overlaps || bent {
        return overlaps;
    }
    let own = scene.normals[ids[0] as usize];
    let flat = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
    let n = if own == Vec3::ZERO {
        flat
    } else {
        own.normalize_or_zero()
    };
    [n, -n].iter().any(|n| {
        // a rounding of the normal must not lose a triangle
        (0..3).all(|i| {
            n[i] + 1e-5 >= domain.minimum[columns::N + i]
                && n[i] - 1e-5 < domain.maximum[columns::N + i]
        })
    })
}

/// A direction uniform over the hemisphere about `n`, density 1 / (2 pi).
fn hemisphere(n: Vec3, u1: f32, u2: f32) -> Vec3 {
    // z in (0, 1]: a view at exactly grazing has no meaning
    let z = 1.0 - u1;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (std::f32::consts::TAU * u2).sin_cos();
    let (s, t) = n.any_orthonormal_pair();
    (s * (r * cos) + t * (r * sin) + n * z).normalize()
}

/// The first `count` accepted rows of a proposal and the census of what was left out.
/// Stops early once `patience` candidates a row wanted have been drawn.
pub fn accept(proposal: &Proposal, count: usize, patience: usize) -> Accepted {
    let mut accepted = Accepted::default();
    let limit = count.saturating_mul(patience).min(u32::MAX as usize) as u32;
    let mut next = 0u32;
    while accepted.index.len() < count && next < limit {
        let end = next.saturating_add(BLOCK).min(limit);
        let drawn: Vec<_> = (next..end)
            .into_par_iter()
            .map(|k| proposal.draw(k))
            .collect();
        for (k, drawn) in (next..end).zip(drawn) {
            if accepted.index.len() == count {
                break;
            }
            match drawn {
                Ok(row) => accepted.push(k, row),
                Err(why) => accepted.census.count(why),
            }
        }
        next = end;
    }
    accepted
}

/// Candidates drawn in parallel before the count is looked at.
const BLOCK: u32 = 2048;

/// Accepted rows as columns.
#[derive(Clone, Debug, Default)]
pub struct Accepted {
    /// Number of the candidate.
    pub index: Vec<u64>,
    /// Raw columns.
    pub rows: Columns,
    /// Where the points lie.
    pub surface: Vec<SurfacePoint>,
    /// Material ids.
    pub material: Vec<u32>,
    /// How many candidates were accepted and left out.
    pub census: Census,
}

impl Accepted {
    fn push(&mut self, k: u32, row: Row) {
        self.index.push(u64::from(k));
        self.rows.push(row.raw);
        self.surface.push(row.surface);
        self.material.push(row.material);
        self.census.accepted += 1;
    }
}
