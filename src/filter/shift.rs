//! Images moved by a fraction of a pixel, and how they change with the shift.
//!
//! The image I moved by d = (dx, dy), px, +x to the right and +y down, is I(x - d). Its transform is that of I times
//! exp(-i w·d), w in rad/px, and its derivative in dx has another factor -i w_x. The highest frequency of an axis of
//! even size, pi, stands for both its signs: the factor is their mean cos(pi d), which keeps the image real, with the
//! derivative -pi sin(pi d).
//!
//! All of the canvas moves, direct light included, so light comes in from outside the view as the border rule has it.
//! In a perspective view it is seen there as by the nearest pixel of the view. What leaves the canvas on one side comes
//! back on the other: shifts should be smaller than the padding.
//!
//! Cost: 2 real 2-D FFTs beside those of a render; 10 beside those of a render with derivatives, of whose four images
//! each is transformed, and six are transformed back.

use super::fft2::Fft2;
use crate::error::{Error, Result};
use rayon::prelude::*;
use rustfft::FftNum;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// A shift of images on one canvas.
pub(super) struct Shift {
    /// Across and down.
    axes: [Axis; 2],
}

/// For each frequency of an axis, in the order of its transform.
struct Axis {
    factors: Vec<Complex<f64>>,
    /// Their derivatives in the shift, 1/px.
    slopes: Vec<Complex<f64>>,
}

impl Shift {
    /// The shift by `shift_px`, px, of images as large as `fft` transforms.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a shift that is not finite, or that is larger than the canvas.
    pub(super) fn new<T: FftNum>(fft: &Fft2<T>, shift_px: [f64; 2]) -> Result<Self> {
        let sizes = [fft.width, fft.height];
        for ((name, value), size) in ["shift x, px", "shift y, px"].into_iter().zip(shift_px).zip(sizes) {
            if value.is_nan() || value.abs() > size as f64 {
                let allowed = "finite, and no larger than the padded image";
                return Err(Error::OutOfRange { name: name.into(), value, allowed });
            }
        }
        Ok(Self { axes: [0, 1].map(|axis| Axis::new(sizes[axis], shift_px[axis])) })
    }

    /// For each frequency across, then down, from 0 to all: the factor and its derivative in the shift.
    #[cfg(feature = "gpu")]
    pub(super) fn table(&self) -> impl Iterator<Item = [Complex<f64>; 2]> + '_ {
        self.axes.iter().flat_map(|axis| axis.factors.iter().zip(&axis.slopes).map(|(f, s)| [*f, *s]))
    }

    /// The `image` moved.
    pub(super) fn moved<T: FftNum>(&self, fft: &Fft2<T>, image: Vec<T>) -> Vec<T> {
        let mut spectrum = fft.forward(image);
        self.apply(fft, &mut spectrum, [false; 2]);
        fft.inverse(spectrum)
    }

    /// The `image` moved, and its derivatives in dx and dy, 1/px.
    pub(super) fn moved_with_motion<T: FftNum>(&self, fft: &Fft2<T>, image: Vec<T>) -> [Vec<T>; 3] {
        let spectrum = fft.forward(image);
        [[false, false], [true, false], [false, true]].map(|derived| {
            let mut spectrum = spectrum.clone();
            self.apply(fft, &mut spectrum, derived);
            fft.inverse(spectrum)
        })
    }

    /// Multiplies by the factors of each axis, or by their derivatives where it is `derived`.
    fn apply<T: FftNum>(&self, fft: &Fft2<T>, spectrum: &mut [Complex<T>], derived: [bool; 2]) {
        let [across, down] = [0, 1].map(|axis| {
            let Axis { factors, slopes } = &self.axes[axis];
            if derived[axis] { slopes } else { factors }
        });
        spectrum.par_chunks_mut(fft.height).zip(across).for_each(|(column, across)| {
            for (value, down) in column.iter_mut().zip(down) {
                *value = *value * narrowed(across * down);
            }
        });
    }
}

