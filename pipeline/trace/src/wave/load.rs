//! Paths into the columns of a tile.

use super::lanes::Vertices;
use super::path::{Path, PathLight};
use super::random::Draws;
use super::run::Batch;
use rrf_materials::Bsdf;

/// Copies paths at their vertices, and their points of light where they have some, into a tile's
/// columns.
pub(super) fn load<'a>(
    batch: &Batch,
    bounce: u32,
    paths: impl Iterator<Item = &'a Path>,
    lights: &[PathLight],
    vertices: &mut Vertices,
    draws: &mut Draws,
) {
    let tracer = batch.part.tracer;
    let each = batch.replicate_paths as u32;
    vertices.surfaces.materials.clear();
    for (i, path) in paths.enumerate() {
        let row = batch.row(path);
        let mut vertex = tracer.vertex(path.triangle, path.barycentrics, path.viewer);
        if bounce == 0 && batch.part.broad {
            vertex.bsdf = vertex.bsdf.broad().unwrap_or(Bsdf::BLACK);
        }
        let facet = &tracer.facets[path.triangle as usize];
        if facet.encloses && !path.media.is_empty() {
            vertex.bsdf = tracer.between(facet, vertex.bsdf, path.media);
        }
        // rays pass panes; those that have stopped at one are reflected
        if facet.passes && bounce > 0 {
            vertex.bsdf = vertex.bsdf.without_straight();
        }
        vertices.surfaces.set(i, &vertex);
        vertices.viewer.set(i, path.viewer);
        vertices.throughput.set(i, path.throughput);
        vertices.first[i] = path.first;
        vertices.density[i] = path.density;
        vertices.mirror_density[i] = path.mirror_density;
        if let Some(light) = lights.get(path.slot as usize) {
            let away = vertex.position - light.position;
            let (intensity, solid_angle) = batch.part.source.intensity(light, away);
            vertices.light.set(i, light.position);
            vertices.intensity.set(i, intensity);
            vertices.solid_angle[i] = solid_angle;
        }
        let number = row.replicate.wrapping_mul(each).wrapping_add(path.number);
        draws.name(i, row.index, number);
    }
}
