//! Maps: functions of two variables as colours, in rows on common axes, with one colour bar.

use super::canvas::{Drawn, INK, bitmap, text, write_png, write_svg};
use super::colour_bar::Shade;
use super::scale::Scale;
use crate::error::Result;
use crate::image::Image;
use plotters::chart::ChartBuilder;
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, DrawingBackend, PathElement, RGBColor, Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform};
use std::ops::Range;
use std::path::Path;

const TITLE_PX: f64 = 24.0;
const TEXT_PX: f64 = 17.0;
const TICK_PX: f64 = 15.0;
const MARGIN_PX: i32 = 16;

/// Side of a map on the page, px.
const MAP_PX: i32 = 240;
/// Room for a map's title, its horizontal axis, and between rows, px.
const TITLE_AREA_PX: i32 = 34;
const X_AXIS_PX: u32 = 50;
const ROW_GAP_PX: i32 = 14;
/// Room for the vertical axis, and between maps, px.
const Y_AXIS_PX: u32 = 66;
const GAP_PX: i32 = 10;
/// Room for the colour bar with its numbers and label, px.
const BAR_PX: i32 = 128;
/// The same for a legend.
const LEGEND_PX: i32 = 200;

/// One map.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// What it shows.
    pub title: String,
    /// Values; columns along the horizontal axis, row 0 at the low end of the vertical one.
    pub values: Image,
    /// Whether each of them belongs to a region whose boundary is drawn; empty for none.
    pub region: Vec<bool>,
}

/// Maps that share their vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct MapRow {
    /// Quantity and unit of the vertical axis, and what distinguishes this row from others.
    pub label: String,
    /// From left to right.
    pub maps: Vec<Map>,
}

/// Rows of maps of one quantity over the same two variables.
#[derive(Debug, Clone, PartialEq)]
pub struct MapGrid {
    /// What is shown.
    pub title: String,
    /// From the top.
    pub rows: Vec<MapRow>,
    /// Quantity and unit of the horizontal axis.
    pub x_label: String,
    /// The horizontal axis.
    pub x: Range<f64>,
    /// The vertical axis, from the bottom.
    pub y: Range<f64>,
    /// Whether both axes are logarithmic.
    pub log: bool,
    /// Where a vertical line divides every map.
    pub parted_at: Option<f64>,
    /// How values become colours, in all maps.
    pub shade: Shade,
    /// Quantity and unit of the values.
    pub value_label: String,
}

