//! Writing a file whole or not at all.
//!
//! The bytes go to a [part](super::temporary) in the same folder, through to the disk, which is then renamed: a full disk, an
//! interruption or a power cut leaves the old file as it was.

use super::temporary::{NewFolders, Part, remove_stale};
use crate::error::{Error, Result};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Replaces the contents of `path` by `bytes`, or leaves it untouched.
///
/// A link is followed; something that is no ordinary file (a pipe, a device) is written to directly.
///
/// # Errors
/// [`Error::Write`] with the path.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let replace = || match target(path)? {
        Target::Special => fs::write(path, bytes),
        Target::File(target) => filled(&target, bytes)?.put(&target),
    };
    replace().map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

/// Finds out early whether [`write()`] will be able to write `path`, and removes what dead runs have left of it; leaves nothing
/// behind.
///
/// # Errors
/// [`Error::Write`] with the path.
pub fn check_writable(path: &Path) -> Result<()> {
    let probe = || match target(path)? {
        Target::Special => Ok(()),
        Target::File(target) => {
            let name = target.file_name().unwrap_or_default().to_string_lossy();
            remove_stale(target.parent().unwrap_or(Path::new("")), &[&name]);
            Part::file(&target).map(drop)
        }
    };
    probe().map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

/// Makes the directory `path` and those above it, if they do not exist. What is still empty when the returned value is dropped
/// is removed again.
///
/// # Errors
/// [`Error::Write`] with the path.
pub fn create_dir(path: &Path) -> Result<NewFolders> {
    let make = || check_link(path).and_then(|()| NewFolders::make(path));
    make().map_err(|source| Error::Write { path: path.to_path_buf(), source })
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

/// What a path to be written leads to.
pub(crate) enum Target {
    /// An ordinary file, links followed; it need not exist.
    File(PathBuf),
    /// A pipe or a device.
    Special,
}

/// What `path` leads to.
pub(crate) fn target(path: &Path) -> io::Result<Target> {
    check_link(path)?;
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => Ok(Target::Special),
        Ok(_) => fs::canonicalize(path).map(Target::File),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(Target::File(path.to_path_buf())),
        Err(e) => Err(e),
    }
}

/// A part beside `target` that holds `bytes`, and what may be done with it as with the file that is there.
pub(crate) fn filled(target: &Path, bytes: &[u8]) -> io::Result<Part> {
    let mut part = Part::file(target)?;
    if let Ok(old) = fs::metadata(target) {
        fs::set_permissions(part.path(), old.permissions())?;
    }
    part.fill(bytes)?;
    Ok(part)
}

/// Refuses a link that leads to nothing, or round in a circle.
fn check_link(path: &Path) -> io::Result<()> {
    let is_link = fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink());
    if is_link && fs::metadata(path).is_err() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a link that leads nowhere"));
    }
    Ok(())
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

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_one_that_leads_nowhere_is_refused() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        write(&at("a"), b"one").unwrap();
        fs::set_permissions(at("a"), fs::Permissions::from_mode(0o640)).unwrap();
        for (link, to) in [("link", "a"), ("dangling", "none"), ("loop", "loop")] {
            symlink(to, at(link)).unwrap();
        }
        write(&at("link"), b"two").unwrap();
        assert!(fs::symlink_metadata(at("link")).unwrap().is_symlink());
        assert_eq!(fs::read(at("a")).unwrap(), b"two");
        assert_eq!(fs::metadata(at("a")).unwrap().permissions().mode() & 0o777, 0o640);
        for name in ["dangling", "loop"] {
            for done in [write(&at(name), b"x"), check_writable(&at(name)), create_dir(&at(name)).map(drop)] {
                let error = done.unwrap_err();
                assert!(error.is_usage() && error.to_string().contains("leads nowhere"), "{error}");
            }
        }
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 4);
    }

    #[test]
    fn a_probe_removes_what_dead_runs_have_left() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join(".a.txt.1-2.part"), "x").unwrap();
        check_writable(&dir.path().join("a.txt")).unwrap();
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}
