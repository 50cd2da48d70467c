//! Fits by the model `traced` of planes whose images the tracer made of other paths: thick media, two depths, and what errors of
//! the input and measurements yet to be made do to them.

use crate::common::estimates::{compare_all, status};
use crate::common::recovery::assert_recovered;
use crate::common::sloping;
use nalgebra::Vector3;
use narrowbeam::filter::{Backend, Filter, Target};
use narrowbeam::fit::{ChannelFit, Observation, Settings, Status, advise, fit_channel};
use narrowbeam::forward::{Engine, Quantity, Tracing};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, PhaseFunction, b_of_spread_angle};
use narrowbeam::relief::Relief;
use narrowbeam::scene::{FitOptions, Gain, ParameterOptions};
use narrowbeam::spread::Model;
use narrowbeam::trace::{BATCHES, ImageConfig, PathRecords, Scattered, trace_image, trace_paths};

/// A checkerboard of unequal cells.
fn checkerboard(side: usize) -> Image {
    Image::from_fn(side, side, |x, y| if (x / 5 + y / 7) % 2 == 0 { 0.9 } else { 0.2 })
}

/// A dark half beside a bright one with a checkerboard in it: edges, and what only a wide kernel bridges.
fn halves(side: usize) -> Image {
    Image::from_fn(side, side, |x, y| match (2 * x < side, 2 * y < side && (x / 4 + y / 4) % 2 == 0) {
        (true, _) => 0.02,
        (false, true) => 0.1,
        (false, false) => 1.0,
    })
}

/// One object at several depths, seen through one medium.
struct Views {
    object: Image,
    geometries: Vec<Geometry>,
    reliefs: Vec<Option<Relief>>,
    observed: Vec<Image>,
    truth: Medium,
}

impl Views {
    /// Planes at `depths` behind a medium of `[sigma_s, sigma_a, degrees]`.
    fn planes(object: Image, (pitch, depths): (f64, &[f64]), medium: [f64; 3]) -> Self {
        let plane = |&z: &f64| Geometry::planar(object.width, object.height, pitch, z).unwrap();
        Self::new(depths.iter().map(plane).collect(), object, medium, 1001)
    }

    fn new(
        geometries: Vec<Geometry>,
        object: Image,
        [sigma_s, sigma_a, degrees]: [f64; 3],
        seed: u64,
    ) -> Self {
        let b = b_of_spread_angle(degrees.to_radians());
        let medium = Medium::new(sigma_s, sigma_a, Gaussian::new(b).unwrap()).unwrap();
        let seen = |(i, geometry): (usize, &Geometry)| {
            let view = View::whole(object.width, object.height);
            let (border, seed) = (Border::Mirror, seed + i as u64);
            let (radiance, behind, samples) = (&object, &[][..], 1024);
            let config = ImageConfig { geometry, radiance, behind, border, view, medium, samples, seed };
            trace_image(&config, &|_| ()).unwrap().mean
        };
        let observed = geometries.iter().enumerate().map(seen).collect();
        let reliefs = geometries.iter().map(|g| Filter::Auto.relief(g)).collect();
        Self { reliefs, observed, object, geometries, truth: medium.with_phase((*medium.phase()).into()) }
    }

    fn observations(&self) -> Vec<Observation<'_>> {
        let observation = |i: usize| {
            let target = Target {
                radiance: &self.object,
                behind: &[],
                geometry: &self.geometries[i],
                border: Border::Mirror,
                sampling: Sampling::Pixel,
                view: View::whole(self.object.width, self.object.height),
                relief: self.reliefs[i].as_ref(),
            };
            Observation::plain(target, &self.observed[i])
        };
        (0..self.geometries.len()).map(observation).collect()
    }

    fn options(&self, given: bool) -> FitOptions {
        with_b(given.then_some(self.truth.phase().parameter()))
    }

    fn assert_recovered(&self, name: &str, given: bool, paths: u64) {
        let fit = fit_channel(&self.observations(), &self.options(given), &traced(paths), &|| ()).unwrap();
        assert_recovered(name, &fit, self.truth);
    }
}

/// Options of a fit to which B is given, if it is.
fn with_b(fixed: Option<f64>) -> FitOptions {
    FitOptions { phase: ParameterOptions { fixed, ..ParameterOptions::default() }, ..FitOptions::default() }
}

fn traced(paths: u64) -> Settings<'static> {
    Settings { model: Model::Traced, tracing: Tracing::new(Some(paths), 7), ..Settings::default() }
}

