//! Fits the medium that lies between two arrays, a clear image and a blurred one, with the library alone:
//! `cargo run --release --no-default-features --example fit_two_arrays`

use narrowbeam::filter::{Optics, Target, cpu::CpuFilter};
use narrowbeam::fit::{Observation, Settings, fit_channel};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::scene::FitOptions;
use narrowbeam::spread::Model;

fn main() -> narrowbeam::Result<()> {
    // Pixels of 5 cm, seen through 2 m of the medium.
    let clear = Image::from_fn(48, 48, |x, y| if (x / 5 + y / 7) % 2 == 0 { 0.9 } else { 0.2 });
    let geometry = Geometry::planar(48, 48, 0.05, 2.0)?;
    let (border, view) = (Border::Mirror, View::whole(48, 48));
    let target = Target::plain(&clear, &geometry, border, view);

    let truth = Optics { model: Model::SmallAngle, medium: Medium::gaussian(0.9, 0.05, 0.004)? };
    let blurred = CpuFilter::new(target, &truth, 1.0)?.render(&truth)?;

    let seen = [Observation::plain(target, &blurred)];
    let fit = fit_channel(&seen, &FitOptions::default(), &Settings::default(), &|| ())?;
    for name in ["sigma_s", "sigma_a", "b"] {
        println!(
            "{name:8} {:.6} ± {:.1e}",
            fit.parameters[name].value(),
            fit.std_error(name).unwrap_or(f64::NAN)
        );
    }
    Ok(())
}
