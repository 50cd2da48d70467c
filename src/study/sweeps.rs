//! The images of the stability study: a grid of media, and one thing after the other gone wrong.

use super::setting::{Setting, Texture};
use super::stability::{Method, Trial};
use crate::error::Result;
use crate::fit::Method as Solver;
use crate::fit::noise::with_noise;
use crate::geometry::Geometry;
use crate::image::Image;
use crate::phase::{HenyeyGreenstein, b_of_spread_angle};
use crate::scene::{MediumValues, Scene};
use crate::spread::Model;
use crate::trace::log_spaced;
use rayon::prelude::*;

/// How much is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Extent {
    /// Side of the images, px.
    pub side: usize,
    /// Paths a pixel of a traced image.
    pub samples: u32,
    /// Scattering depths of the grid.
    pub tau: Vec<f64>,
    /// Spread angles of the grid, degrees.
    pub spread_angle_deg: Vec<f64>,
    /// Decades by which a start may have too much of both sigma_s and B. Its kernels are as wide as they get, and a simplex takes
    /// a minute from two decades.
    pub widest_start: f64,
}

impl Extent {
    /// What `narrowbeam stability` looks at.
    pub fn full() -> Self {
        Self {
            side: 48,
            samples: 2048,
            tau: log_spaced(0.1, 12.0, 8),
            spread_angle_deg: log_spaced(2.0, 60.0, 7),
            widest_start: 2.0,
        }
    }

    /// The same in half a minute on two cores.
    pub fn quick() -> Self {
        Self {
            side: 32,
            samples: 256,
            tau: log_spaced(0.2, 8.0, 3),
            spread_angle_deg: log_spaced(4.0, 40.0, 3),
            widest_start: 1.0,
        }
    }
}

/// The models of the grid, and the solvers where it matters.
pub const METHODS: [Method; 10] = [
    Method::of(Model::BeerLambert),
    Method::of(Model::SingleScatter),
    Method::of(Model::Gaussian),
    Method::of(Model::NarrowBeamPrinted),
    Method::of(Model::NarrowBeam),
    Method::of(Model::SmallAngle),
    Method::of(Model::WideAngle),
    Method { model: Some(Model::SmallAngle), solver: Solver::NelderMead },
    Method { model: Some(Model::WideAngle), solver: Solver::NelderMead },
    Method::AUTO,
];

/// What is fitted along the sweeps.
const SWEPT: [Method; 3] = [Method::of(Model::SmallAngle), Method::of(Model::WideAngle), Method::AUTO];
/// The same without the choice of a model, by either solver, for starts.
const SOLVED: [Method; 4] = [METHODS[5], METHODS[6], METHODS[7], METHODS[8]];

const Z: f64 = 2.0;
/// Standard deviation of the noise along the sweeps, in mean radiances.
const NOISE: f64 = 0.005;
/// Paths a pixel along the sweeps, in those of the grid: their noise is to be less than what is added.
const CLEANER: u32 = 8;

/// A plane at scattering depth `tau` in a medium of this spread angle; a pixel is a fifth of the width z sqrt(B).
pub fn plane(tau: f64, spread_angle_deg: f64, side: usize) -> Setting {
    let b = b_of_spread_angle(spread_angle_deg.to_radians());
    let medium = MediumValues::gaussian(tau / Z, 0.3 / Z, b);
    Setting { texture: Texture::Checker, side, pixel_pitch: 0.2 * Z * b.sqrt(), z: Z, medium }
}

/// What traces and fits are reported to: how many of them are done.
pub type Tick<'a> = &'a (dyn Fn(u64) + Sync);

/// Fits over the grid of scattering depths and spread angles, by all `METHODS`.
///
/// # Errors
/// As [`Setting::trace`].
pub fn grid(extent: &Extent, seed: u64, tick: Tick) -> Result<Vec<Trial>> {
    let mut trials = Vec::new();
    for (i, &tau) in extent.tau.iter().enumerate() {
        for (j, &degrees) in extent.spread_angle_deg.iter().enumerate() {
            let setting = plane(tau, degrees, extent.side);
            let seed = seed + (i * extent.spread_angle_deg.len() + j) as u64;
            let image = setting.trace(&setting.medium.lobe()?, extent.samples, seed)?.mean;
            let scene = setting.scene(image, None)?;
            trials.extend(fits("grid", (tau, String::new()), &setting, &scene, &METHODS, [true; 3]));
            tick(1);
        }
    }
    Ok(trials)
}

