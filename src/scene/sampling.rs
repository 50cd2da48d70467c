//! What lies between the pixels of a clear image: stated, or as its values say.

use super::images::ObjectImage;
use super::source::Source;
use crate::error::Result;
use crate::image::{Image, Sampling};

/// Share of neighbouring pixels that are the same from which on an image is piecewise constant.
const CONSTANT: f64 = 0.5;

/// The sampling that `[object] sampling` states, and whether it is known. `auto`, the default, takes a photograph for band-limited, and an image
/// that is piecewise constant for one of constant pixels; nothing in the values of other images tells.
pub(super) fn read_sampling(
    source: &Source,
    stated: Option<&str>,
    object: &ObjectImage,
) -> Result<(Sampling, bool)> {
    match stated {
        None | Some("auto") => {
            let is_constant = object.channels.iter().all(|c| is_piecewise_constant(&c.image));
            let is_photograph = object.is_photograph && !is_constant;
            let sampling = if is_photograph { Sampling::Bandlimited } else { Sampling::Pixel };
            Ok((sampling, is_constant || is_photograph))
        }
        Some(name) => match Sampling::ALL.into_iter().find(|sampling| sampling.name() == name) {
            Some(sampling) => Ok((sampling, true)),
            None => Err(source.error(format!(
                "[object] sampling = \"{name}\" is not \"pixel\", \"bandlimited\" or \"auto\""
            ))),
        },
    }
}

/// Whether most neighbours that are not both black are the same.
fn is_piecewise_constant(image: &Image) -> bool {
    let (mut same, mut all) = (0_u64, 0_u64);
    let mut count = |a: f32, b: f32| {
        let counts = a != 0.0 || b != 0.0;
        (same, all) = (same + u64::from(counts && a == b), all + u64::from(counts));
    };
    for row in image.data.chunks(image.width) {
        row.windows(2).for_each(|pair| count(pair[0], pair[1]));
    }
    let below = image.data.iter().skip(image.width);
    image.data.iter().zip(below).for_each(|(a, b)| count(*a, *b));
    same as f64 >= CONSTANT * all as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_are_piecewise_constant_and_textures_on_black_are_not() {
        let squares = Image::from_fn(32, 32, |x, y| if (x / 4 + y / 4) % 2 == 0 { 0.2 } else { 0.7 });
        assert!(is_piecewise_constant(&squares));
        let texture = |x: usize, y: usize| ((7 * x + 13 * y + x * y) % 31) as f32 / 31.0 + 0.1;
        let on_black = Image::from_fn(32, 32, |x, y| if x < 8 { texture(x, y) } else { 0.0 });
        assert!(!is_piecewise_constant(&on_black));
    }
}
