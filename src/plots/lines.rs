//! A line chart: named series over a linear or logarithmic axis, with the legend beside it.

use super::canvas::{Drawn, INK, bitmap, text, text_width, write_png, write_svg};
use super::scale::Scale;
use super::series::{LABEL_PX, Mark, Series, Spread};
use crate::error::Result;
use plotters::chart::ChartBuilder;
use plotters::coord::Shift;
use plotters::prelude::{
    Circle, DashedLineSeries, DrawingArea, DrawingBackend, LineSeries, PathElement, Polygon, TRANSPARENT,
};
use plotters::style::Color;
use std::path::Path;

const SIZE: (u32, u32) = (1200, 760);
pub(super) const TITLE_PX: f64 = 24.0;
const TICK_PX: f64 = 16.0;

/// A logarithmic axis shows at most this many decades; below, nothing of a kernel can be seen in an image.
const DECADES: f64 = 8.0;

/// One of the two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit, as in `radius (length)`.
    pub label: String,
    /// Logarithmic instead of linear; values that are not positive are left out.
    pub log: bool,
}

/// A chart of several series.
#[derive(Debug, Clone, PartialEq)]
pub struct LineChart {
    /// What is shown.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The series, drawn in this order.
    pub series: Vec<Series>,
}

impl LineChart {
    /// Writes it as a PNG file of 1200 x 760 px.
    ///
    /// # Errors
    /// [`Error::Write`](crate::Error::Write) with the path.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_png(path, SIZE, bitmap(SIZE, |root| self.draw(root)))
    }

    /// Writes it as an SVG file.
    ///
    /// # Errors
    /// [`Error::Write`](crate::Error::Write) with the path.
    pub fn write_svg(&self, path: &Path) -> Result<()> {
        write_svg(path, SIZE, &[], |root| self.draw(root))
    }

    fn draw<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> Drawn {
        let legend_px = self.series.iter().map(Series::sample_width).max().unwrap_or(0);
        let (plot, legend) = root.split_horizontally(SIZE.0 as i32 - legend_px);
        self.draw_axes_and_curves(&plot, scales(&[self]))?;
        self.draw_legend(&legend)
    }

    /// Everything but the legend, on axes from [`scales`].
    pub(super) fn draw_axes_and_curves<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        [x, y]: [Scale; 2],
    ) -> Drawn {
        let widest_tick = y.ticks(9).into_iter().map(|v| text_width(&y.label(v), TICK_PX)).max().unwrap_or(0);

        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, text(TITLE_PX))
            .margin(14)
            .x_label_area_size(62)
            .y_label_area_size(widest_tick + 46)
            .build_cartesian_2d(x, y)
            .map_err(|e| e.to_string())?;
        chart
            .configure_mesh()
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .axis_desc_style(text(LABEL_PX))
            .label_style(text(TICK_PX))
            .axis_style(INK)
            .bold_line_style(INK.mix(0.15))
            .light_line_style(TRANSPARENT)
            .draw()
            .map_err(|e| e.to_string())?;

        for (i, series) in self.series.iter().enumerate() {
            let style = series.style(i);
            let inside =
                |p: &(f64, f64)| (0.0..=1.0).contains(&x.share(p.0)) && (0.0..=1.0).contains(&y.share(p.1));
            let end = |v: f64| if v > y.low { v.min(y.high) } else { y.low };
            if let Spread::Band(_) = series.spread {
                let upper = series.with_ends().map(|p| (p.0, end(p.3)));
                let lower = series.with_ends().map(|p| (p.0, end(p.2)));
                let outline: Vec<_> = upper.chain(lower.collect::<Vec<_>>().into_iter().rev()).collect();
                let band = Polygon::new(outline, style.color.mix(0.2).filled());
                chart.draw_series([band]).map_err(|e| e.to_string())?;
            }
            if let Spread::Bars(_) = series.spread {
                let shown = series.with_ends().filter(|p| inside(&(p.0, p.1)));
                let bar =
                    |p: (f64, f64, f64, f64)| PathElement::new([(p.0, end(p.2)), (p.0, end(p.3))], style);
                chart.draw_series(shown.map(bar)).map_err(|e| e.to_string())?;
            }
            if let Mark::Signs(sign, _) = series.mark {
                let shown = series.points.iter().copied().filter(inside);
                for point in shown {
                    sign.draw(chart.plotting_area(), point, style).map_err(|e| e.to_string())?;
                }
                continue;
            }
            if series.mark == Mark::Points {
                let shown = series.points.iter().copied().filter(inside);
                let dots = shown.map(|p| Circle::new(p, 4, style.filled()));
                chart.draw_series(dots).map_err(|e| e.to_string())?;
                continue;
            }
            for piece in pieces_inside(&series.points, y) {
                let drawn = if series.is_dashed(i) {
                    chart.draw_series(DashedLineSeries::new(piece, 9, 5, style)).map(drop)
                } else {
                    chart.draw_series(LineSeries::new(piece, style)).map(drop)
                };
                drawn.map_err(|e| e.to_string())?;
            }
        }
        Ok(())
    }

    fn draw_legend<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn {
        let row_px = (1.6 * LABEL_PX) as i32;
        let named = self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty());
        for (row, (i, series)) in named.enumerate() {
            series.draw_sample(area, i, (6, 64 + row_px * row as i32))?;
        }
        Ok(())
    }
}

