//! `narrowbeam fit`: from observed scenes to a medium.

mod files;

use super::backend::Chosen;
use super::errors::{Usage, answer};
use super::names::WantedModel;
use super::options::{RenderOptions, TracingOptions, non_negative, positive, provenance};
use super::progress::Progress;
use super::{UNDETERMINED, aligned, say};
use crate::fit::{
    ChannelFit, Draws, Method, SceneFit, Settings, Severity, Ways, add_advice, bootstrap, check_scenes,
    filter_is_weak, fit_scenes, leave_out_tracing, profile, select, trace_instead, tracing_seconds,
};
use crate::io::atomic;
use crate::scene::ObservedScene;
use crate::spread::Model;
use anyhow::Result;
use files::{OUTPUTS, output, write};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scene files; several share one medium
    #[arg(required = true, value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    rendering: RenderOptions,
    #[command(flatten)]
    tracing: TracingOptions,
    /// Relative error of a parameter up to which --model auto accepts a cheaper model
    #[arg(long, default_value_t = 0.01, value_name = "X", value_parser = positive)]
    tolerance: f64,
    /// Seconds that --model auto may spend on traced paths where the filter's error decides; 0: none
    #[arg(long, default_value_t = 60.0, value_name = "SECONDS", value_parser = non_negative)]
    traced_limit: f64,
    /// Optimiser
    #[arg(long, value_enum, value_name = "NAME", default_value = "levenberg-marquardt")]
    solver: Method,
    /// Iterations after which a fit is abandoned
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..))]
    max_iterations: u64,
    /// Also find 95 % intervals by profile likelihood, for each free parameter
    #[arg(long)]
    profile: bool,
    /// Also find 95 % intervals by N refits of the best fit with new noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    bootstrap: usize,
    /// Directory for fit.json, render.exr, residual.exr, hidden_share.exr (if something is hidden) and pictures
    #[arg(long, default_value = "narrowbeam-fit", value_name = "DIR")]
    out: PathBuf,
    /// Print the report as JSON, alone on stdout
    #[arg(long)]
    json: bool,
}

/// Renders that a typical fit takes.
const TYPICAL_RENDERS: u64 = 40;
/// Those that confirm a fit by Gram matrices, where there is only one depth.
const CONFIRMING_RENDERS: u64 = 3;

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    arguments.tracing.check(&arguments.rendering)?;
    check_intervals(arguments)?;
    let scenes =
        arguments.scenes.iter().map(|path| ObservedScene::read(path)).collect::<crate::Result<Vec<_>>>()?;
    let of = scenes.iter().map(|observed| &observed.scene);
    let chosen = Chosen::new(arguments.rendering.backend, of, [CONFIRMING_RENDERS, TYPICAL_RENDERS])?;
    check_scenes(&scenes, &settings_of(arguments, &chosen))?;
    atomic::create_dir(&arguments.out)?;
    for i in 0..scenes.len() {
        for (name, kind) in OUTPUTS {
            atomic::check_writable(&output(arguments, scenes.len(), i, name, kind))?;
        }
    }
    atomic::check_writable(&arguments.out.join("fit.json"))?;
    let all: Vec<_> = scenes.iter().map(|observed| &observed.scene).collect();
    if let Some(why) = chosen.long(&all, [CONFIRMING_RENDERS, TYPICAL_RENDERS]) {
        // A broken stderr changes nothing.
        let _ = writeln!(std::io::stderr(), "{why}");
    }
    let mut fit = estimate(arguments, &scenes, &chosen)?;
    add_intervals(arguments, &scenes, &chosen, &mut fit)?;
    advise(arguments, &scenes, &chosen, &mut fit)?;
    fit.report.backend.reason = Some(chosen.reason.clone());
    fit.report.command = provenance().into_iter().find(|(key, _)| key == "command").map(|(_, value)| value);
    write(arguments, &scenes, &fit, &chosen)?;
    print(arguments, &fit, &chosen)?;
    Ok(if fit.report.is_complete() { ExitCode::SUCCESS } else { ExitCode::from(UNDETERMINED) })
}

/// Refuses intervals that would not include the noise of traced paths.
fn check_intervals(arguments: &Arguments) -> Result<(), Usage> {
    let wanted = arguments.profile || arguments.bootstrap > 0;
    if wanted && arguments.rendering.model == WantedModel::This(Model::Traced) {
        let why = "--profile and --bootstrap do not include the noise of the paths of --model traced; its model_error does";
        return Err(Usage(why.into()));
    }
    Ok(())
}

fn settings_of<'a>(arguments: &Arguments, chosen: &'a Chosen) -> Settings<'a> {
    let model = match arguments.rendering.model {
        WantedModel::This(model) => model,
        // The least that any input needs.
        WantedModel::Auto => Model::SmallAngle,
    };
    Settings {
        model,
        backend: chosen.backend(),
        method: arguments.solver,
        max_iterations: arguments.max_iterations,
        gram: arguments.solver == Method::LevenbergMarquardt,
        tracing: arguments.tracing.tracing(),
    }
}

