//! The folder of a recording: its document and its tables.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::episode::Episode;
use crate::error::{Error, File, Place};
use crate::fault::Fault;
use crate::replace::recover_folder;
use crate::table::{Budget, CheckTitle, Table};
use crate::validate::check_name;

/// File name of the metadata.
pub(crate) const METADATA_FILE: &str = "recording.toml";

/// The folder of a recording on disk. Ignores all files but `recording.toml` and tables, and files whose name begins with
/// a dot.
pub(crate) struct Folder {
    /// The folder.
    pub path: PathBuf,
    /// Text of `recording.toml`.
    pub text: String,
    /// Paths of the episode tables by episode name.
    tables: BTreeMap<String, PathBuf>,
}

impl Folder {
    /// Reads the document, and lists the tables.
    pub fn open(path: &Path) -> Result<Self, Error> {
        recover_folder(path)
            .map_err(|source| Fault::Io { action: "recovered", source }.at(Place::path(path)))?;
        let text = metadata_text(path, &path.join(METADATA_FILE))?;
        Ok(Self { path: path.to_owned(), text, tables: tables(path)? })
    }

    /// Reads all tables.
    pub fn episodes(&self, check: CheckTitle<'_>) -> Result<Vec<Episode>, Error> {
        let size = |path: &PathBuf| fs::metadata(path).map_or(0, |found| found.len());
        let mut budget = Budget::of(self.tables.values().map(size).sum());
        let mut episodes = Vec::with_capacity(self.tables.len());
        for (name, path) in &self.tables {
            if let Some(table) = Table::of(path) {
                episodes.push(table.read(path, name, &mut budget, check)?);
            }
        }
        Ok(episodes)
    }

    /// The same error with the path of its file.
    pub fn locate(&self, error: Error) -> Error {
        error.on_disk(|file| match file {
            File::Metadata => Some(self.path.join(METADATA_FILE)),
            File::Episode(name) => self.tables.get(name).cloned(),
            File::Path(_) => None,
        })
    }
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
