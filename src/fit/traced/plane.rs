//! A plane seen by parallel rays: its kernel from path statistics, its image from the object blurred by Gaussians.
//!
//! Of every path count n, L, its deflections and the radius r of its crossing. Reweighted and summed in bins of radius
//! they make the transfer function M(k) - T = sum over bins of light · mean of J0(kr), with derivatives by likelihood ratios.
//! As for fits by sums, a ladder of Gaussians stands for that kernel ([`Basis`]), and evens its noise out.

use super::Paths;
use crate::error::Result;
use crate::filter::basis::Basis;
use crate::filter::cpu::Rendering;
use crate::filter::slices::Node;
use crate::filter::{Optics, Target};
use crate::geometry::Camera;
use crate::image::Image;
use crate::medium::Medium;
use crate::relief::Relief;
use crate::spread::Dual;
use crate::trace::{
    BATCHES, Effective, Histories, History, Information, Likelihood, Reweighting, Scattered, Turbid,
    annulus_mean, log_spaced, trace_histories,
};
use rayon::prelude::*;
use std::ops::Range;

/// Edges of the radius bins, in units of the path length: two percent apart, over which J0(kr) is averaged as if light were even
/// there. It falls outwards, so the kernel comes out too wide: with eight percent B was 1.3 % low in the mean of 16 fits at tau 5.
fn edges() -> Vec<f64> {
    log_spaced(1e-6, 1e3, 1041)
}

/// Columns of a strip that are copied together.
const BLOCK: usize = 256;

/// A plane without its paths.
pub(super) struct Plane<'a> {
    basis: Basis<'a>,
    target: Target<'a>,
    node: Node,
}

impl<'a> Plane<'a> {
    /// The plane that `target` is; `None` if it is none.
    pub(super) fn of(target: Target<'a>) -> Option<Self> {
        let parallel = matches!(target.geometry.camera, Camera::Orthographic { .. });
        if !(parallel && Relief::new(target.geometry).is_flat()) {
            return None;
        }
        let basis = Basis::new(Target { relief: None, ..target })?;
        let [node] = *basis.nodes() else { return None };
        Some(Self { basis, target, node })
    }

    /// The plane with `paths` paths traced in `medium`.
    pub(super) fn traced<P: Likelihood>(
        self,
        medium: Turbid<P>,
        paths: u64,
        seed: u64,
    ) -> Result<TracedPlane<'a, P>> {
        let scaled = in_depths(&medium, self.node.z);
        let edges = edges();
        let each = paths.div_ceil(BATCHES as u64);
        let batch = |i: u64| {
            let histories = trace_histories(
                scaled,
                Scattered::Once,
                each,
                seed.wrapping_mul(BATCHES as u64).wrapping_add(i),
            )?;
            let bin = |h: &History<P::Memory>| edges.partition_point(|&e| e <= f64::from(h.radius)) as u16;
            Ok(Batch { bins: histories.paths.iter().map(bin).collect(), histories })
        };
        Ok(TracedPlane {
            images: images(&self.basis, &self.target),
            batches: (0..BATCHES as u64).map(batch).collect::<Result<_>>()?,
            edges,
            plane: self,
        })
    }
}

/// The object at one depth, blurred by each Gaussian.
fn images(basis: &Basis, target: &Target) -> Vec<Image> {
    let (width, height) = (target.view.width, target.view.height);
    let images = basis.images();
    let strips = images.strips();
    let strip = |strip: &Range<usize>| {
        let mut rows = vec![vec![0.0; width * strip.len()]; basis.count()];
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
    (0..basis.count()).map(image).collect()
}

/// `medium` with lengths in units of `z`.
fn in_depths<P: Copy>(medium: &Turbid<P>, z: f64) -> Turbid<P> {
    Turbid { sigma_s: medium.sigma_s * z, sigma_a: medium.sigma_a * z, phase: medium.phase }
}

/// Independent paths, and the radius bin of each.
struct Batch<P: Likelihood> {
    histories: Histories<P>,
    bins: Vec<u16>,
}

/// A plane with its paths.
pub(super) struct TracedPlane<'a, P: Likelihood> {
    plane: Plane<'a>,
    images: Vec<Image>,
    edges: Vec<f64>,
    batches: Vec<Batch<P>>,
}

