//! Writing images in the format that their file name asks for.

use super::{Format, hdr, pfm, tiff_write};
use crate::error::{Error, Result};
use crate::image::Channel;
use crate::io::colour::Tone;
use crate::io::{atomic, exr, png};
use std::io;
use std::path::Path;

/// The names that [`write()`] can write, for messages.
pub const OUTPUTS: &str = ".exr, .tif, .pfm or .hdr (linear), or .png (an 8-bit picture)";

/// Whether the name of `path` asks for a format that is written.
pub fn is_output(path: &Path) -> bool {
    Format::of_name(path).is_some_and(|format| format != Format::Jpeg)
}

/// Writes `channels`, one or three of one size, whole or not at all: linear as EXR with its `provenance`, as TIFF or PFM of 32-bit
/// floats, or as Radiance HDR, whose colours have 8 bits and no sign; or as a PNG picture, whose white is the 99.5 % quantile.
///
/// # Errors
/// [`Error::Write`] with the path, also for a name of another format.
///
/// # Panics
/// Unless there are one or three channels, all of one size.
pub fn write(path: &Path, channels: &[Channel], provenance: &[(String, String)]) -> Result<()> {
    assert!(matches!(channels.len(), 1 | 3), "one channel or three");
    let failed = |source: io::Error| Error::Write { path: path.to_path_buf(), source };
    let bytes = match Format::of_name(path) {
        Some(Format::Exr) => return exr::write_finite(path, channels, provenance),
        Some(Format::Png) => return png::write_picture(path, channels, Tone::of(channels)),
        Some(Format::Tiff) => tiff_write::encode(channels).map_err(failed)?,
        Some(Format::Pfm) => pfm::encode(channels),
        Some(Format::Hdr) => hdr::encode(channels),
        Some(Format::Jpeg) | None => {
            return Err(failed(io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("must end in {OUTPUTS}"),
            )));
        }
    };
    atomic::write(path, &bytes)
}
