//! The files of a fit.

use super::{Arguments, how_it_went};
use crate::cli::backend::Chosen;
use crate::cli::options::provenance;
use crate::fit::SceneFit;
use crate::io::colour::{Tone, residual_scale};
use crate::io::{atomic, exr, png};
use crate::plots::{Figure, Panel, Shade};
use crate::scene::ObservedScene;
use anyhow::Result;
use rayon::prelude::*;
use std::path::PathBuf;

/// Name and kind of what is written for each scene; `hidden_share` only if something is hidden.
pub(super) const OUTPUTS: [(&str, &str); 8] = [
    ("render", "exr"),
    ("residual", "exr"),
    ("hidden_share", "exr"),
    ("object", "png"),
    ("observed", "png"),
    ("render", "png"),
    ("residual", "png"),
    ("fit", "png"),
];

/// Path of such a file for scene `i` of `scenes`.
pub(super) fn output(arguments: &Arguments, scenes: usize, i: usize, name: &str, kind: &str) -> PathBuf {
    let suffix = if scenes == 1 { String::new() } else { format!("-{}", i + 1) };
    arguments.out.join(format!("{name}{suffix}.{kind}"))
}

/// The report, then `render`, `residual`, `hidden_share` and the pictures of each scene. An earlier fit's `hidden_share`
/// is removed if nothing is hidden now.
pub(super) fn write(
    arguments: &Arguments,
    scenes: &[ObservedScene],
    fit: &SceneFit,
    chosen: &Chosen,
) -> Result<()> {
    let json = serde_json::to_string_pretty(&fit.report)?;
    atomic::write(&arguments.out.join("fit.json"), json.as_bytes())?;
    for (i, ObservedScene { scene, observation }) in scenes.iter().enumerate() {
        let file = |name: &str, kind: &str| output(arguments, scenes.len(), i, name, kind);
        let (render, residual) = (fit.render(i), fit.residual(i, &observation.image));
        let (clear, tone) = (Tone::of(&scene.object), Tone::of(&observation.image));
        let scale = residual_scale(&residual);
        let share = fit.hidden_share(i);
        let panel = |title: &str, channels, shade| Panel { title: title.into(), channels, shade };
        let mut panels = vec![
            panel("object (clear)", scene.object.clone(), Shade::Radiance(clear)),
            panel("observed", observation.image.clone(), Shade::Radiance(tone)),
            panel("best fit", render.clone(), Shade::Radiance(tone)),
            panel("observed - best fit", residual.clone(), Shade::Diverging { scale }),
        ];
        if let Some(share) = &share {
            panels.push(panel("share of hidden light", share.clone(), Shade::from_zero(share)));
        }
        let figure = Figure {
            title: format!("{}: {} fit", scene.path.display(), fit.report.model),
            columns: if panels.len() > 4 { 3 } else { 4 },
            panels,
            table: fit.report.table("1/length"),
            notes: fit.report.remarks().into_iter().chain([how_it_went(arguments, fit, chosen)]).collect(),
        };
        let share = || match &share {
            Some(share) => exr::write_finite(&file("hidden_share", "exr"), share, &provenance()),
            None => atomic::remove(&file("hidden_share", "exr")),
        };
        let tasks: [&(dyn Fn() -> crate::Result<()> + Sync); 8] = [
            &|| exr::write_finite(&file("render", "exr"), &render, &provenance()),
            &|| exr::write_finite(&file("residual", "exr"), &residual, &provenance()),
            &share,
            &|| png::write_picture(&file("object", "png"), &scene.object, clear),
            &|| png::write_picture(&file("observed", "png"), &observation.image, tone),
            &|| png::write_picture(&file("render", "png"), &render, tone),
            &|| png::write_residual(&file("residual", "png"), &residual, Some(scale)).map(|_| ()),
            &|| figure.write_png(&file("fit", "png")),
        ];
        tasks.par_iter().try_for_each(|task| task())?;
    }
    Ok(())
}
