//! The shaders once more in Rust, f32, name by name and as close to their text as Rust allows: what each hand-written
//! stage is compared with. The twin of `fft` is rustfft.

#![allow(clippy::needless_range_loop, reason = "a twin reads like its shader")]

pub mod arrive;
pub mod arriving;
pub mod canvas;
pub mod collect;
pub mod crop;
pub mod gather;
pub mod pass;
pub mod shift;
pub mod slope_correction;
pub mod split;
pub mod store;
pub mod sums;
pub mod total;
pub mod two_sum;
pub mod weigh;

use rustfft::num_complex::Complex;

/// A complex number, as the shaders' vec2f.
pub type C = Complex<f32>;

/// Twins of the functions in shaders/shared/complex.wgsl.
pub fn first_of(z: C, opposite: C) -> C {
    0.5 * (z + opposite.conj())
}

pub fn second_of(z: C, opposite: C) -> C {
    let twice = z - opposite.conj();
    0.5 * C::new(twice.im, -twice.re)
}

pub fn multiply(a: C, b: C) -> C {
    C::new(a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re)
}

pub fn together(a: C, b: C) -> C {
    C::new(a.re - b.im, a.im + b.re)
}

/// Twin of shaders/shared/direct.wgsl.
pub fn direct(light: f32, sigma_t: f32, way: f32, unit: f32) -> [f32; 4] {
    let arrived = (-sigma_t * way).exp() * light;
    let slope = -way / unit * arrived;
    [arrived, slope, slope, 0.0]
}
