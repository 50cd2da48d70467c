//! `narrowbeam fit`: from observed scenes to a medium.

mod files;

use super::backend::Chosen;
use super::console::{self, detail, note, warn};
use super::errors::{Usage, answer};
use super::names::WantedModel;
use super::options::{RenderOptions, TracingOptions, non_negative, positive};
use super::progress::Progress;
use super::record;
use super::results::{REPORT, Results};
use super::{UNDETERMINED, aligned};
use crate::error::Error;
use crate::fit::{
    ChannelFit, Draws, Fit, InputFile, Method, Provenance, ResolvedSettings, SceneFit, Settings, Severity,
    Ways, add_advice, bootstrap, check_scenes, filter_is_weak, fit_scenes, free_camera, leave_out_tracing,
    profile, select, trace_instead, tracing_seconds,
};
use crate::scene::ObservedScene;
use crate::spread::Model;
use anyhow::Result;
use files::{HIDDEN_SHARE, OUTPUTS, output, write};
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
    let mut scenes =
        arguments.scenes.iter().map(|path| ObservedScene::read(path)).collect::<crate::Result<Vec<_>>>()?;
    let of = scenes.iter().map(|observed| &observed.scene);
    let chosen = Chosen::new(arguments.rendering.backend, of, [CONFIRMING_RENDERS, TYPICAL_RENDERS])?;
    check_scenes(&scenes, &settings_of(arguments, &chosen))?;
    let inputs = scenes.iter().flat_map(|observed| observed.scene.files.clone()).collect::<Vec<_>>();
    record::tell_inputs(&inputs);
    let results = begin(arguments, scenes.len(), &inputs)?;
    let read = record::inputs(&inputs);
    detail(|| format!("computing on {}, to be written to {}", chosen.describe(), arguments.out.display()));
    let all: Vec<_> = scenes.iter().map(|observed| &observed.scene).collect();
    if let Some(why) = chosen.long(&all, [CONFIRMING_RENDERS, TYPICAL_RENDERS]) {
        note(&why);
    }
    let mut fit = estimate(arguments, &mut scenes, &chosen)?;
    add_intervals(arguments, &scenes, &chosen, &mut fit)?;
    advise(arguments, &scenes, &chosen, &mut fit)?;
    fit.report.backend.reason = Some(chosen.reason.clone());
    fit.report.command = Some(record::arguments().join(" "));
    fit.report.provenance = Some(provenance(arguments, &fit.report, read));
    write(arguments, &results, &scenes, &mut fit, &chosen)?;
    results.commit()?;
    print(arguments, &fit, &chosen)?;
    Ok(if fit.report.is_complete() { ExitCode::SUCCESS } else { ExitCode::from(UNDETERMINED) })
}

/// Begins the set of results, which must not destroy what the fit reads.
fn begin(arguments: &Arguments, scenes: usize, inputs: &[PathBuf]) -> crate::Result<Results> {
    let of =
        |(name, kind): (&str, &str)| (0..scenes).map(|i| output(scenes, i, name, kind)).collect::<Vec<_>>();
    let mut names: Vec<String> = OUTPUTS.into_iter().flat_map(of).collect();
    names.push(REPORT.into());
    Results::begin(&arguments.out, names, &of(HIDDEN_SHARE), inputs)
}

fn provenance(arguments: &Arguments, report: &Fit, inputs: Vec<InputFile>) -> Provenance {
    Provenance {
        version: report.version.clone(),
        date: record::now(),
        working_directory: std::env::current_dir().ok().map(|here| here.display().to_string()),
        arguments: record::arguments(),
        settings: ResolvedSettings {
            model: report.model.clone(),
            filter: report.filter.clone(),
            backend: report.backend.kind.clone(),
            solver: arguments.solver.name().into(),
            max_iterations: arguments.max_iterations,
            tolerance: arguments.tolerance,
            traced_limit: arguments.traced_limit,
            paths: report.fit.traced.map_or(0, |traced| traced.paths),
            profile: arguments.profile,
            bootstrap: arguments.bootstrap as u64,
        },
        inputs,
        adapter: report.backend.adapter.clone(),
        seed: arguments.tracing.seed,
    }
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

fn estimate(arguments: &Arguments, scenes: &mut [ObservedScene], chosen: &Chosen) -> crate::Result<SceneFit> {
    let renders = TYPICAL_RENDERS * (scenes.len() * scenes[0].scene.object.len()) as u64;
    let progress = match arguments.rendering.model {
        WantedModel::This(Model::Traced) => Progress::uncounted("tracing and fitting"),
        _ => Progress::new("fitting", "renders", renders),
    };
    let tick = || progress.add(1);
    let (settings, filter) = (settings_of(arguments, chosen), arguments.rendering.filter);
    let model = arguments.rendering.model;
    let whole = |scenes: &[ObservedScene]| match model {
        WantedModel::This(_) => fit_scenes(scenes, &settings, filter, &tick),
        WantedModel::Auto => select(scenes, &settings, filter, arguments.tolerance, &tick),
    };
    // Where the model is chosen, the most exact one looks for what the camera does.
    let exact = match model {
        WantedModel::This(_) => settings,
        WantedModel::Auto => Settings { model: Model::WideAngle, ..settings },
    };
    let probe = |scenes: &[ObservedScene]| match fit_scenes(scenes, &exact, filter, &tick) {
        Err(Error::OutOfRange { .. }) if model == WantedModel::Auto => {
            fit_scenes(scenes, &settings, filter, &tick)
        }
        fit => fit,
    };
    let fit = if model == WantedModel::This(Model::Traced) {
        whole(scenes)?
    } else {
        free_camera(scenes, whole, probe)?
    };
    drop(progress);
    if model == WantedModel::Auto { trace_if_weak(arguments, scenes, chosen, fit) } else { Ok(fit) }
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
    note(&format!(
        "the filter's error beside edges decides this fit: tracing paths instead, some {seconds:.0} s (--traced-limit)"
    ));
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
    report.camera.iter().for_each(|step| text += &format!("{}\n", step.line()));
    report.candidates.iter().for_each(|candidate| text += &format!("{}\n", candidate.line()));
    console::answer(arguments.json, report, &text)?;
    for warning in &report.warnings {
        let severity = if warning.severity == Severity::Invalid { "invalid" } else { "warning" };
        warn(&format!("{severity} ({}): {}{}", warning.code, warning.message, answer(warning.code)));
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
