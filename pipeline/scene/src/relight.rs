//! A scene whose own lights have been taken out, to be lit by others.

use crate::{INVALID, Scene};
use glam::Vec3;
use rrf_materials::Bsdf;

impl Scene {
    /// The scene without its own lights: lights, sky and emission go, and with them the triangles
    /// that only emit. A surface that emits and reflects nothing *is* the lamp; one
    /// that reflects stays, dark.
    pub fn unlit(&self) -> Scene {
        let keep = self.unlit_triangles();
        let pick = |column: &[u32]| keep.iter().map(|&t| column[t]).collect();
        Scene {
            triangles: keep.iter().map(|&t| self.triangles[t]).collect(),
            triangle_material: pick(&self.triangle_material),
            triangle_light: vec![INVALID; keep.len()],
            triangle_object: pick(&self.triangle_object),
            lights: Vec::new(),
            area_lights: Vec::new(),
            area_light_names: Vec::new(),
            area_light_textures: Vec::new(),
            ..self.clone()
        }
    }

    /// The triangles that [`Scene::unlit`] keeps, in its order.
    pub fn unlit_triangles(&self) -> Vec<usize> {
        let all = 0..self.triangles.len();
        all.filter(|&t| !self.is_lamp(t)).collect()
    }

    /// The scene with one of its own lights alone, the surfaces of others dark.
    pub fn lit_by(&self, name: &str) -> Scene {
        let mut scene = self.clone();
        scene.lights.retain(|light| light.name == name);
        let names = &self.area_light_names;
        for (light, own) in scene.area_lights.iter_mut().zip(names) {
            if own != name {
                light.radiance = Vec3::ZERO;
            }
        }
        scene
    }

    /// Whether a triangle only shines, so that [`Scene::unlit`] leaves it out.
    pub fn is_lamp(&self, triangle: usize) -> bool {
        let material = &self.materials[self.triangle_material[triangle] as usize];
        self.triangle_light[triangle] != INVALID && Bsdf::of(material).is_black()
    }
}

#[cfg(test)]
mod tests {
    use crate::{INVALID, LoadOptions, load};
    use std::path::Path;

    #[test]
    fn the_cornell_lamp_goes_and_nothing_else() {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box/scene.pbrt");
        let scene = load(&path, &LoadOptions::default()).unwrap();
        let unlit = scene.unlit();
        assert_eq!((scene.triangles.len(), unlit.triangles.len()), (36, 34));
        assert!(unlit.triangle_light.iter().all(|&l| l == INVALID));
        let lamp_area = 0.47 * 0.38;
        let areas = |s: &crate::Scene| {
            (0..s.triangles.len())
                .map(|t| s.triangle_area(t))
                .sum::<f64>()
        };
        assert!((areas(&scene) - areas(&unlit) - lamp_area).abs() < 1e-6);
    }
}