#[test]
fn a_plane_is_blurred_by_the_kernel_of_its_paths() {
    // A cosine whose half period is the mirrored view, of w rad/px: the medium scales it by T + sum of light · J0(kr), pixels by sinc².
    let (side, pitch, paths) = (64, 0.05, 1 << 18);
    let w = std::f64::consts::PI / side as f64;
    let object = Image::from_fn(side, side, |x, _| 1.0 + (w * (x as f64 + 0.5)).cos() as f32);
    let geometry = Geometry::planar(side, side, pitch, 1.0).unwrap();
    let (border, view) = (Border::Mirror, View::whole(side, side));
    let target = Target::plain(&object, &geometry, border, view);
    let phase = Gaussian::new(b_of_spread_angle(25_f64.to_radians())).unwrap();
    let medium = Medium::new(5.0, 0.2, phase.into()).unwrap();
    let tracing = Tracing::new(Some(paths), 5);
    let engine = Engine { model: Model::Traced, backend: Backend::Cpu, tracing };
    let image = engine.render(target, medium).unwrap().image;
    let cosine = |x: usize| (w * (x as f64 + 0.5)).cos();
    let found = (0..side).map(|x| f64::from(image.at(x, 0)) * cosine(x)).sum::<f64>() * 2.0 / side as f64;
    let batches = BATCHES as u64;
    let light = (0..batches).map(|i| {
        trace_paths(medium.with_phase(phase), Scattered::Once, paths / batches, 5 * batches + i).unwrap()
    });
    let j0 = |h: PathRecords<Gaussian>| {
        h.weight * h.paths.iter().map(|p| libm::j0(w / pitch * f64::from(p.radius))).sum::<f64>()
    };
    let sinc = (0.5 * w).sin() / (0.5 * w);
    let scattered = sinc * sinc * light.map(j0).sum::<f64>() / batches as f64;
    let wanted = medium.transmittance(1.0) + scattered;
    println!("{found:.6} of {wanted:.6}");
    // The same paths: what is left is the width of the bins of radius and the set of Gaussians.
    assert!((found / wanted - 1.0).abs() < 1e-4, "{found} {wanted}");
}

#[test]
fn a_lobe_wider_than_the_table_comes_back() {
    let views = Views::planes(checkerboard(48), (0.1, &[1.0]), [2.0, 0.3, 75.0]);
    views.assert_recovered("75°", false, 1 << 19);
}

#[test]
fn thick_media_come_back() {
    // Wide kernels show all three only where the image has dark parts far from bright ones.
    let views = Views::planes(halves(64), (0.05, &[1.0]), [5.0, 0.2, 25.0]);
    views.assert_recovered("tau 5", false, 1 << 20);
    // Of thicker media one image shows sigma_s·B alone: B is given.
    for tau in [8.0, 12.0, 15.0] {
        let views = Views::planes(checkerboard(48), (0.1, &[1.0]), [tau, 0.05, 20.0]);
        views.assert_recovered(&format!("tau {tau}"), true, 1 << 19);
    }
}

#[test]
#[ignore = "two minutes of processor time: a statistic of docs/wide-angle.md"]
fn errors_over_many_images_are_as_stated() {
    let images = 24;
    let (mut sums, mut squares) = (Vector3::zeros(), Vector3::zeros());
    for seed in 0..images {
        let plane = Geometry::planar(64, 64, 0.05, 1.0).unwrap();
        let views = Views::new(vec![plane], halves(64), [5.0, 0.2, 25.0], 1001 + seed);
        let tracing = Tracing::new(Some(1 << 20), 7 + seed);
        let settings = Settings { tracing, ..traced(1) };
        let fit = fit_channel(&views.observations(), &views.options(false), &settings, &|| ()).unwrap();
        let error = Vector3::from(compare_all(&fit, views.truth).map(|found| {
            let along = fit.parameters.along(found.id);
            let paths = fit.model_error.as_ref().unwrap().variance_of(&along).sqrt();
            found.off() / found.std_error.unwrap().hypot(paths)
        }));
        sums += error;
        squares += error.component_mul(&error);
    }
    let (mean, rms) = (sums / images as f64, (squares / images as f64).map(f64::sqrt));
    println!("in standard errors: mean {:.2?}, root mean square {:.2?}", mean.as_slice(), rms.as_slice());
    // The mean of 24 is known to .2, times the root mean square.
    assert!(mean.amax() < 0.8 && rms.max() < 1.7, "{mean} {rms}");
}

#[test]
fn two_depths_free_the_gain_of_a_thick_medium() {
    assert_gain_is_freed(8.0);
}

#[test]
#[ignore = "half a minute of processor time: the same, thicker"]
fn two_depths_free_the_gain_of_a_medium_as_thick_as_the_table() {
    assert_gain_is_freed(12.0);
}

