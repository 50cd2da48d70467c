//! The grid of the stability study: scattering depths and spread angles, by all models.

use super::setting::{Setting, Texture};
use super::stability::Method;
use super::trial::{Place, Trial};
use crate::error::Result;
use crate::forward::Quantity;
use crate::medium::Medium;
use crate::phase::b_of_spread_angle;
use crate::scene::ObservedScene;
use crate::spread::Model;
use crate::trace::log_spaced;
use rayon::prelude::*;

/// The extent of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Extent {
    /// Side of the images, px.
    pub side: usize,
    /// Paths per pixel of a traced image.
    pub samples: u32,
    /// Scattering depths of the grid.
    pub tau: Vec<f64>,
    /// Spread angles of the grid, degrees.
    pub spread_angle_deg: Vec<f64>,
    /// Decades by which a start may have too much of both sigma_s and B: its kernels are as wide as they get, and a simplex
    /// takes a minute from two decades.
    pub widest_start: f64,
    /// Decades up to which the simplex is tried at all.
    pub widest_simplex: f64,
    /// The methods along the sweeps of the camera.
    pub of_camera: &'static [Method],
}

impl Extent {
    /// The extent of `narrowbeam stability`.
    pub fn full() -> Self {
        Self {
            side: 48,
            samples: 2048,
            tau: log_spaced(0.1, 12.0, 8),
            spread_angle_deg: log_spaced(2.0, 60.0, 7),
            widest_start: 2.0,
            widest_simplex: 2.0,
            of_camera: &OF_CAMERA,
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
            widest_simplex: 0.5,
            of_camera: &OF_CAMERA[2..],
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
    Method::simplex(Model::SmallAngle),
    Method::simplex(Model::WideAngle),
    Method::AUTO,
];

/// The methods along the sweeps of the camera.
const OF_CAMERA: [Method; 4] =
    [Method::of(Model::SmallAngle), Method::of(Model::WideAngle), Method::AUTO, Method::CAMERA];

/// Depth of the planes, length.
pub(super) const Z: f64 = 2.0;

/// A plane at scattering depth `tau` in a medium of this spread angle; a pixel is a fifth of the width z sqrt(B).
///
/// # Errors
/// As [`Medium::gaussian`].
pub fn plane(tau: f64, spread_angle_deg: f64, side: usize) -> Result<Setting> {
    let b = b_of_spread_angle(spread_angle_deg.to_radians());
    let medium = Medium::gaussian(tau / Z, 0.3 / Z, b)?;
    Ok(Setting { texture: Texture::Checker, side, pixel_pitch: 0.2 * Z * b.sqrt(), z: Z, medium })
}

/// Called with the number of images that are done.
pub type Tick<'a> = &'a (dyn Fn(u64) + Sync);

/// Fits over the grid of scattering depths and spread angles, by all `METHODS`.
///
/// # Errors
/// As [`Setting::trace`].
pub fn grid(extent: &Extent, seed: u64, tick: Tick) -> Result<Vec<Trial>> {
    let mut trials = Vec::new();
    for (i, &tau) in extent.tau.iter().enumerate() {
        for (j, &degrees) in extent.spread_angle_deg.iter().enumerate() {
            let setting = plane(tau, degrees, extent.side)?;
            let seed = seed + (i * extent.spread_angle_deg.len() + j) as u64;
            let image = setting.trace(*setting.medium.phase(), extent.samples, seed)?.mean;
            let scene = setting.scene(image, None)?;
            trials.extend(fits(&Place::at("grid", tau), &setting, &scene, &METHODS, &Quantity::MEDIUM));
            tick(1);
        }
    }
    Ok(trials)
}

/// Fits `scene` by all `methods`.
pub(super) fn fits(
    place: &Place,
    setting: &Setting,
    scene: &ObservedScene,
    methods: &[Method],
    compared: &[Quantity],
) -> Vec<Trial> {
    let one = |&method: &Method| Trial {
        place: place.clone(),
        setting: *setting,
        method,
        outcome: method.try_on(scene, setting, compared),
    };
    methods.par_iter().map(one).collect()
}
