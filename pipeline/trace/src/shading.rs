//! Textures and interpolated normals.

use crate::tracer::Tracer;
use glam::{Vec2, Vec3};
use rrf_materials::{Bsdf, Material};

impl Tracer<'_> {
    /// A material's constants times its textures at a point.
    pub(crate) fn textured(&self, triangle: u32, at: [f32; 2], constants: Bsdf) -> Bsdf {
        let (material, uv) = (self.material(triangle), self.uv(triangle, at));
        constants.textured(material, &self.scene.textures, uv)
    }

    /// Opacity at a point in [0, 1].
    pub(crate) fn opacity(&self, triangle: u32, at: [f32; 2]) -> f32 {
        let opacity = &self.material(triangle).opacity;
        opacity.at(&self.scene.textures, || self.uv(triangle, at))
    }

    fn material(&self, triangle: u32) -> &Material {
        let id = self.facets[triangle as usize].material;
        &self.scene.materials[id as usize]
    }

    fn uv(&self, triangle: u32, [b1, b2]: [f32; 2]) -> Vec2 {
        let vertices = self.scene.triangles[triangle as usize];
        let [t0, t1, t2] = vertices.map(|v| self.scene.uvs[v as usize]);
        t0 + (t1 - t0) * b1 + (t2 - t0) * b2
    }

    /// Unit shading normal on the outer side: interpolated, then bent by the normal map.
    pub(crate) fn bent_normal(&self, triangle: u32, barycentrics: [f32; 2]) -> Vec3 {
        let smooth = self.smooth_normal(triangle, barycentrics);
        let id = self.material(triangle).normal_texture;
        let Some(texture) = self.scene.textures.get(id as usize) else {
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
        let [e1, e2] = self.facets[triangle as usize].edges;
        let (s1, s2) = (t1 - t0, t2 - t0);
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
    fn smooth_normal(&self, triangle: u32, [b1, b2]: [f32; 2]) -> Vec3 {
        let vertices = self.scene.triangles[triangle as usize];
        let [n0, n1, n2] = vertices.map(|v| self.scene.normals[v as usize]);
        let sum = n0 * (1.0 - b1 - b2) + n1 * b1 + n2 * b2;
        let outward = self.facets[triangle as usize].normal;
        sum.try_normalize().unwrap_or(outward)
    }
}
