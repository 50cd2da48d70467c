//! The memory that a filter takes, reserved before it is taken.

use super::canvas::Canvas;
use super::plan::Plan;
use super::sources::Layer;
use crate::error::Result;
use crate::image::Border;
use crate::memory::{Reservation, product, reserve};

/// Images on the canvas that a render holds at once: for the image and three derivatives what is carried from behind an occluder, the
/// spectra gathered there and their fields.
const RENDERED: usize = 12;
/// Bytes of an object pixel whose direct light is listed.
const DIRECT: usize = 32;

/// Reserves what a filter of `plan` and its renders take on `canvas`: the object's light, and that of its slopes, weighted for
/// each slice.
pub(super) fn reserve_planes(plan: &Plan, canvas: &Canvas, layers: &[Layer]) -> Result<Reservation> {
    let slices = plan.slice_count();
    let occluders = plan.occluders().len();
    let sloping = layers.iter().flatten().flatten().any(|source| source.slope != [0.0; 2]);
    let largest = plan.slices.iter().flatten().map(|slices| slices.nodes.len()).max().unwrap_or(0);
    // While the light of a slab's slopes is made, there is half as much of it again.
    let images =
        slices * (1 + usize::from(sloping)) + RENDERED.max(usize::from(sloping) * largest) + 2 + occluders;
    let shown = match plan.target.border {
        Border::Zero => plan.target.radiance.data.len(),
        Border::Clamp | Border::Mirror | Border::Unknown => canvas.pixels(),
    };
    let direct = product(&[shown, layers.len(), DIRECT]);
    let what = || {
        let [width, height] = [canvas.fft.width, canvas.fft.height];
        let [own_width, own_height] = canvas.object;
        format!(
            "a filter of {slices} depth slices and {occluders} occluders over {own_width}x{own_height} px, padded to {width}x{height} px"
        )
    };
    reserve(what, product(&[canvas.pixels(), images, size_of::<f32>()]).saturating_add(direct))
}
