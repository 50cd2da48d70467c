//! `narrowbeam calibrate`: whether the error bars contain the truth as often as they should.

use super::aligned;
use super::console::say;
use super::progress::Progress;
use crate::io::atomic;
use crate::lab::study::calibration::cases;
use anyhow::Result;
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
    let mut rows = vec![head.map(String::from).to_vec()];
    for (i, case) in cases.iter().enumerate() {
        // Noise of its own for each setting.
        let seed = arguments.seed.wrapping_add((i as u64) << 16);
        for found in case.run(draws, seed, &|| progress.add(1))? {
            rows.push(vec![
                case.name.into(),
                case.model.name().into(),
                found.parameter.clone(),
                found.draws.to_string(),
                found.inside.to_string(),
                format!("{:.4}", found.share()),
                found.undetermined.to_string(),
                format!("{:.2e}", found.bound),
                format!("{:.3}", found.bias),
                format!("{:.3}", found.rms),
            ]);
        }
    }
    drop(progress);
    let csv: String = rows.iter().map(|row| row.join(",").replace(", ", "; ") + "\n").collect();
    atomic::write(&file, csv.as_bytes())?;
    say(&aligned(&rows));
    Ok(ExitCode::SUCCESS)
}