impl<P: Likelihood> TracedPlane<'_, P> {
    fn medium(&self, optics: &Optics) -> Result<Turbid<P>> {
        Ok(in_depths(&super::turbid(optics)?, self.plane.node.z))
    }

    fn reweighting(&self, to: &Turbid<P>) -> Reweighting {
        Reweighting::new(&self.batches[0].histories.medium, to)
    }

    /// Light in each bin of radius, by some batches, with its derivatives in sigma_s z, sigma_a z and the shape.
    fn light(&self, medium: &Turbid<P>, batches: Range<usize>) -> Vec<Dual> {
        let reweighting = self.reweighting(medium);
        let share = 1.0 / batches.len() as f64;
        let of = |batch: &Batch<P>| {
            let mut light = vec![Dual::default(); self.edges.len() + 1];
            for (path, &bin) in batch.histories.paths.iter().zip(&batch.bins) {
                let weight = reweighting.of(path.scatterings, path.length, path.memory.as_ref());
                let value = share * batch.histories.weight * weight.ratio;
                light[bin as usize] =
                    light[bin as usize] + Dual { value, gradient: weight.slopes.map(|s| value * s) };
            }
            light
        };
        let parts: Vec<Vec<Dual>> = self.batches[batches].par_iter().map(of).collect();
        let sum = |bin: usize| parts.iter().fold(Dual::default(), |sum, part| sum + part[bin]);
        (0..=self.edges.len()).map(sum).collect()
    }
}

impl<P: Likelihood> Paths for TracedPlane<'_, P> {
    fn render(&self, optics: &Optics, batches: Range<usize>) -> Result<Rendering> {
        let Node { z, .. } = self.plane.node;
        let light = self.light(&self.medium(optics)?, batches);
        let transfer = |k: f64| {
            let mut inner = 0.0;
            let mut sum = if k == 0.0 { light[self.edges.len()] } else { Dual::default() };
            for (&outer, &light) in self.edges.iter().zip(&light) {
                sum = sum + annulus_mean(k * z, inner, outer) * light;
                inner = outer;
            }
            let [tau, absorption, shape] = sum.gradient;
            Dual { value: sum.value, gradient: [z * tau, z * absorption, shape] }
        };
        let medium: &Medium = &optics.medium;
        let t = medium.transmittance(z);
        let direct = Dual { value: t, gradient: [-z * t, -z * t, 0.0] };
        let weights = self.plane.basis.weights_at(&self.plane.node, direct, &transfer);
        let sum = |of: &(dyn Fn(&Dual) -> f64 + Sync)| {
            let first = &self.images[0];
            let pixel = |i: usize| {
                let terms = weights.iter().zip(&self.images);
                terms.map(|(weight, image)| of(weight) * f64::from(image.data[i])).sum::<f64>() as f32
            };
            Image { data: (0..first.data.len()).into_par_iter().map(pixel).collect(), ..*first }
        };
        let slope = |c: usize| sum(&move |weight| weight.gradient[c]);
        Ok(Rendering {
            image: sum(&|weight| weight.value),
            gradient: Some([slope(0), slope(1), slope(2)]),
            motion: None,
        })
    }

    fn effective_share(&self, optics: &Optics) -> Result<f64> {
        let reweighting = self.reweighting(&self.medium(optics)?);
        let mut effective = Effective::default();
        for path in self.batches.iter().flat_map(|b| &b.histories.paths) {
            let ratio = reweighting.of(path.scatterings, path.length, path.memory.as_ref()).ratio;
            effective.add(1.0, ratio);
        }
        Ok(effective.share())
    }

    fn information(&self) -> ([f64; 3], f64) {
        let reweighting = self.reweighting(&self.batches[0].histories.medium);
        let mut information = Information::default();
        for path in self.batches.iter().flat_map(|b| &b.histories.paths) {
            information.add(1.0, reweighting.of(path.scatterings, path.length, path.memory.as_ref()).slopes);
        }
        let ([tau, absorption, shape], z) = (information.of_a_path(), self.plane.node.z);
        ([z * z * tau, z * z * absorption, shape], P::FARTHEST)
    }

    fn count(&self) -> u64 {
        self.batches.iter().map(|b| b.histories.paths.len() as u64).sum()
    }
}
