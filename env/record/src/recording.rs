//! A recording in memory, and reading it from its folder.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::episode::Episode;
use crate::error::{Error, File, Place};
use crate::fault::Fault;
use crate::metadata::Metadata;
use crate::replace::recover_folder;
use crate::table::{Budget, Table};
use crate::validate::check_name;

/// File name of the metadata.
pub(crate) const METADATA_FILE: &str = "recording.toml";

/// A recording: its metadata and its episodes in chronological order.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Content of `recording.toml`.
    pub metadata: Metadata,
    /// Episodes, sorted by name.
    pub episodes: Vec<Episode>,
}

impl Recording {
    /// Creates a recording of `episodes`, sorts them by name, and validates it.
    ///
    /// # Errors
    /// As [`Recording::validate`].
    pub fn new(metadata: Metadata, mut episodes: Vec<Episode>) -> Result<Self, Error> {
        episodes.sort_by(|a, b| a.name.cmp(&b.name));
        let recording = Self { metadata, episodes };
        recording.validate()?;
        Ok(recording)
    }

    /// Reads and validates the folder `path`: `recording.toml` and each `NAME.csv` or `NAME.parquet`. Ignores all other
    /// files, and files whose name begins with a dot.
    ///
    /// # Errors
    /// If a file cannot be read, or the recording is invalid (see [`Recording::validate`]).
    pub fn read(path: &Path) -> Result<Self, Error> {
        recover_folder(path)
            .map_err(|source| Fault::Io { action: "recovered", source }.at(Place::path(path)))?;
        let document = path.join(METADATA_FILE);
        let text = metadata_text(path, &document)?;
        let tables = tables(path)?;
        read_all(&text, &tables).map_err(|error| {
            error.on_disk(|file| match file {
                File::Metadata => Some(document),
                File::Episode(name) => tables.get(name).cloned(),
                File::Path(_) => None,
            })
        })
    }
}

fn read_all(text: &str, tables: &BTreeMap<String, PathBuf>) -> Result<Recording, Error> {
    let metadata = Metadata::from_toml(text)?;
    let size = |path: &PathBuf| fs::metadata(path).map_or(0, |found| found.len());
    let mut budget = Budget::of(tables.values().map(size).sum());
    let mut episodes = Vec::with_capacity(tables.len());
    for (name, path) in tables {
        if let Some(table) = Table::of(path) {
            episodes.push(table.read(path, name, &mut budget)?);
        }
    }
    Recording::new(metadata, episodes)
}

fn metadata_text(folder: &Path, document: &Path) -> Result<String, Error> {
    let problem = match fs::metadata(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Some("there is no such folder"),
        Ok(found) if !found.is_dir() => Some("this is not a folder"),
        Ok(_) if !document.exists() => Some("the folder has no recording.toml"),
        _ => None,
    };
    if let Some(problem) = problem {
        return Err(Fault::NotARecording { problem }.at(Place::path(folder)));
    }
    fs::read_to_string(document).map_err(|source| match source.kind() {
        io::ErrorKind::InvalidData => Fault::Encoding.at(Place::path(document)),
        _ => Fault::Io { action: "read", source }.at(Place::path(document)),
    })
}

/// Paths of the episode tables by episode name.
fn tables(folder: &Path) -> Result<BTreeMap<String, PathBuf>, Error> {
    let io = |source| Fault::Io { action: "listed", source }.at(Place::path(folder));
    let mut tables: BTreeMap<String, PathBuf> = BTreeMap::new();
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        paths.push(entry.map_err(io)?.path());
    }
    paths.sort();
    for path in paths.into_iter().filter(|path| Table::of(path).is_some() && path.is_file()) {
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        if name.starts_with('.') {
            continue;
        }
        check_name(&name).map_err(|fault| fault.at(Place::path(folder)))?;
        if let Some(first) = tables.insert(name, path.clone()) {
            let other = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            return Err(Fault::TwoTables { other }.at(Place::path(&first)));
        }
    }
    Ok(tables)
}
