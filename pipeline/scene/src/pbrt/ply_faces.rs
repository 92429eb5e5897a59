//! The faces of a PLY mesh.

use super::ply_body::{Body, broken};
use super::ply_header::{Element, Wrong, wrong};
use crate::polygon::triangulate;
use glam::DVec3;

/// Most corners of a face: ear clipping may take the square of their number.
const MAX_CORNERS: usize = 1 << 14;

/// Faces of three corners and more, their corners one after another.
#[derive(Default)]
pub(super) struct Faces {
    corners: Vec<i64>,
    /// Where each face ends.
    ends: Vec<usize>,
}

impl Faces {
    /// Reads the corners of an element's faces.
    pub(super) fn read(&mut self, element: &Element, body: &mut Body<'_>) -> Result<(), Wrong> {
        let wanted = element.properties.iter().position(|property| {
            let name = property.name.as_str();
            property.length.is_some() && matches!(name, "vertex_indices" | "vertex_index")
        });
        let Some(wanted) = wanted else {
            return wrong("header", "the face element has no list vertex_indices");
        };
        for index in 0..element.count {
            for (p, property) in element.properties.iter().enumerate() {
                let start = self.corners.len();
                let mut fraction = None;
                let mut keep = |value: f64| {
                    if p != wanted {
                        return;
                    }
                    if value != value.trunc() {
                        fraction.get_or_insert(value);
                    }
                    if self.corners.len() - start <= MAX_CORNERS {
                        self.corners.push(value as i64);
                    }
                };
                let whole = match property.length {
                    Some(length) => body.list(length, property.scalar, keep),
                    None => body.number(property.scalar).map(&mut keep).is_some(),
                };
                if !whole {
                    return broken(element, index);
                }
                if p == wanted {
                    self.end(index, self.corners.len() - start, fraction)?;
                }
            }
        }
        Ok(())
    }

    fn end(&mut self, index: u64, count: usize, fraction: Option<f64>) -> Result<(), Wrong> {
        let place = format!("face {index}");
        if let Some(corner) = fraction {
            return wrong(place, format!("vertex index {corner} is no whole number"));
        }
        if !(3..=MAX_CORNERS).contains(&count) {
            let message = format!("{count} corners; 3 to {MAX_CORNERS} are read");
            return wrong(place, message);
        }
        self.ends.push(self.corners.len());
        Ok(())
    }

    /// The triangles, once the positions are known; ids are checked.
    pub(super) fn triangles(&self, positions: &[DVec3]) -> Result<Vec<[u32; 3]>, Wrong> {
        let mut triangles = Vec::with_capacity(self.ends.len());
        let (mut start, mut places) = (0, Vec::new());
        for (face, &end) in self.ends.iter().enumerate() {
            let corners = self.corners.get(start..end).unwrap_or_default();
            start = end;
            places.clear();
            for &corner in corners {
                let position = usize::try_from(corner).ok().and_then(|i| positions.get(i));
                let Some(position) = position else {
                    return wrong(
                        format!("face {face}"),
                        format!(
                            "vertex index {corner}, but there are {} vertices (0 to {})",
                            positions.len(),
                            positions.len() - 1
                        ),
                    );
                };
                places.push(*position);
            }
            let id = |i: u32| corners.get(i as usize).copied().unwrap_or_default() as u32;
            triangles.extend(triangulate(&places).into_iter().map(|ids| ids.map(id)));
        }
        Ok(triangles)
    }
}
