//! Compares synthesized scenes with what Mitsuba traced there (`scripts/tub_mitsuba.py --witness`), part by part, prints
//! a table of the errors and draws where they are:
//! `cargo run --release --example synthesis_check -- MODEL docs/synthesis_error.png FOLDER…`

use narrowbeam::filter::{Backend, Filter};
use narrowbeam::geometry::{EDGE_PITCHES, Geometry};
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::colour::Tone;
use narrowbeam::io::exr::ExrFile;
use narrowbeam::plots::{Figure, Panel, Shade};
use narrowbeam::scene::{LitScene, PartialMedium};
use narrowbeam::spread::Model;
use narrowbeam::synthesis::{Synthesis, synthesize};
use std::path::PathBuf;
use std::time::Instant;

/// Differences of this share of the mean light have the full colour.
const FULL_COLOUR: f64 = 0.5;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(model), Some(picture)) = (arguments.next(), arguments.next()) else {
        anyhow::bail!("usage: synthesis_check MODEL PICTURE.png FOLDER…");
    };
    let model: Model = model.to_string_lossy().parse()?;
    println!(
        "| scene | channel | part | share of the light | mean | rms | rms near edges | elsewhere | rms by eq29 |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let (mut panels, mut notes) = (Vec::new(), Vec::new());
    for folder in arguments {
        let name = folder.file_name().unwrap_or(folder.as_os_str()).display().to_string();
        let scene = LitScene::read(&folder.join("scene.toml"))?;
        let media = scene.scene.media(PartialMedium::default())?;
        let made = |filter| synthesize(&scene, &media, model, filter, Backend::Cpu);
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
        let near_edge = &near_edges(&scene.scene.geometry);
        let mut all = Vec::new();
        for (i, object) in scene.scene.object.iter().enumerate() {
            let part = |part: &str| -> narrowbeam::Result<[Image; 2]> {
                let channel = format!("{part}.{}", object.name);
                Ok([traced.named(&channel)?.image, traced.named(&format!("{channel}.variance"))?.image])
            };
            let ([object_light, object_variance], [veil, veil_variance]) = (part("object")?, part("veil")?);
            let light = object_light.mean() + veil.mean();
            let row = |part: &str, truth: &Image, variance: &Image, [a, b]: [Image; 2]| {
                let percent = |v: f64| format!("{:.1} %", 100.0 * v / light);
                let share = percent(truth.mean());
                let mean = percent(a.mean() - truth.mean());
                let near = |at_edge: bool| (0..near_edge.len()).filter(move |&i| near_edge[i] == at_edge);
                let rms = |image: &Image, pixels: Vec<usize>| percent(rms(image, truth, variance, &pixels));
                let all: Vec<usize> = (0..near_edge.len()).collect();
                println!(
                    "| {name} | {} | {part} | {share} | {mean} | {} | {} | {} | {} |",
                    object.name,
                    rms(&a, all.clone()),
                    rms(&a, near(true).collect()),
                    rms(&a, near(false).collect()),
                    rms(&b, all)
                );
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

/// Root mean square difference over `pixels`, that of the noise of `truth` taken off.
fn rms(image: &Image, truth: &Image, variance: &Image, pixels: &[usize]) -> f64 {
    let square = |&i: &usize| f64::from(image.data[i] - truth.data[i]).powi(2) - f64::from(variance.data[i]);
    (pixels.iter().map(square).sum::<f64>() / pixels.len() as f64).max(0.0).sqrt()
}

/// Whether within two pixels of each pixel the depth steps by more than an edge does.
fn near_edges(geometry: &Geometry) -> Vec<bool> {
    let (width, height) = (geometry.width, geometry.height);
    let depth = |x: usize, y: usize| geometry.object_distance(x, y).unwrap_or(f64::INFINITY);
    let steps = |x: usize, y: usize| {
        let around = |v: usize, n: usize| v.saturating_sub(2)..(v + 3).min(n);
        let least = 2.0 * EDGE_PITCHES * geometry.pixel_pitch(depth(x, y));
        around(y, height)
            .flat_map(|v| around(x, width).map(move |u| (u, v)))
            .any(|(u, v)| (depth(u, v) - depth(x, y)).abs() > least)
    };
    (0..width * height).map(|i| steps(i % width, i / width)).collect()
}
