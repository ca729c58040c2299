//! Atomic writing of a recording.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::recording::{METADATA_FILE, Recording};
use crate::replace::{recover_folder, replace_folder};
use crate::table::Table;

impl Recording {
    /// Writes the folder `path` and replaces an earlier recording there. Equal recordings give equal bytes.
    ///
    /// # Errors
    /// If the recording is invalid, `path` contains anything but a recording, or a file operation fails. `path` is then
    /// unchanged.
    pub fn write(&self, path: &Path, table: Table) -> Result<(), Error> {
        self.validate()?;
        let text = self.metadata.to_toml()?;
        let io = |source| Fault::Io { action: "written", source }.at(Place::path(path));
        recover_folder(path).map_err(io)?;
        let occupied = occupied(path).map_err(io)?;
        if let Some(problem) = occupied {
            return Err(Fault::Occupied { problem }.at(Place::path(path)));
        }
        let temporary = temporary_sibling(path).map_err(io)?;
        let folder = temporary.path().join("new");
        fs::create_dir(&folder).map_err(io)?;
        fs::write(folder.join(METADATA_FILE), text).map_err(io)?;
        for episode in &self.episodes {
            let name = format!("{}.{}", episode.name, table.extension());
            let written = table.write(&folder.join(&name), episode);
            // Report the final path: the temporary folder no longer exists when the user reads the error.
            written.map_err(|error| error.on_disk(|_| Some(path.join(&name))))?;
        }
        replace_folder(&folder, path).map_err(io)
    }
}

/// Why `path` must not be replaced; `None` if it may be.
fn occupied(path: &Path) -> io::Result<Option<String>> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
        Ok(found) if !found.is_dir() => return Ok(Some("is not a folder".to_owned())),
        Ok(_) => {}
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(path)? {
        names.push(entry?.file_name());
    }
    if names.is_empty() {
        return Ok(None);
    }
    if !names.iter().any(|name| name == METADATA_FILE) {
        return Ok(Some("is not a recording".to_owned()));
    }
    let unrelated = names.iter().find(|name| *name != METADATA_FILE && Table::of(Path::new(name)).is_none());
    Ok(unrelated.map(|name| format!("contains {name:?}, which is not part of a recording")))
}

/// An empty folder in the parent of `path`, removed on drop.
fn temporary_sibling(path: &Path) -> io::Result<TempDir> {
    let parent = match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    fs::create_dir_all(&parent)?;
    tempfile::Builder::new().prefix(".trundle-").tempdir_in(parent)
}
