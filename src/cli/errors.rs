//! What the command line adds to errors: the options concerned, and the exit code.

use super::console::warn;
use crate::error::Error;
use crate::fit::WarningCode;
use std::process::ExitCode;

/// Bad usage or input.
const USAGE: u8 = 2;

/// Options that contradict each other.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct Usage(pub String);

/// Prints `error` with the options concerned, and returns the exit code.
pub(super) fn report(error: &anyhow::Error) -> ExitCode {
    warn(&format!("narrowbeam: {}", worded(error)));
    match error.downcast_ref::<Error>() {
        Some(ours) if ours.is_usage() => ExitCode::from(USAGE),
        Some(Error::Write { .. }) => {
            warn("free some space, or write elsewhere, and run the same command again");
            ExitCode::FAILURE
        }
        _ if error.is::<Usage>() => ExitCode::from(USAGE),
        _ => ExitCode::FAILURE,
    }
}

fn worded(error: &anyhow::Error) -> String {
    match error.downcast_ref::<Error>() {
        Some(Error::NoAdapter) => format!("--backend gpu: {error}, or use --backend cpu"),
        Some(Error::Gpu(_)) => format!("{error}, or use --backend cpu"),
        Some(Error::Memory { .. } | Error::TooLarge { .. }) => format!("{error} (--memory)"),
        Some(Error::NoKernel) => format!("--model: {error}; use it with narrowbeam fit or render"),
        _ => error.to_string(),
    }
}

/// The keys and options by which a warning of this kind can be answered.
pub(super) fn answer(code: WarningCode) -> &'static str {
    match code {
        WarningCode::HiddenLight => " ([[object.layer]]; [observation] hidden_share_max)",
        WarningCode::ModelError | WarningCode::OutsideValidity => " (--model auto)",
        _ => "",
    }
}
