//! PLY meshes: ASCII and binary of both byte orders.
//!
//! Format: G. Turk, "The PLY Polygon File Format", 1994. Read are vertex positions
//! (`x y z`), normals (`nx ny nz`) and texture coordinates (`u v`, `s t`, `texture_u
//! texture_v` or `texture_s texture_t`), and faces of three or four corners; all other
//! elements and properties are passed over.

use super::mesh::Local;
use super::ply_header::{Element, Format, Scalar, Wrong, header, wrong};
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
    let mut body = Body { format, rest: body };
    let mut vertices = Vertices::default();
    let mut faces = Vec::new();
    for element in &elements {
        match element.name.as_str() {
            "vertex" => vertices.read(element, &mut body)?,
            "face" => read_faces(element, &mut body, &mut faces)?,
            _ => pass_over(element, &mut body)?,
        }
    }
    let local = vertices.finish(faces)?;
    if local.triangles.is_empty() {
        return wrong("body", "the mesh has no faces");
    }
    Ok(local)
}

/// The bytes after the header, taken number by number.
struct Body<'a> {
    format: Format,
    rest: &'a [u8],
}

impl Body<'_> {
    /// The next number, or `None` where the file ends or has none.
    fn number(&mut self, scalar: Scalar) -> Option<f64> {
        if self.format == Format::Ascii {
            return self.word()?.parse::<f64>().ok();
        }
        Some(match scalar {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    /// The next `N` bytes, the lowest first.
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        let mut bytes = *taken;
        if self.format == Format::Big {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn word(&mut self) -> Option<&str> {
        let start = self
            .rest
            .iter()
            .position(|byte| !byte.is_ascii_whitespace())?;
        let text = self.rest.get(start..)?;
        let end = text
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.rest = rest;
        std::str::from_utf8(word).ok()
    }

    /// The length of a list, then its numbers through `each`; false if the file ends.
    fn list(&mut self, length: Scalar, scalar: Scalar, mut each: impl FnMut(f64)) -> bool {
        let Some(length) = self.number(length).filter(|n| *n >= 0.0 && *n == n.trunc()) else {
            return false;
        };
        for _ in 0..length as u64 {
            match self.number(scalar) {
                Some(value) => each(value),
                None => return false,
            }
        }
        true
    }
}

/// The fault of an element whose data end or are no numbers.
fn broken<T>(element: &Element, index: u64) -> Result<T, Wrong> {
    wrong(
        format!("{} {index}", element.name),
        format!(
            "its data end or are no numbers, of {} announced; is the file truncated?",
            element.count
        ),
    )
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

    fn finish(self, faces: Vec<Face>) -> Result<Local, Wrong> {
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
        let mut triangles = Vec::with_capacity(faces.len());
        for (corners, count, face) in faces {
            let mut ids = [0; 4];
            for (id, corner) in ids.iter_mut().zip(corners).take(count) {
                if corner < 0 || corner >= positions.len() as i64 {
                    return wrong(
                        format!("face {face}"),
                        format!(
                            "vertex index {corner}, but there are {} vertices (0 to {})",
                            positions.len(),
                            positions.len() - 1
                        ),
                    );
                }
                *id = corner as u32;
            }
            let [a, b, c, d] = ids;
            triangles.push([a, b, c]);
            if count == 4 {
                triangles.push([a, c, d]);
            }
        }
        Ok(Local {
            normals,
            positions,
            uvs,
            triangles,
            reverse_normals: false,
        })
    }
}

/// A face's corners, how many they are, and its index.
type Face = ([i64; 4], usize, u64);

/// Reads the faces' corners; triangles and quads only.
fn read_faces(element: &Element, body: &mut Body<'_>, faces: &mut Vec<Face>) -> Result<(), Wrong> {
    let wanted = element.properties.iter().position(|property| {
        let name = property.name.as_str();
        property.length.is_some() && matches!(name, "vertex_indices" | "vertex_index")
    });
    let Some(wanted) = wanted else {
        return wrong("header", "the face element has no list vertex_indices");
    };
    for index in 0..element.count {
        for (p, property) in element.properties.iter().enumerate() {
            let (mut count, mut corners) = (0_usize, [f64::NAN; 4]);
            let mut keep = |value: f64| {
                if let Some(corner) = corners.get_mut(count) {
                    *corner = value;
                }
                count += 1;
            };
            let whole = match property.length {
                Some(length) => body.list(length, property.scalar, keep),
                None => body.number(property.scalar).map(&mut keep).is_some(),
            };
            if !whole {
                return broken(element, index);
            }
            if p == wanted {
                faces.push(face(corners, count, index)?);
            }
        }
    }
    Ok(())
}

fn face(corners: [f64; 4], count: usize, index: u64) -> Result<Face, Wrong> {
    let place = format!("face {index}");
    if count != 3 && count != 4 {
        return wrong(place, format!("{count} corners; only 3 and 4 are read"));
    }
    match corners
        .iter()
        .take(count)
        .find(|corner| **corner != corner.trunc())
    {
        Some(corner) => wrong(place, format!("vertex index {corner} is no whole number")),
        None => Ok((corners.map(|corner| corner as i64), count, index)),
    }
}
