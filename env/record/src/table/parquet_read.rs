//! Episode tables from Parquet, as pandas, pyarrow, polars and others write it.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::parquet_types::{Content, content};
use super::{Kind, kinds};
use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;

/// Values decoded at a time.
const BATCH: usize = 8192;

/// A fault, and the column it is in.
type Located = (Option<String>, Fault);

/// Reads the table at `path` as the episode `name`; nulls become empty cells.
pub(super) fn read(path: &Path, name: &str) -> Result<Episode, Error> {
    let file =
        File::open(path).map_err(|source| Fault::Io { action: "read", source }.at(Place::path(path)))?;
    // The decoder is not proof against every damaged file, and no panic may leave this crate.
    catch_unwind(AssertUnwindSafe(|| decode(file, name)))
        .unwrap_or_else(|_| Err((None, damaged("its parts contradict each other"))))
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

fn decode(file: File, name: &str) -> Result<Episode, Located> {
    let reader = SerializedFileReader::new(file).map_err(|error| (None, damaged(error)))?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let mut episode = Episode { name: name.to_owned(), ..Episode::default() };
    // A column within a list or a structure has a title of several parts, which is then unknown.
    let titles: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
    let kinds = kinds(&titles).map_err(|(title, fault)| (Some(title), fault))?;
    for (index, (title, kind)) in titles.into_iter().zip(kinds).enumerate() {
        insert(&mut episode, &title, kind, &reader, index).map_err(|fault| (Some(title), fault))?;
    }
    Ok(episode)
}

fn insert(
    episode: &mut Episode,
    title: &str,
    kind: Kind,
    reader: &SerializedFileReader<File>,
    index: usize,
) -> Result<(), Fault> {
    let schema = reader.metadata().file_metadata().schema_descr();
    let content = content(&schema.column(index), kind == Kind::Note)?;
    match kind {
        Kind::Note => {
            let texts = column_of(reader, index, String::new(), |chunk| text(chunk, content))?;
            episode.notes.insert(title.to_owned(), texts);
        }
        Kind::Number => {
            let numbers = column_of(reader, index, f64::NAN, |chunk| number(chunk, content))?;
            episode.insert(title.to_owned(), numbers);
        }
    }
    Ok(())
}

/// All cells of one column: row group by row group, `empty` where a cell is null.
fn column_of<C: Clone>(
    reader: &SerializedFileReader<File>,
    column: usize,
    empty: C,
    decode: impl Fn(ColumnReader) -> Result<Chunk<C>, Fault>,
) -> Result<Vec<C>, Fault> {
    let mut cells = Vec::new();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(damaged)?;
        let Chunk { filled, values } = decode(group.get_column_reader(column).map_err(damaged)?)?;
        let rows = group.metadata().num_rows();
        if usize::try_from(rows) != Ok(filled.len()) {
            return Err(damaged(format!("{} cells in a row group of {rows}", filled.len())));
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

/// A column chunk: which cells are filled, and with what.
struct Chunk<C> {
    filled: Vec<bool>,
    values: Vec<C>,
}

fn number(reader: ColumnReader, content: Content) -> Result<Chunk<f64>, Fault> {
    match reader {
        ColumnReader::DoubleColumnReader(reader) => chunk(reader, |&value| Ok(value)),
        ColumnReader::FloatColumnReader(reader) => chunk(reader, |&value| Ok(f64::from(value))),
        ColumnReader::Int32ColumnReader(reader) => chunk(reader, |&value| Ok(content.int32(value))),
        ColumnReader::Int64ColumnReader(reader) => chunk(reader, |&value| Ok(content.int64(value))),
        _ => Err(Fault::ColumnType { found: "no numbers".to_owned() }),
    }
}

fn text(reader: ColumnReader, content: Content) -> Result<Chunk<String>, Fault> {
    match reader {
        ColumnReader::BoolColumnReader(reader) => chunk(reader, |value| Ok(value.to_string())),
        ColumnReader::ByteArrayColumnReader(reader) => chunk(reader, utf8),
        ColumnReader::DoubleColumnReader(reader) => chunk(reader, |value| Ok(value.to_string())),
        ColumnReader::FloatColumnReader(reader) => chunk(reader, |value| Ok(value.to_string())),
        ColumnReader::Int32ColumnReader(reader) => {
            chunk(reader, |&value| Ok(content.int32(value).to_string()))
        }
        ColumnReader::Int64ColumnReader(reader) => chunk(reader, |&value| Ok(content.int64_text(value))),
        _ => Err(Fault::ColumnType { found: "binary values".to_owned() }),
    }
}

fn utf8(value: &ByteArray) -> Result<String, Fault> {
    value.as_utf8().map(str::to_owned).map_err(|_| Fault::Encoding)
}

fn chunk<T: DataType, C>(
    mut reader: ColumnReaderImpl<T>,
    cell: impl Fn(&T::T) -> Result<C, Fault>,
) -> Result<Chunk<C>, Fault> {
    let mut chunk = Chunk { filled: Vec::new(), values: Vec::new() };
    let (mut levels, mut batch) = (Vec::new(), Vec::new());
    loop {
        levels.clear();
        batch.clear();
        let (rows, values, _) =
            reader.read_records(BATCH, Some(&mut levels), None, &mut batch).map_err(damaged)?;
        if rows == 0 {
            return Ok(chunk);
        }
        // A column that cannot be null has no levels.
        match levels.is_empty() {
            true => chunk.filled.resize(chunk.filled.len() + values, true),
            false => chunk.filled.extend(levels.iter().map(|&level| level > 0)),
        }
        for value in &batch {
            chunk.values.push(cell(value)?);
        }
    }
}