fn estimate(arguments: &Arguments, scenes: &[ObservedScene], chosen: &Chosen) -> crate::Result<SceneFit> {
    let renders = TYPICAL_RENDERS * (scenes.len() * scenes[0].scene.object.len()) as u64;
    let progress = match arguments.rendering.model {
        WantedModel::This(Model::Traced) => Progress::uncounted("tracing and fitting"),
        _ => Progress::new("fitting", "renders", renders),
    };
    let tick = || progress.add(1);
    let (settings, filter) = (settings_of(arguments, chosen), arguments.rendering.filter);
    match arguments.rendering.model {
        WantedModel::This(_) => fit_scenes(scenes, &settings, filter, &tick),
        WantedModel::Auto => {
            let fit = select(scenes, &settings, filter, arguments.tolerance, &tick)?;
            drop(progress);
            trace_if_weak(arguments, scenes, chosen, fit)
        }
    }
}

/// The fit by `traced` where the filter is the weak link, if that takes no longer than is allowed.
fn trace_if_weak(
    arguments: &Arguments,
    scenes: &[ObservedScene],
    chosen: &Chosen,
    mut fit: SceneFit,
) -> crate::Result<SceneFit> {
    if arguments.traced_limit == 0.0 || !filter_is_weak(&fit, scenes, arguments.tolerance) {
        return Ok(fit);
    }
    let settings = settings_of(arguments, chosen);
    let seconds = tracing_seconds(scenes, &settings, &fit)?;
    if seconds > arguments.traced_limit {
        leave_out_tracing(&mut fit, seconds);
        return Ok(fit);
    }
    // A broken stderr changes nothing.
    let _ = writeln!(
        std::io::stderr(),
        "the filter's error beside edges decides this fit: tracing paths instead, some {seconds:.0} s (--traced-limit)"
    );
    let progress = Progress::uncounted("tracing and fitting");
    let tick = || progress.add(1);
    trace_instead(scenes, &settings, arguments.rendering.filter, fit, &tick)
}

/// The intervals for `--profile` and `--bootstrap`.
fn add_intervals(
    arguments: &Arguments,
    scenes: &[ObservedScene],
    chosen: &Chosen,
    fit: &mut SceneFit,
) -> crate::Result<()> {
    let filter = arguments.rendering.filter;
    let settings = |channel: &ChannelFit| Settings { model: channel.model, ..settings_of(arguments, chosen) };
    if arguments.profile {
        let progress = Progress::uncounted("profile likelihood");
        fit.add_intervals(Ways::Profile, scenes, filter, |observations, channel, options| {
            profile(observations, channel, options, &settings(channel), &|| progress.add(1))
        })?;
    }
    if arguments.bootstrap > 0 {
        let refits = (arguments.bootstrap * scenes[0].scene.object.len()) as u64;
        let progress = Progress::new("bootstrap", "fits", refits);
        let draws = Draws { count: arguments.bootstrap, seed: arguments.tracing.seed };
        fit.add_intervals(Ways::Bootstrap, scenes, filter, |observations, channel, options| {
            bootstrap(observations, channel, options, &settings(channel), draws, &|| progress.add(1))
        })?;
    }
    Ok(())
}

/// The measurements that would determine what is undetermined, if something is.
fn advise(
    arguments: &Arguments,
    scenes: &[ObservedScene],
    chosen: &Chosen,
    fit: &mut SceneFit,
) -> crate::Result<()> {
    let progress = Progress::uncounted("computing what would determine more");
    let settings = settings_of(arguments, chosen);
    add_advice(fit, scenes, &settings, arguments.rendering.filter, &|| progress.add(1))
}

/// The table for people goes to stdout, or to stderr if stdout is for the JSON.
fn print(arguments: &Arguments, fit: &SceneFit, chosen: &Chosen) -> Result<()> {
    let report = &fit.report;
    let mut text = aligned(&report.table("1/length"));
    report.remarks().iter().for_each(|line| text += &format!("{line}\n"));
    text += &format!("{}\n", how_it_went(arguments, fit, chosen));
    report.candidates.iter().for_each(|candidate| text += &format!("{}\n", candidate.line()));
    if arguments.json {
        eprint!("{text}");
        say(&format!("{}\n", serde_json::to_string_pretty(report)?))?;
    } else {
        say(&text)?;
    }
    for warning in &report.warnings {
        let severity = if warning.severity == Severity::Invalid { "invalid" } else { "warning" };
        eprintln!("{severity} ({}): {}{}", warning.code, warning.message, answer(warning.code));
    }
    Ok(())
}

fn how_it_went(arguments: &Arguments, fit: &SceneFit, chosen: &Chosen) -> String {
    let (report, summary) = (&fit.report, &fit.report.fit);
    let left_out = if fit.hides() {
        let all = summary.hidden_pixels + summary.pixels;
        format!(", {} of {all} pixels left out for hidden light", summary.hidden_pixels)
    } else {
        String::new()
    };
    let by_gram = if summary.path == "sums" {
        format!("{} evaluations by sums and ", summary.sum_evaluations)
    } else {
        String::new()
    };
    format!(
        "{}, {} on {}: reduced chi² {:.3} over {} pixels{left_out}, {} iterations, {by_gram}{} renders, {:.3} s; \
         report in {}",
        report.model,
        report.filter,
        chosen.describe(),
        summary.reduced_chi2,
        summary.pixels,
        summary.iterations,
        summary.evaluations,
        summary.seconds,
        arguments.out.display()
    )
}
