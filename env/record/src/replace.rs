//! A folder takes another one's place in one step.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Puts the folder `new` in the place of `path`, which need not exist. Afterwards `new` holds what was there before,
/// or is gone.
///
/// Both must lie in one folder. On Linux and macOS the two are exchanged by one system call: a process that is killed
/// at any instant leaves at `path` either all that was there or all that is new. Where the file system cannot do that,
/// the earlier folder is first renamed to `.NAME.replaced`; a process that is killed between the two renames leaves
/// it there, and [`recover_folder`] brings it back.
///
/// # Errors
/// When the system refuses; what was there before is then untouched.
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
    // On failure the earlier one must come back; the first error is the one to tell.
    fs::rename(new, path).inspect_err(|_| drop(fs::rename(&aside, path)))?;
    fs::rename(&aside, new)
}

/// Brings back what a killed [`replace_folder`] has moved aside, or removes it if its successor is in place.
///
/// # Errors
/// When the system refuses.
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

/// Where a folder is moved while another takes its place.
fn aside(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(".replaced");
    Ok(path.with_file_name(hidden))
}

/// Exchanges two paths in one step; false where the file system cannot.
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
    fn a_folder_is_replaced_in_one_step() {
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

    /// Where folders cannot be exchanged there is an instant at which nothing is at the path.
    #[test]
    fn what_a_killed_process_moved_aside_comes_back() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("path");
        let moved = aside(&path).unwrap();
        folder(&moved, "one");
        recover_folder(&path).unwrap();
        assert_eq!((mark(&path).as_str(), moved.exists()), ("one", false));
        // Killed after the successor was in place.
        folder(&moved, "zero");
        recover_folder(&path).unwrap();
        assert_eq!((mark(&path).as_str(), moved.exists()), ("one", false));
    }
}
