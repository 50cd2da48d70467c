//! Draws scenes in clear air and through their medium, side by side, one scene a row, each picture exposed for itself:
//! `cargo run --release --example synthesis_figure -- docs/synthesis.png examples/scenes/milk examples/scenes/juice`

use narrowbeam::filter::{Backend, Filter};
use narrowbeam::image::Channel;
use narrowbeam::io::colour::Tone;
use narrowbeam::io::png::write_rgb;
use narrowbeam::scene::{LitScene, PartialMedium};
use narrowbeam::spread::Model;
use narrowbeam::synthesis::synthesize;
use std::path::PathBuf;

/// White between the pictures, px.
const GAP: usize = 6;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let Some(picture) = arguments.next() else {
        anyhow::bail!("usage: synthesis_figure PICTURE.png SCENE-FOLDER…");
    };
    let mut rows: Vec<[Vec<Channel>; 2]> = Vec::new();
    for folder in arguments {
        let scene = LitScene::read(&folder.join("scene.toml"))?;
        let media = scene.scene.media(PartialMedium::default())?;
        let made = synthesize(&scene, &media, Model::SmallAngle, Filter::Auto, Backend::Cpu)?;
        rows.push([made.clear.clone(), made.total()]);
    }
    let size = |channels: &[Channel]| (channels[0].image.width, channels[0].image.height);
    let (width, height) =
        rows.iter().flatten().map(|c| size(c)).fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let page = (2 * width + GAP, rows.len() * (height + GAP) - GAP);
    let mut rgb = vec![255; 3 * page.0 * page.1];
    for (row, pictures) in rows.iter().enumerate() {
        for (column, channels) in pictures.iter().enumerate() {
            let tone = Tone::of(channels);
            for y in 0..size(channels).1 {
                for x in 0..size(channels).0 {
                    let at = (row * (height + GAP) + y) * page.0 + column * (width + GAP) + x;
                    for c in 0..3 {
                        // A gray image has one channel for all three.
                        let image = &channels[c % channels.len()].image;
                        rgb[3 * at + c] = tone.level(f64::from(image.at(x, y)));
                    }
                }
            }
        }
    }
    write_rgb(&picture, &rgb, page)?;
    Ok(())
}
