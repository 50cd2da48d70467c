//! `--model auto`: no more model than a scene needs. Images are the reference model's, from thin to thick and from narrow to
//! wide; what is tested is which model is taken, and that its estimate deserves it.

use crate::common::{texture, with_noise};
use nalgebra::Vector3;
use narrowbeam::filter::{Backend, Filter, Optics, Target};
use narrowbeam::fit::ladder::{RUNGS, climb};
use narrowbeam::fit::scenes::{SceneFit, fit_scenes};
use narrowbeam::fit::{NAMES, Settings};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Channel, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, b_of_spread_angle};
use narrowbeam::scene::{FitOptions, Gain, Noise, Observation, ObservedScene, PartialMedium, Scene, Veil};
use narrowbeam::spread::Model;
use std::path::PathBuf;

const SIDE: usize = 64;
const Z: f64 = 1.0;
/// What `--tolerance` is if not given.
const TOLERANCE: f64 = 0.01;

/// A medium, the pixel pitch and the noise with which it is looked at.
#[derive(Clone, Copy)]
struct Regime {
    tau: f64,
    sigma_a: f64,
    spread_angle_deg: f64,
    pixel_pitch: f64,
    noise: f64,
    /// Which of sigma_s, sigma_a, B are known.
    fixed: [bool; 3],
}

impl Regime {
    fn truth(&self) -> [f64; 3] {
        [self.tau / Z, self.sigma_a, b_of_spread_angle(self.spread_angle_deg.to_radians())]
    }

    fn scene(&self) -> ObservedScene {
        let geometry = Geometry::planar(SIDE, SIDE, self.pixel_pitch, Z).unwrap();
        let [sigma_s, sigma_a, b] = self.truth();
        let phase = Gaussian::new(b).unwrap();
        let optics =
            Optics { model: Model::WideAngle, medium: Medium::new(sigma_s, sigma_a, phase.into()).unwrap() };
        let object = texture(SIDE, SIDE);
        let target = Target {
            radiance: &object,
            behind: &[],
            geometry: &geometry,
            border: Border::Zero,
            view: View::whole(SIDE, SIDE),
            relief: None,
        };
        let image = Backend::Cpu.prepare(target, &optics, 1.0).unwrap().render(&optics).unwrap();
        let image = with_noise(&image, self.noise, 7);
        let gray = |image: Image| vec![Channel { name: "Y".into(), image }];
        let fixed = std::array::from_fn(|i| self.fixed[i].then_some(self.truth()[i]));
        let scene = Scene {
            path: PathBuf::from("scene"),
            object: gray(object),
            behind: vec![Vec::new()],
            geometry,
            depth_error: 0.0,
            border: Border::Zero,
            view: View::whole(SIDE, SIDE),
            medium: vec![PartialMedium::default()],
            fit: vec![FitOptions { fixed, ..FitOptions::default() }],
        };
        let observation = Observation {
            path: PathBuf::from("observed"),
            image: gray(image),
            noise: Some(Noise::Level(self.noise)),
            mask: None,
            gain: Gain::Fixed(1.0),
            veil: Veil::Fixed(0.0),
            gain_error: 0.0,
            hidden_share_max: 0.01,
        };
        ObservedScene { scene, observation }
    }

    fn climb(&self) -> SceneFit {
        climb(&[self.scene()], &Settings::default(), Filter::Auto, TOLERANCE).unwrap()
    }
}

const BASE: Regime = Regime {
    tau: 1.0,
    sigma_a: 0.1,
    spread_angle_deg: 3.0,
    pixel_pitch: 0.01,
    noise: 1e-3,
    fixed: [false; 3],
};

/// Name, medium, and the model that it needs.
const REGIMES: [(&str, Regime, Model); 6] = [
    (
        "absorption alone, next to no scattering",
        Regime { tau: 0.002, sigma_a: 0.5, fixed: [true, false, true], ..BASE },
        Model::BeerLambert,
    ),
    (
        "thin, B known",
        Regime { tau: 0.01, fixed: [false, false, true], noise: 2e-3, ..BASE },
        Model::SingleScatter,
    ),
    (
        "absorption alone, scattering known",
        Regime { tau: 4.0, sigma_a: 0.5, fixed: [true, false, true], pixel_pitch: 0.05, noise: 0.05, ..BASE },
        Model::Gaussian,
    ),
    ("thin", Regime { tau: 0.05, ..BASE }, Model::NarrowBeam),
    ("of one mean free path, narrow", BASE, Model::SmallAngle),
    (
        "of one mean free path, wide",
        Regime { spread_angle_deg: 30.0, pixel_pitch: 0.04, ..BASE },
        Model::WideAngle,
    ),
];

