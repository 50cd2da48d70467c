//! Putting a set of results in its place: the whole folder in one step, or file by file.

use super::owned::Owned;
use super::{REPORT, undisturbed};
use crate::io::atomic::{self, Target};
use crate::io::temporary::{Part, sync_folder};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Whether another folder may take the place of `folder`: not if it is a link, a mount point or someone else's, nor if this
/// process is in it.
pub(super) fn is_replaceable(folder: &Path) -> bool {
    let is_link = fs::symlink_metadata(folder).map_or(true, |found| found.is_symlink());
    let is_here = || {
        let here = std::env::current_dir().and_then(fs::canonicalize);
        let whole = fs::canonicalize(folder);
        here.is_ok_and(|here| whole.is_ok_and(|whole| here.starts_with(whole)))
    };
    !is_link && folder.file_name().is_some() && !is_here() && is_of_its_parent(folder)
}

#[cfg(unix)]
fn is_of_its_parent(folder: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let parent = folder.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let device = |path: &Path| fs::metadata(path).map(|found| found.dev());
    device(folder).is_ok_and(|inner| device(parent).is_ok_and(|outer| inner == outer))
}

#[cfg(not(unix))]
fn is_of_its_parent(_: &Path) -> bool {
    true
}

/// Names of the files in `folder`, in order.
pub(super) fn names_in(folder: &Path) -> io::Result<Vec<String>> {
    let name = |entry: io::Result<fs::DirEntry>| Ok(entry?.file_name().to_string_lossy().into_owned());
    let mut names = fs::read_dir(folder)?.map(name).collect::<io::Result<Vec<_>>>()?;
    names.sort_unstable();
    Ok(names)
}

/// Puts the folder `part` in the place of `folder`, of which all is ours or has one of the `names`.
///
/// # Errors
/// If that is not possible in one step; nothing has changed then.
pub(super) fn replace(part: &Part, folder: &Path, names: &[String], owned: &Owned) -> io::Result<()> {
    sync_folder(&part.path().join(REPORT));
    let is_beside = part.path().parent() != Some(folder);
    match fs::symlink_metadata(folder) {
        Err(e) if e.kind() == io::ErrorKind::NotFound && is_beside => {
            undisturbed(|| fs::rename(part.path(), folder))?;
        }
        Err(e) => return Err(e),
        Ok(old) => {
            if !is_beside || !is_replaceable(folder) || !all_is_ours(folder, names, owned)? {
                return Err(io::ErrorKind::DirectoryNotEmpty.into());
            }
            is_of_one(&old, &fs::metadata(part.path())?)?;
            fs::set_permissions(part.path(), old.permissions())?;
            undisturbed(|| exchange(part.path(), folder))?;
            give_back(part.path(), folder, names, owned);
        }
    }
    sync_folder(folder);
    Ok(())
}

#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(unix)]
fn is_of_one(old: &fs::Metadata, new: &fs::Metadata) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let same = (old.uid(), old.gid()) == (new.uid(), new.gid());
    if same { Ok(()) } else { Err(io::ErrorKind::PermissionDenied.into()) }
}

#[cfg(not(unix))]
fn is_of_one(_: &fs::Metadata, _: &fs::Metadata) -> io::Result<()> {
    Ok(())
}

fn all_is_ours(folder: &Path, names: &[String], owned: &Owned) -> io::Result<bool> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let is_ours = |name: &str| names.iter().any(|known| known == name) || owned.has(folder, name);
        if !entry.file_type()?.is_file() || !name.to_str().is_some_and(is_ours) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Gives `folder` what came into the `old` one after all in it was found to be ours.
fn give_back(old: &Path, folder: &Path, names: &[String], owned: &Owned) {
    for name in names_in(old).unwrap_or_default() {
        let is_ours = names.contains(&name) || owned.has(old, &name);
        if !is_ours && fs::symlink_metadata(folder.join(&name)).is_err() {
            // What cannot be moved is lost with the folder that it was put into a moment ago.
            let _ = fs::rename(old.join(&name), folder.join(&name));
        }
    }
}

/// Puts the files of `part` into `folder` one by one, removes what an earlier fit has left and this one has not, and puts the
/// report last.
///
/// # Errors
/// What the system says; what is there then is not what the report there says.
pub(super) fn one_by_one(part: &Part, folder: &Path, owned: &Owned) -> io::Result<()> {
    let names = names_in(part.path())?;
    let left: Vec<&str> = owned.names().filter(|left| !names.iter().any(|name| name == left)).collect();
    let left: Vec<PathBuf> =
        left.into_iter().filter(|name| owned.has(folder, name)).map(|name| folder.join(name)).collect();
    let steps = names.iter().map(|name| Step::new(part, folder, name)).collect::<io::Result<Vec<_>>>()?;
    let (report, others): (Vec<_>, Vec<_>) = steps.into_iter().partition(|step| step.is_report);
    undisturbed(|| {
        others.iter().try_for_each(Step::take)?;
        left.iter().try_for_each(fs::remove_file)?;
        sync_folder(&folder.join(REPORT));
        report.iter().try_for_each(Step::take)
    })?;
    sync_folder(&folder.join(REPORT));
    Ok(())
}

/// One file to be renamed.
struct Step {
    from: PathBuf,
    /// Where to; `None` for what was written directly, a pipe or a device.
    to: Option<PathBuf>,
    is_report: bool,
    /// A copy beside the file to which a link leads.
    _copy: Option<Part>,
}

impl Step {
    fn new(part: &Part, folder: &Path, name: &str) -> io::Result<Self> {
        let (from, path, is_report) = (part.path().join(name), folder.join(name), name == REPORT);
        match atomic::target(&path)? {
            Target::Special => {
                fs::write(&path, fs::read(&from)?)?;
                Ok(Self { from, to: None, is_report, _copy: None })
            }
            Target::File(to) if fs::symlink_metadata(&path).is_ok_and(|found| found.is_symlink()) => {
                let copy = atomic::filled(&to, &fs::read(&from)?)?;
                Ok(Self { from: copy.path().to_path_buf(), to: Some(to), is_report, _copy: Some(copy) })
            }
            Target::File(to) => {
                if let Ok(old) = fs::metadata(&to) {
                    fs::set_permissions(&from, old.permissions())?;
                }
                Ok(Self { from, to: Some(to), is_report, _copy: None })
            }
        }
    }

    fn take(&self) -> io::Result<()> {
        self.to.as_ref().map_or(Ok(()), |to| fs::rename(&self.from, to))
    }
}
