//! Writing f32 channels with a record of how they were made.

use crate::error::{Error, Result, shown};
use crate::image::Channel;
use crate::io::atomic;
use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use ::exr::meta::attribute::{AttributeValue, Text};
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{Blocks, Compression, LineOrder};
use std::io::{self, Cursor};
use std::path::Path;

/// Writes `channels`, all of one size, as 32-bit floats without compression, whole or not at all. Each pair of
/// `provenance` becomes a text attribute: `software` the one of that name, any other key (`version`, `command`,
/// `seed`) one with `narrowbeam:` before it, since the format reserves some names, `version` among them.
///
/// # Errors
/// [`Error::Write`] with the path.
///
/// # Panics
/// If there is no channel, or the channels differ in size.
pub fn write(path: &Path, channels: &[Channel], provenance: &[(String, String)]) -> Result<()> {
    let failed = |e: ::exr::error::Error| Error::Write { path: path.to_path_buf(), source: to_io(e) };
    let bytes = encode(channels, provenance).map_err(failed)?;
    atomic::write(path, &bytes)
}

/// Writes `channels` as [`write()`] does, if all of their pixels are finite.
///
/// # Errors
/// As [`write()`], and [`Error::NotFinite`] that names the pixel which is not.
///
/// # Panics
/// As [`write()`].
pub fn write_finite(path: &Path, channels: &[Channel], provenance: &[(String, String)]) -> Result<()> {
    channels.iter().try_for_each(|channel| check_finite(path, channel))?;
    write(path, channels, provenance)
}

fn check_finite(path: &Path, Channel { name, image }: &Channel) -> Result<()> {
    match image.data.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => {
            let (x, y, value) = (i % image.width, i / image.width, image.data[i]);
            let path = shown(path);
            Err(Error::NotFinite(format!(
                "{path}: not written: channel {name}, pixel ({x}, {y}) would be {value}"
            )))
        }
    }
}

fn encode(
    channels: &[Channel],
    provenance: &[(String, String)],
) -> std::result::Result<Vec<u8>, ::exr::error::Error> {
    let first = &channels.first().expect("an image has a channel").image;
    let size = (first.width, first.height);
    assert!(channels.iter().all(|c| (c.image.width, c.image.height) == size), "channels of one size");
    let list = channels.iter().map(|c| {
        let samples = FlatSamples::F32(c.image.data.clone());
        // The format's flag for the eye's response: light is linear.
        AnyChannel {
            name: text(&c.name),
            sample_data: samples,
            quantize_linearly: false,
            sampling: (1, 1).into(),
        }
    });
    let mut attributes = LayerAttributes::default();
    for (key, value) in provenance {
        match key.as_str() {
            "software" => attributes.software_name = Some(text(value)),
            _ => {
                let name = text(&format!("narrowbeam:{key}"));
                attributes.other.insert(name, AttributeValue::Text(text(value)));
            }
        }
    }
    let encoding = Encoding {
        // The digits of an image with noise do not shrink: compression would save 2 % of a render and nothing of a residual.
        compression: Compression::Uncompressed,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(list.collect()));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes)?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// Bytes of a file before its first attribute: magic number and version.
const PREAMBLE: usize = 8;

/// Brings the attributes of the only header of a file into the order of their names; the crate writes them in an order of its
/// own in every run. Each is its name, its type, both ended by a zero, the length of its value, and that; a zero ends them all.
fn sort_attributes(file: &mut [u8]) {
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    let mut at = PREAMBLE;
    while let Some(length) = attribute_length(&file[at..]) {
        attributes.push(file[at..at + length].to_vec());
        at += length;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    file[PREAMBLE..PREAMBLE + sorted.len()].copy_from_slice(&sorted);
}

/// Bytes of the attribute that `file` begins with; `None` at their end.
fn attribute_length(file: &[u8]) -> Option<usize> {
    let text = |from: usize| Some(from + file.get(from..)?.iter().position(|&b| b == 0)? + 1);
    let name = text(0).filter(|end| *end > 1)?;
    let value = text(name)?;
    let length = file.get(value..value + 4)?.try_into().ok().map(u32::from_le_bytes)?;
    Some(value + 4 + length as usize).filter(|end| *end <= file.len())
}

/// The format's text is Latin-1: any other character becomes a question mark.
fn text(string: &str) -> Text {
    let latin = |c: char| if (c as u32) < 256 && c != '\0' { c } else { '?' };
    Text::new_or_panic(string.chars().map(latin).collect::<String>())
}

fn to_io(error: ::exr::error::Error) -> io::Error {
    match error {
        ::exr::error::Error::Io(e) => e,
        other => io::Error::other(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image;

    #[test]
    fn the_same_image_gives_the_same_bytes() {
        let channel = Channel { name: "Y".into(), image: image::Image::filled(3, 2, 0.5) };
        let pair = |i: usize| (format!("key {i}"), format!("value {i}"));
        let pairs: Vec<_> = (0..12).map(pair).collect();
        let first = encode(std::slice::from_ref(&channel), &pairs).unwrap();
        for _ in 0..5 {
            assert!(encode(std::slice::from_ref(&channel), &pairs).unwrap() == first);
        }
        let meta = ::exr::meta::MetaData::read_from_buffered(Cursor::new(&first), true).unwrap();
        assert_eq!(meta.headers[0].own_attributes.other.len(), pairs.len());
        let other = encode(std::slice::from_ref(&channel), &pairs[1..]).unwrap();
        assert!(other != first);
    }
}
