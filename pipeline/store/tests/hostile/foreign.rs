//! Points tables as other programs write them: every codec and encoding, nested columns,
//! dictionaries.

use crate::made;
use arrow::array::{ArrayRef, AsArray, DictionaryArray, RecordBatch, StringArray, StructArray};
use arrow::array::{BooleanArray, Int32Array, ListArray};
use arrow::datatypes::{DataType, Field, Float32Type, Int32Type};
use arrow::ipc::CompressionType;
use arrow::ipc::writer::{FileWriter, IpcWriteOptions};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, Encoding};
use parquet::file::properties::{WriterProperties, WriterVersion};
use std::sync::Arc;

const ROWS: usize = 30;

/// Name and bytes of each table.
pub fn tables() -> Vec<(String, Vec<u8>)> {
    let batch = batch();
    let codecs = [
        (
            "plain",
            Compression::UNCOMPRESSED,
            WriterVersion::PARQUET_1_0,
        ),
        ("snappy", Compression::SNAPPY, WriterVersion::PARQUET_2_0),
        (
            "gzip",
            Compression::GZIP(Default::default()),
            WriterVersion::PARQUET_1_0,
        ),
        ("lz4", Compression::LZ4_RAW, WriterVersion::PARQUET_2_0),
        (
            "zstd",
            Compression::ZSTD(Default::default()),
            WriterVersion::PARQUET_1_0,
        ),
    ];
    let parquet = codecs
        .map(|(name, codec, version)| (format!("{name}.parquet"), parquet(&batch, codec, version)));
    let codecs = [
        ("plain", None),
        ("lz4", Some(CompressionType::LZ4_FRAME)),
        ("zstd", Some(CompressionType::ZSTD)),
    ];
    let arrow = codecs.map(|(name, codec)| (format!("{name}.arrow"), arrow(&batch, codec)));
    parquet.into_iter().chain(arrow).collect()
}

fn batch() -> RecordBatch {
    let samples = made::samples(1, 0, ROWS as u64).to_batch().unwrap();
    let mut columns: Vec<(String, ArrayRef)> = Vec::new();
    let fields = samples.schema();
    for (field, array) in fields
        .fields()
        .iter()
        .zip(samples.columns())
        .skip(2)
        .take(12)
    {
        columns.push((field.name().clone(), array.clone()));
    }
    let text = |r: usize| format!("wall of the room, number {}", r % 4);
    let texts = StringArray::from((0..ROWS).map(text).collect::<Vec<_>>());
    let sparse: StringArray = (0..ROWS).map(|r| (r % 3 == 0).then(|| text(r))).collect();
    let keys: Int32Array = (0..ROWS).map(|r| Some(r as i32 % 4)).collect();
    let coded = DictionaryArray::<Int32Type>::new(keys, Arc::new(texts.slice(0, 4)));
    let lists = (0..ROWS).map(|r| (r % 5 != 0).then(|| vec![Some(r as i32); r % 4]));
    let lists = ListArray::from_iter_primitive::<Int32Type, _, _>(lists);
    let px = samples.column(2).as_primitive::<Float32Type>().clone();
    let structs = StructArray::from(vec![(
        Arc::new(Field::new("x", DataType::Float32, false)),
        Arc::new(px) as ArrayRef,
    )]);
    let flags = BooleanArray::from((0..ROWS).map(|r| r % 2 == 0).collect::<Vec<_>>());
    columns.push(("material".into(), Arc::new(texts.clone())));
    columns.push(("delta".into(), Arc::new(texts)));
    columns.push(("sparse".into(), Arc::new(sparse)));
    columns.push(("coded".into(), Arc::new(coded)));
    columns.push(("list".into(), Arc::new(lists)));
    columns.push(("struct".into(), Arc::new(structs)));
    columns.push(("flag".into(), Arc::new(flags)));
    RecordBatch::try_from_iter(columns).unwrap()
}

/// A table whose text `delta` shares beginnings with the text before.
pub fn delta_byte_array() -> Vec<u8> {
    let properties = WriterProperties::builder()
        .set_column_dictionary_enabled("delta".into(), false)
        .set_column_encoding("delta".into(), Encoding::DELTA_BYTE_ARRAY);
    write(&batch(), properties.build())
}

fn parquet(batch: &RecordBatch, codec: Compression, version: WriterVersion) -> Vec<u8> {
    let properties = WriterProperties::builder()
        .set_compression(codec)
        .set_writer_version(version)
        .set_column_dictionary_enabled("delta".into(), false)
        .set_column_encoding("delta".into(), Encoding::DELTA_LENGTH_BYTE_ARRAY)
        .set_data_page_row_count_limit(16)
        .set_write_batch_size(8)
        .build();
    write(batch, properties)
}

fn write(batch: &RecordBatch, properties: WriterProperties) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties)).unwrap();
    writer.write(batch).unwrap();
    writer.close().unwrap();
    bytes
}

fn arrow(batch: &RecordBatch, codec: Option<CompressionType>) -> Vec<u8> {
    let options = IpcWriteOptions::default()
        .try_with_compression(codec)
        .unwrap();
    let schema = batch.schema();
    let mut writer = FileWriter::try_new_with_options(Vec::new(), &schema, options).unwrap();
    writer.write(batch).unwrap();
    writer.into_inner().unwrap()
}
