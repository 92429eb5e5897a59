//! Primitives to columns of vertices and triangles.

use super::document::{Document, place};
use super::material::{MaterialUse, Materials};
use super::nodes::Placed;
use super::output::Output;
use super::primitive::Source;
use super::uv::{UvSource, stays_in_picture};
use crate::warn::Warnings;
use crate::{AreaLight, INVALID, Scene, SceneError};
use ::gltf::json::Mesh;
use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::Semantic;
use glam::{DMat3, DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// Adds the triangles of a node's mesh.
pub(super) fn add(
    document: &Document,
    placed: &Placed,
    materials: &mut Materials,
    output: &mut Output,
) -> Result<(), SceneError> {
    let Some((m, mesh)) = placed
        .node
        .mesh
        .and_then(|index| Some((index.value(), document.root.get(index)?)))
    else {
        return Ok(());
    };
    note_morph(document, placed, mesh, &mut output.warnings);
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        let place = place("mesh", m, mesh.name.as_deref());
        let place = format!("{place}, primitive {p}");
        let warnings = &mut output.warnings;
        let Some(source) = Source::new(document, placed, primitive, place, warnings)? else {
            continue;
        };
        if source.has(Semantic::Colors(0)) {
            warnings.add(&source.place, "vertex colours left out");
        }
        let material = materials.of_primitive(primitive.material, warnings)?;
        let object = object_name(document, placed, mesh, p);
        let light = area_light(&material, materials.name(material.id), output);
        source.append(&material, light, object, output)?;
    }
    Ok(())
}

fn note_morph(document: &Document, placed: &Placed, mesh: &Mesh, warnings: &mut Warnings) {
    let weights = placed.node.weights.as_ref().or(mesh.weights.as_ref());
    if weights.is_some_and(|weights| weights.iter().any(|&weight| weight != 0.0)) {
        let place = document.node_place(placed.index);
        warnings.add(place, "morph targets left out: the mesh is read unmorphed");
    }
}

fn object_name(document: &Document, placed: &Placed, mesh: &Mesh, primitive: usize) -> String {
    let name = placed.node.name.as_ref().or(mesh.name.as_ref());
    let name = name.map_or_else(|| document.node_place(placed.index), String::clone);
    match mesh.primitives.len() {
        0 | 1 => name,
        _ => format!("{name}/{primitive}"),
    }
}

