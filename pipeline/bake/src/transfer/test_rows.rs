//! Test rows: what eyes come to see, each under one light, against the path tracer.
//!
//! Rows that judge cells also choose among fits, and they are drawn where light falls steeply. Test
//! rows do neither: places by the eyes' own view, lights that the ensemble does not hold beside the scene's own.

use super::config::TransferBakeConfig;
use super::ensemble::{conditions, light_stream};
use super::space::FreeSpace;
use super::summary::TransferTest;
use super::test_truth::{Shining, truth};
use crate::error::BakeError;
use crate::exec::watch::Watch;
use glam::Vec3;
use rrf_lights::{DistantLight, LightSource, PointLight};
use rrf_metrics::estimate::{ErrorEstimate, by_halves};
use rrf_metrics::relative::{
    channel_mean, epsilon_of, inverse_level, median, percentile_95, worst_share,
};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Hits, Rays, Sampling, Tracer};
use rrf_transfer::{
    LightBook, MOST_RESIDUAL, PointDraw, RowPoint, TransferAnswer, TransferError, TransferModel,
    TransferQuery,
};

/// One test row for so many first rows, and their bounds.
const SHARE: usize = 40;
const LEAST: usize = 64;
const MOST: usize = 2_048;
/// Paths of a test row relative to those of a row, and the least.
const PATHS: u32 = 4;
const LEAST_PATHS: u32 = 512;
/// Points and suns, and own lights at most.
const POINTS: usize = 64;
const SUNS: usize = 16;
const OWN: usize = 16;
/// Places that are drawn for one row, of which some are lost.
const DRAWN: usize = 4;
/// Where test rows begin in the sequence of places: no bake draws as many.
const FIRST: u64 = 1 << 40;
/// Rows that are traced between two looks at the clock.
const AT_ONCE: usize = 64;

/// A light that some test rows are under.
enum TestLight {
    Point(PointLight),
    Sun(DistantLight),
    /// An own light of the scene by its name.
    Own(String),
}

/// A row that was asked and traced.
struct Asked {
    answer: Vec3,
    trusted: bool,
    halves: [Vec3; 2],
}

/// A model that is tested.
pub(super) struct Tests<'a> {
    pub(super) scene: &'a Scene,
    pub(super) space: &'a FreeSpace<'a>,
    pub(super) config: &'a TransferBakeConfig,
    /// Triangles of the scene that are no lamps.
    pub(super) kept: Vec<usize>,
    pub(super) watch: &'a dyn Watch,
}

