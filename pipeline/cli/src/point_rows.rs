//! A model at the rows of a points table, light by light.

use crate::baked::{Baked, ReadyModel};
use crate::failure::BadInput;
use crate::points;
use crate::table_lights::by_light;
use glam::Vec3;
use rayon::prelude::*;
use rrf_field::columns::{self, Columns};
use rrf_lights::{DistantLight, OwnLight};
use rrf_render::{AreaLights, Lights, Passes, PointAnswers, RenderOptions};
use rrf_scene::{INVALID, PointLight, Scene};
use rrf_store::points::{PointsTable, SUN};
use rrf_trace::{SurfacePoint, Tracer};
use std::collections::BTreeMap;
use std::path::Path;

/// Rays of each row into a lobe that is not as sharp as a mirror's.
const NARROW_RAYS: u32 = 64;
/// Share of an answer that has to be believed.
const TRUSTED: f32 = 0.9;

/// Answers at the rows of a table.
pub struct RowAnswers {
    /// Radiance, channel by channel.
    pub radiance: [Vec<f32>; 3],
    /// Cells; `u32::MAX` where none knows the surface.
    pub cells: Vec<u32>,
    /// Whether each answer is believed.
    pub trusted: Vec<bool>,
}

/// Rows that one light shines on.
struct Lit {
    rows: Vec<usize>,
    lights: Lights,
    /// Whether it is the scene's own, with its lamps in place.
    is_own: bool,
}

/// Asks for every row under its own light: a point of 1 W/sr or a sun of 1 W/m² a channel, or a light of the
/// scene. Rows of one light are asked together. `tracer` and `located` are of the scene without lamps.
pub fn answer(
    model: &ReadyModel,
    baked: &Baked,
    tracer: &Tracer,
    (table, located): (&PointsTable, &[SurfacePoint]),
    path: &Path,
    (options, passes): (&RenderOptions, &Passes),
) -> anyhow::Result<RowAnswers> {
    let scene = &baked.scene;
    let parts = match model {
        ReadyModel::Nets(_) => places(table, &(0..table.len()).collect::<Vec<_>>(), &point),
        ReadyModel::Transfer(_) => by_name(table, scene, path)?,
    };
    let has_own = parts.iter().any(|part| part.is_own);
    let whole = has_own.then(|| Tracer::new(scene)).transpose()?;
    let lamps = AreaLights::without_proxies(scene);
    let told = |rows: &Columns| baked.trusted(rows);
    let ask = |part: &Lit| -> anyhow::Result<PointAnswers> {
        let tracer = whole.as_ref().filter(|_| part.is_own).unwrap_or(tracer);
        let places: Vec<SurfacePoint> = match part.is_own {
            true => points::locate_rows(tracer, table, &part.rows, path)?,
            false => part.rows.iter().map(|&row| located[row]).collect(),
        };
        let lamps = (part.lights.area).then(|| lamps.dimmed(scene, &part.lights.dims));
        let options = RenderOptions {
            area_lights: lamps.as_ref(),
            trusted: Some(&told),
            narrow_rays: NARROW_RAYS,
            ..*options
        };
        let viewers = points::vectors_of(table, columns::V, &part.rows);
        let names: Vec<u64> = part.rows.iter().map(|&row| row as u64).collect();
        let renderer = model.renderer(tracer);
        let at = (&places[..], &viewers[..]);
        Ok(renderer.at_points_in_passes(at, &names, &part.lights, &options, passes)?)
    };
    let found: Vec<PointAnswers> = parts.par_iter().map(ask).collect::<Result<_, _>>()?;
    let mut answers = RowAnswers {
        radiance: std::array::from_fn(|_| vec![0.0; located.len()]),
        cells: vec![INVALID; located.len()],
        trusted: vec![false; located.len()],
    };
    for (part, found) in parts.iter().zip(&found) {
        for (k, &row) in part.rows.iter().enumerate() {
            for (channel, x) in (answers.radiance.iter_mut()).zip(found.radiance[k].to_array()) {
                channel[row] = x;
            }
            answers.cells[row] = found.cells[k];
            answers.trusted[row] = found.trust[k] >= TRUSTED;
        }
    }
    Ok(answers)
}

/// Rows by the lights that a table names.
fn by_name(table: &PointsTable, scene: &Scene, path: &Path) -> Result<Vec<Lit>, BadInput> {
    let mut parts = Vec::new();
    for group in by_light(table, scene, path)? {
        match group.name() {
            name if group.is_own() => parts.push(Lit {
                lights: own(scene, name),
                rows: group.rows,
                is_own: true,
            }),
            SUN => {
                let suns = places(table, &group.rows, &sun);
                let has_none = |part: &&Lit| part.lights.sources.is_empty();
                if let Some(part) = suns.iter().find(has_none) {
                    let (path, row) = (path.display(), part.rows[0]);
                    return Err(BadInput(format!(
                        "{path}: row {row}: its sun has no direction (l is 0)"
                    )));
                }
                parts.extend(suns);
            }
            _ => parts.extend(places(table, &group.rows, &point)),
        }
    }
    Ok(parts)
}

/// Rows by the place of their light, or its direction.
fn places(table: &PointsTable, rows: &[usize], light: &dyn Fn(Vec3) -> Lights) -> Vec<Lit> {
    let mut places: BTreeMap<[u32; 3], (Vec3, Vec<usize>)> = BTreeMap::new();
    for (&row, at) in rows.iter().zip(points::vectors_of(table, columns::L, rows)) {
        let key = at.to_array().map(f32::to_bits);
        places.entry(key).or_insert((at, Vec::new())).1.push(row);
    }
    let part = |(at, rows)| Lit {
        rows,
        lights: light(at),
        is_own: false,
    };
    places.into_values().map(part).collect()
}

/// A point of 1 W/sr.
fn point(position: Vec3) -> Lights {
    Lights {
        points: vec![PointLight {
            position,
            intensity: Vec3::ONE,
        }],
        ..Lights::default()
    }
}

/// A sun of 1 W/m²; none without a direction.
fn sun(toward: Vec3) -> Lights {
    let sun = |toward| OwnLight {
        name: SUN.into(),
        source: DistantLight::sun(toward, Vec3::ONE).into(),
    };
    Lights {
        sources: toward.try_normalize().map(sun).into_iter().collect(),
        ..Lights::default()
    }
}

/// One of the scene's own lights.
fn own(scene: &Scene, name: &str) -> Lights {
    let shines = |of: &String| if of == name { Vec3::ONE } else { Vec3::ZERO };
    let dims: Vec<Vec3> = scene.area_light_names.iter().map(shines).collect();
    let sources = scene.lights.iter().filter(|light| light.name == name);
    Lights {
        area: dims.contains(&Vec3::ONE),
        dims,
        sources: sources.cloned().collect(),
        ..Lights::default()
    }
}
