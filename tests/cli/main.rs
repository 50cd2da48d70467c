//! The program as its users run it: exit codes, files, messages.

mod bad_input;
mod fit;
mod phase;
mod render;
mod studies;
mod synthesize;
mod workshop;

#[path = "../common/program.rs"]
mod program;
