//! PLY meshes: ASCII and binary of both byte orders.
//!
//! Format: G. Turk, "The PLY Polygon File Format", 1994. Read are vertex positions
//! (`x y z`), normals (`nx ny nz`) and texture coordinates (`u v`, `s t`, `texture_u
//! texture_v` or `texture_s texture_t`), and faces; all other elements and properties are
//! passed over.

use super::mesh::Local;
use super::ply_body::{Body, broken};
use super::ply_faces::Faces;
use super::ply_header::{Element, Wrong, header, wrong};
use crate::SceneError;
use glam::{DVec2, DVec3};
use std::path::Path;

/// Reads a PLY file's bytes as a mesh in object space.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Local, SceneError> {
    parse(bytes).map_err(|(place, message)| SceneError::Content {
        path: path.to_path_buf(),
        place,
        message,
    })
}

fn parse(bytes: &[u8]) -> Result<Local, Wrong> {
    let (format, elements, body) = header(bytes)?;
    let mut body = Body::new(format, body);
    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    for element in &elements {
        match element.name.as_str() {
            "vertex" => vertices.read(element, &mut body)?,
            "face" => faces.read(element, &mut body)?,
            _ => pass_over(element, &mut body)?,
        }
    }
    let local = vertices.finish(faces)?;
    if local.triangles.is_empty() {
        return wrong("body", "the mesh has no faces");
    }
    Ok(local)
}

/// Reads an element's data, each number given to `each` with its property's index.
fn scan(
    element: &Element,
    body: &mut Body<'_>,
    mut each: impl FnMut(u64, usize, f64) -> Result<(), Wrong>,
) -> Result<(), Wrong> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for index in 0..element.count {
        for (p, property) in element.properties.iter().enumerate() {
            let mut result = Ok(());
            let whole = match property.length {
                None => match body.number(property.scalar) {
                    Some(value) => {
                        result = each(index, p, value);
                        true
                    }
                    None => false,
                },
                Some(length) => body.list(length, property.scalar, |value| {
                    if result.is_ok() {
                        result = each(index, p, value);
                    }
                }),
            };
            result?;
            if !whole {
                return broken(element, index);
            }
        }
    }
    Ok(())
}

fn pass_over(element: &Element, body: &mut Body<'_>) -> Result<(), Wrong> {
    scan(element, body, |_, _, _| Ok(()))
}

/// The columns of a mesh's vertices: x y z, nx ny nz, u v.
#[derive(Default)]
struct Vertices {
    columns: [Vec<f64>; 8],
}

/// The names that a column may have.
const NAMES: [&[&str]; 8] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
];

impl Vertices {
    fn read(&mut self, element: &Element, body: &mut Body<'_>) -> Result<(), Wrong> {
        let columns: Vec<Option<usize>> = element
            .properties
            .iter()
            .map(|property| {
                let name = property.name.as_str();
                let column = NAMES.iter().position(|names| names.contains(&name));
                column.filter(|_| property.length.is_none())
            })
            .collect();
        let mut seen = [false; 8];
        for column in columns.iter().flatten() {
            if let Some(seen) = seen.get_mut(*column)
                && std::mem::replace(seen, true)
            {
                return wrong("header", "the vertex element has a property twice");
            }
        }
        scan(element, body, |index, p, value| {
            let Some(column) = columns.get(p).copied().flatten() else {
                return Ok(());
            };
            if !value.is_finite() {
                return wrong(
                    format!("vertex {index}"),
                    format!("{value} is not a finite number"),
                );
            }
            if let Some(column) = self.columns.get_mut(column) {
                column.push(value);
            }
            Ok(())
        })
    }

    fn triples(&self, first: usize) -> Vec<DVec3> {
        let [x, y, z] = [first, first + 1, first + 2]
            .map(|i| self.columns.get(i).map_or(&[][..], Vec::as_slice));
        x.iter()
            .zip(y)
            .zip(z)
            .map(|((&x, &y), &z)| DVec3::new(x, y, z))
            .collect()
    }

    fn finish(self, faces: Faces) -> Result<Local, Wrong> {
        let positions = self.triples(0);
        if positions.is_empty() {
            return wrong("header", "there are no vertices with x, y and z");
        }
        let [.., u, v] = &self.columns;
        let uvs: Vec<DVec2> = u.iter().zip(v).map(|(&u, &v)| DVec2::new(u, v)).collect();
        let normals = self.triples(3);
        for count in [normals.len(), uvs.len()] {
            if count != 0 && count != positions.len() {
                return wrong("header", "its vertex elements have different properties");
            }
        }
        let triangles = faces.triangles(&positions)?;
        Ok(Local {
            normals,
            positions,
            uvs,
            triangles,
            reverse_normals: false,
        })
    }
}
