//! Writing a file whole or not at all.
//!
//! The bytes go to a temporary file in the same folder, which is then renamed, so a full disk or an interruption
//! leaves the old file as it was.

use crate::error::{Error, Result};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Distinguishes the temporary files of one process.
static COUNTER: AtomicU64 = AtomicU64::new(0);

/// Replaces the contents of `path` by `bytes`, or leaves it untouched.
///
/// A link is followed; something that is no ordinary file (a pipe, a device) is written to directly.
///
/// # Errors
/// [`Error::Write`] with the path.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, bytes).map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

/// Finds out early whether [`write()`] will be able to write `path`; leaves nothing behind.
///
/// # Errors
/// [`Error::Write`] with the path.
pub fn check_writable(path: &Path) -> Result<()> {
    let probe = |target: &Path| {
        let temporary = temporary_beside(target);
        fill(&temporary, &[]).and_then(|()| fs::remove_file(&temporary))
    };
    let result = match fs::canonicalize(path) {
        Ok(existing) if existing.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(existing) if !existing.is_file() => Ok(()),
        Ok(existing) => probe(&existing),
        Err(_) => probe(path),
    };
    result.map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

/// Makes the directory `path` and those above it, if they do not exist.
///
/// # Errors
/// [`Error::Write`] with the path.
pub fn create_dir(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

/// Removes the file `path`, if there is one.
///
/// # Errors
/// [`Error::Write`] with the path.
pub fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            Err(Error::Write { path: path.to_path_buf(), source })
        }
        _ => Ok(()),
    }
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let target = match fs::canonicalize(path) {
        Ok(existing) if existing.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(existing) if !existing.is_file() => return fs::write(existing, bytes),
        Ok(existing) => existing,
        Err(_) => path.to_path_buf(),
    };
    let temporary = temporary_beside(&target);
    let result = fill(&temporary, bytes).and_then(|()| fs::rename(&temporary, &target));
    if result.is_err() {
        // The first error is the one to report; there may be nothing to remove.
        let _ = fs::remove_file(&temporary);
    }
    result
}

fn fill(path: &Path, bytes: &[u8]) -> io::Result<()> {
    fs::OpenOptions::new().write(true).create_new(true).open(path)?.write_all(bytes)
}

fn temporary_beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{count}.part", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_probe_leaves_no_trace_and_keeps_what_was_there() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        check_writable(&path).unwrap();
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
        write(&path, b"one").unwrap();
        check_writable(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert!(matches!(check_writable(&dir.path().join("no/a.txt")), Err(Error::Write { .. })));
        assert!(matches!(check_writable(dir.path()), Err(Error::Write { .. })));
    }

    #[test]
    fn a_file_is_removed_whether_it_is_there_or_not() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write(&path, b"one").unwrap();
        remove(&path).unwrap();
        remove(&path).unwrap();
        assert!(!path.exists());
        assert!(matches!(remove(dir.path()), Err(Error::Write { .. })));
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let path = Path::new("/no/such/folder/a.txt");
        let error = write(path, b"x").unwrap_err();
        assert!(error.to_string().starts_with("/no/such/folder/a.txt: cannot be written"), "{error}");
    }

    #[test]
    fn a_directory_is_not_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        assert!(matches!(write(dir.path(), b"x"), Err(Error::Write { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_not_replaced_by_a_file() {
        write(Path::new("/dev/null"), b"x").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
