//! The fast path: f32 FFTs of a few depth slices, on all cores.
//!
//! A plan holds the transforms of the object weighted for each slice; they do not depend on the medium. A render
//! goes from far to near: the light behind each screen is gathered there in the frequency domain, loses in the image
//! what the screen covers, and is carried on to the next. Slices between two screens share one inverse FFT; a screen
//! costs one more, and a forward one. Derivatives cost three times as many (two if there is a single depth, where the
//! derivative in sigma_a is -z times the image). A perspective view takes a few renders, one for each of its
//! obliquities (`obliquity`).

use super::canvas::{Canvas, most_reach};
use super::obliquity::{Obliquities, Obliquity};
use super::segment::Segment;
use super::slices::{Node, Slices};
use super::sources::{Sheet, hidden_sheets, sheets};
use super::{Optics, Target};
use crate::error::Result;
use crate::image::{Border, Image};
use crate::relief::Relief;
use crate::spread::Model;

/// An image over the target's view and, if asked for, its derivatives in sigma_s, sigma_a and B.
#[derive(Debug, Clone)]
pub struct Rendering {
    /// Direct and scattered light of the object.
    pub image: Image,
    /// Derivatives of `image` in sigma_s (length), sigma_a (length) and B (1/rad²).
    pub gradient: Option<[Image; 3]>,
}

/// How far a plan serves some kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coverage {
    /// Whether its slices suffice, and its padding as far as any would.
    pub served: bool,
    /// Whether the kernels reach beyond the most padding there is, so that light that should leave the image comes
    /// back on its other side.
    pub cut: bool,
}

/// Share of a kernel's light that may fall beyond the padding.
const OUTSIDE: f64 = 1e-5;
/// Largest error of the slices' transfer functions, as a share of the scattered light.
const SLICE_TOLERANCE: f64 = 1e-4;
/// What to tell a user of [`Coverage::cut`].
pub const CUT: &str = "the kernel reaches beyond the most padding there is: light that should leave the image comes \
                       back on its other side; use fewer pixels for the same scene, or a mirrored border";

/// A target prepared for many renders.
pub struct CpuFilter<'a> {
    target: Target<'a>,
    reach_px: f64,
    canvas: Canvas,
    obliquities: Obliquities,
    /// From near to far; all but the first lie behind a screen.
    segments: Vec<Segment>,
}

