//! Image formats, by their first bytes and by their file names.

use std::path::Path;

/// A format of image files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR.
    Exr,
    /// Portable network graphics.
    Png,
    /// Tagged image file format.
    Tiff,
    /// JPEG.
    Jpeg,
    /// Radiance's RGBE.
    Hdr,
    /// Portable float map.
    Pfm,
}

/// First bytes of formats that are not read: what they are, and what helps.
const OTHERS: [(usize, &[u8], &str); 8] = [
    (0, b"GIF8", "a GIF, whose palette is no photograph"),
    (0, b"BM", "a BMP; save it as PNG"),
    (8, b"WEBP", "a WebP; save it as 16-bit TIFF or PNG"),
    (4, b"ftyp", "a HEIF, AVIF or CR3; develop it to a linear 16-bit TIFF"),
    (0, b"FUJIFILMCCD-RAW", "a raw file; develop it to a linear 16-bit TIFF: dcraw -4 -T"),
    (0, b"II*\0\x10\0\0\0CR", "a raw file; develop it to a linear 16-bit TIFF: dcraw -4 -T"),
    (0, b"IIU\0", "a raw file; develop it to a linear 16-bit TIFF: dcraw -4 -T"),
    (0, b"\xff\x0a", "a JPEG XL; save it as 16-bit TIFF or PNG"),
];

impl Format {
    /// The name for people.
    pub fn name(self) -> &'static str {
        match self {
            Format::Exr => "EXR",
            Format::Png => "PNG",
            Format::Tiff => "TIFF",
            Format::Jpeg => "JPEG",
            Format::Hdr => "Radiance HDR",
            Format::Pfm => "PFM",
        }
    }

    /// The format of a file that begins with `bytes`; `None` if they begin none that is known.
    ///
    /// # Errors
    /// What the file is, if it is of a format that is known not to be read.
    pub(super) fn of_bytes(bytes: &[u8]) -> Result<Option<Self>, String> {
        let begins = |start: &[u8]| bytes.starts_with(start);
        let is_other =
            |(at, start, _): &&(usize, &[u8], &str)| bytes.get(*at..).is_some_and(|b| b.starts_with(start));
        if let Some((_, _, what)) = OTHERS.iter().find(is_other) {
            return Err(format!("it is {what}"));
        }
        Ok(match () {
            () if begins(b"\x76\x2f\x31\x01") => Some(Self::Exr),
            () if begins(b"\x89PNG\r\n\x1a\n") => Some(Self::Png),
            () if begins(b"II*\0") || begins(b"MM\0*") || begins(b"II+\0") || begins(b"MM\0+") => {
                Some(Self::Tiff)
            }
            () if begins(b"\xff\xd8\xff") => Some(Self::Jpeg),
            () if begins(b"#?RADIANCE\n") || begins(b"#?RGBE\n") => Some(Self::Hdr),
            () if begins(b"PF\n") || begins(b"Pf\n") => Some(Self::Pfm),
            () => None,
        })
    }

    /// The format that the name of `path` asks for.
    pub fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "exr" => Self::Exr,
            "png" => Self::Png,
            "tif" | "tiff" => Self::Tiff,
            "jpg" | "jpeg" => Self::Jpeg,
            "hdr" | "pic" => Self::Hdr,
            "pfm" => Self::Pfm,
            _ => return None,
        })
    }
}
