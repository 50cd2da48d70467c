//! Reading TIFF files, the first image of each: 8 and 16 bits, floats of 16 to 64.

use super::icc;
use super::opened::{Header, Numbers, Opened};
use ::tiff::ColorType;
use ::tiff::decoder::{Decoder, DecodingResult, Limits};
use ::tiff::tags::{PlanarConfiguration, SampleFormat, Tag};
use std::io::Cursor;

/// What the decoder may allocate for one entry, such as a profile.
const ENTRY_BYTES: usize = 1 << 24;

/// The header of a TIFF file.
pub(super) fn open(bytes: &[u8]) -> Result<Opened<'_>, String> {
    let mut decoder =
        Decoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?.with_limits(limits(ENTRY_BYTES));
    let (width, height) = decoder.dimensions().map_err(|e| e.to_string())?;
    let (samples, bits) = samples(decoder.colortype().map_err(|e| e.to_string())?)?;
    let planar = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).map_err(|e| e.to_string())?;
    if samples > 1 && planar == Some(PlanarConfiguration::Planar.to_u16()) {
        return Err("keeps its colours in planes of their own; save them interleaved".into());
    }
    let orientation = decoder.find_tag_unsigned(Tag::Orientation).map_err(|e| e.to_string())?;
    let profile = decoder.find_tag(Tag::IccProfile).ok().flatten().and_then(|value| value.into_u8_vec().ok());
    let header = Header {
        size: (width as usize, height as usize),
        samples,
        numbers: numbers(&mut decoder, bits)?,
        orientation: orientation.filter(|v| (1..=8).contains(v)).unwrap_or(1),
        embedded: profile.as_deref().and_then(icc::curve).map(|curve| (curve, "ICC profile")),
    };
    let most = header.size.0.saturating_mul(header.size.1).saturating_mul(samples * usize::from(bits) / 8);
    let mut decoder = decoder.with_limits(limits(most));
    let pixels = move || match decoder.read_image().map_err(|e| e.to_string())? {
        DecodingResult::U8(data) => Ok(data.into_iter().map(f32::from).collect()),
        DecodingResult::U16(data) => Ok(data.into_iter().map(f32::from).collect()),
        DecodingResult::F16(data) => Ok(data.into_iter().map(f32::from).collect()),
        DecodingResult::F32(data) => Ok(data),
        DecodingResult::F64(data) => Ok(data.into_iter().map(|v| v as f32).collect()),
        _ => Err("holds integers of a kind that is not read".into()),
    };
    Ok(Opened { header, pixels: Box::new(pixels) })
}

/// Limits of an image of `image_bytes`.
fn limits(image_bytes: usize) -> Limits {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = image_bytes;
    limits.intermediate_buffer_size = image_bytes.max(ENTRY_BYTES);
    limits.ifd_value_size = ENTRY_BYTES;
    limits
}

/// Samples of a pixel, and bits of each.
fn samples(colours: ColorType) -> Result<(usize, u8), String> {
    match colours {
        ColorType::Gray(bits) => Ok((1, bits)),
        ColorType::GrayA(bits) => Ok((2, bits)),
        ColorType::RGB(bits) => Ok((3, bits)),
        ColorType::RGBA(bits) => Ok((4, bits)),
        other => Err(format!("holds {other:?}; save it as grey or RGB")),
    }
}

fn numbers(decoder: &mut Decoder<Cursor<&[u8]>>, bits: u8) -> Result<Numbers, String> {
    let formats = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(|e| e.to_string())?;
    let format = formats.and_then(|all| all.first().copied()).map(SampleFormat::from_u16_exhaustive);
    match (format.unwrap_or(SampleFormat::Uint), bits) {
        (SampleFormat::Uint, 8) => Ok(Numbers::Codes { largest: 255 }),
        (SampleFormat::Uint, 16) => Ok(Numbers::Codes { largest: 65535 }),
        (SampleFormat::IEEEFP, 16 | 32 | 64) => Ok(Numbers::Radiance),
        (_, bits) => Err(format!(
            "holds numbers of {bits} bits of a kind that is not read; save 8 or 16 bits, or floats"
        )),
    }
}
