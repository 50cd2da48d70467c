//! `narrowbeam stability`: where each method fails, and whether it reports that.

mod pictures;

use super::aligned;
use super::console::answer;
use super::progress::Progress;
use crate::fit::WarningCode;
use crate::forward::Quantity;
use crate::io::atomic;
use crate::lab::study::grid::{Extent, grid};
use crate::lab::study::stability::OutcomeKind;
use crate::lab::study::sweeps::{SWEEP_TRACES, sweeps};
use crate::lab::study::trial::{Tally, Trial};
use crate::phase::PhaseFunction;
use anyhow::Result;
use indexmap::IndexMap;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Directory for stability.csv and the maps
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seed of tracing and noise
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// A coarse look in half a minute
    #[arg(long)]
    quick: bool,
    /// Print the numbers as JSON, alone on stdout
    #[arg(long)]
    json: bool,
}

/// What came of all trials.
#[derive(Debug, Serialize)]
struct Summary {
    fits: usize,
    /// Fits that were wrong without a warning.
    silent: usize,
    /// Fits that are right, inside their model's range, with a scene file that is right; and those that carry a warning.
    right: usize,
    false_alarms: usize,
    methods: Vec<Counted>,
}

/// What came of one method on the grid, or on one sweep.
#[derive(Debug, Serialize)]
struct Counted {
    sweep: &'static str,
    method: String,
    fits: usize,
    /// Intervals, and those among them that hold the truth.
    intervals: usize,
    held: usize,
    /// Fits by what came of them.
    outcomes: IndexMap<&'static str, usize>,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    let _folder = atomic::create_dir(&arguments.out)?;
    let file = arguments.out.join("stability.csv");
    for name in pictures::FILES {
        atomic::check_writable(&arguments.out.join(name))?;
    }
    atomic::check_writable(&file)?;
    let extent = if arguments.quick { Extent::quick() } else { Extent::full() };
    let images = (extent.tau.len() * extent.spread_angle_deg.len()) as u64 + SWEEP_TRACES;
    let progress = Progress::new("mapping", "images", images);
    let tick = |n: u64| progress.add(n);
    let mut trials = grid(&extent, arguments.seed, &tick)?;
    trials.extend(sweeps(&extent, arguments.seed, &tick)?);
    drop(progress);
    atomic::write(&file, csv(&trials).as_bytes())?;
    pictures::write(&arguments.out, &trials, &extent)?;
    let Tally { fits, silent, right, false_alarms } = Tally::of(&trials);
    let summary = Summary { fits, silent, right, false_alarms, methods: counted(&trials) };
    let text = format!(
        "{}{silent} of {fits} fits failed silently; {false_alarms} of {right} that are right, inside their model's range and with \
         a scene file that is right, carry a warning\n",
        aligned(&rows(&summary.methods))
    );
    answer(arguments.json, &summary, &text)?;
    Ok(ExitCode::SUCCESS)
}

fn csv(trials: &[Trial]) -> String {
    let mut text =
        String::from("sweep,level,label,tau,spread_angle_deg,method,model,verdict,warnings,refused,seconds");
    for name in NAMES {
        text += &format!(",error_{name},std_error_{name},model_error_{name},held_{name}");
    }
    text.push('\n');
    let quote = |t: &str| t.replace([',', '\n'], ";");
    for t in trials {
        let o = &t.outcome;
        text += &format!(
            "{},{},{},{},{:.1},{},{},{},{},{},{:.4}",
            t.place.sweep,
            t.place.level,
            quote(&t.place.label),
            t.setting.tau(),
            (4.0 * t.setting.medium.phase().parameter()).sqrt().to_degrees(),
            quote(&t.method.name()),
            o.model,
            quote(o.kind().name()),
            names(&o.warnings),
            quote(o.refused.as_deref().unwrap_or("")),
            o.seconds
        );
        for quantity in Quantity::MEDIUM {
            match o.of(quantity) {
                Some(f) => {
                    text += &format!(",{:.3e},{:.3e},{:.3e},{}", f.error, f.std_error, f.model_error, f.held);
                }
                None => text += ",,,,",
            }
        }
        text.push('\n');
    }
    text
}

/// Columns of the parameters of [`Quantity::MEDIUM`].
const NAMES: [&str; 3] = ["sigma_s", "sigma_a", "b"];

fn names(codes: &[WarningCode]) -> String {
    codes.iter().map(|code| code.name()).collect::<Vec<_>>().join(" ")
}

const KINDS: [OutcomeKind; 6] = [
    OutcomeKind::Right,
    OutcomeKind::FalseAlarm,
    OutcomeKind::Undetermined,
    OutcomeKind::Warned,
    OutcomeKind::Refused,
    OutcomeKind::Silent,
];

/// How often each method had each kind of outcome, on the grid and on each sweep.
fn counted(trials: &[Trial]) -> Vec<Counted> {
    let mut keys: Vec<(&'static str, String)> = Vec::new();
    for t in trials {
        let key = (t.place.sweep, t.method.name());
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let count = |(sweep, method): (&'static str, String)| {
        let here: Vec<&Trial> =
            trials.iter().filter(|t| t.place.sweep == sweep && t.method.name() == method).collect();
        let of = |kind: OutcomeKind| here.iter().filter(|t| t.outcome.kind() == kind).count();
        let held: Vec<bool> = here.iter().flat_map(|t| &t.outcome.found).map(|f| f.held).collect();
        Counted {
            sweep,
            method,
            fits: here.len(),
            intervals: held.len(),
            held: held.iter().filter(|h| **h).count(),
            outcomes: KINDS.map(|kind| (kind.name(), of(kind))).into_iter().collect(),
        }
    };
    keys.into_iter().map(count).collect()
}

/// The same as rows for people.
fn rows(methods: &[Counted]) -> Vec<Vec<String>> {
    let head = ["sweep", "method", "fits", "intervals that contain the truth"];
    let head = head.into_iter().chain(KINDS.map(OutcomeKind::name)).map(String::from);
    let row = |c: &Counted| {
        let held = format!("{} of {}", c.held, c.intervals);
        let start = [c.sweep.to_string(), c.method.clone(), c.fits.to_string(), held];
        start.into_iter().chain(c.outcomes.values().map(usize::to_string)).collect()
    };
    std::iter::once(head.collect()).chain(methods.iter().map(row)).collect()
}
