//! Signs for points that differ in more than their colour.

use plotters::coord::CoordTranslate;
use plotters::prelude::{
    Circle, DrawingArea, DrawingAreaErrorKind, DrawingBackend, EmptyElement, PathElement, Polygon, WHITE,
};
use plotters::style::{Color, ShapeStyle};

/// Radius of a disk, px; other outlines have about the same area.
const RADIUS: i32 = 5;

/// The outline of a sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A circle.
    Round,
    /// A triangle that points up.
    Triangle,
    /// A square on its tip.
    Diamond,
}

/// A shape, filled or open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sign {
    /// Its outline.
    pub shape: Shape,
    /// Filled with its colour; else white inside.
    pub filled: bool,
}

impl Sign {
    /// The corners around its place, px; none for a circle.
    fn corners(self) -> &'static [(i32, i32)] {
        match self.shape {
            Shape::Round => &[],
            Shape::Triangle => &[(0, -7), (6, 5), (-6, 5)],
            Shape::Diamond => &[(0, -8), (8, 0), (0, 8), (-8, 0)],
        }
    }

    /// Draws it in `style`.
    pub(super) fn draw<DB: DrawingBackend, C: CoordTranslate>(
        self,
        area: &DrawingArea<DB, C>,
        at: C::From,
        style: ShapeStyle,
    ) -> std::result::Result<(), DrawingAreaErrorKind<DB::ErrorType>>
    where
        C::From: Clone,
    {
        let corners = self.corners();
        let inside = if self.filled { style.filled() } else { WHITE.filled() };
        if corners.is_empty() {
            let disk = Circle::new((0, 0), RADIUS, style.filled());
            return area.draw(&(EmptyElement::at(at) + disk + Circle::new((0, 0), RADIUS - 2, inside)));
        }
        let outline: Vec<_> = corners.iter().chain(&corners[..1]).copied().collect();
        area.draw(&(EmptyElement::at(at) + Polygon::new(corners, inside) + PathElement::new(outline, style)))
    }
}
