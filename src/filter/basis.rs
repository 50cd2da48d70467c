//! The images of which every render of a target is a linear combination: I = sum_c a_c(sigma_s, sigma_a, B) E_c.
//!
//! What the object shows at each depth, blurred by each width of the [`mixture`](super::mixture). The first width is 0: its
//! image carries the depth's direct light too. So it is as long as parallel rays see a scene in which every pixel's light
//! spreads freely.

use super::blur::{Blur, Lane, STRIP};
use super::mixture::GaussianMixture;
use super::slices::{Node, Slices};
use super::{Optics, Target};
use crate::error::Result;
use crate::geometry::Camera;
use crate::image::{Image, Sampling, View};
use crate::memory::{Reservation, product, reserve};
use crate::spread::Dual;
use rayon::prelude::*;
use std::ops::Range;

/// Depths beyond which renders are cheaper: the products of all images grow like the square of the depths, a render's cost
/// does not. A slope at six slices took .27 s where renders took .19 s (256² px).
const MOST_DEPTHS: usize = 2;
/// Largest width in units of the object's larger side: that of thick media whose single scattering is as wide as three
/// sides.
const WIDEST: f64 = 8.0;

/// Images of the object's size that a depth takes: its light, and those blurred on coarse grids.
const PLANES: usize = 8;

/// Columns of a strip that are copied together.
const BLOCK: usize = 256;

/// The images of one target, not yet computed.
pub struct Basis<'a> {
    target: Target<'a>,
    slices: Slices,
    mixture: GaussianMixture,
    /// The object's pixels at each depth, row-major.
    planes: Vec<Vec<f32>>,
    _memory: Reservation,
}

impl<'a> Basis<'a> {
    /// The images of `target`; `None` if occluders, slopes or rays off the axis make its renders another sum than this, or
    /// many depths a long one.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory).
    pub fn new(target: Target<'a>) -> Result<Option<Self>> {
        let parallel = matches!(target.geometry.camera, Camera::Orthographic { .. });
        let free = target.relief.is_none_or(|relief| relief.is_flat());
        if !(parallel && free) {
            return Ok(None);
        }
        let geometry = target.geometry;
        let pitch = geometry.median_pixel_pitch();
        let nodes: Vec<Node> = geometry.path_lengths().into_iter().map(|z| Node { z, pitch }).collect();
        let slices = Slices::new(0.0, &nodes, MOST_DEPTHS + 1);
        if slices.nodes.len() > MOST_DEPTHS {
            return Ok(None);
        }
        let (width, height) = (target.radiance.width, target.radiance.height);
        let what = || format!("{width}x{height} px blurred by Gaussians");
        let bytes = product(&[width * height, slices.nodes.len() * PLANES, size_of::<f32>()]);
        let _memory = reserve(what, bytes)?;
        let mut planes = vec![vec![0.0; target.radiance.data.len()]; slices.nodes.len()];
        let mut latest = (0.0, Vec::new());
        for (i, light) in target.radiance.data.iter().enumerate() {
            let Some(z) = geometry.path_length(i % geometry.width, i / geometry.width) else { continue };
            if z != latest.0 {
                latest = (z, slices.weights(Node { z, pitch }));
            }
            planes.iter_mut().zip(&latest.1).for_each(|(plane, weight)| plane[i] = *weight as f32 * light);
        }
        let side = target.radiance.width.max(target.radiance.height);
        Ok(Some(Self {
            target,
            slices,
            mixture: GaussianMixture::new(WIDEST * side as f64, target.sampling),
            planes,
            _memory,
        }))
    }

    /// Number of images.
    pub fn count(&self) -> usize {
        self.planes.len() * self.mixture.widths().len()
    }

    /// Pixels of each image.
    pub fn pixels(&self) -> usize {
        self.target.view.pixels()
    }