fn assert_gain_is_freed(tau: f64) {
    let mut views = Views::planes(halves(64), (0.05, &[0.5, 1.0]), [tau, 0.1, 30.0]);
    let gains = [0.8, 1.3];
    for (image, gain) in views.observed.iter_mut().zip(gains) {
        image.data.iter_mut().for_each(|v| *v *= gain);
    }
    let mut observations = views.observations();
    observations.iter_mut().for_each(|o| o.gain = Gain::Free);
    let fit = fit_channel(&observations, &views.options(false), &traced(1 << 20), &|| ()).unwrap();
    assert_recovered(&format!("two depths, tau {tau}"), &fit, views.truth);
    for (exposure, gain) in fit.exposures.iter().zip(gains) {
        let error = exposure.gain_error.unwrap();
        println!("  gain {:.4} ± {error:.4} of {gain}", exposure.gain);
        // One part in a hundred for the noise of the paths, which is not in the standard error.
        assert!((exposure.gain - f64::from(gain)).abs() < 3.0 * error + 0.01, "{}", exposure.gain);
        assert!(error < 0.02, "{error}");
    }
}

#[test]
fn a_free_gain_at_one_depth_calls_for_another() {
    // Small angles: what absorbs and what dims are the same but for the detours of the paths.
    let views = Views::planes(halves(48), (0.05, &[1.0]), [2.0, 0.2, 10.0]);
    let mut observations = views.observations();
    observations[0].gain = Gain::Free;
    let (options, settings) = (views.options(false), traced(1 << 18));
    let fit = fit_channel(&observations, &options, &settings, &|| ()).unwrap();
    assert_eq!(status(&fit, Quantity::SigmaS), Status::Free);
    assert_eq!(status(&fit, Quantity::SigmaA), Status::Undetermined);
    assert_eq!(status(&fit, Quantity::Phase), Status::Free);
    let advice = advise(&observations, &fit, &settings, &|| ()).unwrap();
    advice.iter().for_each(|one| println!("{one:?}"));
    let frees = |what: &str| advice.iter().find(|a| a.measurement == what).unwrap().frees;
    assert!(frees("a second scene at half the depth") && frees("a known gain"));
    assert!(!frees("half the noise (four times the exposure)"));
    // Beyond the table nothing is predicted.
    let fit = fit_channel(&observations, &with_b(Some(1.0)), &settings, &|| ()).unwrap();
    assert_eq!(status(&fit, Quantity::SigmaA), Status::Undetermined);
    assert_eq!(advise(&observations, &fit, &settings, &|| ()).unwrap(), []);
}

/// Standard errors of the coordinates by the errors of the input.
fn by_input(fit: &ChannelFit) -> [f64; 3] {
    let along = |quantity| fit.parameters.direction(&[(quantity, 1.0)]);
    Quantity::MEDIUM.map(|quantity| fit.input_error.variance_of(&along(quantity)).sqrt())
}

#[test]
fn errors_of_the_input_have_no_part_of_the_noise_of_the_paths() {
    let plane = Geometry::planar(48, 48, 0.05, 1.0).unwrap();
    let slope = sloping(48, 48, 0.05, 1.0, 0.3);
    // Of a slope the noise does not cancel whole: a path that ends in another pixel meets another light.
    for (name, geometry, paths, error, share) in
        [("plane", plane, 1 << 17, 0.0005, 0.1), ("slope", slope, 1 << 21, 0.01, 0.3)]
    {
        let views = Views::new(vec![geometry], halves(48), [2.0, 0.3, 10.0], 1001);
        for (depth_error, gain_error) in [(error, 0.0), (0.0, error)] {
            let mut observations = views.observations();
            (observations[0].depth_error, observations[0].gain_error) = (depth_error, gain_error);
            let fit = |settings: &Settings| {
                fit_channel(&observations, &views.options(false), settings, &|| ()).unwrap()
            };
            // Small-angle theory, which has no noise, serves at 10°.
            let wanted = by_input(&fit(&Settings { model: Model::SmallAngle, ..Settings::default() }));
            let traced = fit(&traced(paths));
            let found = by_input(&traced);
            let sigma_s = traced.parameters.direction(&[(Quantity::SigmaS, 1.0)]);
            let noise = traced.model_error.unwrap().variance_of(&sigma_s).sqrt();
            println!("{name}: {found:?} of {wanted:?}; paths {noise:.4}");
            let allowed = share * wanted.into_iter().fold(0.0, f64::max);
            assert!((0..3).all(|i| (found[i] - wanted[i]).abs() < allowed), "{name}");
            // Which a part of that noise would not leave alone.
            assert!(noise > 1.5 * error, "{name}: {noise}");
        }
    }
}
