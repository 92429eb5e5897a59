//! Where a frame's indirect light comes from: nets that see the lights, or a transfer under them.

use super::blend::evaluate_blended;
use crate::error::RenderError;
use crate::follow::MetPatches;
use crate::options::{RenderOptions, Trusted};
use crate::tile::VisiblePoints;
use crate::timings::{FrameStage, Stopwatch};
use crate::view::Lights;
use glam::Vec3;
use rrf_field::columns::{self, Columns};
use rrf_field::{EvaluationTimings, Field, Light, LitField, Workspace};
use rrf_lights::LightSource;
use rrf_scene::Scene;
use rrf_trace::{SurfacePoint, Tracer};
use rrf_transfer::{LightBook, LitTransfer, MOST_RESIDUAL, RowPoint, SurfaceKey, TransferQuery};

/// A baked model.
#[derive(Clone, Copy)]
pub(super) enum Baked<'a> {
    /// Nets that see point lights.
    Nets(&'a Field),
    /// A transfer, which knows any light.
    Transfer(&'a LightBook<'a>),
}

/// A baked model under a frame's lights.
pub(super) enum Lit<'f> {
    Nets(LitField<'f>),
    Transfer(LitTransfer<'f>),
}

/// Answers at a tile's visible points.
#[derive(Default)]
pub(super) struct Answers {
    radiance: [Vec<f32>; 3],
    pub(super) cells: Vec<u32>,
    /// Radiance of each point by way of flat mirrors, beside a transfer's; of nets, empty.
    mirrored: Vec<Vec3>,
    /// Whether a transfer's answer is believed.
    trust: Vec<bool>,
    nets: Workspace,
}

impl Answers {
    /// Radiance of a point.
    pub(super) fn radiance(&self, row: usize) -> Vec3 {
        let own = Vec3::from_array([0, 1, 2].map(|c: usize| self.radiance[c][row]));
        self.mirrored.get(row).map_or(own, |&more| own + more)
    }

    /// The part of it that no rays from the point are needed for: light by way of flat mirrors.
    pub(super) fn by_mirrors(&self, row: usize) -> Vec3 {
        self.mirrored.get(row).copied().unwrap_or(Vec3::ZERO)
    }
}

impl<'a> Baked<'a> {
    /// Name of the method.
    pub(super) fn method(&self) -> &'static str {
        match self {
            Baked::Nets(_) => "radiance regression",
            Baked::Transfer(_) => "direct-to-indirect transfer",
        }
    }

    /// The model under lights; `proxies` stand for the lamps where nets know points alone.
    pub(super) fn under(
        self,
        lights: &Lights,
        proxies: impl Iterator<Item = Light>,
        scene: &Scene,
    ) -> Result<Lit<'a>, RenderError> {
        match self {
            Baked::Nets(field) => {
                let points = lights.points.iter().map(|light| Light {
                    position: light.position.to_array(),
                    intensity: light.intensity.to_array(),
                });
                let points: Vec<Light> = points.chain(proxies).collect();
                Ok(Lit::Nets(field.under(&points)))
            }
            Baked::Transfer(book) => {
                let points = lights.points.iter().map(|&point| LightSource::from(point));
                let sources = lights.sources.iter().map(|light| light.source.clone());
                let sources: Vec<LightSource> = points.chain(sources).collect();
                let lamps = lights.area.then_some(scene);
                Ok(Lit::Transfer(book.under(&sources, lamps)?))
            }
        }
    }
}

