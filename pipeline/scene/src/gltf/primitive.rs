//! A primitive's accessors and its triangles' corners.

use super::accessor::Column;
use super::document::Document;
use super::nodes::Placed;
use crate::SceneError;
use crate::warn::Warnings;
use ::gltf::json::Index;
use ::gltf::json::accessor::{Accessor, Type};
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;

/// Most triangles of a scene. Instances multiply what a small file holds, so the sum is
/// checked before memory is asked for.
const MAX_TRIANGLES: usize = 1 << 27;

/// A primitive of triangles at a node, with its checked accessors.
pub(super) struct Source<'a> {
    pub(super) document: &'a Document<'a>,
    pub(super) placed: &'a Placed<'a>,
    primitive: &'a Primitive,
    pub(super) place: String,
    mode: Mode,
    indices: Option<Column<'a>>,
    pub(super) positions: Column<'a>,
}

impl<'a> Source<'a> {
    /// `None`, and a warning, for points and lines.
    pub(super) fn new(
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
            let what = match mode {
                Mode::Points => "points",
                _ => "lines",
            };
            warnings.add(place, format!("{what} left out: they have no surface"));
            return Ok(None);
        }
        let position = attribute(primitive, Semantic::Positions)
            .ok_or_else(|| document.error(&place, "no POSITION"))?;
        let positions = document.number_column(position, "POSITION", Type::Vec3, &place)?;
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
        }))
    }

    /// An error at this primitive.
    pub(super) fn error(&self, message: impl Into<String>) -> SceneError {
        self.document.error(&self.place, message)
    }

    /// Whether the primitive has an attribute.
    pub(super) fn has(&self, semantic: Semantic) -> bool {
        attribute(self.primitive, semantic).is_some()
    }

    /// An attribute, `shape` an element, with an element for every position.
    pub(super) fn attribute(
        &self,
        semantic: Semantic,
        shape: Type,
    ) -> Result<Option<Column<'a>>, SceneError> {
        let name = semantic.to_string();
        let Some(index) = attribute(self.primitive, semantic) else {
            return Ok(None);
        };
        let column = self
            .document
            .number_column(index, &name, shape, &self.place)?;
        let (has, needed) = (column.count(), self.positions.count());
        if has < needed {
            let message = format!("{name} has {has} elements for {needed} positions");
            return Err(self.error(message));
        }
        Ok(Some(column))
    }

    /// Vertex ids of the triangles, each below the number of positions; the scene has
    /// `before` triangles already.
    pub(super) fn corners(&self, before: usize) -> Result<Vec<[u32; 3]>, SceneError> {
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
