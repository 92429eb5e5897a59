//! Primitives to columns of vertices and triangles.

use super::Output;
use super::accessor::Column;
use super::document::{Document, place};
use super::material::{MaterialUse, Materials, stays_in_picture};
use super::nodes::Placed;
use super::uv::UvSource;
use crate::warn::Warnings;
use crate::{AreaLight, INVALID, Scene, SceneError};
use ::gltf::json::accessor::{Accessor, Type};
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, Mesh};
use glam::{DMat3, DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// Most triangles of a scene. Instances multiply what a small file holds, so the sum is
/// checked before memory is asked for.
const MAX_TRIANGLES: usize = 1 << 27;

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
        let material = materials.of_primitive(primitive.material, warnings)?;
        let object = object_name(document, placed, mesh, p);
        source.append(&material, object, output)?;
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

/// A primitive of triangles at a node, with its checked accessors.
struct Source<'a> {
    document: &'a Document<'a>,
    placed: &'a Placed<'a>,
    primitive: &'a Primitive,
    place: String,
    mode: Mode,
    indices: Option<Column<'a>>,
    positions: Column<'a>,
    normals: Option<Column<'a>>,
}

impl<'a> Source<'a> {
    /// `None`, and a warning, for points and lines.
    fn new(
        document: &'a Document<'a>,
        placed: &'a Placed<'a>,
        primitive: &'a Primitive,
        place: String,
        warnings: &mut Warnings,
    ) -> Result<Option<Self>, SceneError> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err(document.error(place, "unknown primitive mode"));
        };
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            warnings.add(place, format!("{mode:?} left out: they have no surface"));
            return Ok(None);
        }
        if has(primitive, Semantic::Colors(0)) {
            warnings.add(&place, "vertex colours left out");
        }
        let position = attribute(primitive, Semantic::Positions)
            .ok_or_else(|| document.error(&place, "no POSITION"))?;
        let positions = document.number_column(position, "POSITION", Type::Vec3, &place)?;
        let normals = vertex_column(document, primitive, Semantic::Normals, &positions, &place)?;
        let indices = primitive
            .indices
            .map(|index| document.index_column(index, &place))
            .transpose()?;
        Ok(Some(Self {
            document,
            placed,
            primitive,
            place,
            mode,
            indices,
            positions,
            normals,
        }))
    }

    fn error(&self, message: impl Into<String>) -> SceneError {
        self.document.error(&self.place, message)
    }

    /// Vertex ids of the triangles, each below the number of positions; the scene has
    /// `before` triangles already.
    fn corners(&self, before: usize) -> Result<Vec<[u32; 3]>, SceneError> {
        let count = self.indices.as_ref().unwrap_or(&self.positions).count();
        let triangles = match self.mode {
            Mode::Triangles => count / 3,
            _ => count.saturating_sub(2),
        };
        if triangles > MAX_TRIANGLES - before.min(MAX_TRIANGLES) {
            let message = format!("the scene would have more than {MAX_TRIANGLES} triangles");
            return Err(self.error(message));
        }
        if self.mode == Mode::Triangles && !count.is_multiple_of(3) {
            let message = format!("{count} corners: triangles need a multiple of 3");
            return Err(self.error(message));
        }
        (0..triangles)
            .map(|t| {
                let [a, b, c] = corner_numbers(self.mode, t);
                Ok([self.vertex(a)?, self.vertex(b)?, self.vertex(c)?])
            })
            .collect()
    }

    /// The vertex id of corner `corner`.
    fn vertex(&self, corner: usize) -> Result<u32, SceneError> {
        let count = self.positions.count();
        let vertex = match &self.indices {
            Some(indices) => indices.index(corner),
            None => u32::try_from(corner).ok(),
        };
        match vertex {
            Some(vertex) if (vertex as usize) < count => Ok(vertex),
            _ => {
                let vertex = vertex.map_or("beyond the end".into(), |v| v.to_string());
                Err(self.error(format!(
                    "corner {corner} is vertex {vertex}, there are {count} vertices"
                )))
            }
        }
    }

    /// Adds the used vertices and the triangles in world space.
    fn append(
        &self,
        material: &MaterialUse,
        object: String,
        output: &mut Output,
    ) -> Result<(), SceneError> {
        let corners = self.corners(output.scene.triangles.len())?;
        let first = output.scene.positions.len();
        let (vertices, local) = used_vertices(&corners);
        self.append_positions(&vertices, &mut output.scene)?;
        self.append_normals(&vertices, output);
        self.append_uvs(material, &vertices, output)?;
        let scene = &mut output.scene;
        let light = area_light(material, scene);
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
                    "vertex {vertex} at {stored:?} is not finite in world space ({node})"
                )));
            }
            scene.positions.push(position);
        }
        Ok(())
    }

    /// Normals transform by the cofactor matrix, which has the inverse transpose's direction
    /// up to the determinant's sign, and exists for flat scalings too.
    fn append_normals(&self, vertices: &[u32], output: &mut Output) {
        let scene = &mut output.scene;
        let Some(normals) = &self.normals else {
            scene.normals.resize(scene.positions.len(), Vec3::ZERO);
            return;
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
    }

    fn append_uvs(
        &self,
        material: &MaterialUse,
        vertices: &[u32],
        output: &mut Output,
    ) -> Result<(), SceneError> {
        let Output { scene, warnings } = output;
        let source = material.uv.unwrap_or(UvSource::PLAIN);
        let semantic = Semantic::TexCoords(source.set);
        let name = semantic.to_string();
        let (document, primitive, place) = (self.document, self.primitive, &self.place);
        let Some(uvs) = vertex_column(document, primitive, semantic, &self.positions, place)?
        else {
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
                let message = format!("{name} of vertex {vertex} is {stored:?}, not finite");
                return Err(self.error(message));
            }
            scene.uvs.push(uv);
        }
        let added = scene.uvs.get(first..).unwrap_or(&[]);
        if material.leaves_repetition && !stays_in_picture(added.iter().copied()) {
            let message = "a texture that clamps or mirrors is repeated instead";
            warnings.add(place, message);
        }
        if material.bends_normals && has(primitive, Semantic::Tangents) {
            let message = "TANGENT left out: tangents follow from the texture coordinates";
            warnings.add(place, message);
        }
        Ok(())
    }
}

