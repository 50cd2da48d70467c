//! Light scattered once, exactly.
//!
//! A path turned by theta at the height u above the plane lands at r = u tan(theta), after the length
//! 1 - u + u/cos(theta). With P the phase function per steradian, t = tau + a and c = t (1/cos(theta) - 1), the light
//! within r is
//!
//! `tau exp(-t) ∫_0^{pi/2} 2 pi sin(theta) P(theta) (1 - exp(-c U))/c dtheta,  U = min(1, r/tan(theta))`,
//!
//! and its slope is tan(theta).

use super::Radial;
use crate::medium::Medium;
use crate::phase::{Family, Phase, PhaseFunction};
use crate::quadrature::nodes;
use std::f64::consts::{FRAC_PI_2, PI};

/// Light scattered once in the bins between `edges`, in units of z times the planar width of the phase function, of
/// `medium`, lengths in units of z.
pub(super) fn radial(medium: &Medium, edges: &[f64]) -> Radial {
    let width = medium.phase().planar_width();
    let within: Vec<[f64; 2]> = edges
        .iter()
        .map(|x| encircled(medium, x * width))
        .chain([encircled(medium, f64::INFINITY)])
        .collect();
    let between = |i: usize| -> Vec<f64> {
        let mut last = 0.0;
        within.iter().map(|e| e[i] - std::mem::replace(&mut last, e[i])).collect()
    };
    Radial { light: between(0), slope: between(1) }
}

/// Angles between which the integrand is smooth on the scale of the first of them or of the phase function's width, around the kink at
/// `kink`. Twenty widths of a Gaussian hold all but exp(-100); Henyey-Greenstein's falls like a power.
fn pieces(phase: &Phase, kink: f64) -> Vec<f64> {
    let width = phase.planar_width();
    match phase.family() {
        Family::Gaussian => {
            let end = FRAC_PI_2.min(20.0 * width);
            vec![0.0, kink.min(end), end]
        }
        Family::HenyeyGreenstein => {
            let doubled = (0..).map(|i| width * f64::from(1 << i)).take_while(|&theta| theta < FRAC_PI_2);
            let mut all: Vec<f64> = [0.0, kink, FRAC_PI_2].into_iter().chain(doubled).collect();
            all.sort_by(f64::total_cmp);
            all
        }
    }
}

/// Light, and light times slope, within radius `r`.
fn encircled(medium: &Medium, r: f64) -> [f64; 2] {
    let (phase, t) = (medium.phase(), medium.sigma_t());
    let mut sums = [0.0; 2];
    for piece in pieces(phase, r.atan()).windows(2) {
        let (from, to) = (piece[0], piece[1]);
        let scale = match phase.family() {
            Family::Gaussian => phase.planar_width(),
            Family::HenyeyGreenstein => phase.planar_width().max(from),
        };
        let panels = 1 + (2.0 * (to - from) / scale) as usize;
        for (theta, weight) in nodes(from, to, panels) {
            let (sin, cos) = theta.sin_cos();
            let reach = (r * cos / sin).min(1.0);
            let c = t * (1.0 - cos) / cos;
            let length = if c * reach < 1e-9 { reach } else { -(-c * reach).exp_m1() / c };
            let light = weight * 2.0 * PI * sin * phase.pdf(cos) * length;
            sums[0] += light;
            sums[1] += light * sin / cos;
        }
    }
    sums.map(|s| medium.sigma_s() * (-t).exp() * s)
}
