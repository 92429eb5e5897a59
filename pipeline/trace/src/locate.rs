//! Which surface point a row of a table means.

use crate::facets::Facet;
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use glam::Vec3;
use obvhs::aabb::Aabb;

impl Tracer<'_> {
    /// The surface point at `position` whose geometric normal is nearest to parallel with
    /// `normal`, either side up, or `None` when no triangle comes within a thousandth of the
    /// scene's size.
    ///
    /// Tables carry positions in f32 and normals that may be interpolated or turned to the
    /// viewer; among triangles at the same distance the one facing along `normal` wins.
    pub fn locate(&self, position: Vec3, normal: Vec3) -> Option<SurfacePoint> {
        let root = self.bvh.nodes.first()?.aabb();
        if !position.is_finite() || !normal.is_finite() {
            return None;
        }
        let size = (root.max - root.min).max_element();
        let reach = 1e-3 * size;
        let around = Aabb::new((position - reach).into(), (position + reach).into());
        let mut best: Option<(f32, u32, [f32; 2])> = None;
        self.bvh.aabb_traverse(around, |bvh, node| {
            let node = &bvh.nodes[node as usize];
            for slot in node.first_index..node.first_index + node.prim_count {
                let id = self.kept[bvh.primitive_indices[slot as usize] as usize];
                let barycentrics = closest_barycentrics(&self.facets[id as usize], position);
                let at = self.point(id, barycentrics);
                let distance = at.position.distance(position);
                if distance > reach {
                    continue;
                }
                // Turning away costs as much as half the reach, facing backwards a hundredth.
                let cosine = at.normal.dot(normal);
                let turned = 0.5 * (1.0 - cosine.abs()) + if cosine < 0.0 { 0.01 } else { 0.0 };
                let score = distance + reach * turned;
                if best.is_none_or(|(s, i, _)| (score, id) < (s, i)) {
                    best = Some((score, id, barycentrics));
                }
            }
            true
        });
        best.map(|(_, id, barycentrics)| self.point(id, barycentrics))
    }

    /// Distance of a place to the nearest surface where that is at most `reach`.
    pub fn distance(&self, place: Vec3, reach: f32) -> Option<f32> {
        let around = Aabb::new((place - reach).into(), (place + reach).into());
        let mut nearest = f32::INFINITY;
        if place.is_finite() && !self.bvh.nodes.is_empty() {
            self.bvh.aabb_traverse(around, |bvh, node| {
                let node = &bvh.nodes[node as usize];
                for slot in node.first_index..node.first_index + node.prim_count {
                    let id = self.kept[bvh.primitive_indices[slot as usize] as usize];
                    let barycentrics = closest_barycentrics(&self.facets[id as usize], place);
                    let at = self.point(id, barycentrics).position;
                    nearest = nearest.min(at.distance(place));
                }
                true
            });
        }
        (nearest <= reach).then_some(nearest)
    }
}

/// Barycentrics of the point of a triangle nearest to `p`
/// (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5: Voronoi regions).
fn closest_barycentrics(facet: &Facet, p: Vec3) -> [f32; 2] {
    let (a, [ab, ac]) = (facet.corner, facet.edges);
    let (b, c) = (a + ab, a + ac);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return [d1 / (d1 - d3), 0.0];
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return [0.0, d2 / (d2 - d6)];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [1.0 - w, w];
    }
    let sum = va + vb + vc;
    [vb / sum, vc / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_scene::{LoadOptions, load};

    /// Against the nearest of many points of every triangle, which is farther by less than their
    /// spacing.
    #[test]
    fn distance_to_the_nearest_surface() {
        let file = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../scenes/cornell-box/scene.pbrt"
        );
        let scene = load(file.as_ref(), &LoadOptions::default())
            .unwrap()
            .unlit();
        let tracer = Tracer::new(&scene).unwrap();
        const N: u32 = 64;
        let weights = (0..=N).flat_map(|i| (0..=N - i).map(move |j| [i, j]));
        let weights: Vec<[f32; 2]> = weights.map(|w| w.map(|w| w as f32 / N as f32)).collect();
        let points: Vec<Vec3> = (0..scene.triangles.len() as u32)
            .flat_map(|t| weights.iter().map(move |&w| (t, w)))
            .map(|(t, w)| tracer.point(t, w).position)
            .collect();
        // the longest edge, of the room's walls, is below 3
        let spacing = 3.0 / N as f32;
        for k in 0..100 {
            let u = rrf_sampling::Stream::new(5, rrf_sampling::Stage::Test, 0).units(k, 0, 0);
            let place = Vec3::new(1.8 * u[0] - 0.9, 1.9 * u[1] + 0.05, 1.8 * u[2] - 0.9);
            let nearest = points.iter().map(|p| p.distance(place)).fold(9.0, f32::min);
            let found = tracer.distance(place, 2.0).unwrap();
            assert!(found <= nearest + 1e-6 && nearest - found < spacing);
            assert_eq!(tracer.distance(place, 0.5 * found), None);
        }
    }
}