impl Axis {
    fn new(n: usize, shift_px: f64) -> Self {
        let of = |k: usize| {
            if 2 * k == n {
                let (sin, cos) = (PI * shift_px).sin_cos();
                return (cos.into(), (-PI * sin).into());
            }
            let number = if 2 * k < n { k as f64 } else { k as f64 - n as f64 };
            let w = 2.0 * PI * number / n as f64;
            let factor = Complex::cis(-w * shift_px);
            (factor, Complex::new(0.0, -w) * factor)
        };
        let (factors, slopes) = (0..n).map(of).unzip();
        Self { factors, slopes }
    }
}

fn narrowed<T: FftNum>(value: Complex<f64>) -> Complex<T> {
    let part = |v: f64| T::from_f64(v).expect("a float fits a float");
    Complex::new(part(value.re), part(value.im))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [24, 20];

    /// Waves of all frequencies but the highest ones.
    fn image() -> Vec<f64> {
        let fft = Fft2::<f64>::new(SIZE[0], SIZE[1]);
        let noise = (0..SIZE[0] * SIZE[1]).map(|i| ((i * i + 7 * i) % 31) as f64 / 31.0).collect();
        let mut spectrum = fft.forward(noise);
        for (kx, column) in spectrum.chunks_mut(SIZE[1]).enumerate() {
            let highest = |ky: usize| 2 * kx == SIZE[0] || 2 * ky == SIZE[1];
            column.iter_mut().enumerate().filter(|(ky, _)| highest(*ky)).for_each(|(_, v)| *v = 0.0.into());
        }
        fft.inverse(spectrum)
    }

    fn moved(image: &[f64], shift_px: [f64; 2]) -> Vec<f64> {
        let fft = Fft2::new(SIZE[0], SIZE[1]);
        Shift::new(&fft, shift_px).unwrap().moved(&fft, image.to_vec())
    }

    fn apart(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn whole_pixels_move_the_pixels() {
        let mut image = image();
        image[77] += 5.0;
        let turned: Vec<f64> = (0..image.len())
            .map(|i| {
                let (x, y) = (i % SIZE[0], i / SIZE[0]);
                image[(y + 2) % SIZE[1] * SIZE[0] + (x + SIZE[0] - 3) % SIZE[0]]
            })
            .collect();
        assert!(apart(&moved(&image, [3.0, -2.0]), &turned) < 1e-12);
        assert!(apart(&moved(&image, [-3.0, -2.0]), &turned) > 1.0, "the other way");
        assert!(apart(&moved(&image, [0.0; 2]), &image) < 1e-12);
    }

    #[test]
    fn shifts_add_up() {
        let image = image();
        let twice = moved(&moved(&image, [0.3, -1.7]), [1.45, 0.2]);
        assert!(apart(&twice, &moved(&image, [1.75, -1.5])) < 1e-12);
        assert!(apart(&twice, &moved(&image, [1.76, -1.5])) > 1e-3);
    }

    #[test]
    fn motion_is_the_derivative_in_the_shift() {
        let fft = Fft2::new(SIZE[0], SIZE[1]);
        let mut image = image();
        // The highest frequencies too.
        image[77] += 5.0;
        let [_, x, y] = Shift::new(&fft, [0.3, -1.7]).unwrap().moved_with_motion(&fft, image.clone());
        let step = 1e-4;
        for (axis, motion) in [x, y].iter().enumerate() {
            let at = |side: f64| {
                let mut shift_px = [0.3, -1.7];
                shift_px[axis] += side * step;
                moved(&image, shift_px)
            };
            let slopes: Vec<f64> =
                at(1.0).iter().zip(at(-1.0)).map(|(a, b)| (a - b) / (2.0 * step)).collect();
            assert!(apart(motion, &slopes) < 1e-6, "axis {axis}: {}", apart(motion, &slopes));
        }
    }

    #[test]
    fn shifts_that_no_canvas_holds_are_refused_by_name() {
        let fft = Fft2::<f32>::new(SIZE[0], SIZE[1]);
        for (shift_px, name) in [([f64::NAN, 0.0], "shift x"), ([0.0, -21.0], "shift y")] {
            let error = Shift::new(&fft, shift_px).err().unwrap().to_string();
            assert!(error.contains(name), "{error}");
        }
    }
}
