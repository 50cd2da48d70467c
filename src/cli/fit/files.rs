//! The files of a fit.

use super::{Arguments, how_it_went};
use crate::cli::backend::Chosen;
use crate::cli::record::provenance;
use crate::cli::results::{REPORT, Results};
use crate::fit::SceneFit;
use crate::io::colour::{Tone, residual_scale};
use crate::io::{atomic, exr, png};
use crate::plots::{Figure, Panel, Shade};
use crate::scene::ObservedScene;
use anyhow::Result;
use rayon::prelude::*;

/// Name and kind of what is written for each scene only if something is hidden.
pub(super) const HIDDEN_SHARE: (&str, &str) = ("hidden_share", "exr");

/// Name and kind of what is written for each scene.
pub(super) const OUTPUTS: [(&str, &str); 8] = [
    ("render", "exr"),
    ("residual", "exr"),
    HIDDEN_SHARE,
    ("object", "png"),
    ("observed", "png"),
    ("render", "png"),
    ("residual", "png"),
    ("fit", "png"),
];

/// Name of such a file for scene `i` of `scenes`.
pub(super) fn output(scenes: usize, i: usize, name: &str, kind: &str) -> String {
    let suffix = if scenes == 1 { String::new() } else { format!("-{}", i + 1) };
    format!("{name}{suffix}.{kind}")
}

/// `render`, `residual`, `hidden_share` and the pictures of each scene, then the report, which names them.
pub(super) fn write(
    arguments: &Arguments,
    results: &Results,
    scenes: &[ObservedScene],
    fit: &mut SceneFit,
    chosen: &Chosen,
) -> Result<()> {
    for (i, ObservedScene { scene, observation }) in scenes.iter().enumerate() {
        let file = |name: &str, kind: &str| results.path(&output(scenes.len(), i, name, kind));
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
            None => Ok(()),
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
        tasks.par_iter().try_for_each(|task| task()).map_err(|error| results.worded(error))?;
    }
    fit.report.files = results.hashes()?;
    let json = serde_json::to_string_pretty(&fit.report)?;
    Ok(atomic::write(&results.path(REPORT), json.as_bytes()).map_err(|error| results.worded(error))?)
}