impl Tests<'_> {
    /// Asks a model for test rows and traces them.
    ///
    /// # Errors
    /// [`BakeError::TransferHalted`] where the watch stops it; [`BakeError`] of a step.
    pub(super) fn run(&self, model: &TransferModel) -> Result<TransferTest, BakeError> {
        let book = LightBook::new(model, self.space.tracer()).map_err(BakeError::Transfer)?;
        let (rows, lights) = (self.rows(), self.lights()?);
        let of_kind = |is_wanted: fn(&TestLight) -> bool| -> Vec<usize> {
            let wanted = (0..lights.len()).filter(|&l| is_wanted(&lights[l]));
            wanted.collect()
        };
        let kinds = [
            of_kind(|light| matches!(light, TestLight::Point(_))),
            of_kind(|light| matches!(light, TestLight::Sun(_))),
        ];
        let own = of_kind(|light| matches!(light, TestLight::Own(_)));
        let own = own.into_iter().map(|light| vec![light]);
        self.watch.begin_stage("test rows", rows.len() as u64);
        let mut tested = Vec::with_capacity(rows.len());
        // levels are relative to the mean under lights of a kind: own lights differ by factors
        for kind in kinds.into_iter().chain(own) {
            let mut asked = Vec::new();
            for light in kind {
                let own = rows.iter().skip(light).step_by(lights.len().max(1));
                asked.extend(self.under(&book, &lights[light], light as u32, own)?);
            }
            tested.extend(squares(&asked));
        }
        self.watch.end();
        Ok(summed(&tested))
    }

    /// Places that eyes see.
    fn rows(&self) -> Vec<RowPoint> {
        let count = (self.config.rows / SHARE).clamp(LEAST, MOST);
        let mut rows = self.space.draw(FIRST, count * DRAWN);
        // what narrow parts send is traced where it is asked for, and no model's to answer
        if !self.config.narrow.is_learned() {
            let tracer = self.space.tracer();
            rows.retain(|row| tracer.material_at(&row.point).narrow().is_none());
        }
        rows.truncate(count);
        rows
    }

    /// Points and suns like those of the ensemble, and the scene's own lights one by one.
    fn lights(&self) -> Result<Vec<TestLight>, BakeError> {
        let tracer = self.space.tracer();
        let plan = TransferBakeConfig {
            points: self.config.points.min(POINTS),
            suns: self.config.suns.min(SUNS),
            skies: 0,
            ..self.config.clone()
        };
        let stream = light_stream(self.config.seed).part(6);
        let drawn = conditions(tracer.scene(), tracer, self.space, &plan, stream)?;
        let sources = drawn.sources.into_iter().flatten();
        let drawn = sources.filter_map(|source| match source {
            LightSource::Point(point) => Some(TestLight::Point(point)),
            LightSource::Distant(sun) => Some(TestLight::Sun(sun)),
            _ => None,
        });
        let names = self.scene.own_light_names();
        let step = names.len().div_ceil(OWN).max(1);
        let own = names.iter().step_by(step);
        let own = own.map(|name| TestLight::Own(name.to_string()));
        Ok(drawn.chain(own).collect())
    }

    /// Rows under a light of some number.
    fn under<'r>(
        &self,
        book: &LightBook,
        light: &TestLight,
        number: u32,
        rows: impl Iterator<Item = &'r RowPoint>,
    ) -> Result<Vec<Asked>, BakeError> {
        let (alone, whole);
        let shining = match light {
            TestLight::Point(point) => Shining::Point(*point),
            TestLight::Sun(sun) => Shining::Sun(*sun),
            TestLight::Own(name) => {
                alone = self.scene.lit_by(name);
                whole = Tracer::new(&alone)?;
                Shining::Own(&whole)
            }
        };
        let seen = |row: &&RowPoint| match &shining {
            Shining::Own(tracer) => !self.is_hidden(tracer, row),
            _ => true,
        };
        let rows: Vec<RowPoint> = rows.filter(seen).copied().collect();
        let answers = self.answers(book, &shining, &rows);
        let mut answers = answers.map_err(BakeError::Transfer)?.into_iter();
        let sampling = Sampling {
            paths: (PATHS * self.config.paths).max(LEAST_PATHS),
            replicates: 2,
        };
        let stream = Stream::new(self.config.seed, Stage::Transfer, 6).part(number);
        let mut asked = Vec::with_capacity(rows.len());
        for (part, rows) in rows.chunks(AT_ONCE).enumerate() {
            if let Some(why) = self.watch.halted() {
                return Err(BakeError::TransferHalted { why });
            }
            let tracer = self.space.tracer();
            let numbers = (sampling, stream, (part * AT_ONCE) as u64);
            let traced = truth(tracer, &shining, &self.kept, rows, numbers)?;
            let halves = (0..rows.len()).map(|row| traced.halves(row));
            asked.extend(
                halves
                    .zip(&mut answers)
                    .map(|(halves, (answer, trusted))| Asked {
                        answer,
                        trusted,
                        halves,
                    }),
            );
            self.watch.advance(rows.len() as u64);
        }
        Ok(asked)
    }

    /// Whether a lamp of the whole scene stands before a point that eyes see without it.
    fn is_hidden(&self, whole: &Tracer, row: &RowPoint) -> bool {
        let (mut rays, mut hits) = (Rays::default(), Hits::default());
        let tracer = self.space.tracer();
        let origin = tracer.lift(row.point.triangle, row.point.position, row.viewer);
        rays.push(origin, row.viewer, f32::INFINITY);
        whole.closest(&rays, &mut hits);
        let met = hits.triangle[0];
        met != INVALID && self.kept.binary_search(&(met as usize)).is_err()
    }

    /// The model's answers, and whether they are trusted.
    fn answers(
        &self,
        book: &LightBook,
        light: &Shining,
        rows: &[RowPoint],
    ) -> Result<Vec<(Vec3, bool)>, TransferError> {
        let tracer = self.space.tracer();
        let lit = match light {
            Shining::Point(point) => book.under(&[(*point).into()], None)?,
            Shining::Sun(sun) => book.under(&[(*sun).into()], None)?,
            Shining::Own(whole) => {
                let scene = whole.scene();
                let sources = scene.lights.iter().map(|light| light.source.clone());
                book.under(&sources.collect::<Vec<_>>(), Some(scene))?
            }
        };
        let queries = rows.iter().map(|row| TransferQuery::of_row(tracer, row));
        let found = lit.evaluate(&queries.collect::<Vec<_>>());
        let mirrored = lit.by_mirrors(tracer, rows, 0);
        let is_known = lit.residual <= MOST_RESIDUAL;
        let answer = |(found, mirrored): (&TransferAnswer, Vec3)| {
            (found.radiance + mirrored, found.trusted && is_known)
        };
        Ok(found.iter().zip(mirrored).map(answer).collect())
    }
}

/// Squared relative error of rows, each with whether it is trusted.
fn squares(asked: &[Asked]) -> Vec<(f64, bool)> {
    let wide = |x: Vec3| x.to_array().map(f64::from);
    let means = asked
        .iter()
        .map(|row| wide((row.halves[0] + row.halves[1]) * 0.5));
    let means: Vec<[f64; 3]> = means.collect();
    let epsilon = epsilon_of(means.iter().copied());
    let square = |(row, mean): (&Asked, &[f64; 3])| {
        let by = inverse_level(channel_mean(*mean), epsilon);
        let [a, b] = row.halves.map(|half| half.to_array());
        (by_halves(wide(row.answer), a, b, by), row.trusted)
    };
    asked.iter().zip(&means).map(square).collect()
}

fn summed(tested: &[(f64, bool)]) -> TransferTest {
    let squares: Vec<f64> = tested.iter().map(|row| row.0).collect();
    let trusted = tested.iter().filter(|row| row.1);
    let trusted: Vec<f64> = trusted.map(|row| row.0).collect();
    let error = ErrorEstimate::of(&squares);
    TransferTest {
        test_rows: squares.len() as u32,
        relative_error: error.relative(),
        relative_error_se: error.relative_se(),
        median_error: median(&squares),
        percentile_95: percentile_95(&squares),
        worst_share: worst_share(&squares),
        trusted_share: trusted.len() as f64 / squares.len().max(1) as f64,
        trusted_error: ErrorEstimate::of(&trusted).relative(),
    }
}
