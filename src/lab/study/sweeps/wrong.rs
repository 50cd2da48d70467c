//! Sweeps along which the scene file is wrong: depths, gains, phase functions, media, pixels.

use super::{SWEPT, Sweeps};
use crate::error::Result;
use crate::forward::Quantity;
use crate::geometry::Geometry;
use crate::image::Image;
use crate::lab::study::grid::fits;
use crate::lab::study::setting::Setting;
use crate::lab::study::trial::{Place, Trial};
use crate::medium::Medium;
use crate::phase::HenyeyGreenstein;
use crate::spread::Model;

impl Sweeps<'_> {
    /// Depth and gain that are not what the scene says.
    pub(super) fn wrong_inputs(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for error in [0.01, 0.02, 0.05, 0.1] {
            let mut scene = self.noisy(&self.base, clean)?;
            let Setting { side, pixel_pitch, z, .. } = self.base;
            scene.scene.geometry = Geometry::planar(side, side, pixel_pitch, z * (1.0 + error))?;
            scene.scene.depth_error = error;
            trials.extend(self.fits("depth error", error, &scene));

            let mut brighter = clean.clone();
            brighter.data.iter_mut().for_each(|v| *v *= 1.0 + error as f32);
            let mut scene = self.noisy(&self.base, &brighter)?;
            scene.observation.gain_error = error;
            trials.extend(self.fits("gain error", error, &scene));
        }
        Ok(trials)
    }

    /// Henyey-Greenstein phase functions, for which B has no meaning.
    pub(super) fn phase_functions(&self) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for g in [0.99, 0.95, 0.9, 0.8] {
            let image = self.base.trace(HenyeyGreenstein::new(g)?, self.samples, self.seed)?.mean;
            (self.tick)(1);
            let scene = self.noisy(&self.base, &image)?;
            trials.extend(fits(
                &Place::at("Henyey-Greenstein g", g),
                &self.base,
                &scene,
                &SWEPT,
                &[Quantity::SigmaS, Quantity::SigmaA],
            ));
        }
        Ok(trials)
    }

    /// The same phase functions, fitted as what they are, up to lobes that are far narrower than a pixel.
    pub(in crate::lab::study) fn fitted_phase_functions(&self) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for g in [0.8, 0.9, 0.95, 0.99, 0.998, 0.9999] {
            let base = self.base.medium;
            let medium = Medium::new(base.sigma_s(), base.sigma_a(), HenyeyGreenstein::new(g)?.into())?;
            let setting = Setting { medium, ..self.base };
            let scene = self.noisy(&setting, &self.trace(&setting)?)?;
            trials.extend(fits(&Place::at("fitted g", g), &setting, &scene, &SWEPT, &Quantity::MEDIUM));
        }
        Ok(trials)
    }

    /// sigma_s that grows linearly from left to right, its mean that of the base: each pixel sees its own medium.
    pub(super) fn heterogeneous(&self) -> Result<Vec<Trial>> {
        const SHARES: usize = 9;
        let mut trials = Vec::new();
        for change in [0.02, 0.05, 0.1, 0.2, 0.5] {
            let at = |k: usize| 1.0 + change * (2.0 * k as f64 / (SHARES - 1) as f64 - 1.0);
            let render = |k: usize| {
                let base = self.base.medium;
                let medium = Medium::new(base.sigma_s() * at(k), base.sigma_a(), *base.phase())?;
                Setting { medium, ..self.base }.render(Model::WideAngle)
            };
            let renders = (0..SHARES).map(render).collect::<Result<Vec<_>>>()?;
            let side = self.base.side;
            let image = Image::from_fn(side, side, |x, y| {
                let place = (x as f32 + 0.5) / side as f32 * (SHARES - 1) as f32;
                let (k, t) = (place as usize, place.fract());
                (1.0 - t) * renders[k].at(x, y) + t * renders[(k + 1).min(SHARES - 1)].at(x, y)
            });
            let scene = self.noisy(&self.base, &image)?;
            trials.extend(self.fits("varying sigma_s", change, &scene));
        }
        Ok(trials)
    }

    /// The brightest pixels clipped.
    pub(super) fn saturated(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for share in [0.01, 0.05, 0.2, 0.5] {
            let mut scene = self.noisy(&self.base, clean)?;
            let image = &mut scene.observation.image[0].image;
            let mut sorted = image.data.clone();
            sorted.sort_by(f32::total_cmp);
            let top = sorted[((1.0 - share) * (sorted.len() - 1) as f64) as usize];
            image.data.iter_mut().for_each(|v| *v = v.min(top));
            trials.extend(self.fits("saturated share", share, &scene));
        }
        Ok(trials)
    }
}