impl<'f> Lit<'f> {
    /// The model's patches in the frame's scene; nets have none.
    pub(super) fn patches(&self, scene: &Scene) -> Option<MetPatches<'f>> {
        match self {
            Lit::Nets(_) => None,
            Lit::Transfer(lit) => Some(MetPatches::new(lit.patches(), lit.bright(), scene)),
        }
    }

    /// Indirect light at visible points; `first` names their random numbers.
    pub(super) fn evaluate(
        &self,
        tracer: &Tracer,
        seen: &VisiblePoints,
        options: &RenderOptions,
        first: u64,
        answers: &mut Answers,
        watch: &mut Stopwatch,
    ) -> Result<(), RenderError> {
        let Answers {
            radiance,
            cells,
            nets,
            mirrored,
            ..
        } = answers;
        mirrored.clear();
        match (self, options.borders) {
            (Lit::Nets(lit), Some(borders)) => {
                evaluate_blended(borders, lit, &seen.rows, radiance, cells)?;
                Ok(())
            }
            (Lit::Nets(lit), None) => {
                let mut spent = EvaluationTimings::default();
                lit.evaluate(&seen.rows, nets, radiance, cells, Some(&mut spent))?;
                watch.end_nets(&spent);
                Ok(())
            }
            (Lit::Transfer(lit), _) => {
                answer(lit, tracer, seen, first, answers);
                watch.end(FrameStage::Nets);
                Ok(())
            }
        }
    }

    /// Whether each visible point's answer is believed; of nets, if `trusted` can tell.
    pub(super) fn trust(
        &self,
        trusted: Option<&Trusted>,
        seen: &VisiblePoints,
        answers: &Answers,
    ) -> Option<Vec<bool>> {
        match self {
            Lit::Nets(lit) => Some(trusted_under_all(trusted?, &seen.rows, lit.lights())),
            Lit::Transfer(_) => Some(answers.trust.clone()),
        }
    }

    /// Radiance that a row of a surface sends by its patch's light; none that nets know of.
    pub(super) fn sent(
        &self,
        scene: &Scene,
        seen: &VisiblePoints,
        row: usize,
        baked: &SurfacePoint,
    ) -> Option<Vec3> {
        match self {
            Lit::Nets(_) => None,
            Lit::Transfer(lit) => {
                lit.sent(baked, &query(scene, seen, row), &seen.under_lights(row))
            }
        }
    }

    /// Whether a place lies on a flat mirror whose direct light on others the model has.
    pub(super) fn is_on_mirror(&self, position: Vec3, normal: Vec3) -> bool {
        match self {
            Lit::Nets(_) => false,
            Lit::Transfer(lit) => lit.is_on_mirror(position, normal),
        }
    }
}

/// A transfer's answers.
fn answer(
    lit: &LitTransfer,
    tracer: &Tracer,
    seen: &VisiblePoints,
    first: u64,
    answers: &mut Answers,
) {
    let queries: Vec<TransferQuery> = (0..seen.points.len())
        .map(|row| query(tracer.scene(), seen, row))
        .collect();
    let found = lit.evaluate(&queries);
    mirrored(lit, tracer, seen, first, &mut answers.mirrored);
    answers.radiance.iter_mut().for_each(Vec::clear);
    answers.cells.clear();
    answers.trust.clear();
    for (row, found) in found.iter().enumerate() {
        let own = found.radiance.to_array();
        for (channel, x) in answers.radiance.iter_mut().zip(own) {
            channel.push(x);
        }
        answers.cells.push(found.cell);
        let is_fit = match seen.is_gathered(row) {
            true => found.trusted_on_average,
            false => found.trusted,
        };
        let has_sense = found.radiance.element_sum() >= 0.0;
        (answers.trust).push(is_fit && lit.residual <= MOST_RESIDUAL && has_sense);
    }
}

/// Light by way of flat mirrors, where it is not in the light of a patch.
fn mirrored(
    lit: &LitTransfer,
    tracer: &Tracer,
    seen: &VisiblePoints,
    first: u64,
    mirrored: &mut Vec<Vec3>,
) {
    let asked: Vec<usize> = (0..seen.points.len())
        .filter(|&row| seen.is_asked(row))
        .collect();
    let rows = asked.iter().map(|&row| RowPoint {
        point: seen.points[row],
        viewer: seen.viewers[row],
    });
    let rows: Vec<RowPoint> = rows.collect();
    mirrored.clear();
    mirrored.resize(seen.points.len(), Vec3::ZERO);
    for (row, own) in asked.into_iter().zip(lit.by_mirrors(tracer, &rows, first)) {
        mirrored[row] = own;
    }
}

/// A visible point as a transfer is asked about it.
fn query(scene: &Scene, seen: &VisiblePoints, row: usize) -> TransferQuery {
    let (point, viewer) = (&seen.points[row], seen.viewers[row]);
    let back = point.normal.dot(viewer) < 0.0;
    let triangle = point.triangle as usize;
    TransferQuery {
        position: point.position,
        geometric: if back { -point.normal } else { point.normal },
        shading: seen.normals[row],
        viewer,
        base_color: seen.materials[row].base_color,
        surface: SurfaceKey {
            object: scene.triangle_object.get(triangle).copied().unwrap_or(0),
            material: scene.triangle_material[triangle],
            back,
        },
    }
}

/// Whether each row is trusted under every one of the lights.
fn trusted_under_all(trusted: &Trusted, rows: &Columns, lights: &[Light]) -> Vec<bool> {
    let mut rows = rows.clone();
    let mut all = vec![true; rows.len()];
    for light in lights {
        for (i, x) in light.position.into_iter().enumerate() {
            rows.columns[columns::L + i].fill(x);
        }
        for (all, one) in all.iter_mut().zip(trusted(&rows)) {
            *all &= one;
        }
    }
    all
}
