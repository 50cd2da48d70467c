//! A set of results that is in its folder whole, or not at all.
//!
//! The files are made in a [part](crate::io::temporary) of the folder, and are on the disk before anything else happens. Then
//! the folder takes the place of the earlier one in one step, if all in that is [ours](owned). A folder that holds other
//! things, or that cannot be replaced (the one that the command runs in, a mount point, a link), gets the files one by one, the
//! report last: it names all others with their SHA-256, so that a set that is not whole can be told.

mod hash;
mod owned;
mod put;

pub(super) use hash::sha256;

use super::outputs;
use crate::error::{Error, Result};
use crate::io::atomic;
use crate::io::temporary::{NewFolders, Part, remove_stale, undisturbed};
use indexmap::IndexMap;
use owned::Owned;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The report, which names all other files of a set.
pub(super) const REPORT: &str = "fit.json";

/// What a part within the folder is named after.
const WITHIN: &str = "fit";

/// A set of results on its way into a folder; it vanishes with this value unless it is committed.
pub(super) struct Results {
    folder: PathBuf,
    /// Names of all files that such a set may have, the report among them.
    names: Vec<String>,
    part: Part,
    owned: Owned,
    /// Folders that were made for this one.
    _made: NewFolders,
}

impl Results {
    /// Begins a set in `folder`. Its files will be some of `names`: those that are `optional` may also be lacking, and
    /// what an earlier fit has left of them is removed then. What is one of `inputs` is spared.
    ///
    /// # Errors
    /// [`Error::Protected`] and [`Error::Write`], with the path, for whatever could not be written, or would be lost.
    pub(super) fn begin(
        folder: &Path,
        names: Vec<String>,
        optional: &[String],
        inputs: &[PathBuf],
    ) -> Result<Self> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let failed = |source| Error::Write { path: folder.to_path_buf(), source };
        let exists = fs::symlink_metadata(folder).is_ok();
        let parent = folder.parent().unwrap_or(Path::new(""));
        let made = atomic::create_dir(if exists { folder } else { parent })?;
        let owned = Owned::read(folder);
        if exists {
            for name in &names {
                outputs::check(&folder.join(name), inputs)?;
            }
            check_left(folder, &owned, &names, optional, inputs)?;
            remove_stale(folder, &[WITHIN]);
        }
        let beside = || {
            let name = folder.file_name().filter(|_| !exists || put::is_replaceable(folder));
            let name = name.ok_or(io::ErrorKind::InvalidInput)?;
            remove_stale(parent, &[&name.to_string_lossy()]);
            Part::folder(parent, name)
        };
        let within = |error| if exists { Part::folder(folder, OsStr::new(WITHIN)) } else { Err(error) };
        let part = beside().or_else(within).map_err(failed)?;
        Ok(Self { folder: folder.to_path_buf(), names, part, owned, _made: made })
    }

    /// Where to write the file `name` of the set.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.part.path().join(name)
    }

    /// Names and SHA-256 of the files so far, by name.
    ///
    /// # Errors
    /// [`Error::Write`] with the path.
    pub(super) fn hashes(&self) -> Result<IndexMap<String, String>> {
        let hashed = |name: String| {
            let path = self.path(&name);
            let hash = sha256(&path).map_err(|source| Error::Write { path, source })?;
            Ok((name, hash))
        };
        put::names_in(self.part.path()).map_err(|e| self.failed(e))?.into_iter().map(hashed).collect()
    }

    /// Puts the set in its place.
    ///
    /// # Errors
    /// [`Error::Write`] with the path.
    pub(super) fn commit(self) -> Result<()> {
        let Self { folder, names, part, owned, .. } = &self;
        let done = put::replace(part, folder, names, owned);
        let done =
            done.or_else(|e| if folder.is_dir() { put::one_by_one(part, folder, owned) } else { Err(e) });
        done.map_err(|e| self.failed(e))
    }

    /// An error of writing the set, as one of its place.
    pub(super) fn worded(&self, error: Error) -> Error {
        match error {
            Error::Write { path, source } => {
                let path =
                    path.strip_prefix(self.part.path()).map_or(path.clone(), |name| self.folder.join(name));
                Error::Write { path, source }
            }
            other => other,
        }
    }

    fn failed(&self, source: io::Error) -> Error {
        Error::Write { path: self.folder.clone(), source }
    }
}

/// Refuses a set whose place can only be made by removing what an earlier fit has not left, or what is an input.
fn check_left(
    folder: &Path,
    owned: &Owned,
    names: &[String],
    optional: &[String],
    inputs: &[PathBuf],
) -> Result<()> {
    for name in optional {
        let path = folder.join(name);
        if fs::symlink_metadata(&path).is_ok() && !owned.has(folder, name) {
            let why =
                "is not as an earlier fit left it, and would be lost; move it away, or choose another --out";
            return Err(Error::Protected { path, why: why.into() });
        }
    }
    let left = owned.names().filter(|name| !names.iter().any(|other| other == name));
    for name in left.filter(|name| owned.has(folder, name)) {
        outputs::spare(&folder.join(name), inputs, "choose another --out")?;
    }
    Ok(())
}
