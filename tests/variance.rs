//! Noise given as a variance image.

use narrowbeam::filter::Filter;
use narrowbeam::fit::scenes::fit_scenes;
use narrowbeam::fit::{ChannelFit, NAMES, Settings};
use narrowbeam::image::{Channel, Image};
use narrowbeam::phase::Gaussian;
use narrowbeam::scene::{MediumValues, Noise};
use narrowbeam::spread::Model;
use narrowbeam::study::{Setting, Texture};

const PLANE: Setting = Setting {
    texture: Texture::Checker,
    side: 48,
    pixel_pitch: 0.03,
    z: 2.0,
    medium: MediumValues { sigma_s: 0.7, sigma_a: 0.15, b: 0.004 },
};

fn fit(plane: &Setting, observed: Image, noise: Option<Noise>, model: Model) -> ChannelFit {
    let mut scene = plane.scene(observed, None).unwrap();
    scene.observation.as_mut().unwrap().noise = noise;
    fit_scenes(&[scene], &Settings { model, ..Settings::default() }, Filter::Auto).unwrap().channels.remove(0).1
}

fn variance(image: Image) -> Option<Noise> {
    Some(Noise::Variance(vec![Channel { name: "Y".into(), image }]))
}

fn smooth(v: &Image) -> Image {
    let (w, h) = (v.width as i64, v.height as i64);
    Image::from_fn(v.width, v.height, |x, y| {
        let (mut s, mut n) = (0.0, 0.0);
        for dy in -1..=1i64 { for dx in -1..=1i64 {
            let (a, b) = (x as i64 + dx, y as i64 + dy);
            if (dx, dy) != (0, 0) && a >= 0 && b >= 0 && a < w && b < h { s += v.at(a as usize, b as usize); n += 1.0; }
        }}
        s / n
    })
}

#[test]
fn explore() {
    let phase = Gaussian::new(PLANE.medium.b).unwrap();
    for samples in [64, 256, 1024] {
        for kind in 0..4 {
            let mut pulls = [0.0; 3]; let mut squares = [0.0; 3]; let mut chi = 0.0;
            const N: u64 = 8;
            for seed in 0..N {
                let traced = PLANE.trace(&phase, samples, seed + 1).unwrap();
                let noise = match kind {
                    0 => None,
                    1 => variance(traced.variance.clone()),
                    2 => variance(smooth(&traced.variance)),
                    _ => variance(PLANE.trace(&phase, samples, seed + 1000).unwrap().variance),
                };
                let f = fit(&PLANE, traced.mean.clone(), noise, Model::WideAngle);
                chi += f.reduced_chi2 / N as f64;
                for i in 0..3 {
                    let t = PLANE.truth()[i];
                    let v = f.parameters.values()[i];
                    let off = if i == 1 { v - t } else { (v / t).ln() } / f.uncertainty.std_error(i).unwrap();
                    pulls[i] += off / N as f64; squares[i] += off * off / N as f64;
                }
            }
            println!("samples {samples} kind {kind}: chi2 {chi:.4} mean pulls {pulls:.2?} rms {:.2?}", squares.map(f64::sqrt));
        }
    }
    let _ = NAMES;
}
