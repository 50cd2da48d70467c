//! The source image of the slope term.
//!
//! Paths of slope s meet a surface with the depth gradient grad d at the rate 1 - s·grad d per projected area. With
//! E[s exp(i k·r)] = -i (k/k²) N(k) (see [`SpreadKernel::mean_slope`](crate::spread::SpreadKernel::mean_slope)) a
//! surface of radiance L adds N(k) i k·FT[L grad d]/k² to the image's transform. In pixels, with g = grad d in length
//! per pixel and w = k·pitch, that is N i w·FT[L g]/w²: the pitch drops out.

use super::canvas::{Canvas, Spectrum};
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// i w·FT[(fx, fy)] / w² of a vector image on the canvas. At the highest frequency of an axis a derivative along it has
/// no sign and is left out, as it is in the sum over its aliases.
pub(super) fn slope_correction(canvas: &Canvas, field: [Vec<f32>; 2]) -> Spectrum {
    let (width, height) = (canvas.fft.width, canvas.fft.height);
    let [x, y] = field.map(|plane| canvas.fft.forward(plane));
    let along = |i: usize, n: usize| {
        let signed = if 2 * i < n { i as f64 } else { i as f64 - n as f64 };
        2.0 * PI * signed / n as f64
    };
    let slope = |w: f64| if w.abs() < PI { w } else { 0.0 };
    let at = |(i, (x, y)): (usize, (&Complex<f32>, &Complex<f32>))| {
        let (wx, wy) = (along(i / height, width), along(i % height, height));
        let square = wx * wx + wy * wy;
        if square == 0.0 {
            return Complex::new(0.0, 0.0);
        }
        let (fx, fy) = ((slope(wx) / square) as f32, (slope(wy) / square) as f32);
        Complex::<f32>::i() * (*x * fx + *y * fy)
    };
    x.iter().zip(&y).enumerate().map(at).collect()
}
