//! Where rays end: points, frames and materials on the scene's surface.

use crate::bsdf::Bsdf;
use crate::lamps;
use crate::tracer::Tracer;
use glam::{DVec3, Vec2, Vec3};
use obvhs::aabb::Aabb;
use rrf_scene::{INVALID, MaterialKind, Texture};

/// A point on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Scene id of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's second and third corner.
    pub barycentrics: [f32; 2],
    /// World position, metres.
    pub position: Vec3,
    /// Unit geometric normal (p1-p0) x (p2-p0), world frame.
    pub normal: Vec3,
}

/// A surface point as shading sees it: both normals on the viewer's side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    pub(crate) position: Vec3,
    pub(crate) geometric: Vec3,
    pub(crate) shading: Vec3,
    /// How far rays start off the triangle, metres.
    pub(crate) lift: f32,
    pub(crate) bsdf: Bsdf,
}

impl Vertex {
    /// Black, nowhere.
    pub(crate) const NONE: Vertex = Vertex {
        position: Vec3::ZERO,
        geometric: Vec3::Z,
        shading: Vec3::Z,
        lift: 0.0,
        bsdf: Bsdf {
            kind: MaterialKind::Lambert,
            base_color: Vec3::ZERO,
            roughness: 1.0,
            metallic: 0.0,
            specular: 0.0,
        },
    };
}

/// Orthonormal axes at a surface point, right-handed: x by y is z, and z the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// Normal.
    pub z: Vec3,
}

