//! Images side by side, each with its title and colour bar, and a table of numbers below.

use super::canvas::{Drawn, INK, Inset, bitmap, text, text_width, write_png, write_svg};
pub use super::colour_bar::Shade;
use crate::error::Result;
use crate::image::{Channel, Image};
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, DrawingBackend, PathElement, Rectangle, Text};
use plotters::style::Color;
use std::path::Path;

const TITLE_PX: f64 = 22.0;
const TEXT_PX: f64 = 17.0;
const ROW_PX: i32 = 26;
const MARGIN_PX: i32 = 18;

/// Longer side of an image on the page, px.
const IMAGE_PX: usize = 288;

/// Room for a bar and its numbers, px.
const BAR_PX: i32 = 108;

/// One image.
#[derive(Debug, Clone)]
pub struct Panel {
    /// What it shows.
    pub title: String,
    /// One channel or R, G, B.
    pub channels: Vec<Channel>,
    /// How values become colours.
    pub shade: Shade,
}

/// Panels in rows, and text below.
#[derive(Debug, Clone)]
pub struct Figure {
    /// What is shown.
    pub title: String,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels in a row; at least 1.
    pub columns: usize,
    /// Rows of cells, aligned in columns; the first row is the heading. May be empty.
    pub table: Vec<Vec<String>>,
    /// Lines below the table.
    pub notes: Vec<String>,
}

impl Figure {
    /// Writes it as a PNG file.
    ///
    /// # Errors
    /// [`Error::Write`](crate::Error::Write) with the path.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        let size = self.size();
        let buffer = bitmap(size, |root| self.draw(root)).map(|mut buffer| {
            for (i, panel) in self.panels.iter().enumerate() {
                paint(&mut buffer, size.0 as usize, self.corner(i), panel);
            }
            buffer
        });
        write_png(path, size, buffer)
    }

    /// Writes it as an SVG file that holds the images as PNG.
    ///
    /// # Errors
    /// [`Error::Write`](crate::Error::Write) with the path.
    pub fn write_svg(&self, path: &Path) -> Result<()> {
        let inset = |(i, panel): (usize, &Panel)| {
            let (size, rgb) = pixels(panel);
            Inset { corner: self.corner(i), size, rgb }
        };
        let insets: Vec<Inset> = self.panels.iter().enumerate().map(inset).collect();
        write_svg(path, self.size(), &insets, |root| self.draw(root))
    }

    fn cell(&self) -> (i32, i32) {
        let tallest = self.panels.iter().map(|p| fitted(&p.channels[0].image).1).max().unwrap_or(0);
        (IMAGE_PX as i32 + BAR_PX, tallest as i32 + ROW_PX + MARGIN_PX)
    }

    /// Top left corner of the image of panel `i`, below its title.
    fn corner(&self, i: usize) -> (i32, i32) {
        let (width, height) = self.cell();
        let (column, row) = ((i % self.columns) as i32, (i / self.columns) as i32);
        (MARGIN_PX + column * width, MARGIN_PX + 2 * ROW_PX + row * height + 6)
    }

    fn size(&self) -> (u32, u32) {
        let (width, height) = self.cell();
        let rows = self.panels.len().div_ceil(self.columns) as i32;
        let lines = (self.table.len() + self.notes.len()) as i32;
        let panels = 2 * MARGIN_PX + width * self.columns.min(self.panels.len().max(1)) as i32;
        let title = text_width(&self.title, TITLE_PX) as i32;
        let notes = self.notes.iter().map(|n| text_width(n, TEXT_PX) as i32);
        let text =
            notes.chain([title, self.column_offsets().last().copied().unwrap_or(0)]).max().unwrap_or(0);
        let width = panels.max(text + 2 * MARGIN_PX);
        (width as u32, (2 * MARGIN_PX + 2 * ROW_PX + rows * height + lines * ROW_PX) as u32)
    }

    /// Where the columns of the table begin, and where the last one ends, from the left margin.
    fn column_offsets(&self) -> Vec<i32> {
        let columns = self.table.iter().map(Vec::len).max().unwrap_or(0);
        let width =
            |c: usize| self.table.iter().filter_map(|row| row.get(c)).map(|s| text_width(s, TEXT_PX)).max();
        let mut offsets = vec![0];
        for c in 0..columns {
            offsets.push(offsets[c] + width(c).unwrap_or(0) as i32 + 28);
        }
        offsets
    }

    fn draw<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> Drawn {
        let write = |string: &str, at: (i32, i32), size: f64| {
            root.draw(&Text::new(string.to_string(), at, text(size))).map_err(|e| e.to_string())
        };
        write(&self.title, (MARGIN_PX, MARGIN_PX), TITLE_PX)?;
        for (i, panel) in self.panels.iter().enumerate() {
            let (x, y) = self.corner(i);
            write(&panel.title, (x, y - ROW_PX), TEXT_PX)?;
            let (w, h) = fitted(&panel.channels[0].image);
            let frame = [(x - 1, y - 1), (x + w as i32, y + h as i32)];
            root.draw(&Rectangle::new(frame, INK.mix(0.5))).map_err(|e| e.to_string())?;
            panel.shade.draw_bar(root, (x + w as i32 + 10, y), h as i32)?;
        }
        let rows = self.panels.len().div_ceil(self.columns) as i32;
        let top = MARGIN_PX + 2 * ROW_PX + rows * self.cell().1 + 6;
        let offsets = self.column_offsets();
        for (r, row) in self.table.iter().enumerate() {
            for (cell, offset) in row.iter().zip(&offsets) {
                write(
                    cell,
                    (MARGIN_PX + offset, top + ROW_PX * r as i32 + if r == 0 { -3 } else { 2 }),
                    TEXT_PX,
                )?;
            }
        }
        if !self.table.is_empty() {
            let y = top + ROW_PX - 5;
            let end = MARGIN_PX + offsets.last().copied().unwrap_or(0) - 28;
            let rule = PathElement::new([(MARGIN_PX, y), (end, y)], INK.mix(0.5));
            root.draw(&rule).map_err(|e| e.to_string())?;
        }
        for (n, note) in self.notes.iter().enumerate() {
            write(note, (MARGIN_PX, top + ROW_PX * (self.table.len() + n) as i32 + 6), TEXT_PX)?;
        }
        Ok(())
    }
}

