//! A plane behind a medium, seen by parallel rays: the scene of the studies.

use crate::error::Result;
use crate::filter::{Backend, Optics, Target};
use crate::forward::{Quantity, State};
use crate::geometry::Geometry;
use crate::image::{Border, Channel, Image, Sampling, View};
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use crate::scene::{FitOptions, Noise, Observation, ObservedScene, PartialMedium, Scene};
use crate::spread::Model;
use crate::trace::{ImageConfig, TracedImage, trace_image};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use std::path::PathBuf;

/// What the plane shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Texture {
    /// Two fields, side by side.
    Edge,
    /// A checkerboard of 5 by 7 px under a wave of light.
    Checker,
    /// A dead-leaves texture: opaque disks of all sizes that cover one another, with the statistics of natural images.
    Natural,
    /// Uniform grey to within 2 %.
    NearlyFlat,
}

impl Texture {
    /// All textures.
    pub const ALL: [Self; 4] = [Self::Edge, Self::Checker, Self::Natural, Self::NearlyFlat];

    /// The name used in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Edge => "edge",
            Self::Checker => "checker",
            Self::Natural => "natural",
            Self::NearlyFlat => "nearly flat",
        }
    }

    /// Its radiance, `side` px square, between 0 and 1.2.
    pub fn image(self, side: usize) -> Image {
        match self {
            Self::Edge => Image::from_fn(side, side, |x, _| if 2 * x < side { 0.9 } else { 0.2 }),
            Self::Checker => Image::from_fn(side, side, |x, y| {
                let cell = if (x / 5 + y / 7) % 2 == 0 { 0.7 } else { 0.1 };
                cell + 0.2 * (1.0 + (0.31 * x as f32 + 0.17 * y as f32).sin())
            }),
            Self::Natural => fallen_disks(side),
            Self::NearlyFlat => Image::from_fn(side, side, |x, y| {
                0.5 * (1.0 + 0.02 * (0.31 * x as f32).sin() * (0.23 * y as f32).sin())
            }),
        }
    }
}

/// Disks with radii of density 1/r³ above 2 px, in uniform greys.
fn fallen_disks(side: usize) -> Image {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut uniform = || (stream.next_u64() >> 40) as f32 / (1 << 24) as f32;
    let mut image = Image::filled(side, side, 0.5);
    for _ in 0..side * side / 4 {
        let radius = 2.0 / (1.0 - 0.99 * uniform()).sqrt();
        let (x0, y0, grey) = (uniform() * side as f32, uniform() * side as f32, 0.05 + 0.95 * uniform());
        for (i, value) in image.data.iter_mut().enumerate() {
            let (x, y) = ((i % side) as f32 + 0.5 - x0, (i / side) as f32 + 0.5 - y0);
            if x * x + y * y < radius * radius {
                *value = grey;
            }
        }
    }
    image
}

/// A textured plane, black around, behind a medium that begins at the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// What the plane shows.
    pub texture: Texture,
    /// Side of the image, px.
    pub side: usize,
    /// Side of a pixel at the object, length.
    pub pixel_pitch: f64,
    /// Depth of the plane, length.
    pub z: f64,
    /// The medium.
    pub medium: Medium,
}

impl Setting {
    /// Scattering depth of the plane.
    pub fn tau(&self) -> f64 {
        self.medium.tau(self.z)
    }

    /// The true value of `quantity`.
    pub fn truth(&self, quantity: Quantity) -> f64 {
        State::from(self.medium).value(quantity)
    }

    fn geometry(&self) -> Result<Geometry> {
        Geometry::planar(self.side, self.side, self.pixel_pitch, self.z)
    }

    /// What `model` renders.
    ///
    /// # Errors
    /// As [`Backend::prepare`] and [`Optics::kernel`].
    pub fn render(&self, model: Model) -> Result<Image> {
        let (object, geometry) = (self.texture.image(self.side), self.geometry()?);
        let optics = Optics { model, medium: self.medium };
        let target = Target::plain(&object, &geometry, Border::Zero, View::whole(self.side, self.side));
        Backend::Cpu.prepare(target, &optics, 1.0)?.render(&optics)
    }

    /// The image traced with `samples` paths per pixel and the phase function `phase`, which need not be the medium's.
    ///
    /// # Errors
    /// As [`trace_image`].
    pub fn trace(&self, phase: impl PhaseFunction + Copy, samples: u32, seed: u64) -> Result<TracedImage> {
        let config = ImageConfig {
            geometry: &self.geometry()?,
            radiance: &self.texture.image(self.side),
            behind: &[],
            border: Border::Zero,
            view: View::whole(self.side, self.side),
            medium: self.medium.with_phase(phase),
            samples,
            seed,
        };
        trace_image(&config, &|_| ())
    }

    /// The scene to fit to `observed`, whose pixels have the standard deviation `noise` if that is known; of the medium it
    /// holds only the family of its phase function.
    ///
    /// # Errors
    /// As [`Geometry::planar`].
    pub fn scene(&self, observed: Image, noise: Option<f64>) -> Result<ObservedScene> {
        let gray = |image: Image| vec![Channel { name: "Y".into(), image }];
        let scene = Scene {
            path: PathBuf::from("plane"),
            files: Vec::new(),
            object: gray(self.texture.image(self.side)),
            object_noise: None,
            cautions: Vec::new(),
            behind: vec![Vec::new()],
            geometry: self.geometry()?,
            depth_error: 0.0,
            border: Border::Zero,
            sampling: Sampling::Pixel,
            sampling_is_known: true,
            view: View::whole(self.side, self.side),
            medium: vec![PartialMedium::default()],
            fit: vec![FitOptions { family: self.medium.phase().family(), ..FitOptions::default() }],
        };
        let observation = Observation {
            noise: noise.map(Noise::Level),
            ..Observation::plain(PathBuf::from("plane"), gray(observed))
        };
        Ok(ObservedScene { scene, observation })
    }
}
