//! Points tables: their rows as points of the surface and as raw columns.

use crate::failure::BadInput;
use glam::Vec3;
use rrf_field::columns::{self, Columns};
use rrf_store::points::PointsTable;
use rrf_trace::{SurfacePoint, Tracer};
use std::path::Path;

/// The surface point of every row.
pub fn locate(
    tracer: &Tracer,
    table: &PointsTable,
    path: &Path,
) -> Result<Vec<SurfacePoint>, BadInput> {
    let all: Vec<usize> = (0..table.len()).collect();
    locate_rows(tracer, table, &all, path)
}

/// The surface points of some rows.
pub fn locate_rows(
    tracer: &Tracer,
    table: &PointsTable,
    rows: &[usize],
    path: &Path,
) -> Result<Vec<SurfacePoint>, BadInput> {
    rows.iter()
        .map(|&row| {
            let (p, n) = (vec3(table, columns::P, row), vec3(table, columns::N, row));
            tracer.locate(p, n).ok_or_else(|| {
                BadInput(format!(
                    "{}: row {row}: no surface of the scene at {p} (within a thousandth of its \
                     size): is the table of another scene?",
                    path.display()
                ))
            })
        })
        .collect()
}

/// The raw columns of every row: geometry from the table, material from the scene.
pub fn rows(tracer: &Tracer, table: &PointsTable, located: &[SurfacePoint]) -> Columns {
    let mut rows = Columns::default();
    for (row, point) in located.iter().enumerate() {
        let mut raw = [0.0; columns::COUNT];
        for (raw, column) in raw.iter_mut().zip(&table.geometry) {
            *raw = column[row];
        }
        let material = tracer.material_at(point);
        raw[columns::BASE..=columns::SPECULAR].copy_from_slice(&material.columns());
        rows.push(raw);
    }
    rows
}

/// Three columns of some rows.
pub fn vectors_of(table: &PointsTable, first: usize, rows: &[usize]) -> Vec<Vec3> {
    rows.iter().map(|&row| vec3(table, first, row)).collect()
}

/// Three columns of every row.
pub fn vectors(table: &PointsTable, first: usize) -> Vec<Vec3> {
    (0..table.len())
        .map(|row| vec3(table, first, row))
        .collect()
}

fn vec3(table: &PointsTable, first: usize, row: usize) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|i| table.geometry[first + i][row]))
}

/// Metadata of a written table: its origin.
pub fn facts(scene_hash: &str, seed: u64) -> [(&'static str, String); 2] {
    [
        ("rrf.scene_hash", scene_hash.to_string()),
        ("rrf.seed", seed.to_string()),
    ]
}
