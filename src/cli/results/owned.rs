//! Which files of a folder an earlier fit has left: those that a report names, with their SHA-256.

use super::{REPORT, WITHIN, sha256};
use crate::io::temporary::part_of;
use indexmap::IndexMap;
use serde::Deserialize;
use std::fs;
use std::path::{Component, Path};

/// What a report says of the files of its set.
#[derive(Deserialize)]
struct Manifest {
    #[serde(default)]
    files: IndexMap<String, String>,
}

/// Names and hashes, by the report of a folder and by those of runs that died while they put their files there.
pub(super) struct Owned(Vec<(String, String)>);

impl Owned {
    pub(super) fn read(folder: &Path) -> Self {
        let reports = [folder.join(REPORT)].into_iter().chain(died(folder));
        let read = |report| serde_json::from_slice::<Manifest>(&fs::read(report).ok()?).ok();
        let files = reports.filter_map(read).flat_map(|manifest| manifest.files);
        // No report may speak of another folder.
        Self(files.filter(|(name, _)| is_plain(name)).collect())
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// Whether the file `name` of `folder` is as a report says.
    pub(super) fn has(&self, folder: &Path, name: &str) -> bool {
        let mut hashes = self.0.iter().filter(|(known, _)| known == name).map(|(_, hash)| hash).peekable();
        let path = folder.join(name);
        let is_file = || fs::symlink_metadata(&path).is_ok_and(|found| found.is_file());
        hashes.peek().is_some() && is_file() && {
            let hash = sha256(&path).ok();
            hashes.any(|known| Some(known) == hash.as_ref())
        }
    }
}

/// Reports in the parts that are left in `folder`, and beside it.
fn died(folder: &Path) -> Vec<std::path::PathBuf> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let parent = folder.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let parts = |place: &Path, of: &str| -> Vec<_> {
        let entries = fs::read_dir(place).into_iter().flatten().flatten();
        let is_part = |file_name: &str| part_of(file_name) == Some(of);
        entries.filter(|e| is_part(&e.file_name().to_string_lossy())).map(|e| e.path().join(REPORT)).collect()
    };
    [parts(folder, WITHIN), parts(parent, &name)].concat()
}

fn is_plain(name: &str) -> bool {
    let mut components = Path::new(name).components();
    matches!((components.next(), components.next()), (Some(Component::Normal(_)), None))
}
