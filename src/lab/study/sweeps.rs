//! The sweeps of the stability study: images in which one property after another goes wrong.

mod camera;
mod wrong;

use super::grid::{Extent, METHODS, Tick, Z, fits, plane};
use super::setting::{Setting, Texture};
use super::stability::Method;
use super::trial::{Place, Trial};
use crate::error::Result;
use crate::fit::noise::with_noise;
use crate::forward::Quantity;
use crate::image::Image;
use crate::phase::PhaseFunction;
use crate::scene::ObservedScene;
use crate::spread::Model;

/// The methods along the sweeps.
const SWEPT: [Method; 3] = [Method::of(Model::SmallAngle), Method::of(Model::WideAngle), Method::AUTO];
/// The same without the choice of a model, for starts; and by the other solver.
const SOLVED: [Method; 2] = [METHODS[5], METHODS[6]];
const SIMPLEX: [Method; 2] = [METHODS[7], METHODS[8]];

/// Standard deviation of the noise along the sweeps, in mean radiances.
const NOISE: f64 = 0.005;
/// Paths per pixel along the sweeps, as a multiple of those of the grid: their noise must be less than the added noise.
const CLEANER: u32 = 8;

/// Number of traces that [`sweeps`] makes.
pub const SWEEP_TRACES: u64 = 2 * (1 + 4 + 7 + 6 + 3);

/// Fits along all sweeps, around a medium of a narrow phase function and one of a wide one.
///
/// # Errors
/// As [`Setting::trace`].
pub fn sweeps(extent: &Extent, seed: u64, tick: Tick) -> Result<Vec<Trial>> {
    let mut trials = Vec::new();
    for (i, degrees) in [6.0, 30.0].into_iter().enumerate() {
        let base = plane(1.5, degrees, extent.side)?;
        let (samples, seed) = (extent.samples * CLEANER, seed + 1000 * (i as u64 + 1));
        trials.extend(Sweeps { base, samples, extent, seed, tick }.all()?);
    }
    Ok(trials)
}

struct Sweeps<'a> {
    base: Setting,
    samples: u32,
    extent: &'a Extent,
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
        trials.extend(self.fitted_phase_functions()?);
        trials.extend(self.heterogeneous()?);
        trials.extend(self.saturated(&clean)?);
        trials.extend(self.camera(&clean)?);
        Ok(trials)
    }

    fn trace(&self, setting: &Setting) -> Result<Image> {
        let image = setting.trace(*setting.medium.phase(), self.samples, self.seed)?.mean;
        (self.tick)(1);
        Ok(image)
    }

    /// Fits of `scene`, seen in the base setting, at `level` of `sweep`.
    fn fits(&self, sweep: &'static str, level: f64, scene: &ObservedScene) -> Vec<Trial> {
        fits(&Place::at(sweep, level), &self.base, scene, &SWEPT, &Quantity::MEDIUM)
    }

    /// The same along a sweep of the camera.
    fn fits_of_camera(&self, sweep: &'static str, level: f64, scene: &ObservedScene) -> Vec<Trial> {
        fits(&Place::at(sweep, level), &self.base, scene, self.extent.of_camera, &Quantity::MEDIUM)
    }

    /// The scene of `clean` with the usual noise.
    fn noisy(&self, setting: &Setting, clean: &Image) -> Result<ObservedScene> {
        setting.scene(with_noise(clean, NOISE * clean.mean(), self.seed), None)
    }

    fn noise(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for level in [0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2] {
            let scene = self.base.scene(with_noise(clean, level * clean.mean(), self.seed), None)?;
            trials.extend(self.fits("noise", level, &scene));
        }
        Ok(trials)
    }

    fn starts(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for (i, sign) in [[1, 1], [1, -1], [-1, 1], [-1, -1]].into_iter().enumerate() {
            let most = if sign == [1, 1] { self.extent.widest_start } else { f64::INFINITY };
            for decades in [0.5, 1.0, 2.0].into_iter().filter(|&decades| decades <= most) {
                let mut scene = self.noisy(&self.base, clean)?;
                let [of_sigma_s, of_b] = sign.map(|sign| 10f64.powf(decades * f64::from(sign)));
                let off = |quantity: Quantity| match quantity {
                    Quantity::SigmaS => of_sigma_s,
                    Quantity::Phase => of_b,
                    _ => 1.0,
                };
                let options = &mut scene.scene.fit[0];
                *options = options.started_at(|quantity| self.base.truth(quantity) * off(quantity));
                let label = format!("sigma_s x {of_sigma_s:.3}, B x {of_b:.3}");
                let place = Place { label, ..Place::at("start", decades + 10.0 * i as f64) };
                let simplex = if decades <= self.extent.widest_simplex { &SIMPLEX[..] } else { &[] };
                let methods = [&SOLVED[..], simplex].concat();
                trials.extend(fits(&place, &self.base, &scene, &methods, &Quantity::MEDIUM));
            }
        }
        Ok(trials)
    }

    fn textures(&self) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for (i, texture) in Texture::ALL.into_iter().enumerate() {
            let setting = Setting { texture, ..self.base };
            let scene = self.noisy(&setting, &self.trace(&setting)?)?;
            let place = Place { label: texture.name().into(), ..Place::at("texture", i as f64) };
            trials.extend(fits(&place, &setting, &scene, &SWEPT, &Quantity::MEDIUM));
        }
        Ok(trials)
    }

    /// From kernels of a tenth of a pixel to ones of twice the view.
    fn pitches(&self) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        let width = Z * self.base.medium.phase().parameter().sqrt();
        for width_px in [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 2.0 * self.base.side as f64] {
            let setting = Setting { pixel_pitch: width / width_px, ..self.base };
            let scene = self.noisy(&setting, &self.trace(&setting)?)?;
            trials.extend(fits(
                &Place::at("kernel width", width_px),
                &setting,
                &scene,
                &SWEPT,
                &Quantity::MEDIUM,
            ));
        }
        Ok(trials)
    }
}
