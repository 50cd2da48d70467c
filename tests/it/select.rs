//! `--model auto`: no more model than a scene needs. Images are the reference model's, from thin to thick and from narrow to
//! wide; what is tested is which model is taken, and that its estimate deserves it.

use crate::common::estimates::{compare_all, values};
use crate::common::report::{fit_scenes, select};
use crate::common::{texture, with_noise};
use narrowbeam::filter::{Backend, Filter, Optics, Target};
use narrowbeam::fit::{SEQUENCE, SceneFit, Settings};
use narrowbeam::forward::Quantity;
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Channel, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{PhaseFunction, b_of_spread_angle};
use narrowbeam::scene::{
    FitOptions, Noise, Observation, ObservedScene, ParameterOptions, PartialMedium, Scene,
};
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
    /// What is known.
    fixed: &'static [Quantity],
}

impl Regime {
    fn truth(&self) -> Medium {
        let b = b_of_spread_angle(self.spread_angle_deg.to_radians());
        Medium::gaussian(self.tau / Z, self.sigma_a, b).unwrap()
    }

    fn options(&self) -> FitOptions {
        let truth = self.truth();
        let known = |quantity, value: f64| ParameterOptions {
            fixed: self.fixed.contains(&quantity).then_some(value),
            ..ParameterOptions::default()
        };
        FitOptions {
            sigma_s: known(Quantity::SigmaS, truth.sigma_s()),
            sigma_a: known(Quantity::SigmaA, truth.sigma_a()),
            phase: known(Quantity::Phase, truth.phase().parameter()),
            ..FitOptions::default()
        }
    }

    fn scene(&self) -> ObservedScene {
        let geometry = Geometry::planar(SIDE, SIDE, self.pixel_pitch, Z).unwrap();
        let optics = Optics { model: Model::WideAngle, medium: self.truth() };
        let object = texture(SIDE, SIDE);
        let target = Target::plain(&object, &geometry, Border::Zero, View::whole(SIDE, SIDE));
        let image = Backend::Cpu.prepare(target, &optics, 1.0).unwrap().render(&optics).unwrap();
        let image = with_noise(&image, self.noise, 7);
        let gray = |image: Image| vec![Channel { name: "Y".into(), image }];
        let scene = Scene {
            path: PathBuf::from("scene"),
            files: Vec::new(),
            object: gray(object),
            object_noise: None,
            cautions: Vec::new(),
            behind: vec![Vec::new()],
            geometry,
            depth_error: 0.0,
            border: Border::Zero,
            sampling: Sampling::Pixel,
            sampling_is_known: true,
            view: View::whole(SIDE, SIDE),
            medium: vec![PartialMedium::default()],
            fit: vec![self.options()],
        };
        let observation = Observation {
            noise: Some(Noise::Level(self.noise)),
            ..Observation::plain(PathBuf::from("observed"), gray(image))
        };
        ObservedScene { scene, observation }
    }

    fn select(&self) -> SceneFit {
        select(&[self.scene()], &Settings::default(), Filter::Auto, TOLERANCE, &|| ()).unwrap()
    }
}

const BASE: Regime =
    Regime { tau: 1.0, sigma_a: 0.1, spread_angle_deg: 3.0, pixel_pitch: 0.01, noise: 1e-3, fixed: &[] };

