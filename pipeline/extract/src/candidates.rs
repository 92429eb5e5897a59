//! Candidate rows of one cell: a surface point, a side, a viewer direction, a light position.
//!
//! Candidate `k` of a draw is point `k` of a scrambled Sobol sequence seeded by (seed, stream):
//! the surface point is uniform over the area that lies in the cell's box of positions, the
//! viewer direction uniform over the hemisphere, the light uniform in the cell's part of the
//! light box. What falls outside the cell is rejected, so the accepted rows are uniform in it, but for
//! what cannot be learned and, where eyes are given, what none of them sees.

use crate::census::{Census, Rejection};
use crate::config::NarrowLight;
use crate::eyes::Eyes;
use crate::patches::Patches;
use crate::region::Region;
use crate::visibility::{PointClass, QueryScratch, VisibilityQueries};
use glam::Vec3;
use rayon::prelude::*;
use rrf_field::columns::{self, Columns};
use rrf_field::tree::Domain;
use rrf_sampling::sobol::Sequence;
use rrf_scene::Scene;
use rrf_trace::{SurfacePoint, Tracer};

/// One accepted row.
#[derive(Clone, Copy, Debug)]
pub struct CandidateRow {
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
    visibility: &'a VisibilityQueries<'a>,
    eyes: Option<&'a Eyes>,
    narrow: NarrowLight,
    patches: Patches,
    domain: Domain,
    light: Region,
    sequence: Sequence,
}

impl<'a> Proposal<'a> {
    /// The candidates inside `domain`; none where no triangle or light reaches into it.
    pub fn new(
        scene: &'a Scene,
        tracer: &'a Tracer<'a>,
        visibility: &'a VisibilityQueries<'a>,
        domain: Domain,
        light_box: Region,
        seed: u64,
    ) -> Option<Proposal<'a>> {
        let light = light_box.within(&domain)?;
        let patches = Patches::new(scene, &domain);
        (!patches.is_empty()).then(|| Proposal {
            scene,
            tracer,
            visibility,
            eyes: None,
            narrow: NarrowLight::Learned,
            patches,
            domain,
            light,
            sequence: Sequence::new(seed),
        })
    }

    /// Keeps the points that one of some eyes sees.
    pub fn seen_by(self, eyes: Option<&'a Eyes>) -> Proposal<'a> {
        Proposal { eyes, ..self }
    }

    /// Leaves out points that have nothing but a narrow part, if that is traced.
    pub fn without_traced(self, narrow: NarrowLight) -> Proposal<'a> {
        Proposal { narrow, ..self }
    }

    /// Candidate `k`.
    pub fn draw(&self, k: u32, scratch: &mut QueryScratch) -> Result<CandidateRow, Rejection> {
        let u = self.sequence.point(k);
        let (patch, weights) = self.patches.sample([u[0], u[1], u[2]]);
        let surface = self.tracer.point(patch.triangle, weights);
        let side = if patch.back {
            -surface.normal
        } else {
            surface.normal
        };
        let light = self.light.at([u[5], u[6], u[7]]);
        let view = hemisphere(side, u[3], u[4]);
        let mut raw = [0.0; columns::COUNT];
        raw[columns::P..columns::N].copy_from_slice(&surface.position.to_array());
        raw[columns::V..columns::L].copy_from_slice(&view.to_array());
        raw[columns::L..columns::BASE].copy_from_slice(&light.to_array());
        // most of what lies elsewhere is known before its material is
        if !self.domain.contains_in(columns::P..columns::N, &raw)
            || !self.domain.contains_in(columns::V..columns::BASE, &raw)
        {
            return Err(Rejection::OtherCell);
        }
        let (normal, material) = self.tracer.shading_at(&surface, view);
        raw[columns::N..columns::V].copy_from_slice(&normal.to_array());
        raw[columns::BASE..=columns::SPECULAR].copy_from_slice(&material.columns());
        if !self.domain.contains(&raw) {
            return Err(Rejection::OtherCell);
        }
        let learned = match self.narrow {
            NarrowLight::Learned => Some(material),
            NarrowLight::Traced => material.broad(),
        };
        if learned.is_none_or(|learned| learned.is_black()) {
            return Err(Rejection::Black);
        }
        let unseen = |eyes: &Eyes| !eyes.see(self.visibility, &surface, side, scratch);
        if self.eyes.is_some_and(unseen) {
            return Err(Rejection::Unseen);
        }
        if self.visibility.inside_solid_with(light, scratch) {
            return Err(Rejection::LightInSolid);
        }
        match self.visibility.from_surface_with(&surface, side, scratch) {
            PointClass::InsideSolid => return Err(Rejection::PointInSolid),
            PointClass::Nothing => return Err(Rejection::SeesNothing),
            PointClass::Open => {}
        }
        let material = self.scene.triangle_material[surface.triangle as usize];
        Ok(CandidateRow {
            raw,
            surface,
            material,
        })
    }
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
/// Stops early once `patience` candidates a row wanted have been drawn, or where its tracer is halted.
pub fn accept(proposal: &Proposal, count: usize, patience: usize) -> Accepted {
    let mut accepted = Accepted::default();
    let limit = count.saturating_mul(patience).min(u32::MAX as usize) as u32;
    let mut next = 0u32;
    while accepted.index.len() < count && next < limit && !proposal.tracer.is_halted() {
        let missing = (count - accepted.index.len()) as u32;
        let end = next
            .saturating_add(missing.clamp(LEAST_BLOCK, BLOCK))
            .min(limit);
        let drawn: Vec<_> = (next..end)
            .into_par_iter()
            .map_init(QueryScratch::default, |scratch, k| {
                proposal.draw(k, scratch)
            })
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

/// Candidates drawn in parallel before the count is looked at: no more than are missing, but for
/// the last few.
const BLOCK: u32 = 2048;
const LEAST_BLOCK: u32 = 128;

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
    fn push(&mut self, k: u32, row: CandidateRow) {
        self.index.push(u64::from(k));
        self.rows.push(row.raw);
        self.surface.push(row.surface);
        self.material.push(row.material);
        self.census.accepted += 1;
    }
}
