//! Portable float maps: a header of three lines, then rows of 32-bit floats from the bottom up. The sign of the third line is the
//! byte order; its magnitude, a unit on which writers do not agree, is ignored.

use super::opened::{Header, Numbers, Opened};
use crate::image::Channel;

/// The header of a PFM file.
pub(super) fn open(bytes: &[u8]) -> Result<Opened<'_>, String> {
    let (samples, rest) = match bytes.get(..3) {
        Some(b"PF\n") => (3, &bytes[3..]),
        Some(b"Pf\n") => (1, &bytes[3..]),
        _ => return Err("does not begin as one".into()),
    };
    let mut words = Words { rest };
    let mut next = || words.next().ok_or("its header breaks off");
    let sizes =
        [next()?, next()?].map(|word| word.parse::<usize>().map_err(|_| format!("its size is {word}")));
    let [width, height] = sizes;
    let (width, height) = (width?, height?);
    let scale = next()?;
    let unit: f32 = scale.parse().map_err(|_| format!("its scale is {scale}"))?;
    if unit == 0.0 || !unit.is_finite() {
        return Err(format!("its scale is {scale}"));
    }
    let data = words.rest;
    let header = Header::plain((width, height), samples, Numbers::Radiance);
    let pixels = move || {
        let bytes = width * height * samples * 4;
        let data = data.get(..bytes).ok_or("has fewer pixels than its header promises")?;
        let number = |quad: &[u8]| {
            let quad = [quad[0], quad[1], quad[2], quad[3]];
            if unit < 0.0 { f32::from_le_bytes(quad) } else { f32::from_be_bytes(quad) }
        };
        let rows = data.chunks_exact(4 * samples * width).rev();
        Ok(rows.flat_map(|row| row.chunks_exact(4).map(number)).collect())
    };
    Ok(Opened { header, pixels: Box::new(pixels) })
}

/// Words, each ended by one white character.
struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let end = self.rest.iter().take(32).position(u8::is_ascii_whitespace)?;
        let word = std::str::from_utf8(&self.rest[..end]).ok()?;
        self.rest = &self.rest[end + 1..];
        Some(word)
    }
}

/// The file of one or three channels.
pub(super) fn encode(channels: &[Channel]) -> Vec<u8> {
    let image = &channels[0].image;
    let kind = if channels.len() == 1 { "Pf" } else { "PF" };
    let mut bytes = format!("{kind}\n{} {}\n-1.0\n", image.width, image.height).into_bytes();
    for y in (0..image.height).rev() {
        let row = y * image.width..(y + 1) * image.width;
        row.for_each(|i| channels.iter().for_each(|c| bytes.extend(c.image.data[i].to_le_bytes())));
    }
    bytes
}
