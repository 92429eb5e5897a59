//! Meshes into the scene's columns, objects and their instances, and `Attribute` defaults.

use super::fault::{Place, Read, fault};
use super::mesh::{Lights, Mesh};
use super::params::Params;
use super::reader::{Reader, Recording};
use super::state::{Block, Defaults, Version};
use crate::INVALID;

impl Reader {
    /// Adds a mesh to the scene's columns, or to the object that is open.
    pub fn add_mesh(&mut self, mesh: Mesh, place: Place) -> Read<()> {
        let limit = self.max_triangles;
        self.triangles_made = self.triangles_made.saturating_add(mesh.triangles.len());
        self.vertices_made = self.vertices_made.saturating_add(mesh.positions.len());
        if self.triangles_made > limit || self.vertices_made > limit.saturating_mul(3) {
            return fault(
                place,
                format!(
                    "more than {limit} triangles (or three times as many vertices), instances \
                     counted each time; simplify the scene"
                ),
            );
        }
        if let Some(recording) = &mut self.recording {
            recording.meshes.push(mesh);
            return Ok(());
        }
        let scene = &mut self.scene;
        let first = scene.positions.len() as u32;
        let object = scene.objects.len() as u32;
        scene.objects.push(mesh.name);
        scene.positions.extend(mesh.positions);
        scene.normals.extend(mesh.normals);
        scene.uvs.extend(mesh.uvs);
        for (i, triangle) in mesh.triangles.into_iter().enumerate() {
            scene.triangles.push(triangle.map(|vertex| vertex + first));
            scene.triangle_material.push(mesh.material);
            scene.triangle_object.push(object);
            scene.triangle_light.push(match mesh.lights {
                Lights::None => INVALID,
                Lights::One(light) => light,
                Lights::Each(light) => light + i as u32,
            });
        }
        Ok(())
    }

    /// `ObjectBegin`: the shapes that follow are kept for instances.
    pub fn object_begin(&mut self, name: String, place: Place) -> Read<()> {
        if self.recording.is_some() {
            return fault(place, "ObjectBegin inside another object");
        }
        self.push(Block::Object, place)?;
        self.recording = Some(Recording {
            name,
            meshes: Vec::new(),
        });
        Ok(())
    }

    /// `ObjectEnd`.
    pub fn object_end(&mut self, place: Place) -> Read<()> {
        self.pop(Block::Object, place)?;
        if let Some(recording) = self.recording.take() {
            self.objects.insert(recording.name, recording.meshes);
        }
        Ok(())
    }

    /// `ObjectInstance`: the object's triangles once more, under the current transform.
    pub fn object_instance(&mut self, name: &str, place: Place) -> Read<()> {
        if self.recording.is_some() {
            return fault(place, "ObjectInstance inside an object");
        }
        let Some((name, meshes)) = self.objects.remove_entry(name) else {
            return fault(place, format!("no object \"{name}\" is known"));
        };
        let ctm = self.state.ctm;
        let added = meshes.iter().try_for_each(|mesh| {
            let instance = mesh.transformed(&ctm, place)?;
            self.add_mesh(instance, place)
        });
        self.objects.insert(name, meshes);
        added
    }

    /// `Attribute`: defaults for the parameters of later directives (version 4).
    pub fn attribute(&mut self, target: String, at: Place, params: Params) -> Read<()> {
        const MAX_CHAIN: usize = 1000;
        self.sees(Version::V4);
        if !["shape", "light", "material", "medium", "texture"].contains(&target.as_str()) {
            return fault(at, format!("unknown Attribute target \"{target}\""));
        }
        let before = self.state.defaults;
        let depth = before
            .and_then(|i| self.defaults.get(i))
            .map_or(0, |d| d.depth + 1);
        if depth > MAX_CHAIN {
            return fault(
                at,
                format!("more than {MAX_CHAIN} Attribute directives in one block"),
            );
        }
        self.state.defaults = Some(self.defaults.len());
        self.defaults.push(Defaults {
            before,
            depth,
            target,
            params,
        });
        Ok(())
    }

    /// Adds the defaults in force to a directive's own parameters; later ones come first.
    pub fn add_defaults(&self, directive: &str, params: &mut Params) {
        let target = match directive {
            "Shape" => "shape",
            "LightSource" | "AreaLightSource" => "light",
            "Material" | "MakeNamedMaterial" => "material",
            "Texture" => "texture",
            _ => return,
        };
        let mut next = self.state.defaults;
        while let Some(defaults) = next.and_then(|i| self.defaults.get(i)) {
            if defaults.target == target {
                params.add_defaults(&defaults.params);
            }
            next = defaults.before;
        }
    }
}
