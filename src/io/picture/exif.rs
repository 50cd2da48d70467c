//! What matters of an Exif block: the orientation, and whether the camera says that it wrote sRGB.

/// Tags: orientation, pointer to the camera's directory, colour space.
const ORIENTATION: u16 = 0x0112;
const EXIF_DIRECTORY: u16 = 0x8769;
const COLOUR_SPACE: u16 = 0xa001;
/// sRGB as a colour space.
const SRGB: u32 = 1;

/// What an Exif block says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Exif {
    /// 1 to 8; 1 if it is not given.
    pub orientation: u32,
    pub is_srgb: bool,
}

impl Exif {
    /// That of a block that begins as a TIFF file does. A damaged block says nothing.
    pub(super) fn read(block: &[u8]) -> Self {
        let reader = Reader::new(block.strip_prefix(b"Exif\0\0").unwrap_or(block));
        let Some((reader, first)) = reader else { return Self { orientation: 1, is_srgb: false } };
        let orientation = reader.value(first, ORIENTATION).filter(|v| (1..=8).contains(v));
        let camera = reader.value(first, EXIF_DIRECTORY);
        let space = camera.and_then(|at| reader.value(at as usize, COLOUR_SPACE));
        Self { orientation: orientation.unwrap_or(1), is_srgb: space == Some(SRGB) }
    }
}

/// Reads directories of one byte order.
struct Reader<'a> {
    block: &'a [u8],
    is_big_endian: bool,
}

impl<'a> Reader<'a> {
    /// The reader and where the first directory is.
    fn new(block: &'a [u8]) -> Option<(Self, usize)> {
        let is_big_endian = match block.get(..4)? {
            b"MM\0*" => true,
            b"II*\0" => false,
            _ => return None,
        };
        let reader = Self { block, is_big_endian };
        let first = reader.long(4)? as usize;
        Some((reader, first))
    }

    fn short(&self, at: usize) -> Option<u16> {
        let bytes = self.block.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if self.is_big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    }

    fn long(&self, at: usize) -> Option<u32> {
        let bytes = self.block.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(if self.is_big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// The first number of the entry `tag` of the directory at `directory`.
    fn value(&self, directory: usize, tag: u16) -> Option<u32> {
        const SHORT: u16 = 3;
        let entries = self.short(directory)?;
        let mut places = (0..usize::from(entries)).map(|i| directory.saturating_add(2 + 12 * i));
        let entry = places.find(|&at| self.short(at) == Some(tag))?;
        if self.short(entry + 2)? == SHORT {
            self.short(entry + 8).map(u32::from)
        } else {
            self.long(entry + 8)
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A block in either byte order that holds an orientation and the colour space sRGB.
    pub(crate) fn block(orientation: u16, is_big_endian: bool) -> Vec<u8> {
        let short = |v: u16| if is_big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
        let long = |v: u32| if is_big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
        let mut bytes = if is_big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
        bytes.extend(long(8));
        bytes.extend(short(2));
        bytes.extend([short(ORIENTATION), short(3)].concat());
        bytes.extend(long(1));
        bytes.extend([short(orientation), short(0)].concat());
        bytes.extend([short(EXIF_DIRECTORY), short(4)].concat());
        bytes.extend([long(1), long(38), long(0)].concat());
        bytes.extend(short(1));
        bytes.extend([short(COLOUR_SPACE), short(3)].concat());
        bytes.extend(long(1));
        bytes.extend([short(1), short(0)].concat());
        bytes
    }

    #[test]
    fn orientation_and_colour_space_are_found_in_both_byte_orders() {
        for is_big_endian in [false, true] {
            let exif = Exif::read(&block(6, is_big_endian));
            assert_eq!(exif, Exif { orientation: 6, is_srgb: true });
        }
        assert_eq!(Exif::read(&block(9, true)).orientation, 1);
    }

    #[test]
    fn damaged_blocks_say_nothing() {
        let whole = block(6, true);
        for length in 0..whole.len() {
            let exif = Exif::read(&whole[..length]);
            assert!([1, 6].contains(&exif.orientation), "{length}");
        }
        let mut wild = whole;
        wild[4..8].copy_from_slice(&[0xff; 4]);
        assert_eq!(Exif::read(&wild), Exif { orientation: 1, is_srgb: false });
    }
}
