//! Reading JPEG files, grey or colour, of 8 bits.

use super::exif::Exif;
use super::icc;
use super::opened::{Embedded, Header, Numbers, Opened};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The format's largest side, px.
const MAX_SIDE: usize = 65535;

/// The header of a JPEG file.
pub(super) fn open(bytes: &[u8]) -> Result<Opened<'_>, String> {
    // A file that breaks off is damaged, not grey below.
    let options =
        DecoderOptions::default().set_strict_mode(true).set_max_width(MAX_SIDE).set_max_height(MAX_SIDE);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| e.to_string())?;
    let info = decoder.info().ok_or("has no header")?;
    let (samples, colours) = match info.components {
        1 => (1, ColorSpace::Luma),
        3 => (3, ColorSpace::RGB),
        n => return Err(format!("has {n} colours, as for print; save it in RGB")),
    };
    decoder.set_options(options.jpeg_set_out_colorspace(colours));
    let exif = decoder.exif().map(|block| Exif::read(block));
    let profile = decoder.icc_profile().as_deref().and_then(icc::curve);
    let camera = exif.filter(|exif| exif.is_srgb).map(|_| (Embedded::Srgb, "Exif colour space"));
    let header = Header {
        size: (usize::from(info.width), usize::from(info.height)),
        samples,
        numbers: Numbers::Codes { largest: 255 },
        orientation: exif.map_or(1, |exif| exif.orientation),
        embedded: profile.map(|curve| (curve, "ICC profile")).or(camera),
    };
    let pixels = move || {
        check_whole(bytes)?;
        let data = decoder.decode().map_err(|e| e.to_string())?;
        Ok(data.into_iter().map(f32::from).collect())
    };
    Ok(Opened { header, pixels: Box::new(pixels) })
}

/// Refuses a file that breaks off: the decoder makes what is missing grey. The last end of an image must follow the last scan.
fn check_whole(bytes: &[u8]) -> Result<(), String> {
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    if last(0xd9) > last(0xda) { Ok(()) } else { Err("breaks off before its end".into()) }
}