/// Corners of triangle `t`, counter-clockwise (glTF 2.0, 3.7.2.1).
fn corner_numbers(mode: Mode, t: usize) -> [usize; 3] {
    match mode {
        Mode::TriangleStrip => [t, t + 1 + t % 2, t + 2 - t % 2],
        Mode::TriangleFan => [t + 1, t + 2, 0],
        _ => [3 * t, 3 * t + 1, 3 * t + 2],
    }
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    let key = Checked::Valid(semantic);
    primitive.attributes.get(&key).copied()
}

fn has(primitive: &Primitive, semantic: Semantic) -> bool {
    attribute(primitive, semantic).is_some()
}

/// An attribute with an element for every position.
fn vertex_column<'a>(
    document: &'a Document,
    primitive: &Primitive,
    semantic: Semantic,
    positions: &Column,
    place: &str,
) -> Result<Option<Column<'a>>, SceneError> {
    let shape = match semantic {
        Semantic::TexCoords(_) => Type::Vec2,
        _ => Type::Vec3,
    };
    let name = semantic.to_string();
    let Some(index) = attribute(primitive, semantic) else {
        return Ok(None);
    };
    let column = document.number_column(index, &name, shape, place)?;
    if column.count() < positions.count() {
        let message = format!(
            "{name} has {} elements for {} positions",
            column.count(),
            positions.count()
        );
        return Err(document.error(place, message));
    }
    Ok(Some(column))
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
fn area_light(material: &MaterialUse, scene: &mut Scene) -> u32 {
    if material.radiance == Vec3::ZERO {
        return INVALID;
    }
    scene.area_lights.push(AreaLight {
        radiance: material.radiance,
        two_sided: material.double_sided,
    });
    scene.area_lights.len() as u32 - 1
}

/// Cofactor matrix times the determinant's sign.
fn cofactor(m: &DMat3) -> DMat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
}
