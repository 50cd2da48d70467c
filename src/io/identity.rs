//! Whether two paths lead to the same file.

use std::fs::{self, Metadata};
use std::path::Path;

/// Whether `a` and `b` are one file: by another spelling, a symbolic or a hard link. Two paths at which there is nothing yet
/// are the same where the same file would be made.
pub fn same(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(x), Ok(y)) => is_one(&x, &y) || same_place(a, b),
        (Err(_), Err(_)) => a == b || same_place(a, b),
        _ => false,
    }
}

/// Whether both lead to one place in one folder.
fn same_place(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let whole = fs::canonicalize(path).ok();
        whole.or_else(|| Some(fs::canonicalize(folder).ok()?.join(path.file_name()?)))
    };
    place(a).is_some_and(|a| place(b) == Some(a))
}

#[cfg(unix)]
pub(super) fn is_one(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// Elsewhere a hard link is not known for one.
#[cfg(not(unix))]
pub(super) fn is_one(_: &Metadata, _: &Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_a_path_are_one_file_and_copies_are_two() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::create_dir(at("folder")).unwrap();
        for name in ["a", "copy"] {
            fs::write(at(name), "x").unwrap();
        }
        assert!(same(&at("a"), &at("folder/../a")) && same(&at("new"), &at("folder/../new")));
        assert!(
            !same(&at("a"), &at("copy")) && !same(&at("a"), &at("new")) && !same(&at("new"), &at("newer"))
        );
        assert!(!same(&at("new"), &at("folder/new")));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_the_file_that_they_lead_to() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("a"), "x").unwrap();
        fs::hard_link(at("a"), at("hard")).unwrap();
        std::os::unix::fs::symlink("a", at("soft")).unwrap();
        std::os::unix::fs::symlink(".", at("round")).unwrap();
        for name in ["hard", "soft", "round/a", "round/round/soft"] {
            assert!(same(&at("a"), &at(name)), "{name}");
        }
        assert!(same(&at("new"), &at("round/new")) && !same(&at("other"), &at("round/new")));
    }
}
