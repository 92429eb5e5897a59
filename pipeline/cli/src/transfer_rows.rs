//! A transfer at the rows of a points table, light by light.

use crate::baked::Baked;
use crate::failure::BadInput;
use crate::table_lights::by_light;
use glam::Vec3;
use rrf_field::columns;
use rrf_lights::{DistantLight, LightSource};
use rrf_render::MOST_RESIDUAL;
use rrf_scene::{INVALID, PointLight, Scene};
use rrf_store::points::{PointsTable, SUN};
use rrf_trace::{SurfacePoint, Tracer};
use rrf_transfer::{LightBook, LitTransfer, RowPoint, TransferQuery};
use std::collections::BTreeMap;
use std::path::Path;

/// Answers at the rows of a table.
pub struct RowAnswers {
    /// Radiance, channel by channel.
    pub radiance: [Vec<f32>; 3],
    /// Cells; `u32::MAX` where none knows the surface.
    pub cells: Vec<u32>,
    /// Whether each answer is believed.
    pub trusted: Vec<bool>,
}

/// Asks for every row under its own light: a point of 1 W/sr or a sun of 1 W/m² a channel, or a light of the
/// scene. Rows of one light are asked together.
pub fn answer(
    book: &LightBook,
    baked: &Baked,
    tracer: &Tracer,
    (table, located): (&PointsTable, &[SurfacePoint]),
    path: &Path,
) -> anyhow::Result<RowAnswers> {
    let mut answers = RowAnswers {
        radiance: std::array::from_fn(|_| vec![0.0; located.len()]),
        cells: vec![INVALID; located.len()],
        trusted: vec![false; located.len()],
    };
    let vector = |first: usize, row: usize| {
        Vec3::from_array(std::array::from_fn(|i| table.geometry[first + i][row]))
    };
    let mut put = |lit: &LitTransfer, rows: &[usize]| {
        let points = rows.iter().map(|&row| RowPoint {
            point: located[row],
            viewer: vector(columns::V, row),
        });
        let points: Vec<RowPoint> = points.collect();
        let queries = points.iter().map(|row| TransferQuery::of_row(tracer, row));
        let found = lit.evaluate(&queries.collect::<Vec<_>>());
        let first = rows.first().copied().unwrap_or(0) as u64;
        let mirrored = lit.by_mirrors(tracer, &points, first);
        for ((&row, found), mirrored) in rows.iter().zip(found).zip(mirrored) {
            let sum = (found.radiance + mirrored).to_array();
            for (channel, x) in answers.radiance.iter_mut().zip(sum) {
                channel[row] = x;
            }
            answers.cells[row] = found.cell;
            answers.trusted[row] = found.trusted && lit.residual <= MOST_RESIDUAL;
        }
    };
    for group in by_light(table, &baked.scene, path)? {
        if group.is_own() {
            let alone = alone(&baked.scene, group.name());
            let sources: Vec<LightSource> = alone.lights.iter().map(|l| l.source.clone()).collect();
            put(&book.under(&sources, Some(&alone))?, &group.rows);
            continue;
        }
        let mut places: BTreeMap<[u32; 3], Vec<usize>> = BTreeMap::new();
        for &row in &group.rows {
            let key = vector(columns::L, row).to_array().map(f32::to_bits);
            places.entry(key).or_default().push(row);
        }
        for rows in places.into_values() {
            let at = rows
                .first()
                .map_or(Vec3::ZERO, |&row| vector(columns::L, row));
            let light = match group.name() {
                SUN => sun(at, &rows, path)?,
                _ => PointLight {
                    position: at,
                    intensity: Vec3::ONE,
                }
                .into(),
            };
            put(&book.under(&[light], None)?, &rows);
        }
    }
    Ok(answers)
}

/// A sun of 1 W/m² in a direction.
fn sun(toward: Vec3, rows: &[usize], path: &Path) -> Result<LightSource, BadInput> {
    let toward = toward.try_normalize().ok_or_else(|| {
        let (path, row) = (path.display(), rows.first().copied().unwrap_or(0));
        BadInput(format!(
            "{path}: row {row}: its sun has no direction (l is 0)"
        ))
    })?;
    Ok(DistantLight::sun(toward, Vec3::ONE).into())
}

/// The scene with one of its own lights alone.
fn alone(scene: &Scene, name: &str) -> Scene {
    let mut scene = scene.clone();
    scene.lights.retain(|light| light.name == name);
    let names = scene.area_light_names.clone();
    for (light, own) in scene.area_lights.iter_mut().zip(names) {
        if own != name {
            light.radiance = Vec3::ZERO;
        }
    }
    scene
}
