//! Parameters of one scene beside the medium's, which are fitted along so that they do not bias it.

use super::Coordinate;
use super::parameter::{Descriptor, Parameter, Role};
use crate::forward::Quantity;

/// How far a shift may move from where it is first seen, px: the coarse start is within 0.3 px, or found the wrong peak.
const SHIFT_ROOM_PX: f64 = 3.0;
/// Longest step of a shift, px: the cost is a parabola only over the width of the finest detail.
const LONGEST_SHIFT_PX: f64 = 0.5;

/// The shift of the observation of scene number `scene` of `scenes`, first seen at `start_px`.
pub(super) fn shift(scene: usize, scenes: usize, start_px: [f64; 2]) -> Vec<Parameter> {
    let suffix = if scenes == 1 { String::new() } else { format!(".{}", scene + 1) };
    let along = |(quantity, name): (Quantity, &str), start: f64| {
        let descriptor = Descriptor {
            name: format!("{name}{suffix}"),
            unit: "px",
            quantity,
            scene: Some(scene),
            coordinate: Coordinate::Linear,
            bounds: [start - SHIFT_ROOM_PX, start + SHIFT_ROOM_PX],
            role: Role::Free,
            scale: 1.0,
            longest_step: LONGEST_SHIFT_PX,
        };
        Parameter::new(descriptor, start)
    };
    let axes = Quantity::SHIFT.into_iter().zip(["shift_x_px", "shift_y_px"]);
    axes.zip(start_px).map(|(axis, start)| along(axis, start)).collect()
}
