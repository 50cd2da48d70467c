//! Real 2-D FFTs on all cores: rows by realfft, columns by rustfft on the transposed spectrum.
//!
//! The spectrum is stored transposed: `height` frequencies ky contiguous, for each of the `width/2 + 1`
//! frequencies kx. Forward and inverse together multiply by 1.

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftNum, FftPlanner};
use std::sync::Arc;

/// Plan of a real transform of one size.
pub(super) struct Fft2<T: FftNum> {
    pub width: usize,
    pub height: usize,
    rows: Arc<dyn RealToComplex<T>>,
    rows_back: Arc<dyn ComplexToReal<T>>,
    columns: Arc<dyn Fft<T>>,
    columns_back: Arc<dyn Fft<T>>,
}

impl<T: FftNum> Fft2<T> {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let mut real = RealFftPlanner::new();
        let mut complex = FftPlanner::new();
        Self {
            width,
            height,
            rows: real.plan_fft_forward(width),
            rows_back: real.plan_fft_inverse(width),
            columns: complex.plan_fft_forward(height),
            columns_back: complex.plan_fft_inverse(height),
        }
    }

    /// Frequencies kx ≥ 0.
    pub(super) fn half_width(&self) -> usize {
        self.width / 2 + 1
    }

    /// Transform of `image` (row-major, `width * height`), transposed.
    pub(super) fn forward(&self, mut image: Vec<T>) -> Vec<Complex<T>> {
        let half = self.half_width();
        let zero = Complex::new(T::zero(), T::zero());
        let mut rows = vec![zero; half * self.height];
        image.par_chunks_mut(self.width).zip(rows.par_chunks_mut(half)).for_each_init(
            || self.rows.make_scratch_vec(),
            |scratch, (row, out)| {
                self.rows.process_with_scratch(row, out, scratch).expect("sizes are the plan's");
            },
        );
        let mut spectrum = vec![zero; half * self.height];
        transpose::transpose(&rows, &mut spectrum, half, self.height);
        spectrum.par_chunks_mut(self.height).for_each_init(
            || vec![zero; self.columns.get_inplace_scratch_len()],
            |scratch, column| self.columns.process_with_scratch(column, scratch),
        );
        spectrum
    }

    /// Image of a transposed `spectrum`, which is used up.
    pub(super) fn inverse(&self, mut spectrum: Vec<Complex<T>>) -> Vec<T> {
        let half = self.half_width();
        let zero = Complex::new(T::zero(), T::zero());
        spectrum.par_chunks_mut(self.height).for_each_init(
            || vec![zero; self.columns_back.get_inplace_scratch_len()],
            |scratch, column| self.columns_back.process_with_scratch(column, scratch),
        );
        let mut rows = vec![zero; half * self.height];
        transpose::transpose(&spectrum, &mut rows, self.height, half);
        let mut image = vec![T::zero(); self.width * self.height];
        let scale = T::one() / T::from_usize(self.width * self.height).expect("a size fits a float");
        rows.par_chunks_mut(half).zip(image.par_chunks_mut(self.width)).for_each_init(
            || self.rows_back.make_scratch_vec(),
            |scratch, (row, out)| {
                // A real image has real values at the lowest and (for even widths) the highest frequency.
                row[0].im = T::zero();
                if self.width.is_multiple_of(2) {
                    row[half - 1].im = T::zero();
                }
                self.rows_back.process_with_scratch(row, out, scratch).expect("sizes are the plan's");
                out.iter_mut().for_each(|v| *v = *v * scale);
            },
        );
        image
    }
}

/// The smallest size of at least `n` with no prime factor above 5: such transforms are fast.
pub(super) fn fast_size(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    (n.max(2)..).find(|&m| m.is_multiple_of(2) && smooth(m)).expect("powers of two are smooth")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forward_then_inverse_gives_the_image_back() {
        let fft = Fft2::<f64>::new(12, 10);
        let image: Vec<f64> = (0..120).map(|i| ((i * i) % 17) as f64).collect();
        let back = fft.inverse(fft.forward(image.clone()));
        assert!(image.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn the_spectrum_is_transposed() {
        // A wave along x of frequency 3 has all its energy at kx = 3, ky = 0.
        let fft = Fft2::<f64>::new(12, 10);
        let wave = |i: usize| (2.0 * std::f64::consts::PI * 3.0 * (i % 12) as f64 / 12.0).cos();
        let spectrum = fft.forward((0..120).map(wave).collect());
        assert!((spectrum[3 * 10].re - 60.0).abs() < 1e-10);
    }

    #[test]
    fn fast_sizes_are_even_smooth_and_large_enough() {
        assert_eq!(fast_size(1), 2);
        assert_eq!(fast_size(127), 128);
        assert_eq!(fast_size(321), 324);
    }
}
