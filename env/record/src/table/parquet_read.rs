//! Reading episode tables from Parquet files, as written by pandas, pyarrow, polars and others.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::budget::Budget;
use super::columns::{CheckTitle, ColumnKind, column_kinds};
use super::parquet_pages;
use super::parquet_types::{Content, content};
use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;

/// Values per decoded batch.
const BATCH_SIZE: usize = 8192;

/// A fault, and its column if known.
type Located = (Option<String>, Fault);

/// Reads the table at `path` as the episode `name`; nulls become empty cells.
pub(super) fn read(
    path: &Path,
    name: &str,
    budget: &mut Budget,
    check: CheckTitle<'_>,
) -> Result<Episode, Error> {
    let file =
        File::open(path).map_err(|source| Fault::Io { action: "read", source }.at(Place::path(path)))?;
    // The decoder panics on some damaged files, and no panic may leave this crate.
    catch_unwind(AssertUnwindSafe(|| decode(file, name, budget, check)))
        .unwrap_or_else(|_| Err((None, damaged("inconsistent file structure"))))
        .map_err(|(column, fault)| {
            let place = Place::path(path);
            fault.at(match column {
                Some(column) => place.column(&column),
                None => place,
            })
        })
}

fn damaged(reason: impl ToString) -> Fault {
    Fault::Parquet { message: reason.to_string() }
}

fn decode(file: File, name: &str, budget: &mut Budget, check: CheckTitle<'_>) -> Result<Episode, Located> {
    let again = file.try_clone().map_err(|error| (None, damaged(error)))?;
    let reader = SerializedFileReader::new(file).map_err(|error| (None, damaged(error)))?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let mut episode = Episode { name: name.to_owned(), ..Episode::default() };
    // The title of a column in a list or structure has several parts, and is therefore unknown.
    let titles: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
    let kinds = column_kinds(&titles, check).map_err(|(title, fault)| (Some(title), fault))?;
    for (index, (title, kind)) in titles.into_iter().zip(kinds).enumerate() {
        let column = Column { reader: &reader, file: &again, index };
        insert(&mut episode, &title, kind, &column, budget).map_err(|fault| (Some(title), fault))?;
    }
    Ok(episode)
}

/// One column of an open file.
struct Column<'a> {
    reader: &'a SerializedFileReader<File>,
    /// A second handle of the file, for validation before decoding.
    file: &'a File,
    index: usize,
}

fn insert(
    episode: &mut Episode,
    title: &str,
    kind: ColumnKind,
    column: &Column<'_>,
    budget: &mut Budget,
) -> Result<(), Fault> {
    let schema = column.reader.metadata().file_metadata().schema_descr();
    let content = content(&schema.column(column.index), kind == ColumnKind::Note)?;
    match kind {
        ColumnKind::Note => {
            let texts =
                column_of(column, budget, String::new(), |chunk, budget| text(chunk, content, budget))?;
            episode.notes.insert(title.to_owned(), texts);
        }
        ColumnKind::Number => {
            let numbers = column_of(column, budget, f64::NAN, |chunk, _| number(chunk, content))?;
            episode.insert(title.to_owned(), numbers);
        }
    }
    Ok(())
}

/// All cells of one column over all row groups. Nulls become `empty`.
fn column_of<C: Clone>(
    column: &Column<'_>,
    budget: &mut Budget,
    empty: C,
    decode: impl Fn(Rows, &mut Budget) -> Result<Chunk<C>, Fault>,
) -> Result<Vec<C>, Fault> {
    let mut cells = Vec::new();
    for group in 0..column.reader.num_row_groups() {
        let group = column.reader.get_row_group(group).map_err(damaged)?;
        let rows = group.metadata().num_rows();
        let rows = usize::try_from(rows).map_err(|_| damaged(format!("a row group states {rows} rows")))?;
        budget.reserve(rows as u64, size_of::<C>())?;
        parquet_pages::check(column.file, group.metadata().column(column.index), budget)?;
        let reader = group.get_column_reader(column.index).map_err(damaged)?;
        let Chunk { filled, values } = decode(Rows { reader, rows }, budget)?;
        if rows != filled.len() {
            return Err(damaged(format!(
                "a column has {} cells in a row group of {rows} rows",
                filled.len()
            )));
        }
        let mut values = values.into_iter();
        cells.extend(
            filled.into_iter().map(|full| {
                if full { values.next().unwrap_or_else(|| empty.clone()) } else { empty.clone() }
            }),
        );
    }
    Ok(cells)
}