impl Source<'_> {
    /// Adds the used vertices and the triangles in world space.
    fn append(
        &self,
        material: &MaterialUse,
        light: u32,
        object: String,
        output: &mut Output,
    ) -> Result<(), SceneError> {
        let corners = self.corners(output.scene.triangles.len())?;
        let first = output.scene.positions.len();
        let (vertices, local) = used_vertices(&corners);
        self.append_positions(&vertices, &mut output.scene)?;
        self.append_normals(&vertices, output)?;
        self.append_uvs(material, &vertices, output)?;
        let scene = &mut output.scene;
        // Front faces are counter-clockwise, after a mirror clockwise (glTF 2.0, 3.7.2.1).
        let mirrors = self.placed.world.matrix3.determinant() < 0.0;
        for triangle in local {
            let [a, b, c] = triangle.map(|vertex| first as u32 + vertex);
            scene
                .triangles
                .push(if mirrors { [a, c, b] } else { [a, b, c] });
        }
        let count = scene.triangles.len();
        let object_id = scene.objects.len() as u32;
        scene.triangle_material.resize(count, material.id);
        scene.triangle_light.resize(count, light);
        scene.triangle_object.resize(count, object_id);
        scene.objects.push(object);
        Ok(())
    }

    fn append_positions(&self, vertices: &[u32], scene: &mut Scene) -> Result<(), SceneError> {
        for &vertex in vertices {
            let stored: [f32; 3] = self.positions.numbers(vertex as usize).unwrap_or_default();
            let world = &self.placed.world;
            let position = world
                .transform_point3(DVec3::from_array(stored.map(f64::from)))
                .as_vec3();
            if !position.is_finite() {
                let node = self.document.node_place(self.placed.index);
                return Err(self.error(format!(
                    "vertex {vertex} at {} is not finite in world space ({node})",
                    listed(&stored)
                )));
            }
            scene.positions.push(position);
        }
        Ok(())
    }

    /// Normals transform by the cofactor matrix, which has the inverse transpose's direction
    /// up to the determinant's sign, and exists for flat scalings too.
    fn append_normals(&self, vertices: &[u32], output: &mut Output) -> Result<(), SceneError> {
        let scene = &mut output.scene;
        let Some(normals) = self.attribute(Semantic::Normals, Type::Vec3)? else {
            scene.normals.resize(scene.positions.len(), Vec3::ZERO);
            return Ok(());
        };
        let cofactor = cofactor(&self.placed.world.matrix3);
        for &vertex in vertices {
            let stored: [f32; 3] = normals.numbers(vertex as usize).unwrap_or_default();
            let normal = cofactor * DVec3::from_array(stored.map(f64::from));
            let normal = normal.try_normalize().map_or(Vec3::ZERO, |n| n.as_vec3());
            if normal == Vec3::ZERO {
                let message = "normals without direction: the triangles' own are used there";
                output.warnings.add(&self.place, message);
            }
            scene.normals.push(normal);
        }
        Ok(())
    }

    fn append_uvs(
        &self,
        material: &MaterialUse,
        vertices: &[u32],
        output: &mut Output,
    ) -> Result<(), SceneError> {
        let Output {
            scene, warnings, ..
        } = output;
        let source = material.uv.unwrap_or(UvSource::PLAIN);
        let semantic = Semantic::TexCoords(source.set);
        let name = semantic.to_string();
        let place = &self.place;
        let Some(uvs) = self.attribute(semantic, Type::Vec2)? else {
            if material.uv.is_some() {
                let message = format!("textured, but without {name}: one texel for all");
                warnings.add(place, message);
            }
            scene.uvs.resize(scene.positions.len(), Vec2::ZERO);
            return Ok(());
        };
        let first = scene.uvs.len();
        for &vertex in vertices {
            let stored = uvs.numbers(vertex as usize).unwrap_or_default();
            let uv = source.apply(stored);
            if !uv.is_finite() {
                let stored: [f32; 2] = stored;
                let message = format!(
                    "{name} of vertex {vertex} is {}, not finite",
                    listed(&stored)
                );
                return Err(self.error(message));
            }
            scene.uvs.push(uv);
        }
        let added = scene.uvs.get(first..).unwrap_or(&[]);
        if material.leaves_repetition && !stays_in_picture(added.iter().copied()) {
            let message = "a texture that clamps or mirrors is repeated instead";
            warnings.add(place, message);
        }
        if material.bends_normals && self.has(Semantic::Tangents) {
            let message = "TANGENT left out: tangents follow from the texture coordinates";
            warnings.add(place, message);
        }
        Ok(())
    }
}

/// The vertices that `corners` names, in order of first use, and the corners by them.
fn used_vertices(corners: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    let mut place_of = HashMap::new();
    let local = corners
        .iter()
        .map(|triangle| {
            triangle.map(|vertex| {
                *place_of.entry(vertex).or_insert_with(|| {
                    vertices.push(vertex);
                    vertices.len() as u32 - 1
                })
            })
        })
        .collect();
    (vertices, local)
}

/// A light for one primitive, or [`INVALID`].
fn area_light(material: &MaterialUse, name: &str, output: &mut Output) -> u32 {
    if material.radiance == Vec3::ZERO {
        return INVALID;
    }
    let light = AreaLight {
        radiance: material.radiance,
        two_sided: material.double_sided,
    };
    let name = output.light_names.of_material(material.id, name);
    let texture = material.emission_texture;
    output.scene.add_area_light(light, name, texture)
}

/// Cofactor matrix times the determinant's sign.
fn cofactor(m: &DMat3) -> DMat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
}

/// Numbers as messages show them.
fn listed(numbers: &[f32]) -> String {
    let texts: Vec<String> = numbers.iter().map(f32::to_string).collect();
    texts.join(" ")
}
