//! Line charts side by side, rows on common axes, with one legend above them.

use super::canvas::{Drawn, bitmap, text, write_png, write_svg};
use super::lines::{LineChart, TITLE_PX, scales};
use super::series::{LABEL_PX, Series};
use crate::error::Result;
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, DrawingBackend, Text};
use std::path::Path;

const CELL_PX: (i32, i32) = (520, 430);
const MARGIN_PX: i32 = 16;
const ROW_PX: i32 = (1.6 * LABEL_PX) as i32;

/// Charts of the same series, row by row; those of a row share their axes.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartGrid {
    /// What is shown.
    pub title: String,
    /// The charts; the legend is that of the first.
    pub rows: Vec<Vec<LineChart>>,
}

impl ChartGrid {
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

    fn columns(&self) -> usize {
        self.rows.iter().map(Vec::len).max().unwrap_or(1)
    }

    fn size(&self) -> (u32, u32) {
        let height = self.charts_top() + CELL_PX.1 * self.rows.len() as i32;
        ((CELL_PX.0 * self.columns() as i32) as u32, height as u32)
    }

    /// The series of the legend, with their places among all and the left ends of their samples, px.
    fn legend(&self) -> Vec<(usize, &Series, (i32, i32))> {
        let series = self.rows.iter().flatten().next().map_or(&[][..], |chart| &chart.series);
        let (mut x, mut y) = (MARGIN_PX, MARGIN_PX + 2 * ROW_PX);
        let mut entries = Vec::new();
        for (i, one) in series.iter().enumerate().filter(|(_, one)| !one.name.is_empty()) {
            let width = one.sample_width();
            if x > MARGIN_PX && x + width > CELL_PX.0 * self.columns() as i32 {
                (x, y) = (MARGIN_PX, y + ROW_PX);
            }
            entries.push((i, one, (x, y)));
            x += width;
        }
        entries
    }

    fn charts_top(&self) -> i32 {
        self.legend().last().map_or(MARGIN_PX, |(_, _, place)| place.1) + ROW_PX
    }

    fn draw<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> Drawn {
        let title = Text::new(self.title.clone(), (MARGIN_PX, MARGIN_PX), text(TITLE_PX));
        root.draw(&title).map_err(|e| e.to_string())?;
        for (i, series, place) in self.legend() {
            series.draw_sample(root, i, place)?;
        }
        let (_, charts) = root.split_vertically(self.charts_top());
        let cells = charts.split_evenly((self.rows.len(), self.columns()));
        for (r, row) in self.rows.iter().enumerate() {
            let axes = scales(&row.iter().collect::<Vec<_>>());
            for (c, chart) in row.iter().enumerate() {
                chart.draw_axes_and_curves(&cells[r * self.columns() + c], axes)?;
            }
        }
        Ok(())
    }
}
