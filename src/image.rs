//! Linear images: row-major f32, one plane per channel, row 0 at the top. No colour management here.

/// One channel of an image, row-major, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Columns, px.
    pub width: usize,
    /// Rows, px.
    pub height: usize,
    /// `width * height` values.
    pub data: Vec<f32>,
}

impl Image {
    /// An image of one value.
    pub fn filled(width: usize, height: usize, value: f32) -> Self {
        Self { width, height, data: vec![value; width * height] }
    }

    /// An image whose pixel (x, y) is `f(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> f32) -> Self {
        let data = (0..width * height).map(|i| f(i % width, i / width)).collect();
        Self { width, height, data }
    }

    /// Value of pixel (x, y). Panics outside the image.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        self.data[y * self.width + x]
    }

    /// Mean over all pixels, summed in f64.
    pub fn mean(&self) -> f64 {
        self.data.iter().map(|&v| f64::from(v)).sum::<f64>() / self.data.len() as f64
    }

    /// The part that `view` shows. Panics if it does not lie inside the image.
    pub fn crop(&self, view: View) -> Self {
        Self::from_fn(view.width, view.height, |x, y| self.at(x + view.x, y + view.y))
    }
}

/// What lies between the pixels of a clear image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sampling {
    /// Radiance is constant over a pixel, and an observed pixel is the mean over its area: pixel art, renders whose texels are
    /// pixels.
    #[default]
    Pixel,
    /// Both images hold no frequency beyond half of one a pixel, lens and pixel having averaged them alike: photographs.
    Bandlimited,
}

impl Sampling {
    /// All of them.
    pub const ALL: [Sampling; 2] = [Sampling::Pixel, Sampling::Bandlimited];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Sampling::Pixel => "pixel",
            Sampling::Bandlimited => "bandlimited",
        }
    }
}

/// A rectangle of an image: its top left corner and its size, px.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct View {
    /// Column of the top left pixel.
    pub x: usize,
    /// Row of the top left pixel.
    pub y: usize,
    /// Columns, px.
    pub width: usize,
    /// Rows, px.
    pub height: usize,
}

impl View {
    /// All of an image of this size.
    pub fn whole(width: usize, height: usize) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// The middle of an image of `outer` (width, height), `inner` large.
    pub fn centred(outer: (usize, usize), inner: (usize, usize)) -> Self {
        Self { x: (outer.0 - inner.0) / 2, y: (outer.1 - inner.1) / 2, width: inner.0, height: inner.1 }
    }

    /// Whether it lies inside an image of this size.
    pub fn fits(&self, width: usize, height: usize) -> bool {
        self.x + self.width <= width && self.y + self.height <= height
    }

    /// Pixels in it.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }
}

/// A named channel, such as `Y` or `R`.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name as in the EXR file.
    pub name: String,
    /// Its pixels.
    pub image: Image,
}

/// What lies outside the object image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Border {
    /// No light: the scene is black there.
    #[default]
    Zero,
    /// The outermost pixels are repeated outwards.
    Clamp,
    /// The image is mirrored at its outer edge, again and again.
    Mirror,
    /// It is not known. Renders take the mirrored image for it; fits leave out the pixels that see too much of it.
    Unknown,
}

impl Border {
    /// Whether renders take the mirrored image for what lies outside.
    pub fn mirrors(self) -> bool {
        matches!(self, Self::Mirror | Self::Unknown)
    }

    /// Index of the pixel that represents position `i` (which may lie outside) in a row of `n`; `None` is black.
    pub fn index(self, i: i64, n: usize) -> Option<usize> {
        let size = n as i64;
        match self {
            _ if (0..size).contains(&i) => Some(i as usize),
            Border::Zero => None,
            Border::Clamp => Some(i.clamp(0, size - 1) as usize),
            Border::Mirror | Border::Unknown => {
                let j = i.rem_euclid(2 * size);
                Some(if j < size { j } else { 2 * size - 1 - j } as usize)
            }
        }
    }

    /// Factor of a slope along the row at position `i` (which may lie outside) of `n`: a mirrored surface slopes the
    /// other way, a clamped one continues without slope.
    pub fn turn(self, i: i64, n: usize) -> f64 {
        let inside = (0..n as i64).contains(&i);
        match self {
            _ if inside => 1.0,
            Border::Mirror | Border::Unknown if i.div_euclid(n as i64) % 2 == 0 => 1.0,
            Border::Mirror | Border::Unknown => -1.0,
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_follow_their_rule() {
        let row = |border: Border| (-3..6).map(|i| border.index(i, 3)).collect::<Vec<_>>();
        let some = |v: [usize; 9]| v.map(Some).to_vec();
        assert_eq!(row(Border::Clamp), some([0, 0, 0, 0, 1, 2, 2, 2, 2]));
        assert_eq!(row(Border::Mirror), some([2, 1, 0, 0, 1, 2, 2, 1, 0]));
        assert_eq!(row(Border::Zero)[2], None);
        assert_eq!(row(Border::Zero)[3], Some(0));
    }
}
