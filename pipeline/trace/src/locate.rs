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
