//! Are the error bars right? The same scene is fitted again and again, each time with new noise.
//!
//! The images are made by the model that is fitted, so the noise is the only source of error. 95 of 100 intervals of ± 1.96
//! standard errors should contain the truth, and the root mean square error should equal the Cramér-Rao bound, the standard
//! error that a fit of the noiseless image reports (see [`forecast`](crate::fit::forecast)).

use super::{Setting, Texture};
use crate::error::Result;
use crate::filter::Filter;
use crate::fit::noise::{with_noise, with_variance};
use crate::fit::{ChannelFit, Id, Parameter, Settings, fit_scenes};
use crate::image::{Channel, Image};
use crate::imaging::VeilField;
use crate::medium::Medium;
use crate::phase::b_of_spread_angle;
use crate::scene::{Gain, Noise, ObservedScene, Veil};
use crate::spread::Model;
use rayon::prelude::*;

/// The noise of the images, and what the fit knows of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KnownNoise {
    /// One standard deviation for all pixels, which is given.
    Level,
    /// The same, to be estimated.
    Nothing,
    /// A standard deviation that grows from a third to three times as much from left to right; the variances are given.
    Variance,
}

/// Largest ratio of the standard deviation of uneven noise to its mean.
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
    /// What the fit knows of it.
    pub known: KnownNoise,
    /// Whether gain and veil of the last plane are fitted.
    pub exposure_free: bool,
}

/// How one parameter of a case came out.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Name of the parameter.
    pub parameter: String,
    /// Cramér-Rao bound of ln sigma_s, sigma_a or ln B.
    pub bound: f64,
    /// Fits.
    pub draws: usize,
    /// Those whose interval contains the truth.
    pub inside: usize,
    /// Those that report the parameter as undetermined.
    pub undetermined: usize,
    /// Mean error in units of the bound.
    pub bias: f64,
    /// Root mean square error in units of the bound.
    pub rms: f64,
}

impl Coverage {
    /// Share of the intervals that contain the truth.
    pub fn share(&self) -> f64 {
        self.inside as f64 / self.draws as f64
    }
}

/// The cases: thin and thick, narrow and wide, clean and noisy, sharp and soft, with known and unknown, uniform and uneven
/// noise, with known and unknown exposure.
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
        known: KnownNoise::Level,
        exposure_free: false,
    };
    Ok(vec![
        case("tau 1.4, 7°, checker", &[base], 0.01),
        Case { known: KnownNoise::Nothing, ..case("the same, noise estimated", &[base], 0.01) },
        case("tau 0.3, thin", &[medium(0.15, 0.05, 7.0)?], 0.005),
        case("tau 5, thick", &[medium(2.5, 0.1, 5.0)?], 0.001),
        case("noise of 5 %", &[base], 0.02),
        case("disks", &[Setting { texture: Texture::Natural, ..base }], 0.01),
        Case { exposure_free: true, ..case("two depths, second exposure free", &[near, base], 0.01) },
        Case {
            model: Model::WideAngle,
            ..case("30°, wide-angle", &[Setting { pixel_pitch: 0.1, ..medium(0.8, 0.1, 30.0)? }], 0.005)
        },
        Case { model: Model::Gaussian, ..case("tau 3, gaussian", &[medium(1.5, 0.1, 6.0)?], 0.003) },
        Case { known: KnownNoise::Variance, ..case("noise uneven, variances given", &[base], 0.01) },
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
        let truth = &self.planes[0];
        let mut known = clean.clone();
        for scene in &mut known {
            let options = &mut scene.scene.fit[0];
            *options = options.started_at(|quantity| truth.truth(quantity));
            let observation = &mut scene.observation;
            observation.noise = observation.noise.take().or(Some(Noise::Level(self.noise)));
        }
        let ideal = fit(&known, &Settings { gram: false, ..settings })?;
        let one = |draw: usize| -> Result<Vec<Drawn>> {
            let first = (draw * self.planes.len()) as u64;
            let scenes = self.noisy(clean.clone(), seed.wrapping_mul(1 << 32).wrapping_add(first));
            let fit = fit(&scenes, &Settings { model: self.model, ..Settings::default() })?;
            progress();
            Ok(fit
                .parameters
                .of_medium()
                .map(|(id, p)| Drawn::new(&fit, id, truth.truth(p.descriptor().quantity)))
                .collect())
        };
        let all = (0..draws).into_par_iter().map(one).collect::<Result<Vec<_>>>()?;
        let parameters = ideal.parameters.of_medium().enumerate();
        let coverage = |(i, (id, parameter)): (usize, (Id, &Parameter))| {
            let bound = ideal.covariance.std_error(id).unwrap_or(f64::NAN);
            let drawn: Vec<Drawn> = all.iter().map(|draw| draw[i]).collect();
            coverage(parameter.name(), bound, &drawn)
        };
        Ok(parameters.map(coverage).collect())
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
        match self.known {
            KnownNoise::Level | KnownNoise::Nothing => with_noise(image, self.noise, seed),
            KnownNoise::Variance => with_variance(image, &self.variance(image), seed),
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
        observation.noise = match self.known {
            KnownNoise::Level => Some(Noise::Level(self.noise)),
            KnownNoise::Nothing => None,
            KnownNoise::Variance => Some(Noise::Variance(variance)),
        };
        if self.exposure_free && Some(plane) == self.planes.last() {
            (observation.gain, observation.veil) = (Gain::Free, Veil::Free(VeilField::Constant));
        }
        Ok(scene)
    }
}

/// The fit of the only channel.
fn fit(scenes: &[ObservedScene], settings: &Settings) -> Result<ChannelFit> {
    Ok(fit_scenes(scenes, settings, Filter::Auto, &|| ())?.channels.remove(0).1)
}

/// The estimate of one parameter from one draw, in its coordinate.
#[derive(Debug, Clone, Copy)]
struct Drawn {
    error: f64,
    /// `None` if the parameter was reported as undetermined.
    std_error: Option<f64>,
}

impl Drawn {
    fn new(fit: &ChannelFit, id: Id, truth: f64) -> Self {
        let parameter = fit.parameters.get(id);
        let error = parameter.coordinate() - parameter.coordinate_of(truth);
        Self { error, std_error: fit.covariance.std_error(id) }
    }
}

/// 97.5 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.959_964;

fn coverage(parameter: &str, bound: f64, drawn: &[Drawn]) -> Coverage {
    let number = drawn.len() as f64;
    let is_inside = |d: &&Drawn| d.std_error.is_some_and(|s| d.error.abs() <= NORMAL_95 * s);
    Coverage {
        parameter: parameter.into(),
        bound,
        draws: drawn.len(),
        inside: drawn.iter().filter(is_inside).count(),
        undetermined: drawn.iter().filter(|d| d.std_error.is_none()).count(),
        bias: drawn.iter().map(|d| d.error).sum::<f64>() / number / bound,
        rms: (drawn.iter().map(|d| d.error * d.error).sum::<f64>() / number).sqrt() / bound,
    }
}
