//! `narrowbeam stability`: where each method fails, and whether it says so.

mod pictures;

use super::progress::Progress;
use super::{aligned, say};
use crate::fit::NAMES;
use crate::io::atomic;
use crate::study::stability::{Tally, Trial, Verdict};
use crate::study::sweeps::{Extent, SWEEP_TRACES, grid, sweeps};
use anyhow::Result;
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
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    atomic::create_dir(&arguments.out)?;
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
    let Tally { fits, silent, right, wolves } = Tally::of(&trials);
    say(&format!(
        "{}{silent} of {fits} fits failed silently; {wolves} of {right} that are right, inside their model's validity and in \
         a world that is what the scene says, carry a warning\n",
        aligned(&summary(&trials))
    ))?;
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
            t.sweep,
            t.level,
            quote(&t.label),
            t.setting.tau(),
            (4.0 * t.setting.medium.shape).sqrt().to_degrees(),
            quote(&t.method.name()),
            o.model,
            quote(o.verdict().name()),
            o.warnings.join(" "),
            quote(o.refused.as_deref().unwrap_or("")),
            o.seconds
        );
        for found in &o.found {
            match found {
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

/// How often each method ended in which way, on the grid and on each sweep.
fn summary(trials: &[Trial]) -> Vec<Vec<String>> {
    let mut keys: Vec<(&str, String)> = Vec::new();
    for t in trials {
        let key = (t.sweep, t.method.name());
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    const ALL: [Verdict; 6] = [
        Verdict::Right,
        Verdict::Wolf,
        Verdict::Undetermined,
        Verdict::Warned,
        Verdict::Refused,
        Verdict::Silent,
    ];
    let head = ["sweep", "method", "fits", "intervals that hold the truth"];
    let head = head.into_iter().chain(ALL.map(Verdict::name)).map(String::from);
    let row = |(sweep, method): &(&str, String)| {
        let here: Vec<&Trial> =
            trials.iter().filter(|t| t.sweep == *sweep && t.method.name() == *method).collect();
        let count = |v: Verdict| here.iter().filter(|t| t.outcome.verdict() == v).count().to_string();
        let held: Vec<bool> = here.iter().flat_map(|t| t.outcome.found).flatten().map(|f| f.held).collect();
        let held = format!("{} of {}", held.iter().filter(|h| **h).count(), held.len());
        let start = [sweep.to_string(), method.clone(), here.len().to_string(), held];
        start.into_iter().chain(ALL.map(count)).collect()
    };
    std::iter::once(head.collect()).chain(keys.iter().map(row)).collect()
}
