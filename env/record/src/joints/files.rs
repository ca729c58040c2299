//! Documents of the models inside the folder of a recording.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Component, Path};

use toml::{Table as TomlTable, Value};

use super::includes::included;
use super::metadata::JointMetadata;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::folder::METADATA_FILE;
use crate::table::Table;
use crate::validate::is_printable;

/// Largest document of a model, bytes. Large robots have less than 1 MB; meshes are other files.
const MAX_DOCUMENT_BYTES: u64 = 64 << 20;

/// Documents by their paths inside the folder.
type Documents = BTreeMap<String, Vec<u8>>;

/// Reads the documents of all models of `metadata` in `folder`.
pub(super) fn read_models(metadata: &JointMetadata, folder: &Path) -> Result<Documents, Error> {
    documents(metadata, |path| read_inside(folder, path))
}

/// Checks that `files` are the documents of all models, and no others.
pub(super) fn check_files(metadata: &JointMetadata, files: &Documents) -> Result<(), Error> {
    let missing = || Fault::Value {
        value: "the document".to_owned(),
        problem: "is not among the files of the recording",
        remedy: "add it to them",
    };
    let needed = documents(metadata, |path| files.get(path).cloned().ok_or_else(missing))?;
    match files.keys().find(|path| !needed.contains_key(*path)) {
        None => Ok(()),
        Some(other) => Err(Fault::Value {
            value: format!("{other:?}"),
            problem: "is neither a model of the recording nor included by one",
            remedy: "remove it from the files; meshes and textures are not needed",
        }
        .at(Place::field("mechanism.model"))),
    }
}

/// The paths of the models' documents that the recording in `folder` consists of. Paths that cannot be read are left out.
pub(crate) fn owned_files(folder: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(folder.join(METADATA_FILE)).unwrap_or_default();
    let table: TomlTable = text.parse().unwrap_or_default();
    let model = |of: Option<&Value>| of?.get("model")?.as_str().map(str::to_owned);
    let episodes = table.get("episode").and_then(Value::as_table);
    let mut paths: Vec<String> = model(table.get("mechanism")).into_iter().collect();
    paths.extend(episodes.into_iter().flat_map(|all| all.values()).filter_map(|one| model(Some(one))));
    let mut found = Documents::new();
    for path in paths {
        // A document that cannot be read is not one of the recording's; the others are.
        drop(collect(&path, &mut found, &|path| read_inside(folder, path)));
    }
    found.into_keys().collect()
}

fn documents(
    metadata: &JointMetadata,
    load: impl Fn(&str) -> Result<Vec<u8>, Fault>,
) -> Result<Documents, Error> {
    let own = metadata.mechanism.model.iter().map(|path| ("mechanism.model".to_owned(), path));
    let episodes = metadata.episode.iter();
    let others =
        episodes.filter_map(|(name, meta)| Some((format!("episode.{name}.model"), meta.model.as_ref()?)));
    let mut found = Documents::new();
    for (key, path) in own.chain(others) {
        collect(path, &mut found, &load).map_err(|(path_at_fault, fault)| {
            let fault = match path_at_fault == *path {
                true => fault,
                false => Fault::Included { path: path_at_fault, fault: Box::new(fault) },
            };
            fault.at(Place::field(&key))
        })?;
    }
    Ok(found)
}

/// Adds the document at `path`, and all that it includes, to `found`. An error has the path at fault.
fn collect(
    path: &str,
    found: &mut Documents,
    load: &impl Fn(&str) -> Result<Vec<u8>, Fault>,
) -> Result<(), (String, Fault)> {
    let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut waiting = vec![path.to_owned()];
    while let Some(next) = waiting.pop() {
        if found.contains_key(&next) {
            continue;
        }
        let content = check_path(&next).and_then(|()| load(&next)).map_err(|fault| (next.clone(), fault))?;
        // MuJoCo resolves includes from the folder of the main document.
        let names = included(&content).into_iter();
        waiting.extend(names.map(|name| if folder.is_empty() { name } else { format!("{folder}/{name}") }));
        found.insert(next, content);
    }
    Ok(())
}

/// Refuses a path that is absolute, leaves the folder, or is not that of a model's document.
fn check_path(path: &str) -> Result<(), Fault> {
    let is_inside = Path::new(path).components().all(|part| matches!(part, Component::Normal(_)))
        && path.split('/').all(|part| !part.is_empty() && part != "." && part != "..");
    let is_plain = !path.contains('\\') && !path.contains(':') && path.chars().all(is_printable);
    if !is_inside || !is_plain {
        return Err(Fault::Value {
            value: format!("{path:?}"),
            problem: "is not a path inside the folder of the recording",
            remedy: "copy the document there, and give its relative path with '/' and without '..'",
        });
    }
    let is_table = !path.contains('/') && Table::of(Path::new(path)).is_some();
    if is_table || path == METADATA_FILE {
        return Err(Fault::Value {
            value: format!("{path:?}"),
            problem: "is the name of another file of the recording",
            remedy: "give the path of an MJCF or URDF document",
        });
    }
    Ok(())
}

fn read_inside(folder: &Path, path: &str) -> Result<Vec<u8>, Fault> {
    let file = folder.join(path);
    let io = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => Fault::Value {
            value: format!("{path:?}"),
            problem: "is not a file in the folder of the recording",
            remedy: "copy the MJCF or URDF document there, or correct the path",
        },
        _ => Fault::Io { action: "read", source },
    };
    let found = fs::metadata(&file).map_err(io)?;
    // A symbolic link may lead out of the folder.
    if !file.canonicalize().map_err(io)?.starts_with(folder.canonicalize().map_err(io)?) {
        return Err(Fault::Value {
            value: format!("{path:?}"),
            problem: "is a link out of the folder of the recording",
            remedy: "copy the document there",
        });
    }
    let problem = match (found.is_file(), found.len() > MAX_DOCUMENT_BYTES) {
        (true, false) => return fs::read(&file).map_err(io),
        (false, _) => "is no file",
        (true, true) => "is larger than 64 MiB",
    };
    Err(Fault::Value {
        value: format!("{path:?}"),
        problem,
        remedy: "give the path of an MJCF or URDF document",
    })
}