/// A column chunk to decode, and the number of rows in its group.
struct Rows {
    reader: ColumnReader,
    rows: usize,
}

/// A decoded column chunk: which cells are filled, and the values of these.
struct Chunk<C> {
    filled: Vec<bool>,
    values: Vec<C>,
}

fn number(Rows { reader, rows }: Rows, content: Content) -> Result<Chunk<f64>, Fault> {
    match reader {
        ColumnReader::DoubleColumnReader(reader) => chunk(reader, rows, |&value| Ok(value)),
        ColumnReader::FloatColumnReader(reader) => chunk(reader, rows, |&value| Ok(f64::from(value))),
        ColumnReader::Int32ColumnReader(reader) => chunk(reader, rows, |&value| Ok(content.int32(value))),
        ColumnReader::Int64ColumnReader(reader) => chunk(reader, rows, |&value| Ok(content.int64(value))),
        _ => Err(Fault::ColumnType { found: "values that are not numbers".to_owned() }),
    }
}

fn text(Rows { reader, rows }: Rows, content: Content, budget: &mut Budget) -> Result<Chunk<String>, Fault> {
    match reader {
        ColumnReader::BoolColumnReader(reader) => chunk(reader, rows, |value| Ok(value.to_string())),
        ColumnReader::ByteArrayColumnReader(reader) => chunk(reader, rows, |value| {
            budget.reserve(value.len() as u64, 1)?;
            utf8(value)
        }),
        ColumnReader::DoubleColumnReader(reader) => chunk(reader, rows, |value| Ok(value.to_string())),
        ColumnReader::FloatColumnReader(reader) => chunk(reader, rows, |value| Ok(value.to_string())),
        ColumnReader::Int32ColumnReader(reader) => {
            chunk(reader, rows, |&value| Ok(content.int32(value).to_string()))
        }
        ColumnReader::Int64ColumnReader(reader) => {
            chunk(reader, rows, |&value| Ok(content.int64_text(value)))
        }
        _ => Err(Fault::ColumnType { found: "binary values".to_owned() }),
    }
}

fn utf8(value: &ByteArray) -> Result<String, Fault> {
    value.as_utf8().map(str::to_owned).map_err(|_| Fault::Encoding)
}

fn chunk<T: DataType, C>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    mut cell: impl FnMut(&T::T) -> Result<C, Fault>,
) -> Result<Chunk<C>, Fault> {
    let mut chunk = Chunk { filled: Vec::new(), values: Vec::new() };
    let (mut levels, mut batch) = (Vec::new(), Vec::new());
    loop {
        levels.clear();
        batch.clear();
        let (read, values, _) =
            reader.read_records(BATCH_SIZE, Some(&mut levels), None, &mut batch).map_err(damaged)?;
        if read == 0 {
            return Ok(chunk);
        }
        if chunk.filled.len() + read > rows {
            return Err(damaged(format!(
                "a column has more than {rows} cells in a row group of {rows} rows"
            )));
        }
        // A required column has no definition levels.
        match levels.is_empty() {
            true => chunk.filled.resize(chunk.filled.len() + values, true),
            false => chunk.filled.extend(levels.iter().map(|&level| level > 0)),
        }
        for value in &batch {
            chunk.values.push(cell(value)?);
        }
    }
}
