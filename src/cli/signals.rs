//! Ctrl-C and SIGTERM: nothing unfinished stays behind, the terminal is cleared, and the exit code says what it was.
//!
//! A thread of its own waits for them, so that it does not matter what the others are at. It takes the list of what is
//! [unfinished](crate::io::temporary) and keeps it: results are put in their place before that, all of them, or not at all.

use super::progress;
use crate::io::temporary;

/// What a shell adds to the number of a signal that ended a command.
#[cfg(unix)]
const SIGNALLED: i32 = 128;

/// Begins to wait for signals. Where no thread can be started they end the process as they always do.
#[cfg(unix)]
pub(super) fn watch() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    let wait = || {
        let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
        if let Some(signal) = signals.forever().next() {
            temporary::abandon();
            progress::clear();
            // Without what a library wants to do at the end: other threads are still at work.
            signal_hook::low_level::exit(SIGNALLED + signal);
        }
    };
    let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
}

/// Other systems end the process as they always do.
#[cfg(not(unix))]
pub(super) fn watch() {}
