//! The one place that writes to standard output and to standard error.
//!
//! A stream that is closed, or full, changes nothing of what a command does, nor of how it ends. Of one that is full the other
//! stream tells.

use serde::Serialize;
use std::io::{self, Write};
use std::sync::atomic::{AtomicU8, Ordering};

/// How much a command tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Level {
    /// Warnings, errors, and what `--json` asks for.
    Quiet,
    Normal,
    /// Also what it reads, writes and computes with.
    Verbose,
}

static LEVEL: AtomicU8 = AtomicU8::new(Level::Normal as u8);

pub(super) fn set_level(level: Level) {
    LEVEL.store(level as u8, Ordering::Relaxed);
}

/// Whether so much is to be told.
pub(super) fn tells(level: Level) -> bool {
    LEVEL.load(Ordering::Relaxed) >= level as u8
}

/// Prints the result of a command for people.
pub(super) fn say(text: &str) {
    if tells(Level::Normal) {
        print(text);
    }
}

/// Prints the result of a command: `text` for people or, if `json` is asked for, `numbers` for programs beside it.
pub(super) fn answer(json: bool, numbers: &impl Serialize, text: &str) -> serde_json::Result<()> {
    if json {
        say_json(&serde_json::to_string_pretty(numbers)?, text);
    } else {
        say(text);
    }
    Ok(())
}

/// Prints what programs read, whatever the level, alone on standard output; the `text` for people goes to standard error.
fn say_json(json: &str, text: &str) {
    if tells(Level::Normal) {
        write(&mut io::stderr(), text);
    }
    print(&format!("{json}\n"));
}

/// Prints a line about how the work goes.
pub(super) fn note(line: &str) {
    if tells(Level::Normal) {
        warn(line);
    }
}

/// Prints a line for those who want to know more.
pub(super) fn detail(line: impl FnOnce() -> String) {
    if tells(Level::Verbose) {
        warn(&line());
    }
}

/// Prints a warning or an error, whatever the level.
pub(super) fn warn(line: &str) {
    write(&mut io::stderr(), &format!("{line}\n"));
}

/// Prints what programs read, whatever the level.
pub(super) fn print(text: &str) {
    if let Some(error) = write(&mut io::stdout(), text) {
        warn(&format!("narrowbeam: standard output: cannot be written: {error}"));
    }
}

/// What went wrong, unless it is that nobody reads.
fn write(stream: &mut dyn Write, text: &str) -> Option<io::Error> {
    let done = stream.write_all(text.as_bytes()).and_then(|()| stream.flush());
    done.err().filter(|error| error.kind() != io::ErrorKind::BrokenPipe)
}

/// Does `work`, and keeps to itself what the graphics loader has to say of a machine without a desktop. All else that is
/// written to standard error meanwhile comes after it.
pub(super) fn without_loader_noise<T>(work: impl FnOnce() -> T) -> T {
    #[cfg(target_os = "linux")]
    let _caught = caught::Stderr::catch();
    work()
}

#[cfg(target_os = "linux")]
mod caught {
    use rustix::fs::{MemfdFlags, memfd_create};
    use rustix::stdio::dup2_stderr;
    use std::fs::File;
    use std::io::{self, Read, Seek};
    use std::os::fd::{AsFd, OwnedFd};

    /// What the loader's complaint is about.
    const NOISE: &str = "XDG_RUNTIME_DIR";

    /// Standard error as it was, and what takes its place.
    pub(super) struct Stderr {
        real: OwnedFd,
        caught: File,
    }

    impl Stderr {
        /// Catches what is written to standard error until this value is dropped; `None` if the system does not let it.
        pub(super) fn catch() -> Option<Self> {
            let real = io::stderr().as_fd().try_clone_to_owned().ok()?;
            let caught = File::from(memfd_create("stderr", MemfdFlags::CLOEXEC).ok()?);
            dup2_stderr(&caught).ok()?;
            Some(Self { real, caught })
        }

        /// What was caught so far, without the noise.
        fn text(&mut self) -> String {
            let mut text = Vec::new();
            let _ = self.caught.rewind().and_then(|()| self.caught.read_to_end(&mut text));
            let text = String::from_utf8_lossy(&text);
            text.lines().filter(|line| !line.contains(NOISE)).map(|line| format!("{line}\n")).collect()
        }
    }

    impl Drop for Stderr {
        fn drop(&mut self) {
            if dup2_stderr(&self.real).is_err() {
                return;
            }
            let text = self.text();
            super::write(&mut io::stderr(), &text);
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;
        use std::io::Write;

        #[test]
        fn the_loader_is_silenced_and_nobody_else() {
            let mut caught = Stderr::catch().unwrap();
            let lines = "error: XDG_RUNTIME_DIR is invalid or not set in the environment.\nof another kind\n";
            io::stderr().write_all(lines.as_bytes()).unwrap();
            let text = caught.text();
            drop(caught);
            assert!(text.contains("of another kind") && !text.contains(NOISE), "{text}");
        }
    }
}
