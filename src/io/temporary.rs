//! What exists only while a command works: parts of files and of folders, and folders in which there is nothing yet.
//!
//! A part is named `.NAME.PID-COUNT.part`, after what it becomes and beside it. Its maker holds a lock on it, which the system
//! releases when the process ends, in whatever way: a part that nobody holds is left over from a dead run, and is removed by
//! the next one that writes to the same place.
//!
//! Everything that a signal must remove stands in one list. Whatever is made, renamed or removed is so while that list is
//! locked, so that a process that ends by a signal leaves nothing behind, and nothing half done.

use super::identity::is_one;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a signal removes.
#[derive(Debug, PartialEq)]
enum Unfinished {
    Part(PathBuf),
    /// A new folder, which stays if there is something in it.
    Folder(PathBuf),
}

impl Unfinished {
    fn discard(&self) {
        // What cannot be removed, or is gone, cannot be helped.
        let _ = match self {
            Self::Part(path) => remove_all(path),
            Self::Folder(path) => fs::remove_dir(path),
        };
    }
}

static UNFINISHED: Mutex<Vec<Unfinished>> = Mutex::new(Vec::new());

/// Distinguishes the parts of one process.
static COUNTER: AtomicU64 = AtomicU64::new(0);

fn unfinished() -> MutexGuard<'static, Vec<Unfinished>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes whatever is unfinished. Nothing new can be begun, renamed or removed after it: it is for a process that ends.
pub fn abandon() {
    let list = unfinished();
    list.iter().rev().for_each(Unfinished::discard);
    std::mem::forget(list);
}

/// A file or a folder on its way; it is removed with this value unless it was put in its place.
#[derive(Debug)]
pub struct Part {
    path: PathBuf,
    /// Holds the lock; a system that opens no folder, or locks none, has no lock on it.
    file: Option<File>,
}

impl Part {
    /// An empty file beside `target`.
    ///
    /// # Errors
    /// What the system says.
    pub fn file(target: &Path) -> io::Result<Self> {
        let make = |path: &Path| fs::OpenOptions::new().write(true).create_new(true).open(path).map(Some);
        Self::make(target.parent().unwrap_or(Path::new("")), target.file_name().unwrap_or_default(), make)
    }

    /// An empty folder in `parent`, which is to be called `name`.
    ///
    /// # Errors
    /// What the system says.
    pub fn folder(parent: &Path, name: &OsStr) -> io::Result<Self> {
        Self::make(parent, name, |path| fs::create_dir(path).map(|()| File::open(path).ok()))
    }

    fn make(
        parent: &Path,
        name: &OsStr,
        make: impl Fn(&Path) -> io::Result<Option<File>>,
    ) -> io::Result<Self> {
        loop {
            let count = COUNTER.fetch_add(1, Ordering::Relaxed);
            let id = std::process::id();
            let path = parent.join(format!(".{}.{id}-{count}.part", name.to_string_lossy()));
            let mut list = unfinished();
            let file = match make(&path) {
                // Of an earlier process of this number.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => continue,
                made => made?,
            };
            // Whoever removes what dead runs have left may have been quicker with the lock, and takes it away.
            if file.as_ref().is_none_or(|file| file.try_lock().is_ok() && is_at(file, &path) || !locks(file))
            {
                list.push(Unfinished::Part(path.clone()));
                return Ok(Self { path, file });
            }
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes `bytes` to a file, through to the disk.
    ///
    /// # Errors
    /// What the system says.
    pub fn fill(&mut self, bytes: &[u8]) -> io::Result<()> {
        let file = self.file.as_mut().ok_or(io::ErrorKind::IsADirectory)?;
        file.write_all(bytes)?;
        file.sync_all()
    }

    /// Puts it in the place of `target`, and sees to it that it stays there if the power fails.
    ///
    /// # Errors
    /// What the system says.
    pub fn put(self, target: &Path) -> io::Result<()> {
        undisturbed(|| fs::rename(&self.path, target))?;
        sync_folder(target);
        Ok(())
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let this = Unfinished::Part(std::mem::take(&mut self.path));
        let mut list = unfinished();
        this.discard();
        list.retain(|other| *other != this);
    }
}

#[must_use = "empty folders vanish with it"]
/// Folders that were made for results. Those that are still empty when this value is dropped are removed.
#[derive(Debug)]
pub struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    /// Makes the folder `path` and those above it, as far as they do not exist.
    ///
    /// # Errors
    /// What the system says.
    pub fn make(path: &Path) -> io::Result<Self> {
        let missing = |path: &&Path| !path.as_os_str().is_empty() && !path.is_dir();
        let missing: Vec<&Path> = path.ancestors().take_while(missing).collect();
        let mut made = Self(Vec::new());
        for folder in missing.into_iter().rev() {
            let mut list = unfinished();
            match fs::create_dir(folder) {
                Ok(()) => {
                    list.push(Unfinished::Folder(folder.to_path_buf()));
                    made.0.push(folder.to_path_buf());
                }
                // Made by someone else in between.
                Err(_) if folder.is_dir() => (),
                Err(e) => {
                    drop(list);
                    return Err(e);
                }
            }
        }
        Ok(made)
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        let mut list = unfinished();
        for folder in self.0.drain(..).rev().map(Unfinished::Folder) {
            folder.discard();
            list.retain(|other| *other != folder);
        }
    }
}

/// Does `work`, which makes no part, while no signal ends the process.
pub fn undisturbed<T>(work: impl FnOnce() -> T) -> T {
    let _list = unfinished();
    work()
}

/// Removes the parts in `folder` that dead runs have left of what is called one of `names`.
pub fn remove_stale(folder: &Path, names: &[&str]) {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let of_these = entries.filter(|entry| {
        let file_name = entry.file_name();
        part_of(&file_name.to_string_lossy()).is_some_and(|name| names.contains(&name))
    });
    for entry in of_these {
        let is_plain = entry.file_type().is_ok_and(|kind| kind.is_file() || kind.is_dir());
        let Some(file) = File::open(entry.path()).ok().filter(|_| is_plain) else { continue };
        if file.try_lock().is_ok() {
            Unfinished::Part(entry.path()).discard();
        }
    }
}

/// What the part of this name becomes.
pub fn part_of(file_name: &str) -> Option<&str> {
    let (name, id) = file_name.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.')?;
    let (process, count) = id.split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (is_number(process) && is_number(count)).then_some(name)
}

/// Sees to it that what was put at `path` stays there if the power fails. Systems that cannot do so for a folder do it unasked.
pub fn sync_folder(path: &Path) {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

fn remove_all(path: &Path) -> io::Result<()> {
    if fs::symlink_metadata(path)?.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) }
}

