//! Emission of surfaces by a picture.

use crate::{INVALID, Scene, Texture};
use glam::{DVec3, Vec2, Vec3};

/// Most pieces that a triangle's edge is cut into to find its mean.
const MOST_CUTS: f32 = 64.0;

impl Scene {
    /// The picture that an area light's radiance is multiplied with.
    #[inline]
    pub fn emission_texture(&self, light: u32) -> Option<&Texture> {
        let id = *self.area_light_textures.get(light as usize)?;
        self.textures.get(id as usize)
    }

    #[inline]
    fn shining_picture(&self, triangle: u32) -> Option<&Texture> {
        if self.area_light_textures.is_empty() {
            return None;
        }
        self.emission_texture(*self.triangle_light.get(triangle as usize)?)
    }

    fn corner_uvs(&self, triangle: u32) -> Option<[Vec2; 3]> {
        let vertices = self.triangles.get(triangle as usize)?;
        let uv = |v: u32| self.uvs.get(v as usize).copied().unwrap_or_default();
        Some(vertices.map(uv))
    }

    /// Share of its area light's radiance that a triangle emits at a point, by the weights of its
    /// second and third corner; 1 where the light has no picture.
    #[inline]
    pub fn emitted_share(&self, triangle: u32, [b, c]: [f32; 2]) -> Vec3 {
        let Some(picture) = self.shining_picture(triangle) else {
            return Vec3::ONE;
        };
        let uvs = self.corner_uvs(triangle).unwrap_or_default();
        picture.sample(uvs[0] + (uvs[1] - uvs[0]) * b + (uvs[2] - uvs[0]) * c)
    }

    /// Mean of [`Scene::emitted_share`] over a triangle.
    pub fn mean_share(&self, triangle: u32) -> Vec3 {
        self.mean_share_of(triangle, [Vec2::ZERO, Vec2::X, Vec2::Y])
    }

    /// Mean of [`Scene::emitted_share`] over a part of a triangle, by the barycentrics of the part's
    /// corners: by the middles of equal pieces about a texel wide, at most 64 along an edge.
    pub fn mean_share_of(&self, triangle: u32, part: [Vec2; 3]) -> Vec3 {
        let Some(picture) = self.shining_picture(triangle) else {
            return Vec3::ONE;
        };
        let [a, b, c] = self.corner_uvs(triangle).unwrap_or_default();
        let [a, b, c] = part.map(|at| a + (b - a) * at.x + (c - a) * at.y);
        let size = Vec2::new(picture.width as f32, picture.height as f32);
        let edges = [b - a, c - b, a - c].map(|edge| (edge * size).length());
        let longest = edges.into_iter().fold(0.0, f32::max);
        let cuts = longest.ceil().clamp(1.0, MOST_CUTS) as u32;
        let mut sum = DVec3::ZERO;
        for i in 0..cuts {
            for j in 0..cuts - i {
                // a piece that stands as the whole does, and the one beside it that is turned
                let pieces: &[f32] = if i + j + 1 < cuts {
                    &[1.0, 2.0]
                } else {
                    &[1.0]
                };
                for piece in pieces {
                    let weight = |k: u32| (k as f32 + piece / 3.0) / cuts as f32;
                    let uv = a + (b - a) * weight(i) + (c - a) * weight(j);
                    sum += picture.sample(uv).as_dvec3();
                }
            }
        }
        (sum / f64::from(cuts * cuts)).as_vec3()
    }

    /// Area of each area light, and the same with every triangle's weighed by its mean share, in
    /// the triangles' order.
    pub(crate) fn shining_areas(&self) -> Vec<(f64, DVec3)> {
        let mut sums = vec![(0.0, DVec3::ZERO); self.area_lights.len()];
        for (triangle, &light) in self.triangle_light.iter().enumerate() {
            if light == INVALID {
                continue;
            }
            if let Some(sum) = sums.get_mut(light as usize) {
                let area = self.triangle_area(triangle);
                sum.0 += area;
                sum.1 += self.mean_share(triangle as u32).as_dvec3() * area;
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AreaLight;

    /// A square of two triangles whose light's picture has a bright left half.
    fn square(width: u32) -> Scene {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let bright = |k: u32| Vec3::splat(if 2 * (k % width) < width { 1.0 } else { 0.0 });
        Scene {
            positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
            uvs: corners.map(|(x, y)| Vec2::new(x, y)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            triangle_light: vec![0, 0],
            textures: vec![Texture {
                width,
                height: 2,
                texels: (0..2 * width).map(bright).collect(),
            }],
            area_lights: vec![AreaLight {
                radiance: Vec3::ONE,
                two_sided: false,
            }],
            area_light_textures: vec![0],
            ..Scene::default()
        }
    }

    #[test]
    fn shares_lie_on_the_surface() {
        let scene = square(16);
        assert_eq!(scene.emitted_share(0, [0.1, 0.1]), Vec3::ONE);
        assert_eq!(scene.emitted_share(0, [0.7, 0.1]), Vec3::ZERO);
        assert_eq!(scene.emitted_share(1, [0.1, 0.8]), Vec3::ONE);
        let mut plain = square(16);
        plain.area_light_textures.clear();
        assert_eq!(plain.emitted_share(0, [0.7, 0.1]), Vec3::ONE);
        assert_eq!(plain.mean_share(0), Vec3::ONE);
    }

    /// The bright half covers 1/4 of the lower right triangle and 3/4 of the other.
    #[test]
    fn means_are_integrals() {
        let scene = square(64);
        for (triangle, want) in [(0, 0.25), (1, 0.75)] {
            let mean = scene.mean_share(triangle).x;
            // Midpoints of pieces a texel wide err by their own width along the border.
            assert!((mean - want).abs() < 1.0 / 64.0, "{triangle}: {mean}");
        }
        let (area, weighed) = scene.shining_areas()[0];
        assert!(
            (area - 1.0).abs() < 1e-12 && (weighed.x - 0.5).abs() < 1e-3,
            "{weighed}"
        );
    }
}