/// The horizontal and the vertical axis that show all of `charts`, which have the same kinds of axis.
pub(super) fn scales(charts: &[&LineChart]) -> [Scale; 2] {
    let all = || charts.iter().flat_map(|chart| &chart.series).flat_map(Series::with_ends);
    let [x_log, y_log] = charts.first().map_or([false; 2], |chart| [chart.x.log, chart.y.log]);
    let x = Scale::around(all().map(|p| p.0), x_log, DECADES);
    // Error bars below the smallest value would only stretch a logarithmic axis.
    let low = all().map(|p| if y_log { p.1 } else { p.2 });
    [x, Scale::around(low.chain(all().map(|p| p.3)), y_log, DECADES)]
}

/// The parts of a curve that lie between the ends of the vertical axis, cut where they leave it.
fn pieces_inside(points: &[(f64, f64)], y: Scale) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
    // A value that a logarithmic axis cannot place lies far below it.
    let share = |v: f64| if y.log && v <= 0.0 { -1e3 } else { y.share(v) };
    for pair in points.windows(2) {
        let (from, to) = (share(pair[0].1), share(pair[1].1));
        if !(from.is_finite() && to.is_finite()) || from.max(to) < 0.0 || from.min(to) > 1.0 {
            pieces.push(Vec::new());
            continue;
        }
        // The place at the height `t`; a level line is never cut, so its `end` says where on it that is.
        let cut = |t: f64, end: f64| {
            let f = if from == to { end } else { (t.clamp(0.0, 1.0) - from) / (to - from) };
            (pair[0].0 + f * (pair[1].0 - pair[0].0), y.value(t.clamp(0.0, 1.0)))
        };
        let piece = pieces.last_mut().expect("never empty");
        if piece.is_empty() {
            piece.push(cut(from, 0.0));
        }
        piece.push(cut(to, 1.0));
        if !(0.0..=1.0).contains(&to) {
            pieces.push(Vec::new());
        }
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_cut_where_it_leaves_the_frame() {
        let y = Scale { low: 0.0, high: 1.0, log: false };
        let points = [(0.0, 0.5), (1.0, 1.5), (2.0, 0.5), (3.0, f64::NAN), (4.0, 0.2), (5.0, 0.4)];
        let expected =
            vec![vec![(0.0, 0.5), (0.5, 1.0)], vec![(1.5, 1.0), (2.0, 0.5)], vec![(4.0, 0.2), (5.0, 0.4)]];
        assert_eq!(pieces_inside(&points, y), expected);
    }

    #[test]
    fn a_level_line_and_steps_keep_their_corners() {
        let y = Scale { low: 0.0, high: 1.0, log: false };
        let steps = vec![(0.0, 0.5), (2.0, 0.5), (2.0, 0.25), (4.0, 0.25)];
        assert_eq!(pieces_inside(&steps, y), [steps]);
    }
}
