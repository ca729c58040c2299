//! Episode tables to Parquet: one row group, doubles and strings, null where a cell is empty.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use crate::episode::Episode;

/// Writes `episode`, column after column in the format's order.
pub(super) fn write(episode: &Episode, sink: impl Write + Send) -> Result<(), ParquetError> {
    let header = episode.header();
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut file = SerializedFileWriter::new(sink, schema(episode, &header)?, Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    write_numbers(&mut group, &episode.t)?;
    for &name in &header {
        if let Some(values) = episode.columns.get(name) {
            write_numbers(&mut group, values)?;
        } else if let Some(texts) = episode.notes.get(name) {
            write_texts(&mut group, texts)?;
        }
    }
    group.close()?;
    file.close()?;
    Ok(())
}

fn schema(episode: &Episode, header: &[&str]) -> Result<TypePtr, ParquetError> {
    let names = std::iter::once("t").chain(header.iter().copied());
    let fields = names.map(|name| field(name, episode.notes.contains_key(name)).map(Arc::new));
    let fields = fields.collect::<Result<_, _>>()?;
    Ok(Arc::new(Type::group_type_builder("schema").with_fields(fields).build()?))
}

fn field(name: &str, note: bool) -> Result<Type, ParquetError> {
    let (physical, logical) = match note {
        true => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        false => (Physical::DOUBLE, None),
    };
    let builder = Type::primitive_type_builder(name, physical).with_logical_type(logical);
    builder.with_repetition(Repetition::OPTIONAL).build()
}

fn write_numbers<W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: &[f64],
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(!cell.is_nan())).collect();
    let values: Vec<f64> = cells.iter().copied().filter(|cell| !cell.is_nan()).collect();
    if let Some(mut column) = group.next_column()? {
        column.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
        column.close()?;
    }
    Ok(())
}

fn write_texts<W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: &[String],
) -> Result<(), ParquetError> {
    let values: Vec<ByteArray> = cells.iter().map(|cell| ByteArray::from(cell.as_str())).collect();
    if let Some(mut column) = group.next_column()? {
        column.typed::<ByteArrayType>().write_batch(&values, Some(&vec![1; cells.len()]), None)?;
        column.close()?;
    }
    Ok(())
}
