//! Images whose numbers are no light: depths and masks. No transfer curve applies to them.

use super::source::Source;
use crate::error::{Error, Result};
use crate::image::Channel;
use crate::io::picture::{Format, Picture};
use std::path::Path;

/// Lengths in `path`. Those of an integer file are counted in units of `scale`, the value of `[object] depth_scale`.
pub(super) fn lengths(
    source: &Source,
    path: &Path,
    scale: Option<f64>,
    select: impl Fn(&Picture) -> Result<Channel>,
) -> Result<Channel> {
    let key = "[object] depth_scale";
    let scale = scale.map(|v| source.positive(key, v)).transpose()?;
    let picture = read(path)?;
    let mut channel = select(&picture)?;
    match (&picture.codes, scale) {
        (None, None) => (),
        (Some(_), Some(scale)) => {
            channel.image.data.iter_mut().for_each(|v| *v = (f64::from(*v) * scale) as f32)
        }
        (Some(codes), None) => {
            let message = format!(
                "{key} is missing: {} is {}, so say what length one unit of its numbers is",
                path.display(),
                codes.in_words()
            );
            return Err(source.error(message));
        }
        (None, Some(_)) => {
            let message =
                format!("{key} is given, but {} holds lengths already: leave it out", path.display());
            return Err(source.error(message));
        }
    }
    Ok(channel)
}

/// The only channel of `path`: of a mask, or a share of light, which an integer file counts from 0 to its largest number.
pub(super) fn shares(path: &Path) -> Result<Channel> {
    let picture = read(path)?;
    let mut channel = picture.single()?;
    if let Some(codes) = &picture.codes {
        channel.image.data.iter_mut().for_each(|v| *v /= codes.largest as f32);
    }
    Ok(channel)
}

/// Reads `path`, which must not be a JPEG: its numbers are not kept as they were.
fn read(path: &Path) -> Result<Picture> {
    let picture = Picture::read(path)?;
    match &picture.codes {
        Some(codes) if codes.format == Format::Jpeg => Err(Error::Read {
            path: path.to_path_buf(),
            reason: "it is a JPEG, whose numbers are only about right; save it as PNG or TIFF".into(),
        }),
        _ => Ok(picture),
    }
}