impl<'a> CpuFilter<'a> {
    /// Prepares `target` for kernels up to as wide as those of `optics`, times `headroom`.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn new(target: Target<'a>, optics: &Optics, headroom: f64) -> Result<Self> {
        Self::of_sheets(target, &sheets(&target), optics, headroom)
    }

    /// The same for light of radiance 1 from whatever is supposed, but not known, to lie behind the screens of
    /// `relief`, which the target has: what renders is the share of hidden light.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub(super) fn of_hidden(target: Target<'a>, relief: &Relief, optics: &Optics) -> Result<Self> {
        Self::of_sheets(target, &hidden_sheets(&target, relief), optics, 1.0)
    }

    fn of_sheets(target: Target<'a>, sheets: &[Sheet], optics: &Optics, headroom: f64) -> Result<Self> {
        let divergence = target.geometry.pitch_per_depth();
        let sliced = |nodes: &[Node]| Slices::for_tolerance(divergence, nodes, optics, SLICE_TOLERANCE);
        let slices = per_segment(&target, sheets, sliced)?;
        let reach_px = headroom * reach_px(slices.iter().flatten(), optics)?;
        Ok(Self::with(target, sheets, slices, reach_px))
    }

    /// Prepares `target` with at most `count` slices along z between any two screens and padding for kernels that reach
    /// `reach_px` pixels.
    pub fn with_slices(target: Target<'a>, count: usize, reach_px: f64) -> Self {
        let sheets = sheets(&target);
        let divergence = target.geometry.pitch_per_depth();
        let slices = per_segment(&target, &sheets, |nodes| Ok(Slices::new(divergence, nodes, count)));
        Self::with(target, &sheets, slices.expect("a number of slices cannot fail"), reach_px)
    }

    fn with(target: Target<'a>, sheets: &[Sheet], slices: Vec<Option<Slices>>, reach_px: f64) -> Self {
        let canvas = Canvas::new(&target, reach_px);
        let screens = target.relief.map_or(&[][..], |relief| &relief.screens);
        let segment = |(passed, slices): (usize, Option<Slices>)| {
            let screen = passed.checked_sub(1).map(|i| &screens[i]);
            Segment::new((&target, &canvas), sheets, passed, screen, slices)
        };
        let segments = slices.into_iter().enumerate().map(segment).collect();
        let obliquities = Obliquities::new(target.geometry, target.view);
        Self { target, reach_px, canvas, obliquities, segments }
    }

    /// How far padding and slices serve the kernels of `optics` too.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn coverage(&self, optics: &Optics) -> Result<Coverage> {
        let (reach, most) = (reach_px(self.slices(), optics)?, most_reach(&self.target));
        let mut served = reach.min(most) <= self.reach_px;
        for slices in self.slices() {
            served &= slices.error(optics)? <= SLICE_TOLERANCE;
        }
        Ok(Coverage { served, cut: self.target.border != Border::Mirror && reach > most })
    }

    fn slices(&self) -> impl Iterator<Item = &Slices> {
        self.segments.iter().filter_map(|s| s.slices.as_ref())
    }

    /// Number of slices.
    pub fn slice_count(&self) -> usize {
        self.slices().map(|s| s.nodes.len()).sum()
    }

    /// The only slice, if there is but one.
    fn single_depth(&self) -> Option<Node> {
        match &self.segments[..] {
            [Segment { slices: Some(Slices { nodes, .. }), .. }] if nodes.len() == 1 => Some(nodes[0]),
            _ => None,
        }
    }

    /// Number of real 2-D FFTs that one render takes, without and with the derivatives, and their size.
    pub fn transforms(&self) -> (usize, usize, [usize; 2]) {
        let images = (2 * self.segments.len() - 1) * self.obliquities.count();
        let with_derivatives = if self.single_depth().is_some() { 3 * images } else { 4 * images };
        (images, with_derivatives, [self.canvas.fft.width, self.canvas.fft.height])
    }

    /// The image through the medium, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn render(&self, optics: &Optics) -> Result<Image> {
        Ok(self.evaluate(optics, 1)?.swap_remove(0))
    }

    /// The image and its derivatives, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn render_with_gradient(&self, optics: &Optics) -> Result<Rendering> {
        let mut planes = self.evaluate(optics, 4)?.into_iter();
        let mut next = || planes.next().expect("four planes were asked for");
        Ok(Rendering { image: next(), gradient: Some([next(), next(), next()]) })
    }

    /// The first `count` of image, d/d sigma_s, d/d sigma_a, d/d B.
    fn evaluate(&self, optics: &Optics, count: usize) -> Result<Vec<Image>> {
        if optics.model == Model::BeerLambert {
            let mut planes = vec![vec![0.0; self.canvas.pixels()]; count];
            for segment in self.segments.iter().rev() {
                segment.add_direct(&optics.medium, 0.0, &mut planes);
                if let Some(gate) = &segment.screen {
                    planes.iter_mut().for_each(|plane| gate.stop(plane));
                }
            }
            return Ok(self.view(&planes));
        }
        let mut sum: Option<Vec<Vec<f32>>> = None;
        for (obliquity, weights) in self.obliquities.iter() {
            let mut planes = self.scattered(optics, obliquity, count)?;
            if let Some(weights) = weights {
                planes.iter_mut().for_each(|plane| self.canvas.weigh(plane, self.target.view, weights));
            }
            match &mut sum {
                None => sum = Some(planes),
                Some(sum) => {
                    let pairs = sum.iter_mut().flatten().zip(planes.iter().flatten());
                    pairs.for_each(|(s, v)| *s += v);
                }
            }
        }
        let mut planes = sum.expect("there is an obliquity");
        self.segments[0].add_direct(&optics.medium, 0.0, &mut planes);
        Ok(self.view(&planes))
    }

    /// The same on the canvas without the direct light of the first segment, for rays of one obliquity.
    fn scattered(&self, optics: &Optics, obliquity: Obliquity, count: usize) -> Result<Vec<Vec<f32>>> {
        let single_depth = self.single_depth();
        let components: Vec<usize> = (0..count).filter(|&c| c != 2 || single_depth.is_none()).collect();
        let mut carried = None;
        for segment in self.segments.iter().rev() {
            let spectra = segment.gather(&self.canvas, (optics, obliquity), carried.as_ref(), &components)?;
            let mut fields: Vec<Vec<f32>> = spectra.into_iter().map(|s| self.canvas.fft.inverse(s)).collect();
            if let Some(node) = single_depth.filter(|_| count == 4) {
                let z = obliquity.tilt(node).z as f32;
                fields.insert(2, fields[0].iter().map(|v| -z * v).collect());
            }
            match &segment.screen {
                Some(gate) => carried = Some(segment.pass(gate, &self.canvas, &optics.medium, fields)),
                None => return Ok(fields),
            }
        }
        unreachable!("the first segment has no screen")
    }

    fn view(&self, planes: &[Vec<f32>]) -> Vec<Image> {
        planes.iter().map(|plane| self.canvas.crop(plane, self.target.view)).collect()
    }
}

/// Slices for what lies before the first screen and behind each; none where nothing does.
fn per_segment(
    target: &Target,
    sheets: &[Sheet],
    mut slices: impl FnMut(&[Node]) -> Result<Slices>,
) -> Result<Vec<Option<Slices>>> {
    let screens = target.relief.map_or(0, |relief| relief.screens.len());
    let between = |passed: usize| {
        let mine = sheets.iter().flatten().flatten().filter(|s| s.screens == passed);
        let mut nodes: Vec<Node> = mine.map(|s| s.node).collect();
        nodes.dedup();
        if nodes.is_empty() { Ok(None) } else { slices(&nodes).map(Some) }
    };
    (0..=screens).map(between).collect()
}

/// Radius in pixels beyond which less than [`OUTSIDE`] of the light of any slice falls.
fn reach_px<'s>(slices: impl Iterator<Item = &'s Slices>, optics: &Optics) -> Result<f64> {
    let mut reach: f64 = 0.0;
    for node in slices.flat_map(|s| &s.nodes) {
        reach = reach.max(optics.kernel(node.z)?.support(OUTSIDE) / node.pitch);
    }
    Ok(reach)
}
