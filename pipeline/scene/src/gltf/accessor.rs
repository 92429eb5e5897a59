//! Accessors: typed, strided, perhaps sparse views of the buffers.
//!
//! A [`Column`] is made only after every byte that it can touch has been found inside its
//! buffer, and reads elements one by one: nothing is allocated by what a file declares.

use super::document::{Document, place};
use crate::SceneError;
use ::gltf::json::accessor::{Accessor, ComponentType, Type, sparse::Sparse};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, buffer::View};

/// A checked accessor of `count` elements.
pub(super) struct Column<'a> {
    count: usize,
    elements: Elements<'a>,
    normalized: bool,
    /// Element ids, strictly increasing, and their values in place of the stored ones.
    replaced: Option<(Vec<u32>, Elements<'a>)>,
}

/// Equal elements at equal distances. Without a buffer view `bytes` is empty: all zero.
#[derive(Clone, Copy)]
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: ComponentType,
    width: usize,
}

impl<'a> Elements<'a> {
    /// Element `i`'s bytes.
    fn get(&self, i: usize) -> Option<&'a [u8]> {
        let size = self.component.size() * self.width;
        let start = i.checked_mul(self.stride)?;
        self.bytes.get(start..start.checked_add(size)?)
    }
}

impl<'a> Column<'a> {
    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Element `i` as an index; `None` beyond the end.
    pub(super) fn index(&self, i: usize) -> Option<u32> {
        let (elements, element) = self.stored(i)?;
        Some(match (elements.component, element) {
            (ComponentType::U8, &[a]) => u32::from(a),
            (ComponentType::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
            (ComponentType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
            _ => 0, // no buffer view
        })
    }

    /// Element `i` as numbers (normalised integers as glTF 2.0, section 3.11, has them);
    /// `None` beyond the end.
    pub(super) fn numbers<const N: usize>(&self, i: usize) -> Option<[f32; N]> {
        let (elements, element) = self.stored(i)?;
        let mut numbers = [0.0; N];
        let components = element.chunks_exact(elements.component.size());
        for (number, bytes) in numbers.iter_mut().zip(components) {
            *number = self.number(elements.component, bytes);
        }
        Some(numbers)
    }

    fn stored(&self, i: usize) -> Option<(&Elements<'a>, &'a [u8])> {
        if i >= self.count {
            return None;
        }
        if let Some((ids, values)) = &self.replaced
            && let Ok(k) = ids.binary_search(&u32::try_from(i).ok()?)
        {
            return Some((values, values.get(k)?));
        }
        if self.elements.bytes.is_empty() {
            return Some((&self.elements, &[]));
        }
        Some((&self.elements, self.elements.get(i)?))
    }

    fn number(&self, component: ComponentType, bytes: &[u8]) -> f32 {
        let (value, most) = match (component, bytes) {
            (ComponentType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
            (ComponentType::U8, &[a]) => (f32::from(a), 255.0),
            (ComponentType::I8, &[a]) => (f32::from(a as i8), 127.0),
            (ComponentType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65_535.0),
            (ComponentType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32_767.0),
            _ => (0.0, 1.0),
        };
        if self.normalized {
            (value / most).max(-1.0)
        } else {
            value
        }
    }
}

impl<'a> Document<'a> {
    /// Accessor `index` as triangle corners: scalar unsigned integers.
    pub(super) fn index_column(
        &self,
        index: Index<Accessor>,
        place: &str,
    ) -> Result<Column<'_>, SceneError> {
        use ComponentType::{U8, U16, U32};
        self.column(index, "indices", Type::Scalar, &[U8, U16, U32], place)
    }

    /// Accessor `index` as numbers: f32, or the integers of KHR_mesh_quantization.
    pub(super) fn number_column(
        &self,
        index: Index<Accessor>,
        what: &str,
        shape: Type,
        place: &str,
    ) -> Result<Column<'_>, SceneError> {
        use ComponentType::{F32, I8, I16, U8, U16};
        self.column(index, what, shape, &[F32, I8, I16, U8, U16], place)
    }

    fn column(
        &self,
        index: Index<Accessor>,
        what: &str,
        shape: Type,
        components: &[ComponentType],
        place: &str,
    ) -> Result<Column<'_>, SceneError> {
        let wrong = |message: String| {
            let accessor = index.value();
            self.error(place, format!("{what} (accessor {accessor}): {message}"))
        };
        let accessor = self
            .root
            .get(index)
            .ok_or_else(|| wrong("no such accessor".into()))?;
        let (Checked::Valid(component), Checked::Valid(stored)) =
            (&accessor.component_type, &accessor.type_)
        else {
            return Err(wrong("unknown component or element type".into()));
        };
        let component = component.0;
        if *stored != shape || !components.contains(&component) {
            return Err(wrong(format!(
                "has {} of {}, must be {} of {}",
                shape_name(*stored),
                number_name(component),
                shape_name(shape),
                components
                    .iter()
                    .map(|&c| number_name(c))
                    .collect::<Vec<_>>()
                    .join(" or ")
            )));
        }
        let count = usize::try_from(accessor.count.0).map_err(|e| wrong(e.to_string()))?;
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let elements = self
            .elements(accessor.buffer_view, offset, count, component, shape)
            .map_err(&wrong)?;
        let replaced = accessor
            .sparse
            .as_ref()
            .map(|sparse| self.replaced(sparse, count, component, shape))
            .transpose()
            .map_err(&wrong)?;
        Ok(Column {
            count,
            elements,
            normalized: accessor.normalized,
            replaced,
        })
    }

