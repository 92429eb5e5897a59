//! Extent, areas and the hash of a scene.

use crate::{INVALID, Material, Scene};
use glam::Vec3;

/// An axis-aligned box in world space.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Bounds {
    /// Lowest corner.
    pub min: [f32; 3],
    /// Highest corner.
    pub max: [f32; 3],
}

impl Bounds {
    /// The middle.
    pub fn center(&self) -> Vec3 {
        (Vec3::from_array(self.min) + Vec3::from_array(self.max)) / 2.0
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f32 {
        (Vec3::from_array(self.max) - Vec3::from_array(self.min)).length()
    }

    /// Whether a point lies inside or on the surface.
    pub fn contains(&self, point: Vec3) -> bool {
        point.cmpge(Vec3::from_array(self.min)).all()
            && point.cmple(Vec3::from_array(self.max)).all()
    }
}

impl Scene {
    /// The corners of a triangle, or `None` if there is no such triangle.
    pub fn corners(&self, triangle: usize) -> Option<[Vec3; 3]> {
        let [a, b, c] = *self.triangles.get(triangle)?;
        let corner = |i: u32| self.positions.get(i as usize).copied();
        Some([corner(a)?, corner(b)?, corner(c)?])
    }

    /// Area of a triangle [m^2, or the square of the scene's unit]; 0 if there is none.
    pub fn triangle_area(&self, triangle: usize) -> f64 {
        let Some(corners) = self.corners(triangle) else {
            return 0.0;
        };
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    }

    /// The box around all triangles; `None` without any. Vertices of no triangle do not count.
    pub fn bounds(&self) -> Option<Bounds> {
        let mut corners = (0..self.triangles.len())
            .filter_map(|i| self.corners(i))
            .flatten();
        let first = corners.next()?;
        let (min, max) = corners.fold((first, first), |(min, max), p| (min.min(p), max.max(p)));
        Some(Bounds {
            min: min.to_array(),
            max: max.to_array(),
        })
    }

    /// BLAKE3 over every column that can change the light or a camera: not names, warnings
    /// or the file's path. Equal columns have equal hashes on every machine; another order of
    /// the same triangles is another scene, since ids are positions.
    pub fn hash(&self) -> [u8; 32] {
        let mut hash = Columns(blake3::Hasher::new());
        hash.0.update(b"rrf-scene columns 2\0");
        hash.floats("positions", self.positions.iter().flat_map(Vec3::to_array));
        hash.floats("normals", self.normals.iter().flat_map(Vec3::to_array));
        hash.floats("uvs", self.uvs.iter().flat_map(glam::Vec2::to_array));
        hash.ids("triangles", self.triangles.iter().flatten().copied());
        hash.ids("triangle_material", self.triangle_material.iter().copied());
        hash.ids("triangle_light", self.triangle_light.iter().copied());
        hash.ids("triangle_object", self.triangle_object.iter().copied());
        hash.materials(self);
        hash.ids(
            "texture_sizes",
            self.textures.iter().flat_map(|t| [t.width, t.height]),
        );
        for texture in &self.textures {
            hash.floats("texels", texture.texels.iter().flat_map(Vec3::to_array));
        }
        hash.lights(self);
        let areas = self.area_lights.iter();
        hash.floats("area_lights", areas.flat_map(|l| l.radiance.to_array()));
        hash.ids(
            "two_sided",
            self.area_lights.iter().map(|l| u32::from(l.two_sided)),
        );
        if !self.area_light_textures.is_empty() {
            let textures = self.area_light_textures.iter();
            hash.ids("area_light_textures", textures.copied());
        }
        let cameras = self.cameras.iter();
        hash.floats(
            "cameras",
            cameras
                .flat_map(|c| [c.eye, c.right, c.up, c.forward])
                .flat_map(|v| v.to_array()),
        );
        hash.floats("fov", self.cameras.iter().map(|c| c.fov));
        hash.ids(
            "camera_sizes",
            self.cameras.iter().flat_map(|c| [c.width, c.height]),
        );
        *hash.0.finalize().as_bytes()
    }

    /// [`Scene::hash`] as 64 hexadecimal digits.
    pub fn hash_hex(&self) -> String {
        blake3::Hash::from_bytes(self.hash()).to_hex().to_string()
    }
}

/// Feeds columns to a hash: name, number of entries, entries in little-endian order. The
/// length comes after the entries, so that they need not be counted first.
struct Columns(blake3::Hasher);

impl Columns {
    fn floats(&mut self, name: &str, values: impl Iterator<Item = f32>) {
        self.ids(name, values.map(f32::to_bits));
    }

    fn ids(&mut self, name: &str, values: impl Iterator<Item = u32>) {
        self.0.update(name.as_bytes()).update(&[0]);
        let mut buffer = Vec::with_capacity(1 << 16);
        let mut count = 0_u64;
        for value in values {
            buffer.extend_from_slice(&value.to_le_bytes());
            count += 1;
            if buffer.len() >= 1 << 16 {
                self.0.update(&buffer);
                buffer.clear();
            }
        }
        self.0.update(&buffer).update(&count.to_le_bytes());
    }

    /// Every light's own numbers: as many columns as lights.
    fn lights(&mut self, scene: &Scene) {
        for light in &scene.lights {
            let mut words = Vec::new();
            light.source.words(&mut |word| words.push(word));
            self.ids("light", words.into_iter());
        }
    }

    /// The columns that every kind fills, then further parameters where a kind has them.
    fn materials(&mut self, scene: &Scene) {
        let materials = || scene.materials.iter();
        self.ids("material_kinds", materials().map(|m| m.kind.number));
        self.floats(
            "base_colors",
            materials().flat_map(|m| m.base_color.to_array()),
        );
        self.floats(
            "parameters",
            materials().flat_map(|m| [m.roughness, m.metallic, m.specular]),
        );
        self.ids(
            "material_textures",
            materials().flat_map(Material::textures),
        );
        let veils = || materials().map(|m| m.opacity);
        if veils().any(|o| o.lets_through()) {
            self.floats("opacities", veils().map(|o| o.value));
            self.floats("cutoffs", veils().map(|o| o.cutoff.unwrap_or(-1.0)));
            self.ids("opacity_textures", veils().map(|o| o.texture));
        }
        let further = || materials().flat_map(|m| &m.own);
        if further().next().is_some() {
            self.floats("own", further().flat_map(|p| p.value.to_array()));
            self.ids("own_textures", further().map(|p| p.texture));
        }
    }
}

/// Area of each group of triangles: `groups` gives each triangle's group or [`INVALID`].
/// Added in the triangles' order.
pub(crate) fn areas_by(scene: &Scene, groups: &[u32], count: usize) -> Vec<(u64, f64)> {
    let mut sums = vec![(0, 0.0); count];
    for (triangle, &group) in groups.iter().enumerate() {
        if group == INVALID {
            continue;
        }
        if let Some(sum) = sums.get_mut(group as usize) {
            sum.0 += 1;
            sum.1 += scene.triangle_area(triangle);
        }
    }
    sums
}