impl MapGrid {
    /// Writes it as a PNG file.
    ///
    /// # Errors
    /// [`Error::Write`](crate::Error::Write) with the path.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_png(path, self.size(), bitmap(self.size(), |root| self.draw(root)))
    }

    /// Writes it as an SVG file.
    ///
    /// # Errors
    /// [`Error::Write`](crate::Error::Write) with the path.
    pub fn write_svg(&self, path: &Path) -> Result<()> {
        write_svg(path, self.size(), &[], |root| self.draw(root))
    }

    fn size(&self) -> (u32, u32) {
        let columns = self.rows.iter().map(|row| row.maps.len()).max().unwrap_or(0) as i32;
        let width = 2 * MARGIN_PX + Y_AXIS_PX as i32 + columns * (MAP_PX + GAP_PX) + self.bar_px();
        (width as u32, (self.row_top(self.rows.len()) + MARGIN_PX) as u32)
    }

    fn bar_px(&self) -> i32 {
        if matches!(self.shade, Shade::Categories(_)) { LEGEND_PX } else { BAR_PX }
    }

    /// Top of row `r` with its titles, px.
    fn row_top(&self, r: usize) -> i32 {
        3 * MARGIN_PX + r as i32 * (TITLE_AREA_PX + MAP_PX + X_AXIS_PX as i32 + ROW_GAP_PX)
    }

    fn draw<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> Drawn {
        let title = Text::new(self.title.clone(), (MARGIN_PX, MARGIN_PX), text(TITLE_PX));
        root.draw(&title).map_err(|e| e.to_string())?;
        for (r, row) in self.rows.iter().enumerate() {
            for (c, map) in row.maps.iter().enumerate() {
                let left = MARGIN_PX + Y_AXIS_PX as i32 + c as i32 * (MAP_PX + GAP_PX);
                let label = (c == 0).then_some(row.label.as_str());
                self.draw_map(root, map, (left, self.row_top(r)), label)?;
            }
        }
        let (width, height) = (self.size().0 as i32, self.row_top(self.rows.len()));
        let top = self.row_top(0) + TITLE_AREA_PX;
        let bar = height - ROW_GAP_PX - X_AXIS_PX as i32 - top;
        self.shade.draw_bar(root, (width - self.bar_px(), top), bar)?;
        let turned = text(TEXT_PX).transform(FontTransform::Rotate90);
        let turned = turned.pos(Pos::new(HPos::Center, VPos::Center));
        let label = Text::new(self.value_label.clone(), (width - 2 * MARGIN_PX, top + bar / 2), turned);
        root.draw(&label).map_err(|e| e.to_string())
    }

    /// Draws one map, its title from `left`, `top` px; with numbers on the vertical axis if that has a label.
    fn draw_map<DB: DrawingBackend>(
        &self,
        root: &DrawingArea<DB, Shift>,
        map: &Map,
        (left, top): (i32, i32),
        label: Option<&str>,
    ) -> Drawn {
        let title = Text::new(map.title.clone(), (left, top + 8), text(TEXT_PX));
        root.draw(&title).map_err(|e| e.to_string())?;
        let axis_px = if label.is_some() { Y_AXIS_PX } else { 0 };
        let (width, height) = (MAP_PX as u32 + axis_px, MAP_PX as u32 + X_AXIS_PX);
        let corner = (left - axis_px as i32, top + TITLE_AREA_PX);
        let area = root.clone().shrink(corner, (width, height));
        let mut chart = ChartBuilder::on(&area)
            .x_label_area_size(X_AXIS_PX)
            .y_label_area_size(axis_px)
            .build_cartesian_2d(self.scale(&self.x), self.scale(&self.y))
            .map_err(|e| e.to_string())?;
        chart.draw_series(self.runs(&map.values)).map_err(|e| e.to_string())?;
        let boundary = self.boundary(map).into_iter().map(|ends| PathElement::new(ends, INK.stroke_width(3)));
        chart.draw_series(boundary).map_err(|e| e.to_string())?;
        let parting = |x: f64| PathElement::new([(x, self.y.start), (x, self.y.end)], INK.mix(0.6));
        chart.draw_series(self.parted_at.map(parting)).map_err(|e| e.to_string())?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc(&self.x_label)
            .y_desc(label.unwrap_or_default())
            .x_labels(4)
            .y_labels(4)
            .axis_desc_style(text(TEXT_PX))
            .label_style(text(TICK_PX))
            .axis_style(INK)
            .draw()
            .map_err(|e| e.to_string())
    }

    fn scale(&self, range: &Range<f64>) -> Scale {
        Scale { low: range.start, high: range.end, log: self.log }
    }

    /// The edges between values inside and outside of the region.
    fn boundary(&self, map: &Map) -> Vec<[(f64, f64); 2]> {
        let (width, height) = (map.values.width, map.values.height);
        let x = |column: usize| self.scale(&self.x).value(column as f64 / width as f64);
        let y = |row: usize| self.scale(&self.y).value(row as f64 / height as f64);
        let inside =
            |column: usize, row: usize| map.region.get(row * width + column).copied().unwrap_or(false);
        let mut edges = Vec::new();
        for row in 0..height {
            for column in 0..width {
                if column > 0 && inside(column, row) != inside(column - 1, row) {
                    edges.push([(x(column), y(row)), (x(column), y(row + 1))]);
                }
                if row > 0 && inside(column, row) != inside(column, row - 1) {
                    edges.push([(x(column), y(row)), (x(column + 1), y(row))]);
                }
            }
        }
        edges
    }

    /// Rectangles of one colour: neighbours in a row that share it are one, so that an SVG file stays small.
    fn runs(&self, image: &Image) -> Vec<Rectangle<(f64, f64)>> {
        let x = |column: usize| self.scale(&self.x).value(column as f64 / image.width as f64);
        let y = |row: usize| self.scale(&self.y).value(row as f64 / image.height as f64);
        let mut runs = Vec::new();
        for row in 0..image.height {
            let colour = |column: usize| self.shade.colour(image.at(column, row).into());
            let mut first = 0;
            for end in 1..=image.width {
                if end == image.width || colour(end) != colour(first) {
                    let [r, g, b] = colour(first);
                    let corners = [(x(first), y(row)), (x(end), y(row + 1))];
                    runs.push(Rectangle::new(corners, RGBColor(r, g, b).filled()));
                    first = end;
                }
            }
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> MapGrid {
        MapGrid {
            title: String::new(),
            rows: vec![],
            x_label: String::new(),
            x: -1.0..1.0,
            y: 0.0..3.0,
            log: false,
            parted_at: None,
            shade: Shade::Bands { max: 10.0, decades: 3, per_decade: 4 },
            value_label: String::new(),
        }
    }

    #[test]
    fn neighbours_of_one_colour_become_one_rectangle() {
        let image = Image { width: 4, height: 1, data: vec![9.0, 8.0, 0.0, 7.0] };
        assert_eq!(grid().runs(&image).len(), 3);
    }

    #[test]
    fn a_boundary_parts_a_region_from_the_rest() {
        let values = Image { width: 2, height: 2, data: vec![0.0; 4] };
        let map = Map { title: String::new(), values, region: vec![true, false, true, true] };
        // Below the second column's upper value, and to the left of its lower one.
        assert_eq!(grid().boundary(&map), [[(0.0, 0.0), (0.0, 1.5)], [(0.0, 1.5), (1.0, 1.5)]]);
    }
}
