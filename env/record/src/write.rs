//! Atomic writing of a recording.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::folder::METADATA_FILE;
use crate::joints::owned_files;
use crate::recording::Recording;
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
        write_folder(path, &text, &self.episodes, &BTreeMap::new(), table)
    }
}

/// Writes the folder of a recording with `files` by their paths in it, and replaces an earlier recording at `path`.
pub(crate) fn write_folder(
    path: &Path,
    text: &str,
    episodes: &[Episode],
    files: &BTreeMap<String, Vec<u8>>,
    table: Table,
) -> Result<(), Error> {
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
    for (name, content) in files {
        let file = folder.join(name);
        fs::create_dir_all(file.parent().unwrap_or(&folder)).map_err(io)?;
        fs::write(file, content).map_err(io)?;
    }
    for episode in episodes {
        let name = format!("{}.{}", episode.name, table.extension());
        let written = table.write(&folder.join(&name), episode);
        // Report the final path: the temporary folder no longer exists when the user reads the error.
        written.map_err(|error| error.on_disk(|_| Some(path.join(&name))))?;
    }
    replace_folder(&folder, path).map_err(io)
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
    list(path, "", &mut names)?;
    if names.is_empty() {
        return Ok(None);
    }
    if !names.iter().any(|name| name == METADATA_FILE) {
        return Ok(Some("is not a recording".to_owned()));
    }
    let models = owned_files(path);
    let is_table = |name: &String| !name.contains('/') && Table::of(Path::new(name)).is_some();
    let unrelated =
        names.iter().find(|name| *name != METADATA_FILE && !is_table(name) && !models.contains(*name));
    Ok(unrelated.map(|name| format!("contains {name:?}, which is not part of a recording")))
}

/// Appends the paths of all files and empty folders in `folder`, relative to it and with `/`.
fn list(folder: &Path, prefix: &str, names: &mut Vec<String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        let before = names.len();
        if entry.file_type()?.is_dir() {
            list(&entry.path(), &format!("{name}/"), names)?;
        }
        if names.len() == before {
            names.push(name);
        }
    }
    Ok(())
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