/// Whether the open `file` is still that at `path`.
fn is_at(file: &File, path: &Path) -> bool {
    let now = fs::symlink_metadata(path);
    now.is_ok_and(|now| file.metadata().is_ok_and(|then| !cfg!(unix) || is_one(&then, &now)))
}

/// Whether files of this kind can be locked at all: the error of one that is locked says so.
fn locks(file: &File) -> bool {
    !matches!(file.try_lock(), Err(fs::TryLockError::Error(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn a_part_vanishes_unless_it_is_put_in_its_place() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a.txt");
        let mut part = Part::file(&target).unwrap();
        part.fill(b"x").unwrap();
        assert_eq!(part_of(part.path().file_name().unwrap().to_str().unwrap()), Some("a.txt"));
        drop(part);
        assert_eq!(count(dir.path()), 0);
        let mut part = Part::file(&target).unwrap();
        part.fill(b"x").unwrap();
        part.put(&target).unwrap();
        assert_eq!((fs::read(&target).unwrap(), count(dir.path())), (b"x".to_vec(), 1));
        let folder = Part::folder(dir.path(), OsStr::new("out")).unwrap();
        fs::write(folder.path().join("b"), "x").unwrap();
        drop(folder);
        assert_eq!(count(dir.path()), 1);
    }

    #[cfg(unix)]
    #[test]
    fn what_dead_runs_have_left_is_removed_and_what_is_held_is_not() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        for name in [".a.txt.1-2.part", ".a.txt.part", ".b.txt.1-2.part", ".a.txt.x-2.part", "a.txt.1-2.part"]
        {
            fs::write(at(name), "x").unwrap();
        }
        fs::create_dir(at(".a.txt.3-4.part")).unwrap();
        fs::write(at(".a.txt.3-4.part/within"), "x").unwrap();
        let held =
            [Part::file(&at("a.txt")).unwrap(), Part::folder(dir.path(), OsStr::new("a.txt")).unwrap()];
        remove_stale(dir.path(), &["a.txt"]);
        assert!(held.iter().all(|part| part.path().exists()));
        assert!(!at(".a.txt.1-2.part").exists() && !at(".a.txt.3-4.part").exists());
        drop(held);
        assert_eq!(count(dir.path()), 4);
    }

    #[test]
    fn new_folders_stay_if_something_is_in_them() {
        let dir = tempfile::tempdir().unwrap();
        let deep = dir.path().join("a/b/c");
        drop(NewFolders::make(&deep).unwrap());
        assert_eq!(count(dir.path()), 0);
        let made = NewFolders::make(&deep).unwrap();
        fs::write(dir.path().join("a/x"), "x").unwrap();
        drop(made);
        assert!(dir.path().join("a/x").exists() && !dir.path().join("a/b").exists());
        fs::create_dir(dir.path().join("old")).unwrap();
        drop(NewFolders::make(&dir.path().join("old")).unwrap());
        assert!(dir.path().join("old").exists());
        assert!(NewFolders::make(&dir.path().join("a/x/y")).is_err());
    }
}
