//! What a decoder knows of a file before it decodes its pixels.

/// A file whose header is read.
pub(super) struct Opened<'a> {
    pub header: Header,
    pub pixels: Pixels<'a>,
}

/// Decodes the pixels: row by row from the top, the samples of a pixel beside each other.
pub(super) type Pixels<'a> = Box<dyn FnOnce() -> Result<Vec<f32>, String> + 'a>;

/// What a header says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    /// Width and height as stored, px.
    pub size: (usize, usize),
    /// Numbers of a pixel: 1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha.
    pub samples: usize,
    pub numbers: Numbers,
    /// How the picture is to be turned, as Exif counts: 1 to 8, 1 is upright.
    pub orientation: u32,
    /// What the file says of its transfer curve, and where.
    pub embedded: Option<(Embedded, &'static str)>,
}

/// What the numbers of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Numbers {
    /// Integers from 0 to `largest`.
    Codes { largest: u32 },
    /// Floats, proportional to radiance.
    Radiance,
}

/// What a file says of its transfer curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Embedded {
    /// Codes are proportional to radiance.
    Linear,
    /// The curve of sRGB.
    Srgb,
    /// Radiance is the code to this power.
    Gamma(f64),
    /// Some other curve.
    Curve,
}

impl Header {
    /// Of an upright image that says nothing of its curve.
    pub(super) fn plain(size: (usize, usize), samples: usize, numbers: Numbers) -> Self {
        Self { size, samples, numbers, orientation: 1, embedded: None }
    }

    /// Bytes of a pixel in the file, and at least in memory.
    pub(super) fn pixel_bytes(&self) -> usize {
        let each = match self.numbers {
            Numbers::Codes { largest } if largest <= 255 => 1,
            Numbers::Codes { .. } => 2,
            Numbers::Radiance => 4,
        };
        each * self.samples
    }

    /// Width and height once the picture is upright.
    pub(super) fn upright_size(&self) -> (usize, usize) {
        let (width, height) = self.size;
        if self.orientation >= 5 { (height, width) } else { (width, height) }
    }
}