fn fits(
    sweep: &'static str,
    (level, label): (f64, String),
    setting: &Setting,
    scene: &Scene,
    methods: &[Method],
    compared: [bool; 3],
) -> Vec<Trial> {
    let one = |&method: &Method| Trial {
        sweep,
        level,
        label: label.clone(),
        setting: *setting,
        method,
        outcome: method.try_on(scene, setting, compared),
    };
    methods.par_iter().map(one).collect()
}

/// Number of traces that [`sweeps`] makes.
pub const SWEEP_TRACES: u64 = 2 * (1 + 4 + 7 + 4);

/// Fits along all sweeps, around a medium of narrow lobes and one of wide lobes.
///
/// # Errors
/// As [`Setting::trace`].
pub fn sweeps(extent: &Extent, seed: u64, tick: Tick) -> Result<Vec<Trial>> {
    let mut trials = Vec::new();
    for (i, degrees) in [6.0, 30.0].into_iter().enumerate() {
        let base = plane(1.5, degrees, extent.side);
        let (samples, seed) = (extent.samples * CLEANER, seed + 1000 * (i as u64 + 1));
        trials.extend(Sweeps { base, samples, widest_start: extent.widest_start, seed, tick }.all()?);
    }
    Ok(trials)
}

struct Sweeps<'a> {
    base: Setting,
    samples: u32,
    widest_start: f64,
    seed: u64,
    tick: Tick<'a>,
}

