//! Reading PNG files of 8 and 16 bits; smaller codes are widened to 8.

use super::exif::Exif;
use super::icc;
use super::opened::{Embedded, Header, Numbers, Opened};
use ::png::{BitDepth, ColorType, Decoder, Info, Limits, Transformations};
use std::io::Cursor;

/// What the decoder may allocate beside the image: chunks of text and profiles.
const BESIDE_BYTES: usize = 1 << 26;

/// The header of a PNG file.
pub(super) fn open(bytes: &[u8]) -> Result<Opened<'_>, String> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: BESIDE_BYTES });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let info = reader.info();
    let has_alpha = info.trns.is_some();
    let samples = match info.color_type {
        ColorType::Grayscale => 1 + usize::from(has_alpha),
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb | ColorType::Indexed => 3 + usize::from(has_alpha),
        ColorType::Rgba => 4,
    };
    let largest = if info.bit_depth == BitDepth::Sixteen { 65535 } else { 255 };
    let orientation = info.exif_metadata.as_deref().map_or(1, |block| Exif::read(block).orientation);
    let size = (info.width as usize, info.height as usize);
    let header =
        Header { size, samples, numbers: Numbers::Codes { largest }, orientation, embedded: embedded(info) };
    let pixels = move || {
        let bytes = reader.output_buffer_size().ok_or("its rows are too long")?;
        let mut data = vec![0; bytes];
        reader.next_frame(&mut data).map_err(|e| e.to_string())?;
        Ok(if largest > 255 {
            data.chunks_exact(2).map(|pair| f32::from(u16::from_be_bytes([pair[0], pair[1]]))).collect()
        } else {
            data.into_iter().map(f32::from).collect()
        })
    };
    Ok(Opened { header, pixels: Box::new(pixels) })
}

/// What the chunks say, the one that counts most first (PNG 3, 4.3): cICP, iCCP, sRGB, gAMA.
fn embedded(info: &Info) -> Option<(Embedded, &'static str)> {
    if let Some(points) = info.coding_independent_code_points {
        // ITU-T H.273: 8 is linear, 13 sRGB.
        let curve = match points.transfer_function {
            8 => Embedded::Linear,
            13 => Embedded::Srgb,
            _ => Embedded::Curve,
        };
        return Some((curve, "cICP chunk"));
    }
    if let Some(curve) = info.icc_profile.as_deref().and_then(icc::curve) {
        return Some((curve, "ICC profile"));
    }
    if info.srgb.is_some() {
        return Some((Embedded::Srgb, "sRGB chunk"));
    }
    let gamma = f64::from(info.gama_chunk?.into_value());
    let is_linear = (gamma - 1.0).abs() < 1e-3;
    Some((if is_linear { Embedded::Linear } else { Embedded::Gamma(1.0 / gamma.max(1e-5)) }, "gAMA chunk"))
}