impl Frame {
    /// Tangents for a unit normal without branches on its direction
    /// (Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 2017).
    #[inline(always)]
    pub fn new(z: Vec3) -> Frame {
        let sign = 1.0f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Frame {
            x: Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: Vec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// A world direction in this frame.
    #[inline(always)]
    pub fn to_local(&self, w: Vec3) -> Vec3 {
        Vec3::new(w.dot(self.x), w.dot(self.y), w.dot(self.z))
    }

    /// A direction of this frame in the world.
    #[inline(always)]
    pub fn to_world(&self, w: Vec3) -> Vec3 {
        self.x * w.x + self.y * w.y + self.z * w.z
    }
}

impl Tracer<'_> {
    /// Total area of the surface, square metres, each triangle counted once.
    pub fn area(&self) -> f64 {
        self.area_cdf.last().copied().unwrap_or(0.0)
    }

    /// The point of a triangle with these barycentrics.
    #[inline]
    pub fn point(&self, triangle: u32, barycentrics: [f32; 2]) -> SurfacePoint {
        let [p0, p1, p2] = self.corners_of(triangle);
        let [b1, b2] = barycentrics;
        SurfacePoint {
            triangle,
            barycentrics,
            position: p0 + (p1 - p0) * b1 + (p2 - p0) * b2,
            normal: self.normals[triangle as usize].into(),
        }
    }

    /// A point uniform over the surface by area, from three numbers in [0, 1).
    /// Density 1 / [`Tracer::area`] with respect to area.
    pub fn sample_area(&self, u: [f32; 3]) -> SurfacePoint {
        let target = f64::from(u[0]) * self.area();
        let last = self.area_cdf.len().saturating_sub(1);
        // The first triangle whose cumulative area exceeds the target has an area.
        let triangle = self.area_cdf.partition_point(|&c| c <= target).min(last);
        self.point(triangle as u32, lamps::uniform_triangle([u[1], u[2]]))
    }

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
                let corners = self.corners_of(id);
                let barycentrics = closest_barycentrics(corners, position);
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

    /// Unit shading normal at a point for a viewer in direction `v`: the interpolated normal on
    /// the viewer's geometric side; where that turns away from the viewer, the geometric one.
    pub fn normal_at(&self, point: &SurfacePoint, v: Vec3) -> Vec3 {
        self.vertex(point.triangle, point.barycentrics, v).shading
    }

    /// Material parameters at a point, textures looked up.
    pub fn material_at(&self, point: &SurfacePoint) -> Bsdf {
        self.bsdf(point.triangle, point.barycentrics)
    }

    /// All that shading needs of a point seen from `v`.
    #[inline(always)]
    pub(crate) fn vertex(&self, triangle: u32, barycentrics: [f32; 2], v: Vec3) -> Vertex {
        let [p0, p1, p2] = self.corners_of(triangle);
        let [b1, b2] = barycentrics;
        let outward = Vec3::from(self.normals[triangle as usize]);
        let geometric = if outward.dot(v) < 0.0 {
            -outward
        } else {
            outward
        };
        let mut shading = geometric;
        if !self.flat[triangle as usize] {
            let smooth = self.bent_normal(triangle, barycentrics, outward);
            let turned = if smooth.dot(geometric) < 0.0 {
                -smooth
            } else {
                smooth
            };
            if turned.dot(v) > 0.0 {
                shading = turned;
            }
        }
        Vertex {
            position: p0 + (p1 - p0) * b1 + (p2 - p0) * b2,
            geometric,
            shading,
            lift: self.lifts[triangle as usize],
            bsdf: self.bsdf(triangle, barycentrics),
        }
    }

    #[inline(always)]
    fn bsdf(&self, triangle: u32, barycentrics: [f32; 2]) -> Bsdf {
        let material = self.scene.triangle_material[triangle as usize];
        let material = &self.scene.materials[material as usize];
        let mut bsdf = Bsdf::of(material);
        if material.base_texture != INVALID || material.roughness_metallic_texture != INVALID {
            let uv = self.uv(triangle, barycentrics);
            if let Some(texture) = self.texture(material.base_texture) {
                bsdf.base_color *= texture.sample(uv);
            }
            if let Some(texture) = self.texture(material.roughness_metallic_texture) {
                let texel = texture.sample(uv);
                bsdf.roughness *= texel.y;
                bsdf.metallic *= texel.z;
            }
        }
        bsdf
    }

    fn texture(&self, id: u32) -> Option<&Texture> {
        self.scene.textures.get(id as usize)
    }

    fn uv(&self, triangle: u32, [b1, b2]: [f32; 2]) -> Vec2 {
        let vertices = self.scene.triangles[triangle as usize];
        let [t0, t1, t2] = vertices.map(|v| self.scene.uvs[v as usize]);
        t0 + (t1 - t0) * b1 + (t2 - t0) * b2
    }

    /// Unit shading normal on the outer side: interpolated, then bent by the normal map.
    fn bent_normal(&self, triangle: u32, barycentrics: [f32; 2], outward: Vec3) -> Vec3 {
        let smooth = self.smooth_normal(triangle, barycentrics, outward);
        let material = self.scene.triangle_material[triangle as usize];
        let map = self.scene.materials[material as usize].normal_texture;
        let Some(texture) = self.texture(map) else {
            return smooth;
        };
        let Some((tangent, bitangent)) = self.tangents(triangle, smooth) else {
            return smooth;
        };
        let local = texture.sample(self.uv(triangle, barycentrics)) * 2.0 - Vec3::ONE;
        let bent = tangent * local.x + bitangent * local.y + smooth * local.z;
        bent.try_normalize().unwrap_or(smooth)
    }

    /// Unit directions of growing u and v on a triangle, made orthogonal to `normal`;
    /// `None` where the texture coordinates span no area.
    fn tangents(&self, triangle: u32, normal: Vec3) -> Option<(Vec3, Vec3)> {
        let vertices = self.scene.triangles[triangle as usize];
        let [t0, t1, t2] = vertices.map(|v| self.scene.uvs[v as usize]);
        let [p0, p1, p2] = self.corners_of(triangle);
        let (e1, e2, s1, s2) = (p1 - p0, p2 - p0, t1 - t0, t2 - t0);
        let area = s1.perp_dot(s2);
        // dp/du times the area in (u, v): only its direction is wanted.
        let along_u = (e1 * s2.y - e2 * s1.y) * area.signum();
        let tangent = along_u.reject_from_normalized(normal).try_normalize()?;
        let turn = if area < 0.0 { -1.0 } else { 1.0 };
        let handed = if normal.dot(e1.cross(e2)) < 0.0 {
            -turn
        } else {
            turn
        };
        (area != 0.0).then(|| (tangent, normal.cross(tangent) * handed))
    }

    /// Interpolated unit normal; the geometric one where the corners' cancel.
    fn smooth_normal(&self, triangle: u32, [b1, b2]: [f32; 2], outward: Vec3) -> Vec3 {
        let vertices = self.scene.triangles[triangle as usize];
        let [n0, n1, n2] = vertices.map(|v| self.scene.normals[v as usize]);
        let sum = n0 * (1.0 - b1 - b2) + n1 * b1 + n2 * b2;
        sum.try_normalize().unwrap_or(outward)
    }

    #[inline(always)]
    pub(crate) fn corners_of(&self, triangle: u32) -> [Vec3; 3] {
        self.scene.triangles[triangle as usize].map(|v| self.scene.positions[v as usize])
    }

    /// Radiance that the surface emits at a point toward `v` [W/(sr m^2)].
    pub fn emission(&self, point: &SurfacePoint, v: Vec3) -> Vec3 {
        lamps::emission(self.scene, point.triangle, point.normal, v)
    }
}

/// Cross product of two edges: along the geometric normal, as long as twice the area. In f64,
/// so that needles keep a direction.
pub(crate) fn doubled_area(corners: [Vec3; 3]) -> DVec3 {
    let [p0, p1, p2] = corners.map(Vec3::as_dvec3);
    (p1 - p0).cross(p2 - p0)
}

/// Barycentrics of the point of a triangle nearest to `p`
/// (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5: Voronoi regions).
fn closest_barycentrics([a, b, c]: [Vec3; 3], p: Vec3) -> [f32; 2] {
    let (ab, ac) = (b - a, c - a);
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
