//! Do the error bars hold? The same scene with fresh noise, fitted again and again.
//!
//! The images are those of the model that is fitted, so the whole error is the noise's: 95 of 100 intervals of ± 1.96
//! standard errors should hold the truth, and the root mean square error should be the Cramér-Rao bound, the standard error
//! that a fit of the noiseless image states (see [`forecast`](crate::fit::forecast)).

use super::{Setting, Texture};
use crate::error::Result;
use crate::filter::Filter;
use crate::fit::noise::{with_noise, with_variance};
use crate::fit::scenes::fit_scenes;
use crate::fit::{ChannelFit, NAMES, Parameters, Settings};
use crate::image::{Channel, Image};
use crate::medium::Medium;
use crate::phase::b_of_spread_angle;
use crate::scene::{Gain, Noise, ObservedScene, Veil};
use crate::spread::Model;
use rayon::prelude::*;

/// The noise of the images, and what the fit is told of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Told {
    /// One standard deviation for all pixels, which is given.
    Level,
    /// The same, to be estimated.
    Nothing,
    /// A standard deviation that grows from a third to three times as much from left to right; the variances are given.
    Variance,
}

/// How far the standard deviation of uneven noise goes from its mean.
const UNEVEN: f32 = 3.0;

/// A measurement that is repeated.
#[derive(Debug, Clone)]
pub struct Case {
    /// What is special about it.
    pub name: &'static str,
    /// The model that makes the images and is fitted.
    pub model: Model,
    /// The planes, all behind the same medium.
    pub planes: Vec<Setting>,
    /// Standard deviation of a pixel, of uneven noise the geometric mean.
    pub noise: f64,
    /// What the fit is told of it.
    pub told: Told,
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

/// The cases that are looked at: thin and thick, narrow and wide, clean and noisy, sharp and soft, noise known and not, even
/// and not, exposure known and not.
///
/// # Errors
/// None but those of constants out of range.
pub fn cases() -> Result<Vec<Case>> {
    let b = |degrees: f64| b_of_spread_angle(degrees.to_radians());
    let base = Setting {
        texture: Texture::Checker,
        side: 48,
        pixel_pitch: 0.03,
        z: 2.0,
        medium: Medium::gaussian(0.7, 0.15, b(7.0))?,
    };
    let medium = |sigma_s, sigma_a, degrees| -> Result<Setting> {
        Ok(Setting { medium: Medium::gaussian(sigma_s, sigma_a, b(degrees))?, ..base })
    };
    let near = Setting { z: 1.0, ..base };
    let case = |name, planes: &[Setting], noise| Case {
        name,
        model: Model::SmallAngle,
        planes: planes.to_vec(),
        noise,
        told: Told::Level,
        exposure_free: false,
    };
    Ok(vec![
        case("tau 1.4, 7°, checker", &[base], 0.01),
        Case { told: Told::Nothing, ..case("the same, noise estimated", &[base], 0.01) },
        case("tau .3, thin", &[medium(0.15, 0.05, 7.0)?], 0.005),
        case("tau 5, thick", &[medium(2.5, 0.1, 5.0)?], 0.001),
        case("noise of 5 %", &[base], 0.02),
        case("disks", &[Setting { texture: Texture::Natural, ..base }], 0.01),
        Case { exposure_free: true, ..case("two depths, second exposure free", &[near, base], 0.01) },
        Case {
            model: Model::WideAngle,
            ..case("30°, wide-angle", &[Setting { pixel_pitch: 0.1, ..medium(0.8, 0.1, 30.0)? }], 0.005)
        },
        Case { model: Model::Gaussian, ..case("tau 3, gaussian", &[medium(1.5, 0.1, 6.0)?], 0.003) },
        Case { told: Told::Variance, ..case("noise uneven, variances given", &[base], 0.01) },
    ])
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
            scene.scene.fit[0].start = truth.map(Some);
            let observation = &mut scene.observation;
            observation.noise = observation.noise.take().or(Some(Noise::Level(self.noise)));
        }
        let ideal =
            fit_scenes(&known, &Settings { sums: false, ..settings }, Filter::Auto)?.channels.remove(0).1;
        let one = |draw: usize| -> Result<[Drawn; 3]> {
            let first = (draw * self.planes.len()) as u64;
            let scenes = self.noisy(clean.clone(), seed.wrapping_mul(1 << 32).wrapping_add(first));
            let quiet = Settings { model: self.model, ..Settings::default() };
            let fit = fit_scenes(&scenes, &quiet, Filter::Auto)?.channels.remove(0).1;
            progress();
            Ok(std::array::from_fn(|i| Drawn {
                error: coordinate(&fit, i) - of(i, truth[i]),
                std_error: fit.uncertainty.std_error(i),
            }))
        };
        let all = (0..draws).into_par_iter().map(one).collect::<Result<Vec<_>>>()?;
        Ok((0..3).map(|i| coverage(i, ideal.uncertainty.std_error(i).unwrap_or(f64::NAN), &all)).collect())
    }

    /// The scenes as they would be measured once.
    ///
    /// # Errors
    /// As [`Setting::render`].
    pub fn scenes(&self, seed: u64) -> Result<Vec<ObservedScene>> {
        let clean = self.planes.iter().map(|plane| self.scene(plane)).collect::<Result<_>>()?;
        Ok(self.noisy(clean, seed))
    }

    /// `scenes` with the noise of `seed` and the seeds that follow it.
    fn noisy(&self, mut scenes: Vec<ObservedScene>, seed: u64) -> Vec<ObservedScene> {
        for (scene, own) in scenes.iter_mut().zip(0..) {
            let image = &mut scene.observation.image[0].image;
            *image = self.draw(image, seed.wrapping_add(own));
        }
        scenes
    }

    /// `image` with noise.
    fn draw(&self, image: &Image, seed: u64) -> Image {
        match self.told {
            Told::Level | Told::Nothing => with_noise(image, self.noise, seed),
            Told::Variance => with_variance(image, &self.variance(image), seed),
        }
    }

    /// The variance of each pixel of `image` where noise is uneven.
    fn variance(&self, image: &Image) -> Image {
        Image::from_fn(image.width, image.height, |x, _| {
            let across = 2.0 * (x as f32 + 0.5) / image.width as f32 - 1.0;
            (self.noise as f32 * UNEVEN.powf(across)).powi(2)
        })
    }

    fn scene(&self, plane: &Setting) -> Result<ObservedScene> {
        let image = plane.render(self.model)?;
        let variance = vec![Channel { name: "Y".into(), image: self.variance(&image) }];
        let mut scene = plane.scene(image, None)?;
        let observation = &mut scene.observation;
        observation.noise = match self.told {
            Told::Level => Some(Noise::Level(self.noise)),
            Told::Nothing => None,
            Told::Variance => Some(Noise::Variance(variance)),
        };
        if self.exposure_free && Some(plane) == self.planes.last() {
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

/// One parameter of one fit.
#[derive(Clone, Copy)]
struct Drawn {
    /// Estimate minus truth, of the coordinate.
    error: f64,
    /// As the fit states it; `None` if the parameter is called undetermined.
    std_error: Option<f64>,
}

fn coverage(parameter: usize, bound: f64, all: &[[Drawn; 3]]) -> Coverage {
    let draws: Vec<Drawn> = all.iter().map(|draw| draw[parameter]).collect();
    let number = draws.len() as f64;
    let holds = |d: &&Drawn| d.std_error.is_some_and(|s| d.error.abs() <= NORMAL_95 * s);
    Coverage {
        parameter,
        bound,
        draws: draws.len(),
        inside: draws.iter().filter(holds).count(),
        undetermined: draws.iter().filter(|d| d.std_error.is_none()).count(),
        bias: draws.iter().map(|d| d.error).sum::<f64>() / number / bound,
        rms: (draws.iter().map(|d| d.error * d.error).sum::<f64>() / number).sqrt() / bound,
    }
}
