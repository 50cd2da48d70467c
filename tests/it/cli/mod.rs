//! The program as its users run it: exit codes, files, messages.

mod bad_input;
mod chart;
mod fit;
mod hostile;
mod phase;
mod render;
mod studies;
mod synthesize;
mod table;
pub(crate) mod workshop;
