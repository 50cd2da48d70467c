//! Where pictures are drawn: an RGB buffer that becomes a PNG file, or an SVG text.

use crate::error::{Error, Result};
use crate::io::{atomic, png};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::coord::Shift;
use plotters::prelude::{
    BitMapBackend, DrawingArea, DrawingBackend, IntoDrawingArea, RGBColor, SVGBackend, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, IntoFont, TextStyle, register_font};
use std::io;
use std::path::Path;
use std::sync::Once;

/// The name under which the font is known, in SVG files too.
const FAMILY: &str = "sans-serif";

/// Colour of text and axes.
pub(super) const INK: RGBColor = RGBColor(30, 30, 30);

/// Colours of lines, after Okabe and Ito (2008), without their yellow, which is faint on white; then grey, and two more
/// that are dark enough to differ from these in lightness.
pub(super) const PALETTE: [RGBColor; 10] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(136, 136, 136),
    RGBColor(112, 48, 160),
    RGBColor(122, 80, 40),
];

/// An error of drawing, as text: what can go wrong depends on the backend.
pub(super) type Drawn = std::result::Result<(), String>;

/// Text of a size in px.
pub(super) fn text(size: f64) -> TextStyle<'static> {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        let bytes = include_bytes!("font/DejaVuSans.ttf");
        if register_font(FAMILY, FontStyle::Normal, bytes).is_err() {
            unreachable!("the font is a constant of the program");
        }
    });
    (FAMILY, size).into_font().color(&INK)
}

/// Text of a size in px whose place is the middle of its left edge.
pub(super) fn label(size: f64) -> TextStyle<'static> {
    text(size).pos(Pos::new(HPos::Left, VPos::Center))
}

/// Width of `string` at `size` px, px.
pub(super) fn text_width(string: &str, size: f64) -> u32 {
    text(size).font.box_size(string).map_or(0, |(width, _)| width)
}

/// Draws an RGB picture of `size` (width, height) px on white.
pub(super) fn bitmap(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<BitMapBackend, Shift>) -> Drawn,
) -> std::result::Result<Vec<u8>, String> {
    let mut buffer = vec![255; (size.0 * size.1 * 3) as usize];
    let root = BitMapBackend::with_buffer(&mut buffer, size).into_drawing_area();
    draw(&root)?;
    root.present().map_err(|e| e.to_string())?;
    drop(root);
    Ok(buffer)
}

/// Writes a bitmap as PNG.
pub(super) fn write_png(
    path: &Path,
    size: (u32, u32),
    buffer: std::result::Result<Vec<u8>, String>,
) -> Result<()> {
    let buffer = buffer.map_err(|e| failed(path, e))?;
    png::write_rgb(path, &buffer, (size.0 as usize, size.1 as usize))
}

/// An image in an SVG picture.
pub(super) struct Inset {
    /// Top left corner, px.
    pub corner: (i32, i32),
    /// Width and height, px.
    pub size: (usize, usize),
    pub rgb: Vec<[u8; 3]>,
}

impl Inset {
    /// The element that shows it, its pixels as a PNG within.
    fn element(&self) -> io::Result<String> {
        let ((x, y), (width, height)) = (self.corner, self.size);
        let data = STANDARD.encode(png::encode_rgb(self.rgb.as_flattened(), self.size)?);
        Ok(format!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
             href=\"data:image/png;base64,{data}\"/>\n"
        ))
    }
}

/// Draws an SVG picture of `size` (width, height) px on white, with `insets` on top, and writes it.
pub(super) fn write_svg(
    path: &Path,
    size: (u32, u32),
    insets: &[Inset],
    draw: impl FnOnce(&DrawingArea<SVGBackend, Shift>) -> Drawn,
) -> Result<()> {
    let mut string = String::new();
    let root = SVGBackend::with_string(&mut string, size).into_drawing_area();
    let drawn =
        fill(&root).and_then(|()| draw(&root)).and_then(|()| root.present().map_err(|e| e.to_string()));
    drawn.map_err(|e| failed(path, e))?;
    drop(root);
    let end = string.rfind("</svg>").unwrap_or(string.len());
    for inset in insets.iter().rev() {
        let element = inset.element().map_err(|e| failed(path, e.to_string()))?;
        string.insert_str(end, &element);
    }
    atomic::write(path, string.as_bytes())
}

fn fill<DB: DrawingBackend>(root: &DrawingArea<DB, Shift>) -> Drawn {
    root.fill(&WHITE).map_err(|e| e.to_string())
}

fn failed(path: &Path, reason: String) -> Error {
    Error::Write { path: path.to_path_buf(), source: io::Error::other(reason) }
}