/// Name, medium, and the model that it needs.
const REGIMES: [(&str, Regime, Model); 6] = [
    (
        "absorption alone, next to no scattering",
        Regime { tau: 0.002, sigma_a: 0.5, fixed: &[Quantity::SigmaS, Quantity::Phase], ..BASE },
        Model::BeerLambert,
    ),
    (
        "thin, B known",
        Regime { tau: 0.01, fixed: &[Quantity::Phase], noise: 2e-3, ..BASE },
        Model::SingleScatter,
    ),
    (
        "absorption alone, scattering known",
        Regime {
            tau: 4.0,
            sigma_a: 0.5,
            fixed: &[Quantity::SigmaS, Quantity::Phase],
            pixel_pitch: 0.05,
            noise: 0.05,
            ..BASE
        },
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
    let mut asked = compare_all(fit, regime.truth()).into_iter().filter(|found| found.parameter.is_free());
    asked.all(|found| {
        let error = found.std_error.map(|e| e * found.parameter.slope());
        error.is_some_and(|e| found.error().abs() <= (TOLERANCE * found.truth).max(4.0 * e))
    })
}

#[test]
fn each_regime_gets_the_cheapest_model_that_does() {
    for (name, regime, model) in REGIMES {
        let fit = regime.select();
        println!("{name}: {}", fit.report.model);
        fit.report.candidates.iter().for_each(|candidate| println!("   {}", candidate.line()));
        assert_eq!(fit.report.model, model.name(), "{name}");
        assert!(is_right(&fit, &regime), "{name}: {:?}", values(&fit.channels[0].1));
        assert_eq!(fit.report.candidates.iter().filter(|candidate| candidate.taken).count(), 1);
        let last = fit.report.candidates.last();
        assert!(last.is_some_and(|last| last.taken && last.shortcoming.is_none()), "{name}");
    }
}

#[test]
fn what_is_passed_over_would_have_been_wrong() {
    for (name, regime, model) in &REGIMES[3..] {
        let taken = SEQUENCE.iter().position(|m| m == model).unwrap();
        for cheaper in &SEQUENCE[1..taken] {
            let settings = Settings { model: *cheaper, ..Settings::default() };
            let fit = fit_scenes(&[regime.scene()], &settings, Filter::Auto, &|| ()).unwrap();
            // What single scattering gets wrong in a thin medium is its total: sigma_s.
            let found = values(&fit.channels[0].1);
            assert!(!is_right(&fit, regime), "{name}: {cheaper} would do: {found:?}");
        }
    }
}

#[test]
fn the_stated_error_of_a_model_is_the_error_that_it_makes() {
    // To first order: what is left out is of second order in the error, so errors under 10 % are predicted to a quarter and
    // their noise.
    let media = [(1.0, 3.0, 0.01), (1.0, 8.0, 0.02), (3.0, 4.0, 0.02), (0.5, 12.0, 0.03)];
    for model in [Model::NarrowBeam, Model::SmallAngle] {
        for (tau, spread_angle_deg, pixel_pitch) in media {
            let regime = Regime { tau, spread_angle_deg, pixel_pitch, noise: 2e-4, ..BASE };
            let settings = Settings { model, ..Settings::default() };
            let fit = fit_scenes(&[regime.scene()], &settings, Filter::Auto, &|| ()).unwrap();
            let (_, fit) = &fit.channels[0];
            // Where a model's sigma_s runs away, beyond the range of the reference, it says so.
            let Some(error) = &fit.model_error else {
                assert_eq!((model, tau), (Model::NarrowBeam, 3.0));
                continue;
            };
            for found in compare_all(fit, regime.truth()) {
                let (name, made) = (found.name(), found.off());
                let said = error.bias_of(&fit.parameters.along(found.id));
                let noise = 4.0 * found.std_error.unwrap();
                println!("{model} tau {tau} {spread_angle_deg} deg, {name}: made {made:.5}, said {said:.5}");
                let share = made.abs() / found.unit();
                assert!(share > 0.1 || (made - said).abs() <= 0.25 * made.abs() + noise);
            }
        }
    }
}

#[test]
fn the_reference_itself_states_the_error_of_its_table_alone() {
    let fit = BASE.select();
    let settings = Settings { model: Model::WideAngle, ..Settings::default() };
    let wide = fit_scenes(&[BASE.scene()], &settings, Filter::Auto, &|| ()).unwrap();
    let wide = &wide.channels[0].1;
    let error = wide.model_error.as_ref().unwrap();
    let sigma_s = wide.parameters.direction(&[(Quantity::SigmaS, 1.0)]);
    assert!(error.bias_of(&sigma_s).abs() < 1e-3 * error.of(&sigma_s) + 1e-5);
    assert!(error.of(&sigma_s) > 5e-4 && error.of(&sigma_s) < 5e-3, "{}", error.of(&sigma_s));
    assert!(fit.channels[0].1.model_error.as_ref().unwrap().of(&sigma_s) > error.of(&sigma_s));
}