    /// The weight a_c of every image in a render.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn weights(&self, optics: &Optics) -> Result<Vec<Dual>> {
        let mut all = Vec::with_capacity(self.count());
        for node in &self.slices.nodes {
            let kernel = optics.kernel(node.z)?;
            all.extend(self.weights_at(node, kernel.direct(), &|k| kernel.scattered_transfer(k)));
        }
        Ok(all)
    }

    /// The weights of the images of one depth, for its direct light and the transfer function of its scattered light.
    pub fn weights_at(&self, node: &Node, direct: Dual, transfer: &dyn Fn(f64) -> Dual) -> Vec<Dual> {
        let mut weights = self.mixture.weights(transfer, node.pitch);
        weights[0] = weights[0] + direct;
        weights
    }

    /// The depths.
    pub fn nodes(&self) -> &[Node] {
        &self.slices.nodes
    }

    /// Largest error of the mixture's transfer functions, relative to the scattered light.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn error(&self, optics: &Optics) -> Result<f64> {
        let error = |worst: f64, node: &Node| {
            let kernel = optics.kernel(node.z)?;
            Ok(worst.max(self.mixture.error(&|k| kernel.scattered_transfer(k), node.pitch)))
        };
        self.slices.nodes.iter().try_fold(0.0, error)
    }

    /// Makes the images ready to be computed.
    pub fn images(&self) -> Images<'_> {
        let target = &self.target;
        let size = [target.radiance.width, target.radiance.height];
        let each = |i: usize| {
            let widths = self.mixture.widths();
            let (plane, width) = (&self.planes[i / widths.len()], widths[i % widths.len()]);
            match target.sampling {
                Sampling::Pixel => Blur::new(plane, size, target.border, target.view, width),
                Sampling::Bandlimited => Blur::bandlimited(plane, target, width),
            }
        };
        Images { view: target.view, blurs: (0..self.count()).into_par_iter().map(each).collect() }
    }
}

impl Basis<'_> {
    /// All images, computed.
    pub fn all_images(&self) -> Vec<Image> {
        let View { width, height, .. } = self.target.view;
        let images = self.images();
        let strips = images.strips();
        let strip = |strip: &Range<usize>| {
            let mut rows = vec![vec![0.0; width * strip.len()]; self.count()];
            images.blocks(strip, BLOCK, |columns, blocks| {
                for (rows, lanes) in rows.iter_mut().zip(blocks) {
                    for (x, lane) in columns.clone().zip(lanes) {
                        (0..strip.len()).for_each(|y| rows[y * width + x] = lane[y]);
                    }
                }
            });
            rows
        };
        let parts: Vec<Vec<Vec<f32>>> = strips.par_iter().map(strip).collect();
        let image = |i: usize| Image {
            width,
            height,
            data: parts.iter().flat_map(|rows| rows[i].iter().copied()).collect(),
        };
        (0..self.count()).map(image).collect()
    }
}

/// All images, to be computed in strips of [`STRIP`] rows of the view.
pub struct Images<'a> {
    view: View,
    blurs: Vec<Blur<'a>>,
}

impl Images<'_> {
    /// The rows of each strip.
    pub fn strips(&self) -> Vec<Range<usize>> {
        let height = self.view.height;
        (0..height).step_by(STRIP).map(|y| y..(y + STRIP).min(height)).collect()
    }

    /// Calls `f` with the columns `x..x + columns` of the rows `strip` of all images, for one block after the other.
    pub fn blocks(
        &self,
        strip: &Range<usize>,
        columns: usize,
        mut f: impl FnMut(Range<usize>, &[Vec<Lane>]),
    ) {
        let rows: Vec<Vec<Lane>> = self.blurs.iter().map(|blur| blur.rows(strip.clone())).collect();
        let mut block = vec![Vec::with_capacity(columns); self.blurs.len()];
        for x in (0..self.view.width).step_by(columns) {
            let range = x..(x + columns).min(self.view.width);
            for ((image, blur), rows) in block.iter_mut().zip(&self.blurs).zip(&rows) {
                image.clear();
                image.extend(blur.columns(rows, range.clone()));
            }
            f(range, &block);
        }
    }
}

/// The sum of `images`, each times its weight.
pub fn combination(weights: &[f64], images: &[Image]) -> Image {
    let first = &images[0];
    let pixel = |i: usize| {
        let terms = weights.iter().zip(images);
        terms.map(|(weight, image)| weight * f64::from(image.data[i])).sum::<f64>() as f32
    };
    Image { data: (0..first.data.len()).into_par_iter().map(pixel).collect(), ..*first }
}
