//! What one column of a table can hold.

use arrow::array::{Array, ArrayRef, AsArray, BooleanArray, ListBuilder, PrimitiveArray};
use arrow::array::{PrimitiveBuilder, StringArray, StringBuilder};
use arrow::datatypes::{DataType, Field};
use arrow::datatypes::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, UInt32Type, UInt64Type,
};
use std::sync::Arc;

/// A value of one column.
pub trait Value: Clone {
    /// A column of values, null where `None`.
    fn array<'a>(values: impl Iterator<Item = Option<&'a Self>>) -> ArrayRef
    where
        Self: 'a;

    /// A column's values; none where it is of another type.
    fn values(array: &dyn Array) -> Option<Vec<Option<Self>>>;
}

/// Numbers, and lists of them.
macro_rules! numbers {
    ($($number:ty: $arrow:ty,)*) => {$(
        impl Value for $number {
            fn array<'a>(values: impl Iterator<Item = Option<&'a Self>>) -> ArrayRef {
                Arc::new(values.map(Option::<&$number>::copied).collect::<PrimitiveArray<$arrow>>())
            }

            fn values(array: &dyn Array) -> Option<Vec<Option<Self>>> {
                Some(array.as_primitive_opt::<$arrow>()?.iter().collect())
            }
        }

        impl Value for Vec<$number> {
            fn array<'a>(values: impl Iterator<Item = Option<&'a Self>>) -> ArrayRef {
                let items = PrimitiveBuilder::<$arrow>::new();
                let mut lists = ListBuilder::new(items).with_field(item::<$arrow>());
                for value in values {
                    lists.values().append_slice(value.map_or(&[], Vec::as_slice));
                    lists.append(value.is_some());
                }
                Arc::new(lists.finish())
            }

            fn values(array: &dyn Array) -> Option<Vec<Option<Self>>> {
                lists(array, |items| {
                    let items = items.as_primitive_opt::<$arrow>()?;
                    (items.null_count() == 0).then(|| items.values().to_vec())
                })
            }
        }
    )*};
}

numbers! {
    i8: Int8Type,
    i16: Int16Type,
    i32: Int32Type,
    u32: UInt32Type,
    u64: UInt64Type,
    f32: Float32Type,
    f64: Float64Type,
}

impl Value for bool {
    fn array<'a>(values: impl Iterator<Item = Option<&'a Self>>) -> ArrayRef {
        Arc::new(values.map(|value| value.copied()).collect::<BooleanArray>())
    }

    fn values(array: &dyn Array) -> Option<Vec<Option<Self>>> {
        Some(array.as_boolean_opt()?.iter().collect())
    }
}

impl Value for String {
    fn array<'a>(values: impl Iterator<Item = Option<&'a Self>>) -> ArrayRef {
        Arc::new(values.collect::<StringArray>())
    }

    fn values(array: &dyn Array) -> Option<Vec<Option<Self>>> {
        let texts = array.as_string_opt::<i32>()?.iter();
        Some(texts.map(|text| text.map(str::to_string)).collect())
    }
}

impl Value for Vec<String> {
    fn array<'a>(values: impl Iterator<Item = Option<&'a Self>>) -> ArrayRef {
        let field = Field::new(Field::LIST_FIELD_DEFAULT_NAME, DataType::Utf8, false);
        let mut lists = ListBuilder::new(StringBuilder::new()).with_field(field);
        for value in values {
            for text in value.into_iter().flatten() {
                lists.values().append_value(text);
            }
            lists.append(value.is_some());
        }
        Arc::new(lists.finish())
    }

    fn values(array: &dyn Array) -> Option<Vec<Option<Self>>> {
        lists(array, |items| {
            let texts = items.as_string_opt::<i32>()?.iter();
            texts.map(|text| text.map(str::to_string)).collect()
        })
    }
}

fn item<T: arrow::array::ArrowPrimitiveType>() -> Field {
    Field::new(Field::LIST_FIELD_DEFAULT_NAME, T::DATA_TYPE, false)
}

/// The lists of a column, each by its items; none where the column or any of its items is of
/// another type, or an item is null.
fn lists<T>(array: &dyn Array, of: impl Fn(&dyn Array) -> Option<T>) -> Option<Vec<Option<T>>> {
    let lists = array.as_list_opt::<i32>()?;
    let each = |list: Option<ArrayRef>| match list {
        Some(items) => of(items.as_ref()).map(Some),
        None => Some(None),
    };
    lists.iter().map(each).collect()
}
