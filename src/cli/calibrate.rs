//! `narrowbeam calibrate`: whether the error bars contain the truth as often as they should.

use super::aligned;
use super::console::answer;
use super::progress::Progress;
use crate::io::atomic;
use crate::lab::study::calibration::cases;
use anyhow::Result;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Noisy images of each setting
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(2..))]
    draws: u32,
    /// Seed of the noise
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Directory for calibration.csv
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print the numbers as JSON, alone on stdout
    #[arg(long)]
    json: bool,
}

/// How often the error bars of one parameter in one setting held the truth.
#[derive(Debug, Serialize)]
struct Row {
    setting: &'static str,
    model: &'static str,
    parameter: String,
    draws: usize,
    /// Intervals that hold the truth, and their share.
    inside: usize,
    share: f64,
    undetermined: usize,
    /// Cramér and Rao's bound of the standard error, and bias and rms error in units of it.
    bound: f64,
    bias: f64,
    rms: f64,
}

impl Row {
    fn cells(&self) -> Vec<String> {
        vec![
            self.setting.into(),
            self.model.into(),
            self.parameter.clone(),
            self.draws.to_string(),
            self.inside.to_string(),
            format!("{:.4}", self.share),
            self.undetermined.to_string(),
            format!("{:.2e}", self.bound),
            format!("{:.3}", self.bias),
            format!("{:.3}", self.rms),
        ]
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    let _folder = atomic::create_dir(&arguments.out)?;
    let file = arguments.out.join("calibration.csv");
    atomic::check_writable(&file)?;
    let (cases, draws) = (cases()?, arguments.draws as usize);
    let progress = Progress::new("calibrating", "fits", (cases.len() * draws) as u64);
    let head = [
        "setting",
        "model",
        "parameter",
        "draws",
        "inside",
        "share",
        "undetermined",
        "bound",
        "bias/bound",
        "rms/bound",
    ];
    let mut found = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        // Noise of its own for each setting.
        let seed = arguments.seed.wrapping_add((i as u64) << 16);
        for of in case.run(draws, seed, &|| progress.add(1))? {
            found.push(Row {
                setting: case.name,
                model: case.model.name(),
                share: of.share(),
                draws: of.draws,
                inside: of.inside,
                undetermined: of.undetermined,
                bound: of.bound,
                bias: of.bias,
                rms: of.rms,
                parameter: of.parameter,
            });
        }
    }
    drop(progress);
    let mut rows = vec![head.map(String::from).to_vec()];
    rows.extend(found.iter().map(Row::cells));
    let csv: String = rows.iter().map(|row| row.join(",").replace(", ", "; ") + "\n").collect();
    atomic::write(&file, csv.as_bytes())?;
    answer(arguments.json, &found, &aligned(&rows))?;
    Ok(ExitCode::SUCCESS)
}
