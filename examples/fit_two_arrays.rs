//! Fits the medium that lies between two arrays, a clear image and a blurred one, with the library alone:
//! `cargo run --release --no-default-features --example fit_two_arrays`

use narrowbeam::filter::{Optics, Target, cpu::CpuFilter};
use narrowbeam::fit::{Datum, NAMES, Settings, VeilTerm, fit_channel};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::scene::{FitOptions, Gain};
use narrowbeam::spread::Model;

fn main() -> narrowbeam::Result<()> {
    let (width, height) = (48, 48);
    let clear = Image::from_fn(width, height, |x, y| if (x / 5 + y / 7) % 2 == 0 { 0.9 } else { 0.2 });
    // Pixels of 5 cm, seen through 2 m of the medium.
    let geometry = Geometry::planar(width, height, 0.05, 2.0)?;
    let view = View::whole(width, height);
    let target = Target {
        radiance: &clear,
        behind: &[],
        geometry: &geometry,
        border: Border::Mirror,
        view,
        relief: None,
    };

    let phase = Gaussian::new(0.004)?;
    let truth = Optics { model: Model::SmallAngle, medium: Medium::new(0.9, 0.05)?, phase: &phase };
    let blurred = CpuFilter::new(target, &truth, 1.0)?.render(&truth)?;

    let datum = Datum {
        target,
        observed: &blurred,
        mask: None,
        hidden_share_max: 0.01,
        noise: None,
        gain: Gain::Fixed(1.0),
        gain_error: 0.0,
        depth_error: 0.0,
        veil: VeilTerm::Fixed(0.0),
    };
    let fit = fit_channel(&[datum], &FitOptions::default(), &Settings::default())?;
    NAMES.iter().zip(fit.parameters.values()).for_each(|(name, value)| println!("{name:8} {value:.6}"));
    Ok(())
}
