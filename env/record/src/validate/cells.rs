//! Conditions on columns, times and cells that all formats share.

use crate::episode::{Episode, NOTE_PREFIX};
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::table::CheckTitle;

/// Checks the titles of the columns, and that each has a cell per time.
pub(crate) fn check_columns(episode: &Episode, check: CheckTitle<'_>) -> Result<(), Error> {
    let Episode { name: episode_name, t, columns, notes } = episode;
    let place = || Place::episode(episode_name);
    for name in columns.keys().chain(notes.keys().filter(|name| !name.starts_with(NOTE_PREFIX))) {
        check(name).map_err(|fault| fault.at(place().column(name)))?;
    }
    let numbers = columns.iter().map(|(name, cells)| (name, cells.len()));
    let texts = notes.iter().map(|(name, cells)| (name, cells.len()));
    match (t.len(), numbers.chain(texts).find(|(_, found)| *found != t.len())) {
        (0, None) => Err(Fault::NoRows.at(place())),
        (0, Some(_)) => {
            let reason = "every row needs a time in seconds".to_owned();
            Err(Fault::MissingColumn { reason }.at(place().column("t")))
        }
        (expected, Some((name, found))) => Err(Fault::Length { found, expected }.at(place().column(name))),
        (_, None) => Ok(()),
    }
}

/// Checks that the times increase strictly, and that no number is infinite.
pub(crate) fn check_numbers(episode: &Episode) -> Result<(), Error> {
    let place = |row: usize, column: &str| Place::episode(&episode.name).row(row + 1).column(column);
    let mut previous = f64::NEG_INFINITY;
    for (row, &value) in episode.t.iter().enumerate() {
        let fault = if value.is_nan() {
            Fault::NoTime
        } else if value.is_infinite() {
            Fault::Infinite { value }
        } else if value <= previous {
            Fault::NotIncreasing { value, previous }
        } else {
            previous = value;
            continue;
        };
        return Err(fault.at(place(row, "t")));
    }
    for (name, cells) in &episode.columns {
        if let Some(row) = cells.iter().position(|cell| cell.is_infinite()) {
            return Err(Fault::Infinite { value: cells[row] }.at(place(row, name)));
        }
    }
    Ok(())
}

/// Checks that each row has a sample.
pub(crate) fn check_rows(episode: &Episode) -> Result<(), Error> {
    let is_empty = |row: &usize| episode.columns.values().all(|column| column[*row].is_nan());
    match (0..episode.t.len()).find(is_empty) {
        Some(row) => {
            let place = Place::episode(&episode.name).row(row + 1);
            Err(Fault::EmptyRow { t: episode.t[row] }.at(place))
        }
        None => Ok(()),
    }
}
