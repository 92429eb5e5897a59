//! Indirect light at points that are asked about, as a frame's pixels have it.

use super::Renderer;
use super::job::{Job, PixelNames};
use super::layers::Band;
use crate::error::RenderError;
use crate::timings::Stopwatch;
use glam::Vec3;
use rayon::prelude::*;
use rrf_scene::INVALID;
use rrf_trace::SurfacePoint;

/// Rays of the points that are answered together, at most: their columns stay small.
const RAYS_AT_ONCE: u32 = 16_384;

/// Answers at points: parallel columns of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointAnswers {
    /// Indirect radiance [W/(sr m²)] toward the viewer.
    pub radiance: Vec<Vec3>,
    /// Cell that knows each point, `u32::MAX` where none does.
    pub cells: Vec<u32>,
    /// Share of each answer that is believed, 0 to 1; 0 where that is not asked for.
    pub trust: Vec<f32>,
}

impl Renderer<'_> {
    /// One answer of each point.
    pub(super) fn pass(
        &self,
        job: &Job,
        (points, viewers): (&[SurfacePoint], &[Vec3]),
        names: &[u64],
    ) -> Result<PointAnswers, RenderError> {
        let options = job.options;
        let rays = options.gather.max(options.fallback).max(1);
        let most = (RAYS_AT_ONCE / rays).max(1) as usize;
        let mut runs: Vec<&[u64]> = Vec::new();
        for run in names.chunk_by(|a, b| a + 1 == *b) {
            runs.extend(run.chunks(most));
        }
        let starts = runs.iter().scan(0, |end, run| {
            *end += run.len();
            Some(*end - run.len())
        });
        let starts: Vec<usize> = starts.collect();
        let found = runs.par_iter().zip(&starts).map(|(run, &start)| {
            let own = start..start + run.len();
            let mut work = self.idle().pop().unwrap_or_default();
            work.watch = Stopwatch::default();
            (work.seen).read_points(self.tracer, &points[own.clone()], &viewers[own]);
            let mut found = PointAnswers {
                radiance: vec![Vec3::ZERO; run.len()],
                cells: vec![INVALID; run.len()],
                trust: vec![0.0; run.len()],
            };
            let mut direct = vec![Vec3::ZERO; run.len()];
            let mut band = Band::of_points(
                &mut direct,
                &mut found.radiance,
                &mut found.cells,
                &mut found.trust,
            );
            let names = PixelNames {
                first: run[0],
                corner: run[0],
                width: 1,
            };
            let done = job.shade_seen(&mut work, names, &mut band);
            self.idle().push(work);
            done.map(|()| found)
        });
        let found = found.collect::<Result<Vec<PointAnswers>, RenderError>>()?;
        let mut all = PointAnswers::default();
        for found in found {
            all.radiance.extend(found.radiance);
            all.cells.extend(found.cells);
            all.trust.extend(found.trust);
        }
        Ok(all)
    }
}