impl Sweeps<'_> {
    fn all(&self) -> Result<Vec<Trial>> {
        let clean = self.trace(&self.base)?;
        let mut trials = self.noise(&clean)?;
        trials.extend(self.starts(&clean)?);
        trials.extend(self.textures()?);
        trials.extend(self.pitches()?);
        trials.extend(self.wrong_inputs(&clean)?);
        trials.extend(self.phase_functions()?);
        trials.extend(self.heterogeneous()?);
        trials.extend(self.saturated(&clean)?);
        Ok(trials)
    }

    fn trace(&self, setting: &Setting) -> Result<Image> {
        let image = setting.trace(&setting.medium.lobe()?, self.samples, self.seed)?.mean;
        (self.tick)(1);
        Ok(image)
    }

    /// The scene of `clean` with the usual noise.
    fn noisy(&self, setting: &Setting, clean: &Image) -> Result<Scene> {
        setting.scene(with_noise(clean, NOISE * clean.mean(), self.seed), None)
    }

    fn noise(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for level in [0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2] {
            let scene = self.base.scene(with_noise(clean, level * clean.mean(), self.seed), None)?;
            trials.extend(fits("noise", (level, String::new()), &self.base, &scene, &SWEPT, [true; 3]));
        }
        Ok(trials)
    }

    fn starts(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for (i, sign) in [[1, 1], [1, -1], [-1, 1], [-1, -1]].into_iter().enumerate() {
            let most = if sign == [1, 1] { self.widest_start } else { f64::INFINITY };
            for decades in [0.5, 1.0, 2.0].into_iter().filter(|&decades| decades <= most) {
                let mut scene = self.noisy(&self.base, clean)?;
                let [s, a, b] = self.base.truth();
                let off = |k: usize| 10f64.powf(decades * f64::from(sign[k]));
                scene.fit[0].start = [Some(s * off(0)), Some(a), Some(b * off(1))];
                let place =
                    (decades + 10.0 * i as f64, format!("sigma_s x {:.3}, B x {:.3}", off(0), off(1)));
                trials.extend(fits("start", place, &self.base, &scene, &SOLVED, [true; 3]));
            }
        }
        Ok(trials)
    }

    fn textures(&self) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for (i, texture) in Texture::ALL.into_iter().enumerate() {
            let setting = Setting { texture, ..self.base };
            let scene = self.noisy(&setting, &self.trace(&setting)?)?;
            let place = (i as f64, texture.name().to_string());
            trials.extend(fits("texture", place, &setting, &scene, &SWEPT, [true; 3]));
        }
        Ok(trials)
    }

    /// From kernels of a tenth of a pixel to ones of twice the view.
    fn pitches(&self) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        let width = Z * self.base.medium.shape.sqrt();
        for width_px in [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 2.0 * self.base.side as f64] {
            let setting = Setting { pixel_pitch: width / width_px, ..self.base };
            let scene = self.noisy(&setting, &self.trace(&setting)?)?;
            trials.extend(fits(
                "kernel width",
                (width_px, String::new()),
                &setting,
                &scene,
                &SWEPT,
                [true; 3],
            ));
        }
        Ok(trials)
    }

    /// Depth and gain that are not what the scene says.
    fn wrong_inputs(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for error in [0.01, 0.02, 0.05, 0.1] {
            let mut scene = self.noisy(&self.base, clean)?;
            let Setting { side, pixel_pitch, z, .. } = self.base;
            scene.geometry = Geometry::planar(side, side, pixel_pitch, z * (1.0 + error))?;
            scene.depth_error = error;
            trials.extend(fits("depth error", (error, String::new()), &self.base, &scene, &SWEPT, [true; 3]));

            let mut brighter = clean.clone();
            brighter.data.iter_mut().for_each(|v| *v *= 1.0 + error as f32);
            let mut scene = self.noisy(&self.base, &brighter)?;
            scene.observation.as_mut().expect("made with one").gain_error = error;
            trials.extend(fits("gain error", (error, String::new()), &self.base, &scene, &SWEPT, [true; 3]));
        }
        Ok(trials)
    }

    /// Henyey-Greenstein's lobes: B means nothing for them.
    fn phase_functions(&self) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for g in [0.99, 0.95, 0.9, 0.8] {
            let image = self.base.trace(&HenyeyGreenstein::new(g)?, self.samples, self.seed)?.mean;
            (self.tick)(1);
            let scene = self.noisy(&self.base, &image)?;
            let place = (g, String::new());
            trials.extend(fits(
                "Henyey-Greenstein g",
                place,
                &self.base,
                &scene,
                &SWEPT,
                [true, true, false],
            ));
        }
        Ok(trials)
    }

    /// sigma_s that grows linearly from left to right, its mean that of the base: each pixel sees its own medium.
    fn heterogeneous(&self) -> Result<Vec<Trial>> {
        const SHARES: usize = 9;
        let mut trials = Vec::new();
        for change in [0.02, 0.05, 0.1, 0.2, 0.5] {
            let at = |k: usize| 1.0 + change * (2.0 * k as f64 / (SHARES - 1) as f64 - 1.0);
            let render = |k: usize| {
                let mut setting = self.base;
                setting.medium.sigma_s *= at(k);
                setting.render(Model::WideAngle)
            };
            let renders = (0..SHARES).map(render).collect::<Result<Vec<_>>>()?;
            let side = self.base.side;
            let image = Image::from_fn(side, side, |x, y| {
                let place = (x as f32 + 0.5) / side as f32 * (SHARES - 1) as f32;
                let (k, t) = (place as usize, place.fract());
                (1.0 - t) * renders[k].at(x, y) + t * renders[(k + 1).min(SHARES - 1)].at(x, y)
            });
            let scene = self.noisy(&self.base, &image)?;
            let place = (change, String::new());
            trials.extend(fits("varying sigma_s", place, &self.base, &scene, &SWEPT, [true; 3]));
        }
        Ok(trials)
    }

    /// The brightest pixels cut off.
    fn saturated(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for share in [0.01, 0.05, 0.2, 0.5] {
            let mut scene = self.noisy(&self.base, clean)?;
            let image = &mut scene.observation.as_mut().expect("made with one").image[0].image;
            let mut sorted = image.data.clone();
            sorted.sort_by(f32::total_cmp);
            let top = sorted[((1.0 - share) * (sorted.len() - 1) as f64) as usize];
            image.data.iter_mut().for_each(|v| *v = v.min(top));
            trials.extend(fits(
                "saturated share",
                (share, String::new()),
                &self.base,
                &scene,
                &SWEPT,
                [true; 3],
            ));
        }
        Ok(trials)
    }
}
