//! Compares synthesized scenes with what Mitsuba traced there (`scripts/tub_mitsuba.py --witness`), part by part, prints
//! a table of the errors and draws where they are:
//! `cargo run --release --example synthesis_check -- docs/synthesis_error.png FOLDER…`

use narrowbeam::filter::{Backend, Filter};
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::colour::Tone;
use narrowbeam::io::exr::ExrFile;
use narrowbeam::plots::{Figure, Panel, Shade};
use narrowbeam::scene::{Purpose, Scene};
use narrowbeam::spread::Model;
use narrowbeam::synthesis::{Synthesis, synthesize};
use std::path::PathBuf;
use std::time::Instant;

/// Differences of this share of the mean light have the full colour.
const FULL_COLOUR: f64 = 0.5;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let Some(picture) = arguments.next() else {
        anyhow::bail!("usage: synthesis_check PICTURE.png FOLDER…");
    };
    println!("| scene | channel | part | share of the light | mean | rms | rms by eq29 |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let (mut panels, mut notes) = (Vec::new(), Vec::new());
    for folder in arguments {
        let name = folder.file_name().unwrap_or(folder.as_os_str()).display().to_string();
        let scene = Scene::read(&folder.join("scene.toml"), Purpose::Synthesize)?;
        let media = scene.medium_values([None; 3])?;
        let made = |filter| synthesize(&scene, &media, Model::SmallAngle, filter, Backend::Cpu);
        let start = Instant::now();
        let eq29 = made(Filter::Eq29)?;
        let middle = Instant::now();
        let composite = made(Filter::Auto)?;
        notes.push(format!(
            "{name}: {:.2} s by eq29, {:.2} s by composite",
            (middle - start).as_secs_f64(),
            middle.elapsed().as_secs_f64()
        ));

        let traced = ExrFile::read(&folder.join("witness.exr"))?;
        let mut all = Vec::new();
        for (i, object) in scene.object.iter().enumerate() {
            let part = |part: &str| -> narrowbeam::Result<[Image; 2]> {
                let channel = format!("{part}.{}", object.name);
                Ok([traced.named(&channel)?.image, traced.named(&format!("{channel}.variance"))?.image])
            };
            let ([object_light, object_variance], [veil, veil_variance]) = (part("object")?, part("veil")?);
            let light = object_light.mean() + veil.mean();
            let row = |part: &str, truth: &Image, variance: &Image, [a, b]: [Image; 2]| {
                let percent = |v: f64| format!("{:.1} %", 100.0 * v / light);
                let mean = percent(a.mean() - truth.mean());
                let [rms, by_eq29] = [rms(&a, truth, variance), rms(&b, truth, variance)].map(percent);
                let share = percent(truth.mean());
                println!("| {name} | {} | {part} | {share} | {mean} | {rms} | {by_eq29} |", object.name);
            };
            let of = |f: fn(&Synthesis, usize) -> Image| [f(&composite, i), f(&eq29, i)];
            row("object", &object_light, &object_variance, of(object_part));
            row("veil", &veil, &veil_variance, of(|made, i| made.veil[i].image.clone()));
            all.push(Channel { name: object.name.clone(), image: sum(&object_light, &veil) });
        }
        let total = composite.total();
        let mean = all.iter().map(|c| c.image.mean()).sum::<f64>() / all.len() as f64;
        let difference = total.iter().zip(&all).map(|(a, b)| Channel {
            name: a.name.clone(),
            image: Image {
                data: a.image.data.iter().zip(&b.image.data).map(|(a, b)| (a - b) / mean as f32).collect(),
                ..a.image.clone()
            },
        });
        let difference: Vec<Channel> = difference.collect();
        let tone = Tone::of(&total);
        let panel = |title: String, channels, shade| Panel { title, channels, shade };
        panels.push(panel(format!("{name}: traced by Mitsuba"), all, Shade::Radiance(tone)));
        panels.push(panel("synthesized".into(), total, Shade::Radiance(tone)));
        let scale = FULL_COLOUR;
        panels.push(panel("difference / mean light".into(), difference, Shade::Diverging { scale }));
    }
    notes.iter().for_each(|note| println!("{note}"));
    let title = "Synthesized images against Mitsuba's".into();
    Figure { title, panels, columns: 3, table: Vec::new(), notes: Vec::new() }.write_png(&picture)?;
    Ok(())
}

fn object_part(made: &Synthesis, i: usize) -> Image {
    sum(&made.direct[i].image, &made.scattered[i].image)
}

fn sum(a: &Image, b: &Image) -> Image {
    Image { data: a.data.iter().zip(&b.data).map(|(a, b)| a + b).collect(), ..a.clone() }
}

/// Root mean square difference, that of the noise of `truth` taken off.
fn rms(image: &Image, truth: &Image, variance: &Image) -> f64 {
    let squares = image.data.iter().zip(&truth.data).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
    (squares / image.data.len() as f64 - variance.mean()).max(0.0).sqrt()
}
