//! What a line chart shows: named points, how they are drawn, and their entry in a legend.

use super::canvas::{Drawn, INK, PALETTE, label, text_width};
use super::signs::Sign;
use plotters::coord::Shift;
use plotters::prelude::{Circle, DashedLineSeries, DrawingArea, DrawingBackend, PathElement, RGBColor, Text};
use plotters::style::{Color, ShapeStyle};

pub(super) const LABEL_PX: f64 = 19.0;
const LINE_PX: u32 = 2;
const BROAD_PX: u32 = 5;
const BROAD: RGBColor = RGBColor(150, 150, 150);

/// Length of the line that stands for a series in the legend, px.
const SAMPLE_PX: i32 = 40;

/// The uncertainty of a series, one standard error per point, drawn to either side.
#[derive(Debug, Clone, PartialEq)]
pub enum Spread {
    /// None is drawn.
    None,
    /// A bar at each point.
    Bars(Vec<f64>),
    /// A shaded band.
    Band(Vec<f64>),
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line through the points.
    Line,
    /// The points alone: for measured values among models.
    Points,
    /// A broad gray line beneath the others: for measured values too many for points.
    Broad,
    /// A thin dark line, dashed or not: for bounds and levels.
    Thin {
        /// Dashed.
        dashed: bool,
    },
    /// The points alone as this sign, in the colour that the series at this place has; dark without a place.
    Signs(Sign, Option<usize>),
}

/// Named points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// The name in the legend; empty: the legend leaves it out.
    pub name: String,
    /// (x, y), in increasing x.
    pub points: Vec<(f64, f64)>,
    /// Uncertainty of y, for each point.
    pub spread: Spread,
    /// Line or points.
    pub mark: Mark,
}

impl Series {
    /// A line without uncertainty.
    pub fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, spread: Spread::None, mark: Mark::Line }
    }

    /// Points with a bar of one standard error to either side.
    pub fn measured(name: impl Into<String>, points: Vec<(f64, f64)>, std_errors: Vec<f64>) -> Self {
        Self { name: name.into(), points, spread: Spread::Bars(std_errors), mark: Mark::Points }
    }

    /// Draws its line or point and its name in a legend, as the series `i`, from the left end at `x`, `y` px.
    pub(super) fn draw_sample<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        i: usize,
        (x, y): (i32, i32),
    ) -> Drawn {
        let style = self.style(i);
        let ends = [(x, y), (x + SAMPLE_PX, y)];
        let drawn = match self.mark {
            Mark::Points => area.draw(&Circle::new((x + SAMPLE_PX / 2, y), 4, style.filled())),
            Mark::Signs(sign, _) => sign.draw(area, (x + SAMPLE_PX / 2, y), style),
            _ if self.is_dashed(i) => {
                let mut dashes = DashedLineSeries::new(ends, 9, 5, style).into_iter();
                dashes.try_for_each(|d| area.draw(&d))
            }
            Mark::Line | Mark::Broad | Mark::Thin { .. } => area.draw(&PathElement::new(ends, style)),
        };
        let name = Text::new(self.name.clone(), (x + SAMPLE_PX + 10, y), label(LABEL_PX));
        drawn.and_then(|()| area.draw(&name)).map_err(|e| e.to_string())
    }

    /// The style of the series `i`.
    pub(super) fn style(&self, i: usize) -> ShapeStyle {
        match self.mark {
            Mark::Broad => BROAD.stroke_width(BROAD_PX),
            Mark::Thin { .. } => INK.stroke_width(1),
            Mark::Signs(_, None) => INK.stroke_width(LINE_PX),
            Mark::Line | Mark::Points => PALETTE[i % PALETTE.len()].stroke_width(LINE_PX),
            Mark::Signs(_, Some(place)) => PALETTE[place % PALETTE.len()].stroke_width(LINE_PX),
        }
    }

    /// Every other line is dashed, so that curves that coincide can both be seen.
    pub(super) fn is_dashed(&self, i: usize) -> bool {
        match self.mark {
            Mark::Line => i % 2 == 1,
            Mark::Thin { dashed } => dashed,
            Mark::Points | Mark::Broad | Mark::Signs(..) => false,
        }
    }

    /// Room that it takes in a legend, px.
    pub(super) fn sample_width(&self) -> i32 {
        SAMPLE_PX + 40 + text_width(&self.name, LABEL_PX) as i32
    }

    /// A broad line beneath the others, with a band of one standard error to either side.
    pub fn reference(name: impl Into<String>, points: Vec<(f64, f64)>, std_errors: Vec<f64>) -> Self {
        Self { name: name.into(), points, spread: Spread::Band(std_errors), mark: Mark::Broad }
    }

    /// Each point with the ends of its error bar.
    pub(super) fn with_ends(&self) -> impl Iterator<Item = (f64, f64, f64, f64)> {
        let half = |i: usize| match &self.spread {
            Spread::None => 0.0,
            Spread::Bars(errors) | Spread::Band(errors) => errors.get(i).copied().unwrap_or(0.0),
        };
        self.points.iter().enumerate().map(move |(i, &(x, y))| (x, y, y - half(i), y + half(i)))
    }
}