/// Size of an image on the page, px: its longer side fills the room.
fn fitted(image: &Image) -> (usize, usize) {
    let longer = image.width.max(image.height);
    ((image.width * IMAGE_PX / longer).max(1), (image.height * IMAGE_PX / longer).max(1))
}

/// The panel's image in colours, and its size on the page (width, height), px: small images with their pixels as squares,
/// large ones averaged over the pixels that fall together.
fn pixels(panel: &Panel) -> ((usize, usize), Vec<[u8; 3]>) {
    let size = fitted(&panel.channels[0].image);
    let resized: Vec<Channel> = panel.channels.iter().map(|c| resize(c, size)).collect();
    (size, panel.shade.colours(&resized))
}

/// Copies the panel's image into the buffer.
fn paint(buffer: &mut [u8], buffer_width: usize, corner: (i32, i32), panel: &Panel) {
    let ((width, _), colours) = pixels(panel);
    for (y, row) in colours.chunks_exact(width).enumerate() {
        let start = 3 * ((corner.1 as usize + y) * buffer_width + corner.0 as usize);
        buffer[start..start + 3 * width].copy_from_slice(row.as_flattened());
    }
}

fn resize(channel: &Channel, (width, height): (usize, usize)) -> Channel {
    let image = &channel.image;
    let span = |i: usize, n: usize, source: usize| {
        let first = i * source / n;
        first..((i + 1) * source / n).max(first + 1)
    };
    let mean = |x: usize, y: usize| {
        let (columns, rows) = (span(x, width, image.width), span(y, height, image.height));
        let count = (columns.len() * rows.len()) as f32;
        let sum: f32 = rows.map(|r| columns.clone().map(|c| image.at(c, r)).sum::<f32>()).sum();
        sum / count
    };
    Channel { name: channel.name.clone(), image: Image::from_fn(width, height, mean) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_images_keep_their_pixels_and_large_ones_their_mean() {
        let pair = Channel { name: "Y".into(), image: Image { width: 2, height: 1, data: vec![1.0, 3.0] } };
        assert_eq!(resize(&pair, (4, 1)).image.data, [1.0, 1.0, 3.0, 3.0]);
        assert_eq!(resize(&pair, (1, 1)).image.data, [2.0]);
        assert_eq!(fitted(&Image::filled(100, 50, 0.0)), (IMAGE_PX, IMAGE_PX / 2));
    }
}
