//! Atomic replacement of folders.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Replaces the folder `path`, which need not exist, by the folder `new`. Afterwards `new` contains the previous content
/// of `path`, or does not exist.
///
/// Both folders must have the same parent. On Linux and macOS one system call exchanges them: if the process is killed,
/// `path` contains either all of the old or all of the new content. On file systems without this call, `path` is first
/// renamed to `.NAME.replaced`. If the process is killed between the two renames, [`recover_folder`] restores it.
///
/// # Errors
/// If a file operation fails; `path` is then unchanged.
pub fn replace_folder(new: &Path, path: &Path) -> io::Result<()> {
    recover_folder(path)?;
    if fs::symlink_metadata(path).is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
        return fs::rename(new, path);
    }
    if exchange(new, path)? {
        return Ok(());
    }
    let aside = aside(path)?;
    fs::rename(path, &aside)?;
    // On failure, restore the old folder and return the first error.
    fs::rename(new, path).inspect_err(|_| drop(fs::rename(&aside, path)))?;
    fs::rename(&aside, new)
}

/// Restores the folder that an interrupted [`replace_folder`] has moved away, or removes it if `path` exists.
///
/// # Errors
/// If a file operation fails.
pub fn recover_folder(path: &Path) -> io::Result<()> {
    let Ok(aside) = aside(path) else { return Ok(()) };
    if !aside.exists() {
        return Ok(());
    }
    match path.exists() {
        true => fs::remove_dir_all(aside),
        false => fs::rename(aside, path),
    }
}

/// Temporary path of a folder that is being replaced.
fn aside(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(".replaced");
    Ok(path.with_file_name(hidden))
}

/// Exchanges two paths atomically. Returns false if the file system does not support it.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn exchange(a: &Path, b: &Path) -> io::Result<bool> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;

    match renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE) {
        Ok(()) => Ok(true),
        Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) => Ok(false),
        Err(other) => Err(other.into()),
    }
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn exchange(_a: &Path, _b: &Path) -> io::Result<bool> {
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(path: &Path, text: &str) {
        fs::create_dir(path).unwrap();
        fs::write(path.join("mark"), text).unwrap();
    }

    fn mark(path: &Path) -> String {
        fs::read_to_string(path.join("mark")).unwrap()
    }

    #[test]
    fn replace_folder_exchanges_the_two_folders() {
        let home = tempfile::tempdir().unwrap();
        let [new, path] = ["new", "path"].map(|name| home.path().join(name));
        folder(&new, "one");
        replace_folder(&new, &path).unwrap();
        assert_eq!((mark(&path).as_str(), new.exists()), ("one", false));
        folder(&new, "two");
        replace_folder(&new, &path).unwrap();
        assert_eq!((mark(&path), mark(&new)), ("two".to_owned(), "one".to_owned()));
        assert!(replace_folder(&home.path().join("none"), &path).is_err());
        assert_eq!(mark(&path), "two");
    }

    /// Without an atomic exchange, `path` does not exist for a moment.
    #[test]
    fn recover_folder_restores_after_an_interruption() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("path");
        let moved = aside(&path).unwrap();
        folder(&moved, "one");
        recover_folder(&path).unwrap();
        assert_eq!((mark(&path).as_str(), moved.exists()), ("one", false));
        // Interrupted after the new folder was in place.
        folder(&moved, "zero");
        recover_folder(&path).unwrap();
        assert_eq!((mark(&path).as_str(), moved.exists()), ("one", false));
    }
}
