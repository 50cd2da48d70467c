//! A synthesized image against the same shapes, medium and light traced by Mitsuba (`tests/witness/juice`, made by
//! `scripts/tub_mitsuba.py juice --output tests/witness/juice --width 96 --witness --samples 512 --seed 1`).

use narrowbeam::filter::{Backend, Filter};
use narrowbeam::io::exr::ExrFile;
use narrowbeam::medium::Medium;
use narrowbeam::scene::{LitScene, PartialMedium};
use narrowbeam::spread::Model;
use narrowbeam::synthesis::synthesize;
use std::path::Path;

/// Mean and root mean square error of each channel, over the mean of the traced light, the noise taken off.
fn errors(scene: &LitScene, media: &[Medium], witness: &ExrFile) -> Vec<[f64; 2]> {
    let made = synthesize(scene, media, Model::SmallAngle, Filter::Eq29, Backend::Cpu).unwrap();
    let error = |channel: &narrowbeam::image::Channel| {
        let traced = |part: &str| witness.named(&format!("{part}.{}", channel.name)).unwrap().image;
        let (object, veil) = (traced("object"), traced("veil"));
        // The variance of object + veil, all light, is what object.variance has beyond that of the veil.
        let variance =
            traced_variance(witness, "object", channel) - traced_variance(witness, "veil", channel);
        let light = object.mean() + veil.mean();
        let differences = channel.image.data.iter().zip(object.data.iter().zip(&veil.data));
        let squares = differences.map(|(a, (o, v))| f64::from(a - o - v).powi(2)).sum::<f64>();
        let square = squares / channel.image.data.len() as f64;
        [channel.image.mean() / light - 1.0, (square - variance).max(0.0).sqrt() / light]
    };
    made.total().iter().map(error).collect()
}

fn traced_variance(witness: &ExrFile, part: &str, channel: &narrowbeam::image::Channel) -> f64 {
    witness.named(&format!("{part}.{}.variance", channel.name)).unwrap().image.mean()
}

#[test]
fn a_synthesized_image_has_the_light_that_mitsuba_traces() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/witness/juice");
    let scene = LitScene::read(&folder.join("scene.toml")).unwrap();
    let witness = ExrFile::read(&folder.join("witness.exr")).unwrap();
    let media = scene.scene.media(PartialMedium::default()).unwrap();
    // As measured: docs/synthesis.md has where this comes from.
    let near = |[mean, rms]: [f64; 2]| mean.abs() < 0.04 && rms < 0.2;
    for error in errors(&scene, &media, &witness) {
        println!("mean {:+.1} %, rms {:.1} %", 100.0 * error[0], 100.0 * error[1]);
        assert!(near(error));
    }
    // The comparison tells a tenth more juice.
    let wrong: Vec<Medium> = media
        .iter()
        .map(|m| Medium::new(1.1 * m.sigma_s(), 1.1 * m.sigma_a(), *m.phase()).unwrap())
        .collect();
    for error in errors(&scene, &wrong, &witness) {
        println!("a tenth more: mean {:+.1} %, rms {:.1} %", 100.0 * error[0], 100.0 * error[1]);
        assert!(!near(error));
    }
}
