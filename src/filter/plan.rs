//! What every backend prepares itself from: a target cut into slices, and how far its image must be padded.

use super::canvas::most_reach;
use super::obliquity::Obliquities;
use super::slices::{Node, Slices};
use super::sources::{Layer, hidden_layers, layers, reserve_layers};
use super::{Optics, Target};
use crate::error::Result;
use crate::image::Border;
use crate::phase::PhaseFunction;
use crate::relief::{Occluder, Relief};
use crate::spread::Model;

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
/// Share that may come back to the object image from there, where light falls slowly, as that of Henyey-Greenstein's lobes does
/// in small-angle theory (like 1/r) and that of grazing paths in `wide-angle`: it is spread over all of the padded image.
const RETURNED: f64 = 2e-4;
/// Share of such light that may fall beyond the padding where the border goes on: half of the error of `wide-angle`.
const FAR: f64 = 1e-3;
/// Largest error of the slices' transfer functions, as a share of the scattered light.
const SLICE_TOLERANCE: f64 = 1e-4;
/// What to tell a user of [`Coverage::cut`].
pub const CUT: &str = "the kernel reaches beyond the most padding there is: light that should leave the image comes \
                       back on its other side; use fewer pixels for the same scene, or a mirrored border";

/// A target cut into slices.
pub(super) struct Plan<'a> {
    pub target: Target<'a>,
    /// Farthest reach of a kernel that the padding must serve, px.
    pub reach_px: f64,
    pub obliquities: Obliquities,
    /// Of what lies before the first occluder and behind each; none where nothing does.
    pub slices: Vec<Option<Slices>>,
}

impl<'a> Plan<'a> {
    /// The plan of `target` for kernels up to as wide as those of `optics`, times `headroom`, and its sources.
    pub(super) fn new(target: Target<'a>, optics: &Optics, headroom: f64) -> Result<(Self, Vec<Layer>)> {
        let _memory = reserve_layers(&target)?;
        Self::of_layers(target, layers(&target), optics, headroom)
    }

    /// The same for light of radiance 1 from the surfaces inpainted behind the occluders of
    /// `relief`, which the target has: what renders is the share of hidden light.
    pub(super) fn of_hidden(
        target: Target<'a>,
        relief: &Relief,
        optics: &Optics,
    ) -> Result<(Self, Vec<Layer>)> {
        let _memory = reserve_layers(&target)?;
        Self::of_layers(target, hidden_layers(&target, relief), optics, 1.0)
    }

    fn of_layers(
        target: Target<'a>,
        layers: Vec<Layer>,
        optics: &Optics,
        headroom: f64,
    ) -> Result<(Self, Vec<Layer>)> {
        let divergence = target.geometry.pitch_per_depth();
        let sliced = |nodes: &[Node]| Slices::for_tolerance(divergence, nodes, optics, SLICE_TOLERANCE);
        let slices = per_slab(&target, &layers, sliced)?;
        let reach_px = headroom * reach_px(slices.iter().flatten(), optics, &target)?;
        Ok((Self::with(target, slices, reach_px), layers))
    }

    /// The plan with at most `count` slices along z between any two occluders and padding for kernels that reach
    /// `reach_px` pixels, and its sources.
    pub(super) fn with_slices(target: Target<'a>, count: usize, reach_px: f64) -> Result<(Self, Vec<Layer>)> {
        let _memory = reserve_layers(&target)?;
        let layers = layers(&target);
        let divergence = target.geometry.pitch_per_depth();
        let slices = per_slab(&target, &layers, |nodes| Ok(Slices::new(divergence, nodes, count)))?;
        Ok((Self::with(target, slices, reach_px), layers))
    }

    /// The same with `px` more of padding.
    pub(super) fn padded_by(self, px: f64) -> Self {
        Self { reach_px: self.reach_px + px, ..self }
    }

    fn with(target: Target<'a>, slices: Vec<Option<Slices>>, reach_px: f64) -> Self {
        let obliquities = Obliquities::new(target.geometry, target.view);
        Self { target, reach_px, obliquities, slices }
    }

