//! Images that show light. Those of photographs become radiance as the `transfer` of their section says, which must be stated: what
//! a file says of itself is often wrong.

use super::source::Source;
use super::value::TransferValue;
use super::{Caution, CautionCode};
use crate::error::{Error, Result};
use crate::image::Channel;
use crate::io::picture::ImageFile;
use crate::io::picture::{Codes, Picture};
use crate::io::transfer::{Response, Transfer};
use std::path::Path;

/// Reads the images of one section.
pub(super) struct LightReader<'a> {
    source: &'a Source<'a>,
    /// The section, such as `[object]`.
    section: &'static str,
    transfer: Option<Transfer>,
}

/// An image of radiance.
pub(super) struct Light {
    pub file: ImageFile,
    /// What it was before, if it was a photograph.
    pub codes: Option<Codes>,
    /// What a user should know of it.
    pub caution: Option<Caution>,
}

impl<'a> LightReader<'a> {
    /// That of `section`, whose key `transfer` has this value.
    pub fn new(source: &'a Source, section: &'static str, transfer: Option<&TransferValue>) -> Result<Self> {
        let transfer = transfer.map(|value| match value {
            TransferValue::Linear => Ok(Transfer::Linear),
            TransferValue::Srgb => Ok(Transfer::Srgb),
            TransferValue::Gamma(gamma) => {
                let ok = (0.1..=10.0).contains(gamma);
                let key = format!("{section} transfer");
                source.in_range(&key, *gamma, ok, "from 0.1 to 10, a gamma").map(Transfer::Gamma)
            }
            TransferValue::File(named) => Response::read(&source.resolve(named)).map(Transfer::Response),
        });
        Ok(Self { source, section, transfer: transfer.transpose()? })
    }

    /// Reads `path`.
    pub fn read(&self, path: &Path) -> Result<Light> {
        let Picture { file, codes } = Picture::read(path)?;
        let Some(codes) = codes else { return Ok(Light { file, codes: None, caution: None }) };
        let transfer = self.transfer.as_ref().ok_or_else(|| self.not_stated(path, &codes))?;
        let radiance = |(number, channel): (usize, &Channel)| {
            Ok(Channel {
                name: channel.name.clone(),
                image: transfer.radiance(path, channel, number, &codes)?,
            })
        };
        let channels = file.all().iter().enumerate().map(radiance).collect::<Result<_>>()?;
        let caution = self.caution(path, transfer, &codes);
        Ok(Light { file: ImageFile::with_channels(path, channels), codes: Some(codes), caution })
    }

    /// The same of the section's main image: a transfer beside one that needs none is a mistake.
    pub fn read_main(&self, path: &Path) -> Result<Light> {
        let light = self.read(path)?;
        if light.codes.is_none() && self.transfer.as_ref().is_some_and(|t| *t != Transfer::Linear) {
            let message = format!(
                "{} transfer is given, but {} holds radiance: leave it out",
                self.section,
                path.display()
            );
            return Err(self.source.error(message));
        }
        Ok(light)
    }

    fn not_stated(&self, path: &Path, codes: &Codes) -> Error {
        self.source.error(format!(
            "{section} transfer is missing: {} is a photograph ({}), so say how its numbers follow from radiance: \
             \"srgb\" (JPEG of a camera, most PNG files), \"linear\" (developed from a raw file without a curve), \
             a gamma such as 2.2, or the measured \"response.csv\"",
            path.display(),
            codes.in_words(),
            section = self.section
        ))
    }

    fn caution(&self, path: &Path, transfer: &Transfer, codes: &Codes) -> Option<Caution> {
        let (_, place) = codes.embedded.filter(|(embedded, _)| transfer.contradicts(*embedded))?;
        let message = format!(
            "{} transfer is not what the {place} of {} says; the scene file counts: make sure that it is right",
            self.section,
            path.display()
        );
        Some(Caution { code: CautionCode::Transfer, message })
    }
}
