//! Reading a file whole: an ordinary one, no larger than it says, within the memory budget.

use crate::error::{Error, Result};
use crate::memory;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// The bytes of the file `path`, at most `most`. Pipes and devices are refused before they are opened, since they may never end.
///
/// # Errors
/// [`Error::Read`] with the path; [`Error::TooLarge`] for a file that the memory budget does not hold.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let failed = |reason: String| Error::Read { path: path.to_path_buf(), reason };
    let length = ordinary(path)?.len();
    if length > most {
        return Err(failed(format!("it has {length} bytes, more than {most}")));
    }
    let _held = memory::reserve(|| "its bytes".into(), length).map_err(|e| in_file(e, path))?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize).map_err(|e| failed(e.to_string()))?;
    let file = File::open(path).map_err(|e| failed(e.to_string()))?;
    file.take(length).read_to_end(&mut bytes).map_err(|e| failed(e.to_string()))?;
    Ok(bytes)
}

/// Opens the ordinary file `path`.
///
/// # Errors
/// [`Error::Read`] with the path.
pub fn open(path: &Path) -> Result<File> {
    ordinary(path)?;
    File::open(path).map_err(|e| Error::Read { path: path.to_path_buf(), reason: e.to_string() })
}

/// An error of the memory budget as one of the file `path`, whose content is the cause.
pub fn in_file(error: Error, path: &Path) -> Error {
    match error {
        Error::Memory { what, bytes, left } => {
            Error::TooLarge { path: path.to_path_buf(), what, bytes, left }
        }
        other => other,
    }
}

fn ordinary(path: &Path) -> Result<fs::Metadata> {
    let failed = |reason: String| Error::Read { path: path.to_path_buf(), reason };
    let about = fs::metadata(path).map_err(|e| failed(e.to_string()))?;
    if about.is_dir() {
        return Err(failed("it is a folder".into()));
    }
    if !about.is_file() {
        return Err(failed("it is a pipe or a device; save its contents as a file".into()));
    }
    Ok(about)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_up_to_a_length() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        fs::write(&path, "four").unwrap();
        assert_eq!(read(&path, 4).unwrap(), b"four");
        let message = read(&path, 3).unwrap_err().to_string();
        assert!(message.contains("4 bytes, more than 3"), "{message}");
    }

    #[test]
    fn a_file_with_holes_is_refused_by_its_size() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        File::create(&path).unwrap().set_len(1 << 42).unwrap();
        let error = read(&path, u64::MAX).unwrap_err();
        assert!(matches!(error, Error::TooLarge { .. }) && error.is_usage(), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn what_never_ends_is_refused() {
        for path in ["/dev/zero", "/dev/full", "/"] {
            let message = read(Path::new(path), u64::MAX).unwrap_err().to_string();
            assert!(message.starts_with(&format!("{path}: cannot be read: it is a ")), "{message}");
        }
    }
}
