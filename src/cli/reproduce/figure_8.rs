//! Figure 8 as a picture and a table.

use crate::cli::progress::Progress;
use crate::error::Result;
use crate::geometry::Field;
use crate::image::{Channel, Image};
use crate::io::atomic;
use crate::io::colour::Tone;
use crate::lab::paper::{Effort, figure_8};
use crate::plots::{Figure, Panel, Shade};
use std::path::Path;
use std::time::Instant;

/// The files of this figure.
pub(super) const FILES: [&str; 3] = ["fig8.png", "fig8.svg", "fig8.csv"];

/// The veil is shown brighter than the other parts; otherwise it could not be seen.
const VEIL_BRIGHTER: f64 = 10.0;

/// Makes the pictures, writes them and their numbers into `dir`, and returns the text to print.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write) with the path.
pub(super) fn make(dir: &Path, effort: Effort) -> Result<String> {
    let progress = Progress::uncounted(FILES[0]);
    let start = Instant::now();
    let (lit, media) = figure_8::scene(figure_8::side(effort))?;
    let pictures = figure_8::pictures(&lit, &media)?;
    let scene = &lit.scene;
    let seconds = start.elapsed().as_secs_f64();
    drop(progress);

    let mut csv = String::from("model,channel,clear,direct,scattered,veil,difference\n");
    for light in figure_8::light(&pictures) {
        let [direct, scattered, veil] = light.parts;
        csv += &format!("{},{},{:.5}", light.model, light.channel, light.clear);
        csv += &format!(",{direct:.5},{scattered:.5},{veil:.5},{:.5}\n", light.difference);
    }
    atomic::write(&dir.join(FILES[2]), csv.as_bytes())?;

    let [(first, printed), (second, best)] = &pictures[..] else { unreachable!("there are two models") };
    let tone = Tone::of(&best.clear);
    let radiance = |title: String, channels: Vec<Channel>, tone: Tone| Panel {
        title,
        channels,
        shade: Shade::Radiance(tone),
    };
    let depth = |title: &str, field: &Field| Panel {
        title: title.into(),
        channels: vec![Channel {
            name: "depth".into(),
            image: Image::from_fn(scene.geometry.width, scene.geometry.height, |x, y| field.at(x, y) as f32),
        }],
        shade: Shade::Sequential { max: 36.0 },
    };
    let dim = Tone { white: tone.white / VEIL_BRIGHTER };
    let figure = Figure {
        title: "Balls in thin milk: what goes in, the parts of the light, what comes out".into(),
        panels: vec![
            depth("Depth of the surface, cm", &scene.geometry.surface),
            depth("Depth of the objects, cm", &scene.geometry.depth),
            radiance("Reflectance".into(), scene.object.clone(), Tone { white: 1.0 }),
            radiance("In clear air".into(), best.clear.clone(), tone),
            radiance("Direct light".into(), best.direct.clone(), tone),
            radiance("Scattered object light".into(), best.scattered.clone(), tone),
            radiance(format!("Veil, {VEIL_BRIGHTER} times as bright"), best.veil.clone(), dim),
            radiance(format!("All, {second}"), best.total(), tone),
            radiance(format!("All, {first}"), printed.total(), tone),
        ],
        columns: 3,
        table: Vec::new(),
        notes: vec!["By the paper's eq. 29, which lets the light of the floor through the balls.".into()],
    };
    figure.write_png(&dir.join(FILES[0]))?;
    figure.write_svg(&dir.join(FILES[1]))?;
    let side = scene.geometry.width;
    Ok(format!(
        "{csv}{}: {side} x {side} px, 3 channels, {} models: {seconds:.1} s\n\n",
        FILES.join(", "),
        pictures.len()
    ))
}
