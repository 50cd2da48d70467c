//! Do the error bars hold? The same scene with fresh noise, fitted again and again.
//!
//! The images are those of the model that is fitted, so the whole error is the noise's: 95 of 100 intervals of ± 1.96
//! standard errors should hold the truth, and the root mean square error should be the Cramér-Rao bound, the standard error
//! that a fit of the noiseless image states (see [`forecast`](crate::fit::forecast)).

use super::{Setting, Texture};
use crate::error::Result;
use crate::filter::Filter;
use crate::fit::noise::with_noise;
use crate::fit::scenes::fit_scenes;
use crate::fit::{ChannelFit, NAMES, Parameters, Settings};
use crate::phase::b_of_spread_angle;
use crate::scene::{Gain, MediumValues, Scene, Veil};
use crate::spread::Model;
use rayon::prelude::*;

/// A measurement that is repeated.
#[derive(Debug, Clone)]
pub struct Case {
    /// What is special about it.
    pub name: &'static str,
    /// The model that makes the images and is fitted.
    pub model: Model,
    /// The planes, all behind the same medium.
    pub planes: Vec<Setting>,
    /// Standard deviation of a pixel.
    pub noise: f64,
    /// Whether the fit is told so.
    pub noise_known: bool,
    /// Whether gain and veil of the last plane are fitted.
    pub exposure_free: bool,
}

/// How one parameter of a case came out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// Index in [`NAMES`].
    pub parameter: usize,
    /// Cramér-Rao bound of ln sigma_s, sigma_a or ln B.
    pub bound: f64,
    /// Fits.
    pub draws: usize,
    /// Those whose interval holds the truth.
    pub inside: usize,
    /// Those that call the parameter undetermined.
    pub undetermined: usize,
    /// Mean error in units of the bound.
    pub bias: f64,
    /// Root mean square error in units of the bound.
    pub rms: f64,
}

impl Coverage {
    /// Share of the intervals that hold the truth.
    pub fn share(&self) -> f64 {
        self.inside as f64 / self.draws as f64
    }

    /// The parameter's name.
    pub fn name(&self) -> &'static str {
        NAMES[self.parameter]
    }
}

/// The cases that are looked at: thin and thick, narrow and wide, clean and noisy, sharp and soft, noise known and not,
/// exposure known and not.
pub fn cases() -> Vec<Case> {
    let b = |degrees: f64| b_of_spread_angle(degrees.to_radians());
    let base = Setting {
        texture: Texture::Checker,
        side: 48,
        pixel_pitch: 0.03,
        z: 2.0,
        medium: MediumValues::gaussian(0.7, 0.15, b(7.0)),
    };
    let medium = |sigma_s, sigma_a, degrees| Setting {
        medium: MediumValues::gaussian(sigma_s, sigma_a, b(degrees)),
        ..base
    };
    let near = Setting { z: 1.0, ..base };
    let case = |name, planes: &[Setting], noise| Case {
        name,
        model: Model::SmallAngle,
        planes: planes.to_vec(),
        noise,
        noise_known: true,
        exposure_free: false,
    };
    vec![
        case("tau 1.4, 7°, checker", &[base], 0.01),
        Case { noise_known: false, ..case("the same, noise estimated", &[base], 0.01) },
        case("tau .3, thin", &[medium(0.15, 0.05, 7.0)], 0.005),
        case("tau 5, thick", &[medium(2.5, 0.1, 5.0)], 0.001),
        case("noise of 5 %", &[base], 0.02),
        case("disks", &[Setting { texture: Texture::Natural, ..base }], 0.01),
        Case { exposure_free: true, ..case("two depths, second exposure free", &[near, base], 0.01) },
        Case {
            model: Model::WideAngle,
            ..case("30°, wide-angle", &[Setting { pixel_pitch: 0.1, ..medium(0.8, 0.1, 30.0) }], 0.005)
        },
        Case { model: Model::Gaussian, ..case("tau 3, gaussian", &[medium(1.5, 0.1, 6.0)], 0.003) },
    ]
}

impl Case {
    /// Fits `draws` noisy images and compares with the bound; `progress` is called after each.
    ///
    /// # Errors
    /// As [`fit_scenes`].
    pub fn run(&self, draws: usize, seed: u64, progress: &(dyn Fn() + Sync)) -> Result<Vec<Coverage>> {
        let clean = self.planes.iter().map(|plane| self.scene(plane)).collect::<Result<Vec<_>>>()?;
        let settings = Settings { model: self.model, ..Settings::default() };
        let truth = self.planes[0].truth();
        let mut known = clean.clone();
        for scene in &mut known {
            scene.fit[0].start = truth.map(Some);
            scene.observation.as_mut().expect("made with one").noise = Some(self.noise);
        }
        let ideal =
            fit_scenes(&known, &Settings { sums: false, ..settings }, Filter::Auto)?.channels.remove(0).1;
        let one = |draw: usize| -> Result<[(f64, Option<f64>); 3]> {
            let mut scenes = clean.clone();
            for (i, scene) in scenes.iter_mut().enumerate() {
                let observation = scene.observation.as_mut().expect("made with one");
                let image = &mut observation.image[0].image;
                let own = (draw * self.planes.len() + i) as u64;
                *image = with_noise(image, self.noise, seed.wrapping_mul(1 << 32).wrapping_add(own));
            }
            let quiet = Settings { model: self.model, ..Settings::default() };
            let fit = fit_scenes(&scenes, &quiet, Filter::Auto)?.channels.remove(0).1;
            progress();
            Ok(std::array::from_fn(|i| (coordinate(&fit, i) - of(i, truth[i]), fit.uncertainty.std_error(i))))
        };
        let all = (0..draws).into_par_iter().map(one).collect::<Result<Vec<_>>>()?;
        Ok((0..3).map(|i| coverage(i, ideal.uncertainty.std_error(i).unwrap_or(f64::NAN), &all)).collect())
    }

    fn scene(&self, plane: &Setting) -> Result<Scene> {
        let mut scene = plane.scene(plane.render(self.model)?, self.noise_known.then_some(self.noise))?;
        if self.exposure_free && Some(plane) == self.planes.last() {
            let observation = scene.observation.as_mut().expect("made with one");
            (observation.gain, observation.veil) = (Gain::Free, Veil::Free);
        }
        Ok(scene)
    }
}

/// The coordinate of parameter `i` in which errors are stated.
fn of(i: usize, value: f64) -> f64 {
    if Parameters::is_logarithmic(i) { value.ln() } else { value }
}

fn coordinate(fit: &ChannelFit, i: usize) -> f64 {
    of(i, fit.parameters.values()[i])
}

/// 97.5 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.959_964;

fn coverage(parameter: usize, bound: f64, all: &[[(f64, Option<f64>); 3]]) -> Coverage {
    let errors: Vec<(f64, Option<f64>)> = all.iter().map(|draw| draw[parameter]).collect();
    let number = errors.len() as f64;
    Coverage {
        parameter,
        bound,
        draws: errors.len(),
        inside: errors.iter().filter(|(e, s)| s.is_some_and(|s| e.abs() <= NORMAL_95 * s)).count(),
        undetermined: errors.iter().filter(|(_, s)| s.is_none()).count(),
        bias: errors.iter().map(|(e, _)| e).sum::<f64>() / number / bound,
        rms: (errors.iter().map(|(e, _)| e * e).sum::<f64>() / number).sqrt() / bound,
    }
}
