//! The pixel's footprint in the frequency domain.
//!
//! With s(w) = M(w/pitch) - T and w in rad/px, the weights between pixels have the transform
//! `s̃(wx, wy) = sum_{m,n} s(|w + 2 pi (m, n)|) sinc²((wx + 2 pi m)/2) sinc²((wy + 2 pi n)/2)`, sinc x = sin x / x:
//! sampling a kernel averaged over two pixels. s falls only like 1/w, so the aliases count: without them a kernel
//! of one pixel's width biases sigma_s by 10 %.

use crate::image::Sampling;
use crate::spread::{Dual, SpreadKernel};
use std::f64::consts::PI;

/// sinc²((w + 2 pi m)/2).
pub fn sinc2(w: f64, m: i32) -> f64 {
    let x = 0.5 * w + PI * f64::from(m);
    if x.abs() < 1e-8 {
        1.0
    } else {
        let s = (0.5 * w).sin() / x;
        s * s
    }
}

/// s(|w|) and its derivatives for a kernel seen at `pitch` (length per pixel).
fn at(kernel: &dyn SpreadKernel, pitch: f64, wx: f64, wy: f64) -> Dual {
    kernel.scattered_transfer(wx.hypot(wy) / pitch)
}

/// The aliases (m, n) ≠ (0, 0) of s̃ at (`wx`, `wy`) rad/px, those up to `reach` one by one.
///
/// The squared sincs of all aliases add up to 1. What is left for those beyond `reach` is given to s in rings that
/// grow by a factor q: weights that fall like 1/m² leave 1 - 1/q of the rest to the first ring, and so on; s at
/// 2q/(1+q) times its near edge stands for a ring, which is exact where s is constant and where it falls like 1/w.
pub fn aliases(kernel: &dyn SpreadKernel, pitch: f64, wx: f64, wy: f64, reach: i32) -> Dual {
    let mut sum = Dual::default();
    let mut left = 1.0 - sinc2(wx, 0) * sinc2(wy, 0);
    for n in -reach..=reach {
        for m in -reach..=reach {
            let weight = sinc2(wx, m) * sinc2(wy, n);
            if (m, n) != (0, 0) && weight > 0.0 {
                let (ax, ay) = (wx + 2.0 * PI * f64::from(m), wy + 2.0 * PI * f64::from(n));
                sum = sum + weight * at(kernel, pitch, ax, ay);
                left -= weight;
            }
        }
    }
    let mut edge = 2.0 * PI * (f64::from(reach) + 0.5);
    for _ in 0..RINGS {
        let share = (1.0 - 1.0 / RING_GROWTH) * left;
        sum = sum + share * at(kernel, pitch, edge * 2.0 * RING_GROWTH / (1.0 + RING_GROWTH), 0.0);
        left -= share;
        edge *= RING_GROWTH;
    }
    sum = sum + left * at(kernel, pitch, edge, 0.0);
    sum
}

/// Rings of aliases beyond those summed one by one, and the ratio of their edges: seven octaves in thirds.
const RINGS: usize = 21;
const RING_GROWTH: f64 = 1.259_921;

/// s̃ at (`wx`, `wy`) rad/px, aliases up to `reach` one by one; s itself between band-limited images.
pub fn transfer(
    kernel: &dyn SpreadKernel,
    pitch: f64,
    [wx, wy]: [f64; 2],
    sampling: Sampling,
    reach: i32,
) -> Dual {
    let s = at(kernel, pitch, wx, wy);
    match sampling {
        Sampling::Pixel => pixel_factor(wx, wy, sampling) * s + aliases(kernel, pitch, wx, wy, reach),
        Sampling::Bandlimited => s,
    }
}

/// What both pixels leave of the frequency (`wx`, `wy`) rad/px: sinc² sinc²; all of it between band-limited images.
pub fn pixel_factor(wx: f64, wy: f64, sampling: Sampling) -> f64 {
    match sampling {
        Sampling::Pixel => sinc2(wx, 0) * sinc2(wy, 0),
        Sampling::Bandlimited => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squared_sincs_of_all_aliases_add_up_to_one() {
        for w in [0.3, 2.0, PI] {
            let sum: f64 = (-4000..=4000).map(|m| sinc2(w, m)).sum();
            // The tail beyond reach n is at most 2 / (pi² n).
            assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        }
    }
}
