//! Lights of a points table: its rows light by light, and what they send to their viewers.

use crate::failure::BadInput;
use crate::points;
use glam::Vec3;
use rrf_field::columns;
use rrf_lights::LightSource;
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_store::points::{POINT, PointsTable, SUN};
use rrf_trace::{
    Estimates, Estimator, Illumination, LightSet, Queries, Reflections, Sampling, SurfacePoint,
    TraceError, Tracer, indirect_with, own_light, sun_light,
};
use std::path::Path;

/// Rows of a table that share a light, by their numbers.
pub struct LitRows {
    /// Place of the light in the table's list.
    number: u32,
    /// Name of the light.
    name: String,
    /// Numbers of the rows.
    pub rows: Vec<usize>,
}

impl LitRows {
    /// Name of the light.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the scene's own light shines, so that it is traced with its lamps in it.
    pub fn is_own(&self) -> bool {
        self.name != POINT && self.name != SUN
    }
}

/// The rows of a table by their light, in the order of the lights' first rows. Names that are no
/// light of the scene are refused by row.
pub fn by_light(table: &PointsTable, scene: &Scene, path: &Path) -> Result<Vec<LitRows>, BadInput> {
    let mut groups: Vec<LitRows> = (0u32..)
        .zip(&table.light_names)
        .map(|(number, name)| LitRows {
            number,
            name: name.clone(),
            rows: Vec::new(),
        })
        .collect();
    for (row, &light) in table.light.iter().enumerate() {
        if let Some(group) = groups.get_mut(light as usize) {
            group.rows.push(row);
        }
    }
    groups.retain(|group| !group.rows.is_empty());
    let names = scene.own_light_names();
    for group in groups.iter().filter(|group| group.is_own()) {
        if !names.contains(&group.name.as_str()) {
            let row = group.rows.first().copied().unwrap_or_default();
            let told = format!(
                "{}: row {row}: there is no light {:?}; column light knows {POINT}, {SUN} and the \
                 scene's own lights: {}",
                path.display(),
                group.name,
                scene.own_lights_in_words(),
            );
            return Err(BadInput(told));
        }
    }
    Ok(groups)
}

/// Rows of one light, ready to be traced.
pub struct TableLight<'a> {
    tracer: &'a Tracer<'a>,
    shining: Shining,
    /// Surface points of the rows.
    points: Vec<SurfacePoint>,
    viewers: Vec<Vec3>,
    /// Positions of point lights, directions to suns.
    lights: Vec<Vec3>,
    estimator: Estimator,
    stream: Stream,
}

/// The light of a row.
enum Shining {
    Point,
    Sun,
    Own(Box<LightSet>),
}

impl<'a> TableLight<'a> {
    /// Locates the rows in `tracer`'s scene.
    pub fn new(
        tracer: &'a Tracer<'a>,
        table: &PointsTable,
        group: &LitRows,
        (estimator, seed): (Estimator, u64),
        path: &Path,
    ) -> anyhow::Result<TableLight<'a>> {
        let pick = |first: usize| points::vectors_of(table, first, &group.rows);
        let mut lights = pick(columns::L);
        let shining = match group.name.as_str() {
            POINT => Shining::Point,
            SUN => {
                for (row, light) in group.rows.iter().zip(&mut lights) {
                    *light = light.try_normalize().ok_or_else(|| {
                        let path = path.display();
                        BadInput(format!(
                            "{path}: row {row}: its sun has no direction (l is 0)"
                        ))
                    })?;
                }
                Shining::Sun
            }
            name => Shining::Own(Box::new(own_set(tracer, name)?)),
        };
        Ok(TableLight {
            tracer,
            shining,
            points: points::locate_rows(tracer, table, &group.rows, path)?,
            viewers: pick(columns::V),
            lights,
            estimator,
            stream: Stream::new(seed, Stage::Points, group.number),
        })
    }

    /// Indirect light of the rows from `first` to `end`, counted among those of this light.
    pub fn trace(
        &self,
        (first, end): (usize, usize),
        sampling: Sampling,
    ) -> Result<Estimates, TraceError> {
        let (tracer, stream) = (self.tracer, self.stream);
        let queries = Queries {
            points: &self.points[first..end],
            viewers: &self.viewers[first..end],
            lights: &self.lights[first..end],
        };
        match &self.shining {
            Shining::Point => indirect_with(
                tracer,
                queries,
                sampling,
                self.estimator,
                stream,
                first as u64,
            ),
            Shining::Sun => {
                let how = (self.estimator, sampling);
                sun_light(tracer, queries, how, stream, first as u64)
            }
            Shining::Own(lights) => {
                let illumination = Illumination {
                    lights,
                    reflections: Reflections::More,
                    estimator: self.estimator,
                };
                let Queries {
                    points, viewers, ..
                } = queries;
                let first = first as u64;
                own_light(
                    tracer,
                    illumination,
                    points,
                    viewers,
                    sampling,
                    stream,
                    first,
                )
            }
        }
    }
}

/// An own light alone.
fn own_set(tracer: &Tracer, name: &str) -> Result<LightSet, TraceError> {
    let scene = tracer.scene();
    let shines = |of: &String| if of == name { Vec3::ONE } else { Vec3::ZERO };
    let dims: Vec<Vec3> = scene.area_light_names.iter().map(shines).collect();
    let sources = scene.lights.iter().filter(|light| light.name == name);
    let sources: Vec<LightSource> = sources.map(|light| light.source.clone()).collect();
    tracer.light_set(Some(&dims), sources)
}
