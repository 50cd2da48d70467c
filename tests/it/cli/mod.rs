//! The program as its users run it: exit codes, files, messages.

mod bad_input;
mod chart;
mod documents;
mod fit;
mod hostile;
#[cfg(unix)]
mod killed;
mod phase;
mod render;
#[cfg(unix)]
mod spared;
#[cfg(unix)]
mod streams;
mod studies;
mod synthesize;
mod table;
mod threads;
#[cfg(unix)]
mod whole;
pub(crate) mod workshop;