/// Whether the fit of `model` is within the tolerance of the truth, or within its noise (four standard errors).
fn is_right(fit: &SceneFit, regime: &Regime) -> bool {
    let (_, fit) = &fit.channels[0];
    let right = |i: usize| {
        let (value, truth) = (fit.parameters.values()[i], regime.truth()[i]);
        let error = fit.uncertainty.std_error(i).map(|e| if i == 1 { e } else { e * value });
        error.is_some_and(|e| (value - truth).abs() <= (TOLERANCE * truth).max(4.0 * e))
    };
    (0..3).filter(|&i| !regime.fixed[i]).all(right)
}

#[test]
fn each_regime_gets_the_cheapest_model_that_does() {
    for (name, regime, model) in REGIMES {
        let fit = regime.climb();
        println!("{name}: {}", fit.report.model);
        fit.report.ladder.iter().for_each(|rung| println!("   {}", rung.line()));
        assert_eq!(fit.report.model, model.name(), "{name}");
        assert!(is_right(&fit, &regime), "{name}: {:?}", fit.channels[0].1.parameters.values());
        assert_eq!(fit.report.ladder.iter().filter(|rung| rung.taken).count(), 1);
        assert!(
            fit.report.ladder.last().is_some_and(|rung| rung.taken && rung.shortcoming.is_none()),
            "{name}"
        );
    }
}

#[test]
fn what_is_passed_over_would_have_been_wrong() {
    for (name, regime, model) in &REGIMES[3..] {
        let rung = RUNGS.iter().position(|m| m == model).unwrap();
        for cheaper in &RUNGS[1..rung] {
            let settings = Settings { model: *cheaper, ..Settings::default() };
            let fit = fit_scenes(&[regime.scene()], &settings, Filter::Auto).unwrap();
            // What single scattering gets wrong in a thin medium is its total: sigma_s.
            assert!(
                !is_right(&fit, regime),
                "{name}: {cheaper} would do: {:?}",
                fit.channels[0].1.parameters
            );
        }
    }
}

#[test]
fn the_stated_error_of_a_model_is_the_error_that_it_makes() {
    // To first order: what is left out is of second order in the error, so errors under 10 % are foretold to a quarter and
    // their noise.
    let media = [(1.0, 3.0, 0.01), (1.0, 8.0, 0.02), (3.0, 4.0, 0.02), (0.5, 12.0, 0.03)];
    for model in [Model::NarrowBeam, Model::SmallAngle] {
        for (tau, spread_angle_deg, pixel_pitch) in media {
            let regime = Regime { tau, spread_angle_deg, pixel_pitch, noise: 2e-4, ..BASE };
            let settings = Settings { model, ..Settings::default() };
            let fit = fit_scenes(&[regime.scene()], &settings, Filter::Auto).unwrap();
            let (_, fit) = &fit.channels[0];
            // Where a model's sigma_s runs away, beyond the range of the reference, it says so.
            let Some(error) = fit.model_error else {
                assert_eq!((model, tau), (Model::NarrowBeam, 3.0));
                continue;
            };
            for (i, name) in NAMES.into_iter().enumerate() {
                let (value, truth) = (fit.parameters.values()[i], regime.truth()[i]);
                let made = if i == 1 { value - truth } else { (value / truth).ln() };
                let said = error.bias_of(&Vector3::ith(i, 1.0));
                let noise = 4.0 * fit.uncertainty.std_error(i).unwrap();
                println!("{model} tau {tau} {spread_angle_deg} deg, {name}: made {made:.5}, said {said:.5}");
                let share = if i == 1 { made.abs() / truth } else { made.abs() };
                assert!(share > 0.1 || (made - said).abs() <= 0.25 * made.abs() + noise);
            }
        }
    }
}

#[test]
fn the_reference_itself_states_the_error_of_its_table_alone() {
    let fit = BASE.climb();
    let settings = Settings { model: Model::WideAngle, ..Settings::default() };
    let wide = fit_scenes(&[BASE.scene()], &settings, Filter::Auto).unwrap();
    let error = wide.channels[0].1.model_error.unwrap();
    let sigma_s = Vector3::ith(0, 1.0);
    assert!(error.bias_of(&sigma_s).abs() < 1e-3 * error.of(&sigma_s) + 1e-5);
    assert!(error.of(&sigma_s) > 5e-4 && error.of(&sigma_s) < 5e-3, "{}", error.of(&sigma_s));
    assert!(fit.channels[0].1.model_error.unwrap().of(&sigma_s) > error.of(&sigma_s));
}
