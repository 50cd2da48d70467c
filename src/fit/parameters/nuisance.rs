//! Parameters of one scene beside the medium's, which are fitted along so that they do not bias it.

use super::Coordinate;
use super::parameter::{Bounds, Descriptor, Parameter, Role};
use crate::forward::Quantity;
use crate::imaging::{Imaging, WarpParameter};

/// How far a shift may move from where it is first seen, px: the coarse start is within 0.3 px, or found the wrong peak.
const SHIFT_ROOM_PX: f64 = 3.0;
/// Longest step of a shift, px: the cost is a parabola only over the width of the finest detail.
const LONGEST_SHIFT_PX: f64 = 0.5;
/// The same of turns, scales and so on, from where they are first seen: a 32nd, and steps of a pixel at the edge of a small view.
const WARP_ROOM: f64 = 0.03;
const LONGEST_WARP: f64 = 0.005;
/// Largest variance of a blur, px².
const MOST_BLUR_PX2: f64 = 100.0;
/// Largest coefficient of a gain field: the light is halved.
const MOST_GAIN_TERM: f64 = 0.5;

/// A scene among those of a fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scene {
    pub number: usize,
    pub of: usize,
}

impl Scene {
    /// Its shift, first seen at `start_px`.
    pub(super) fn shift(self, start_px: [f64; 2]) -> Vec<Parameter> {
        let axes = Quantity::SHIFT.into_iter().zip(["shift_x_px", "shift_y_px"]).zip(start_px);
        let along = |((quantity, name), start): ((Quantity, &str), f64)| {
            let bounds = [start - SHIFT_ROOM_PX, start + SHIFT_ROOM_PX];
            self.parameter(name, "px", quantity, start, bounds, LONGEST_SHIFT_PX, 1.0)
        };
        axes.map(along).collect()
    }

    /// What is looked for of its camera, from what `begun` says.
    pub(super) fn imaging(self, begun: &Imaging) -> Vec<Parameter> {
        let one = |quantity: Quantity| {
            let start = quantity.in_imaging(begun);
            match quantity {
                Quantity::Warp(parameter) => {
                    let unit = if parameter == WarpParameter::Rotation { "rad" } else { "1" };
                    let bounds = [start - WARP_ROOM, start + WARP_ROOM];
                    self.parameter(parameter.name(), unit, quantity, start, bounds, LONGEST_WARP, 0.01)
                }
                Quantity::Blur => {
                    self.parameter("blur_px2", "px²", quantity, start, [0.0, MOST_BLUR_PX2], 1.0, 1.0)
                }
                Quantity::GainTerm(term) => {
                    let bounds = [-MOST_GAIN_TERM, MOST_GAIN_TERM];
                    self.parameter(&format!("gain_term_{term}"), "1", quantity, start, bounds, 0.2, 0.1)
                }
                _ => {
                    let bounds = [-MOST_GAIN_TERM, MOST_GAIN_TERM];
                    self.parameter("gain_radial", "1", quantity, start, bounds, 0.2, 0.1)
                }
            }
        };
        Quantity::of_imaging(begun).into_iter().map(one).collect()
    }

    #[expect(clippy::too_many_arguments, reason = "a row of a table")]
    fn parameter(
        self,
        name: &str,
        unit: &'static str,
        quantity: Quantity,
        start: f64,
        bounds: Bounds,
        longest_step: f64,
        scale: f64,
    ) -> Parameter {
        let suffix = if self.of == 1 { String::new() } else { format!(".{}", self.number + 1) };
        let descriptor = Descriptor {
            name: format!("{name}{suffix}"),
            unit,
            quantity,
            scene: Some(self.number),
            coordinate: Coordinate::Linear,
            bounds,
            role: Role::Free,
            scale,
            longest_step,
        };
        Parameter::new(descriptor, start)
    }
}
