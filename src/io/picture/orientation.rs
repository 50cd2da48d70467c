//! Turning pictures upright as Exif says.

use crate::image::Image;

/// `image`, stored as Exif's `orientation` (1 to 8) says, upright.
pub(super) fn upright(image: Image, orientation: u32) -> Image {
    let (width, height) = (image.width, image.height);
    let (right, bottom) = (width - 1, height - 1);
    // Where the upright pixel (x, y) is stored.
    let stored = |x: usize, y: usize| match orientation {
        2 => (right - x, y),
        3 => (right - x, bottom - y),
        4 => (x, bottom - y),
        5 => (y, x),
        6 => (y, bottom - x),
        7 => (right - y, bottom - x),
        8 => (right - y, x),
        _ => (x, y),
    };
    if orientation <= 1 {
        return image;
    }
    let (across, down) = if orientation >= 5 { (height, width) } else { (width, height) };
    Image::from_fn(across, down, |x, y| {
        let (u, v) = stored(x, y);
        image.at(u, v)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The picture "1 2 3 / 4 5 6" as each orientation stores it: row 0 and column 0 are where Exif 2.3, table 7, has them.
    const STORED: [(u32, usize, [u8; 6]); 8] = [
        (1, 3, [1, 2, 3, 4, 5, 6]),
        (2, 3, [3, 2, 1, 6, 5, 4]),
        (3, 3, [6, 5, 4, 3, 2, 1]),
        (4, 3, [4, 5, 6, 1, 2, 3]),
        (5, 2, [1, 4, 2, 5, 3, 6]),
        (6, 2, [3, 6, 2, 5, 1, 4]),
        (7, 2, [6, 3, 5, 2, 4, 1]),
        (8, 2, [4, 1, 5, 2, 6, 3]),
    ];

    #[test]
    fn every_orientation_is_turned_upright() {
        for (orientation, width, values) in STORED {
            let stored = Image { width, height: 6 / width, data: values.map(f32::from).to_vec() };
            let upright = upright(stored, orientation);
            assert_eq!((upright.width, upright.height), (3, 2), "{orientation}");
            assert_eq!(upright.data, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{orientation}");
        }
    }
}
