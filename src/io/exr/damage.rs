//! What a damaged or hostile EXR file is refused for before it is decoded: a decoder that believes it could exhaust the memory.

use crate::memory::product;
use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::compression::Compression;
use ::exr::meta::header::Header;

/// A part larger than this (16384 x 16384 px) is taken to be a damaged header.
const MAX_PIXELS: usize = 1 << 28;

/// No compression of EXR shrinks its data more than this; deflate, the strongest, reaches 1032. A file that
/// promises more is damaged, and believing it could exhaust the memory.
const MAX_COMPRESSION: usize = 2000;

/// Deviation of pixelAspectRatio from 1 up to which pixels are square.
const SQUARE: f32 = 1e-3;

/// Size of the largest image that is believed whatever the length of its file, bytes.
const SMALL_BYTES: usize = 1 << 22;

/// Refuses what is not read, and what a file of this length cannot hold; returns the memory that decoding takes, bytes.
pub(super) fn check_header(header: &Header, file_bytes: usize) -> Result<u64, String> {
    let (width, height) = (header.layer_size.0, header.layer_size.1);
    if header.deep {
        return Err("deep images are not supported".into());
    }
    if header.channels.list.iter().any(|c| (c.sampling.0, c.sampling.1) != (1, 1)) {
        return Err("subsampled channels are not supported".into());
    }
    check_windows(header)?;
    let pixels = width.checked_mul(height).filter(|&n| n <= MAX_PIXELS);
    let bytes = pixels.and_then(|n| n.checked_mul(header.channels.bytes_per_pixel));
    let limit = file_bytes.saturating_mul(MAX_COMPRESSION).max(SMALL_BYTES);
    match bytes {
        // Beside the samples as they are stored, all of them as f32, and once more those that are picked.
        Some(n) if n <= limit => {
            Ok(product(&[width, height, header.channels.bytes_per_pixel + 8 * header.channels.list.len()]))
        }
        _ => Err(format!("its header promises {width}x{height} px, which the file cannot hold")),
    }
}

/// Refuses pixels that are not square, and images that are a part of the picture that they belong to: where they lie in it is not
/// looked at.
fn check_windows(header: &Header) -> Result<(), String> {
    let aspect = header.shared_attributes.pixel_aspect;
    if (aspect - 1.0).abs() > SQUARE {
        return Err(format!("its pixelAspectRatio is {aspect}; resample it to square pixels"));
    }
    let (display, position) = (header.shared_attributes.display_window, header.own_attributes.layer_position);
    if (position, header.layer_size) != (display.position, display.size) {
        return Err(format!(
            "its data window, {}x{} px at ({}, {}), is not its display window, {}x{} px at ({}, {}); save the whole picture, or \
             crop it so that both are the same",
            header.layer_size.0,
            header.layer_size.1,
            position.0,
            position.1,
            display.size.0,
            display.size.1,
            display.position.0,
            display.position.1
        ));
    }
    Ok(())
}

/// What `headers` promise, in words.
pub(super) fn promise(headers: &[Header]) -> String {
    let part = |header: &Header| {
        let (size, channels) = (header.layer_size, header.channels.list.len());
        format!("{}x{} px in {channels} channels", size.0, size.1)
    };
    match headers {
        [only] => part(only),
        [first, rest @ ..] => format!("{} and {} more parts", part(first), rest.len()),
        [] => String::new(),
    }
}

/// Whether the decoder takes as much memory as the chunks of this part say.
pub(super) fn believes_chunks(header: &Header) -> bool {
    matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_))
}

/// Counters of a chunk of DWA compression, 64 bits each, that say how large something is when unpacked.
const UNPACKED: [usize; 5] = [1, 6, 7, 8, 9];
/// Bytes that a pixel of a block of 8x8 px has in one channel at most, rounded up for what run lengths may add.
const PADDED_BYTES: usize = 8;

/// Refuses a chunk whose own counters promise more than a chunk holds.
pub(super) fn check_chunk(headers: &[Header], chunk: &Chunk) -> Result<(), String> {
    let header = headers.get(chunk.layer_index).filter(|header| believes_chunks(header));
    let data = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    let Some(header) = header else { return Ok(()) };
    let block = header.max_block_pixel_size();
    let most = product(&[
        block.0.next_multiple_of(8),
        block.1.next_multiple_of(8),
        header.channels.list.len(),
        PADDED_BYTES,
    ]);
    let counters = data.as_chunks::<8>().0;
    let promised = UNPACKED.iter().filter_map(|&i| counters.get(i)).map(|&bytes| u64::from_le_bytes(bytes));
    match promised.max() {
        Some(bytes) if bytes > most => Err(format!(
            "no EXR file, or truncated or damaged (a block of {}x{} px promises {bytes} bytes)",
            block.0, block.1
        )),
        _ => Ok(()),
    }
}