    /// `count` elements from byte `offset` of a view, all of them inside the view and its
    /// buffer; else a message.
    fn elements(
        &self,
        view: Option<Index<View>>,
        offset: u64,
        count: usize,
        component: ComponentType,
        shape: Type,
    ) -> Result<Elements<'_>, String> {
        let width = shape.multiplicity();
        let size = component.size() * width;
        let Some(view) = view else {
            let bytes: &[u8] = &[];
            return Ok(Elements {
                bytes,
                stride: size,
                component,
                width,
            });
        };
        let bytes = self.view_bytes(view)?;
        let stride = self.root.get(view).and_then(|view| view.byte_stride);
        let stride = stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(format!(
                "byteStride {stride} is less than an element's {size} bytes"
            ));
        }
        let end = (count as u64)
            .saturating_sub(1)
            .checked_mul(stride as u64)
            .and_then(|last| last.checked_add(offset)?.checked_add(size as u64))
            .filter(|&end| end <= bytes.len() as u64)
            .ok_or_else(|| {
                let has = bytes.len();
                format!("{count} elements of {size} bytes, {stride} apart from byte {offset}, do not fit into the view's {has} bytes")
            })?;
        let bytes = bytes.get(offset as usize..end as usize).unwrap_or(&[]);
        Ok(Elements {
            bytes,
            stride,
            component,
            width,
        })
    }

    /// The bytes of a buffer view, or a message.
    pub(super) fn view_bytes(&self, index: Index<View>) -> Result<&[u8], String> {
        let view = self.root.get(index).ok_or("no such buffer view")?;
        let buffer = self
            .buffers
            .get(view.buffer.value())
            .ok_or("no such buffer")?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0);
        let range = |start: u64, end: u64| {
            buffer.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
        };
        end.and_then(|end| range(start, end)).ok_or_else(|| {
            format!(
                "{} of {} bytes from byte {start} does not fit into buffer {}'s {} bytes",
                place("view", index.value(), view.name.as_deref()),
                view.byte_length.0,
                view.buffer.value(),
                buffer.len()
            )
        })
    }

    fn replaced(
        &self,
        sparse: &Sparse,
        count: usize,
        component: ComponentType,
        shape: Type,
    ) -> Result<(Vec<u32>, Elements<'_>), String> {
        let Checked::Valid(id_type) = &sparse.indices.component_type else {
            return Err("unknown type of sparse indices".into());
        };
        let many = usize::try_from(sparse.count.0).map_err(|error| error.to_string())?;
        let view = Some(sparse.indices.buffer_view);
        let offset = sparse.indices.byte_offset.0;
        let ids = self.elements(view, offset, many, id_type.0, Type::Scalar)?;
        let ids = Column {
            count: many,
            elements: ids,
            normalized: false,
            replaced: None,
        };
        let ids: Vec<u32> = (0..many).map_while(|i| ids.index(i)).collect();
        let in_range = ids.last().is_none_or(|&last| (last as usize) < count);
        if !in_range || !ids.is_sorted_by(|a, b| a < b) {
            return Err(format!(
                "sparse indices must increase and stay below {count}"
            ));
        }
        let view = Some(sparse.values.buffer_view);
        let values = self.elements(view, sparse.values.byte_offset.0, many, component, shape)?;
        Ok((ids, values))
    }
}

/// An element's type, as the format's specification writes it.
fn shape_name(shape: Type) -> &'static str {
    match shape {
        Type::Scalar => "SCALAR",
        Type::Vec2 => "VEC2",
        Type::Vec3 => "VEC3",
        Type::Vec4 => "VEC4",
        Type::Mat2 => "MAT2",
        Type::Mat3 => "MAT3",
        Type::Mat4 => "MAT4",
    }
}

/// A number's type in words.
fn number_name(component: ComponentType) -> &'static str {
    match component {
        ComponentType::I8 => "signed bytes",
        ComponentType::U8 => "unsigned bytes",
        ComponentType::I16 => "signed shorts",
        ComponentType::U16 => "unsigned shorts",
        ComponentType::U32 => "unsigned integers",
        ComponentType::F32 => "floats",
    }
}
