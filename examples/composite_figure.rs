//! Draws what the composite filter mends: fits a dataset by eq29 and by composite, and shows both residuals beside the
//! share of light that near surfaces may hide:
//! `cargo run --release --example composite_figure -- datasets/mitsuba-planes docs/composite.png`

use narrowbeam::filter::Filter;
use narrowbeam::fit::{SceneFit, Settings, fit_scenes};
use narrowbeam::forward::State;
use narrowbeam::image::Channel;
use narrowbeam::io::colour::{Tone, residual_scale};
use narrowbeam::plots::{Figure, Panel, Shade};
use narrowbeam::scene::{ObservedScene, read_truth};
use std::path::PathBuf;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(folder), Some(picture)) = (arguments.next(), arguments.next()) else {
        anyhow::bail!("usage: composite_figure DATASET PICTURE.png");
    };
    let scenes = [ObservedScene::read(&folder.join("scene.toml"))?];
    let truth = read_truth(&folder.join("truth.toml"))?;
    let eq29 = fit_scenes(&scenes, &Settings::default(), Filter::Eq29, &|| ())?;
    let composite = fit_scenes(&scenes, &Settings::default(), Filter::Composite, &|| ())?;

    let observation = &scenes[0].observation;
    let most = observation.hidden_share_max;
    let share = composite.hidden_share(0);
    let residual = |fit: &SceneFit| fit.residual(0, &observation.image);
    let shown = match &share {
        Some(share) => without_hidden(residual(&composite), share, most),
        None => residual(&composite),
    };
    let scale = residual_scale(&residual(&eq29));
    let panel = |title: &str, channels: &[Channel], shade| Panel {
        title: title.into(),
        channels: channels.to_vec(),
        shade,
    };
    let mut panels = vec![
        panel("observed", &observation.image, Shade::Radiance(Tone::of(&observation.image))),
        panel("observed - fit by eq29", &residual(&eq29), Shade::Diverging { scale }),
        panel("observed - fit by composite", &shown, Shade::Diverging { scale }),
    ];
    let mut notes =
        vec![format!("reduced chi²: {:.2} by eq29, {:.2} by composite", chi2(&eq29), chi2(&composite))];
    let hidden = composite.report.fit.hidden_pixels;
    if let Some(share) = &share {
        panels.push(panel("share of hidden light", share, Shade::from_zero(share)));
        notes.push(format!(
            "gray: the {} of {} pixels that the fit leaves out, as more than {} % of their light may be hidden",
            hidden,
            hidden + composite.report.fit.pixels,
            100.0 * most
        ));
    }

    let mut table = vec![["", "truth", "eq29", "error", "composite", "error"].map(String::from).to_vec()];
    // One medium in the file stands for all channels.
    let fits = eq29.channels.iter().zip(&composite.channels).zip(truth.iter().cycle());
    for (((channel, by_eq29), (_, by_composite)), truth) in fits {
        for (_, parameter) in by_eq29.parameters.of_medium() {
            let name = parameter.name();
            let truth = State::from(*truth).value(parameter.descriptor().quantity);
            let channel = if eq29.channels.len() == 1 { String::new() } else { format!(".{channel}") };
            let mut row = vec![format!("{name}{channel}"), format!("{truth:.5}")];
            for fit in [by_eq29, by_composite] {
                let value = fit.parameters[name].value();
                row.push(format!("{value:.5}"));
                row.push(format!("{:+.1} %", 100.0 * (value / truth - 1.0)));
            }
            table.push(row);
        }
    }
    let name = folder.file_name().unwrap_or(folder.as_os_str()).display();
    let title = format!("{name}: depth edges and slopes by eq. 29 and by the composite filter");
    Figure { title, panels, columns: 4, table, notes }.write_png(&picture)?;
    Ok(())
}

/// `residual` with NaN, which is drawn gray, where the hidden `share` is above `most`.
fn without_hidden(mut residual: Vec<Channel>, share: &[Channel], most: f64) -> Vec<Channel> {
    for (channel, share) in residual.iter_mut().zip(share) {
        for (value, &share) in channel.image.data.iter_mut().zip(&share.image.data) {
            if f64::from(share) > most {
                *value = f32::NAN;
            }
        }
    }
    residual
}

fn chi2(fit: &SceneFit) -> f64 {
    fit.report.fit.reduced_chi2
}
