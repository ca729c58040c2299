//! Episode tables as CSV: UTF-8, comma-separated, one header line.

use std::io::Write;
use std::path::Path;

use ::csv::{ByteRecord, ReaderBuilder, WriterBuilder};

use super::columns::{CheckTitle, ColumnKind, column_kinds};
use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;

/// Reads the table at `path` as the episode `name`. Ignores spaces around numbers and headers.
pub(crate) fn read(path: &Path, name: &str, check: CheckTitle<'_>) -> Result<Episode, Error> {
    let here = || Place::path(path);
    let not_read = |error: ::csv::Error| Fault::Io { action: "read", source: error.into() }.at(here());
    let mut reader = ReaderBuilder::new().flexible(true).from_path(path).map_err(not_read)?;
    let titles = titles(reader.byte_headers().map_err(not_read)?).map_err(|fault| fault.at(here()))?;
    let mut columns =
        Columns::new(titles, check).map_err(|(title, fault)| fault.at(here().column(&title)))?;
    let (mut record, mut row) = (ByteRecord::new(), 0);
    while reader.read_byte_record(&mut record).map_err(not_read)? {
        row += 1;
        columns.push(&record).map_err(|(title, fault)| {
            let place = here().row(row);
            fault.at(title.map_or(place.clone(), |title| place.column(&title)))
        })?;
    }
    Ok(columns.into_episode(name))
}

/// Writes `episode`, with numbers in the shortest form that survives a round trip.
pub(crate) fn write(episode: &Episode, sink: impl Write) -> Result<(), ::csv::Error> {
    let mut writer = WriterBuilder::new().from_writer(sink);
    let header = episode.header();
    writer.write_record(std::iter::once("t").chain(header.iter().copied()))?;
    for row in 0..episode.t.len() {
        writer.write_field(number(episode.t[row]))?;
        for &name in &header {
            match episode.notes.get(name) {
                Some(texts) => writer.write_field(&texts[row])?,
                None => writer.write_field(number(episode.columns[name][row]))?,
            }
        }
        writer.write_record(None::<&[u8]>)?;
    }
    writer.flush()?;
    Ok(())
}

fn number(value: f64) -> String {
    if value.is_nan() { String::new() } else { format!("{value:?}") }
}

fn titles(record: &ByteRecord) -> Result<Vec<String>, Fault> {
    let text = |cell: &[u8]| std::str::from_utf8(cell).map(|title| title.trim().to_owned());
    record.iter().map(text).collect::<Result<_, _>>().map_err(|_| Fault::Encoding)
}

/// Columns under construction while rows are read.
struct Columns {
    titles: Vec<String>,
    cells: Vec<Cells>,
}

enum Cells {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

impl Columns {
    fn new(titles: Vec<String>, check: CheckTitle<'_>) -> Result<Self, (String, Fault)> {
        let empty = |kind| match kind {
            ColumnKind::Note => Cells::Texts(Vec::new()),
            ColumnKind::Number => Cells::Numbers(Vec::new()),
        };
        let cells = column_kinds(&titles, check)?.into_iter().map(empty).collect();
        Ok(Self { titles, cells })
    }

    fn push(&mut self, record: &ByteRecord) -> Result<(), (Option<String>, Fault)> {
        let (found, expected) = (record.len(), self.titles.len());
        if found != expected {
            return Err((None, Fault::Ragged { found, expected }));
        }
        for ((cell, cells), title) in record.iter().zip(&mut self.cells).zip(&self.titles) {
            cells.push(cell).map_err(|fault| (Some(title.clone()), fault))?;
        }
        Ok(())
    }

    fn into_episode(self, name: &str) -> Episode {
        let mut episode = Episode { name: name.to_owned(), ..Episode::default() };
        for (title, cells) in self.titles.into_iter().zip(self.cells) {
            match cells {
                Cells::Numbers(values) => episode.insert(title, values),
                Cells::Texts(texts) => drop(episode.notes.insert(title, texts)),
            }
        }
        episode
    }
}

impl Cells {
    fn push(&mut self, cell: &[u8]) -> Result<(), Fault> {
        let text = std::str::from_utf8(cell).map_err(|_| Fault::Encoding)?;
        match self {
            Self::Numbers(values) => values.push(parse(text.trim())?),
            Self::Texts(texts) => texts.push(text.to_owned()),
        }
        Ok(())
    }
}

fn parse(text: &str) -> Result<f64, Fault> {
    if text.is_empty() {
        return Ok(f64::NAN);
    }
    text.parse().map_err(|_| Fault::NotANumber { value: text.to_owned() })
}
