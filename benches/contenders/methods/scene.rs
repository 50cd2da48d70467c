//! What the contenders are tried on, and the image that they should give.

use super::{common, depths::Depths};
use narrowbeam::error::Result;
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::slices::{Node, Slices};
use narrowbeam::filter::{Optics, Target, per_depth};
use narrowbeam::geometry::{Field, Geometry};
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::b_of_spread_angle;
use narrowbeam::spread::Model;

const SIGMA_S: f64 = 0.95;
const SIGMA_A: f64 = 0.05;
const SPREAD_ANGLE_DEG: f64 = 8.0;
/// Mean path length.
const DEPTH: f64 = 2.0;
/// Distinct depths of a slope, from 3/4 to 5/4 of the mean.
const DEPTHS: usize = 16;
/// Share of the light that may fall beyond the padding of the reference and of the program.
const OUTSIDE: [f64; 2] = [1e-7, 1e-5];
/// Where the program's padding stops, unless two sides are more.
const MOST_PADDED_PX: usize = 4096;
/// What the program allows its slices.
const SLICE_TOLERANCE: f64 = 1e-4;

/// A square image of a plane or a slope.
pub struct Scene {
    /// Side of the image, px.
    pub n: usize,
    /// Kernel width z sqrt(B) at the mean depth, px.
    pub width_px: f64,
    /// Whether the depth varies.
    pub slope: bool,
    radiance: Image,
    geometry: Geometry,
    medium: Medium,
}

impl Scene {
    /// An image of side `n` through a kernel of `width_px`.
    pub fn new(n: usize, width_px: f64, slope: bool) -> Self {
        let b = b_of_spread_angle(SPREAD_ANGLE_DEG.to_radians());
        let medium = Medium::gaussian(SIGMA_S, SIGMA_A, b).expect("in range");
        let pitch = DEPTH * b.sqrt() / width_px;
        let mut geometry = Geometry::planar(n, n, pitch, DEPTH).expect("in range");
        if slope {
            let step = |x: usize| (x * DEPTHS / n) as f64 + 0.5;
            let depth = |x: usize| (DEPTH * (0.75 + 0.5 * step(x) / DEPTHS as f64)) as f32;
            geometry.depth = Field::Map(Image::from_fn(n, n, |x, _| depth(x)));
        }
        Self { n, width_px, slope, radiance: common::texture(n, n), geometry, medium }
    }

    /// The medium and its kernels.
    pub fn optics(&self) -> Optics {
        Optics { model: Model::SmallAngle, medium: self.medium }
    }

    /// What is filtered.
    pub fn target(&self) -> Target<'_> {
        Target {
            radiance: &self.radiance,
            behind: &[],
            geometry: &self.geometry,
            border: Border::Zero,
            sampling: Sampling::Pixel,
            view: View::whole(self.n, self.n),
            relief: None,
        }
    }

    /// Length of a pixel.
    pub fn pitch(&self) -> f64 {
        self.geometry.pixel_pitch(DEPTH)
    }

    /// The range of its path lengths, with `count` nodes.
    pub fn depths(&self, count: usize) -> Depths {
        let widen = |(near, far): (f64, f64), z: f64| (near.min(z), far.max(z));
        let (near, far) = self.path_lengths().fold((f64::INFINITY, 0.0), widen);
        Depths::new(near, far, count)
    }

    fn path_lengths(&self) -> impl Iterator<Item = f64> + '_ {
        let z = |i: usize| self.geometry.path_length(i % self.n, i / self.n);
        (0..self.n * self.n).map(move |i| z(i).expect("there is an object everywhere"))
    }

    /// Radiance of every pixel, and its place along `depths`.
    pub fn sources(&self, depths: &Depths) -> impl Iterator<Item = [f32; 2]> {
        let places = self.path_lengths().map(|z| depths.place(z) as f32);
        self.radiance.data.iter().copied().zip(places).map(|(light, place)| [light, place])
    }

    /// Radius in px beyond which less than `outside` of any pixel's scattered light falls.
    pub fn reach_px(&self, outside: f64) -> f64 {
        let far = self.depths(1).far();
        let kernel = self.optics().kernel(far).expect("a Gaussian phase function suits every model");
        kernel.support(outside) / self.pitch()
    }

    /// Slices that the program takes, and the side of its padded image.
    pub fn plan(&self) -> (usize, usize) {
        let pitch = self.pitch();
        let nodes: Vec<Node> = self.path_lengths().map(|z| Node { z, pitch }).collect();
        let slices = Slices::for_tolerance(0.0, &nodes, &self.optics(), SLICE_TOLERANCE);
        let most = MOST_PADDED_PX.saturating_sub(self.n).max(2 * self.n);
        let padded = self.n + (self.reach_px(OUTSIDE[1]).ceil() as usize).min(most);
        (slices.expect("a Gaussian phase function suits every model").nodes.len(), fast_size(padded))
    }

    /// The image by a slice for each depth.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn reference(&self) -> Result<Vec<f32>> {
        let filter = CpuFilter::with_slices(self.target(), DEPTHS, self.reach_px(OUTSIDE[0])).unwrap();
        Ok(filter.render(&self.optics())?.data)
    }

    /// The image by the f64 implementation.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn f64_image(&self) -> Result<Vec<f32>> {
        Ok(per_depth::render(&self.target(), &self.optics())?.iter().map(|&v| v as f32).collect())
    }
}

/// Relative L2 distance of `image` from `reference`, and the relative error of its sum.
pub fn errors(image: &[f32], reference: &[f32]) -> [f64; 2] {
    let wide = |image: &[f32]| image.iter().map(|&v| f64::from(v)).collect::<Vec<_>>();
    let (image, reference) = (wide(image), wide(reference));
    let sum = |image: &[f64]| image.iter().sum::<f64>();
    let energy = sum(&image) / sum(&reference) - 1.0;
    [common::relative_l2(image, reference), energy]
}

/// The program's sizes of transforms: even, without a prime factor above 5.
fn fast_size(n: usize) -> usize {
    let smooth = |&m: &usize| {
        let mut rest = m;
        for p in [2, 3, 5] {
            while rest.is_multiple_of(p) {
                rest /= p;
            }
        }
        m.is_multiple_of(2) && rest == 1
    };
    (n.max(2)..).find(smooth).expect("powers of two are smooth")
}