    /// The occluders of the target, nearest first.
    pub(super) fn occluders(&self) -> &'a [Occluder] {
        self.target.relief.map_or(&[], |relief| &relief.occluders)
    }

    /// The last of the `passed` occluders that the light of a slab must pass.
    pub(super) fn occluder(&self, passed: usize) -> Option<&'a Occluder> {
        passed.checked_sub(1).map(|i| &self.occluders()[i])
    }

    /// Where `occluder` stands.
    pub(super) fn node(&self, occluder: &Occluder) -> Node {
        Node { z: occluder.z, pitch: self.target.geometry.pixel_pitch(occluder.depth) }
    }

    /// How far padding and slices serve the kernels of `optics` too.
    pub(super) fn coverage(&self, optics: &Optics) -> Result<Coverage> {
        let most = most_reach(&self.target);
        let reach = reach_px(self.all_slices(), optics, &self.target)?;
        let mut served = reach.min(most) <= self.reach_px;
        for slices in self.all_slices() {
            served &= slices.error(optics)? <= SLICE_TOLERANCE;
        }
        Ok(Coverage { served, cut: !self.target.border.mirrors() && reach > most })
    }

    fn all_slices(&self) -> impl Iterator<Item = &Slices> {
        self.slices.iter().flatten()
    }

    pub(super) fn slice_count(&self) -> usize {
        self.all_slices().map(|s| s.nodes.len()).sum()
    }

    /// Path length of the farthest slice, length.
    #[cfg(feature = "gpu")]
    pub(super) fn farthest(&self) -> f64 {
        let lengths = self.all_slices().flat_map(|s| &s.nodes).map(|node| node.z);
        lengths.fold(0.0, f64::max).max(f64::MIN_POSITIVE)
    }

    /// The only slice, if there is but one.
    pub(super) fn single_depth(&self) -> Option<Node> {
        match &self.slices[..] {
            [Some(Slices { nodes, .. })] if nodes.len() == 1 => Some(nodes[0]),
            _ => None,
        }
    }
}

/// Slices for what lies before the first occluder and behind each; none where nothing does.
fn per_slab(
    target: &Target,
    layers: &[Layer],
    mut slices: impl FnMut(&[Node]) -> Result<Slices>,
) -> Result<Vec<Option<Slices>>> {
    let occluders = target.relief.map_or(0, |relief| relief.occluders.len());
    let between = |passed: usize| {
        let mut nodes: Vec<Node> = Vec::new();
        for source in layers.iter().flatten().flatten().filter(|s| s.occluders == passed) {
            // Neighbours often lie at one depth.
            if nodes.last() != Some(&source.node) {
                nodes.push(source.node);
            }
        }
        if nodes.is_empty() { Ok(None) } else { slices(&nodes).map(Some) }
    };
    (0..=occluders).map(between).collect()
}

/// Radius in pixels beyond which less than [`OUTSIDE`] of the light of any slice falls, or from which less than
/// [`RETURNED`] would come back; some radius above the most padding that there is if it is larger than that.
fn reach_px<'s>(slices: impl Iterator<Item = &'s Slices>, optics: &Optics, target: &Target) -> Result<f64> {
    let most = most_reach(target);
    let side = target.radiance.width.max(target.radiance.height) as f64;
    let slow = optics.model == Model::WideAngle || optics.medium.phase().planar_second_moment().is_none();
    let outside = |r: f64| match (slow, target.border) {
        _ if r > most => 1.0,
        (false, _) => OUTSIDE,
        (true, Border::Zero) => RETURNED * (r / side).powi(2).max(1.0),
        (true, _) => FAR,
    };
    let mut reach: f64 = 0.0;
    for node in slices.flat_map(|s| &s.nodes) {
        reach = reach.max(optics.kernel(node.z)?.reach(&|r| outside(r / node.pitch)) / node.pitch);
    }
    Ok(reach)
}
