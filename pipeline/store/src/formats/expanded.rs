//! How large columns are when every value is written out. Dictionaries, runs, views and lists
//! of nothing let a few bytes stand for any number of values; writing them spells these out.

use arrow::array::{Array, ArrayRef, AsArray, RecordBatch, make_array};
use arrow::datatypes::DataType;

/// Bytes of all values of a batch written out, and at least a byte a value; saturating.
pub(crate) fn expanded_bytes(batch: &RecordBatch) -> u64 {
    sum(batch.columns().iter().map(expanded))
}

fn expanded(array: &ArrayRef) -> u64 {
    let rows = array.len() as u64;
    match array.data_type() {
        DataType::Dictionary(_, _) => {
            let values = array.as_any_dictionary_opt().map(|d| d.values().clone());
            rows.saturating_mul(values.map_or(u64::MAX, |values| longest(&values)))
        }
        DataType::RunEndEncoded(_, _) => {
            let values = array.to_data().child_data().get(1).cloned();
            rows.saturating_mul(values.map_or(u64::MAX, |values| longest(&make_array(values))))
        }
        DataType::Utf8View | DataType::BinaryView => sum(lengths(array)),
        _ => {
            let data = array.to_data();
            let own = data
                .get_slice_memory_size()
                .map_or(u64::MAX, |size| size as u64);
            let children = data.child_data().iter();
            let children = sum(children.map(|child| expanded(&make_array(child.clone()))));
            own.max(rows).saturating_add(children)
        }
    }
}

/// An upper bound of one value's size.
fn longest(values: &ArrayRef) -> u64 {
    match values.data_type() {
        data_type if data_type.is_primitive() => 32,
        DataType::Boolean | DataType::Null => 1,
        DataType::FixedSizeBinary(width) => u64::try_from(*width).unwrap_or(u64::MAX),
        DataType::Utf8
        | DataType::LargeUtf8
        | DataType::Binary
        | DataType::LargeBinary
        | DataType::Utf8View
        | DataType::BinaryView => lengths(values).max().unwrap_or(0).max(1),
        // Nested values of a dictionary: all of them, which is more than one.
        _ => expanded(values),
    }
}

/// Sizes of texts or binaries, 0 for others.
fn lengths(array: &ArrayRef) -> Box<dyn Iterator<Item = u64> + '_> {
    fn sizes<'a, T: AsRef<[u8]> + ?Sized + 'a>(
        values: impl Iterator<Item = Option<&'a T>> + 'a,
    ) -> Box<dyn Iterator<Item = u64> + 'a> {
        Box::new(values.map(|value| value.map_or(0, |value| value.as_ref().len() as u64)))
    }
    match array.data_type() {
        DataType::Utf8 => sizes(array.as_string::<i32>().iter()),
        DataType::LargeUtf8 => sizes(array.as_string::<i64>().iter()),
        DataType::Binary => sizes(array.as_binary::<i32>().iter()),
        DataType::LargeBinary => sizes(array.as_binary::<i64>().iter()),
        DataType::Utf8View => sizes(array.as_string_view().iter()),
        DataType::BinaryView => sizes(array.as_binary_view().iter()),
        _ => Box::new(std::iter::empty()),
    }
}

fn sum(sizes: impl Iterator<Item = u64>) -> u64 {
    sizes.fold(0, u64::saturating_add)
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow::array::{DictionaryArray, FixedSizeListArray, Float32Array, Int32Array};
    use arrow::array::{NullArray, StringArray, StringViewArray};
    use arrow::datatypes::{Field, Int32Type};
    use std::sync::Arc;

    #[test]
    fn repeated_values_count_each_time() {
        let text = StringArray::from(vec!["a".repeat(1000)]);
        let keys = Int32Array::from(vec![0; 500]);
        let coded = DictionaryArray::<Int32Type>::new(keys, Arc::new(text.clone()));
        assert_eq!(expanded(&(Arc::new(coded) as ArrayRef)), 500_000);
        let view = StringViewArray::from_iter_values([text.value(0)]);
        let rows = Int32Array::from(vec![0; 300]);
        let views = arrow::compute::take(&view, &rows, None).unwrap();
        assert_eq!(expanded(&views), 300_000);
    }

    #[test]
    fn lists_of_nothing_count_their_items() {
        let item = Arc::new(Field::new("item", DataType::Null, true));
        let items = Arc::new(NullArray::new(30 * 1_000_000));
        let lists = FixedSizeListArray::new(item, 1_000_000, items, None);
        assert!(expanded(&(Arc::new(lists) as ArrayRef)) >= 30_000_000);
    }

    #[test]
    fn plain_numbers_are_as_large_as_they_are() {
        let numbers = Float32Array::from(vec![1.0; 100]);
        assert_eq!(expanded(&(Arc::new(numbers) as ArrayRef)), 400);
    }
}
