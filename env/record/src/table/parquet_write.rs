//! Writing tables as Parquet: one row group of doubles, strings and booleans; empty cells are null.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use crate::episode::Episode;

/// One column of a table.
#[derive(Clone, Copy, Debug)]
pub enum Column<'a> {
    /// Doubles; NaN is written as null.
    Numbers(&'a [f64]),
    /// Strings.
    Texts(&'a [String]),
    /// Booleans.
    Flags(&'a [bool]),
}

/// Writes `episode` with its columns in the order of the format.
pub(super) fn write(episode: &Episode, sink: impl Write + Send) -> Result<(), ParquetError> {
    let mut columns = vec![("t", Column::Numbers(&episode.t))];
    for name in episode.header() {
        if let Some(values) = episode.columns.get(name) {
            columns.push((name, Column::Numbers(values)));
        } else if let Some(texts) = episode.notes.get(name) {
            columns.push((name, Column::Texts(texts)));
        }
    }
    write_columns(&columns, sink)
}

/// Writes named columns of equal length as one row group.
pub(super) fn write_columns(
    columns: &[(&str, Column<'_>)],
    sink: impl Write + Send,
) -> Result<(), ParquetError> {
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut file = SerializedFileWriter::new(sink, schema(columns)?, Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for (_, column) in columns {
        match column {
            Column::Numbers(cells) => write_numbers(&mut group, cells)?,
            Column::Texts(cells) => write_texts(&mut group, cells)?,
            Column::Flags(cells) => write_flags(&mut group, cells)?,
        }
    }
    group.close()?;
    file.close()?;
    Ok(())
}

fn schema(columns: &[(&str, Column<'_>)]) -> Result<TypePtr, ParquetError> {
    let fields = columns.iter().map(|(name, column)| field(name, column).map(Arc::new));
    let fields = fields.collect::<Result<_, _>>()?;
    Ok(Arc::new(Type::group_type_builder("schema").with_fields(fields).build()?))
}

fn field(name: &str, column: &Column<'_>) -> Result<Type, ParquetError> {
    let (physical, logical) = match column {
        Column::Texts(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Column::Numbers(_) => (Physical::DOUBLE, None),
        Column::Flags(_) => (Physical::BOOLEAN, None),
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

fn write_flags<W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: &[bool],
) -> Result<(), ParquetError> {
    if let Some(mut column) = group.next_column()? {
        column.typed::<BoolType>().write_batch(cells, Some(&vec![1; cells.len()]), None)?;
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
