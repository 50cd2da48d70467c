//! Inverse Hankel transforms of slowly decaying transfer functions.
//!
//! The integrals ∫ f(k) J(k r) dk are summed between (near-)zeros of the Bessel function and the alternating tail is
//! extrapolated by Wynn's epsilon algorithm (Wynn 1956; Longman 1956 for the partition).

use crate::quadrature::integrate;
use libm::{j0, j1};
use std::f64::consts::PI;

/// Intervals between zeros after which summation stops.
const MOST_INTERVALS: usize = 4000;
/// Partial sums given to the extrapolation.
const EXTRAPOLATED: usize = 24;
/// Relative change between two extrapolations at which the sum has converged.
const TOLERANCE: f64 = 1e-11;

/// (1/2pi) ∫_0^∞ f(k) J0(k r) k dk for `r` > 0; `f` varies on the scale `k_scale` and decays no slower than 1/k².
pub(super) fn inverse_j0(f: impl Fn(f64) -> f64, r: f64, k_scale: f64) -> f64 {
    oscillatory(|k| f(k) * j0(k * r) * k, r, 0.75, k_scale) / (2.0 * PI)
}

/// r ∫_0^∞ f(k) J1(k r) dk: what the transfer function `f` encircles within radius `r`.
pub(super) fn encircled_j1(f: impl Fn(f64) -> f64, r: f64, k_scale: f64) -> f64 {
    r * oscillatory(|k| f(k) * j1(k * r), r, 1.25, k_scale)
}

/// ∫_0^∞ of an integrand whose sign changes near k r = (n + `first`) pi.
fn oscillatory(f: impl Fn(f64) -> f64, r: f64, first: f64, k_scale: f64) -> f64 {
    let zero = |n: usize| (n as f64 + first) * PI / r;
    let mut sum = graded(&f, 0.0, zero(0), k_scale);
    let mut sums = vec![sum];
    let (mut last, mut agreed) = (f64::NAN, 0);
    for n in 0..MOST_INTERVALS {
        sum += graded(&f, zero(n), zero(n + 1), k_scale);
        sums.push(sum);
        // Extrapolate only past the scale on which f varies: before, the terms do not alternate regularly.
        if zero(n) > 4.0 * k_scale && sums.len() >= EXTRAPOLATED {
            let limit = epsilon(&sums[sums.len() - EXTRAPOLATED..]);
            agreed = if (limit - last).abs() <= TOLERANCE * limit.abs().max(sums[0].abs() * 1e-6) {
                agreed + 1
            } else {
                0
            };
            if agreed == 2 {
                return limit;
            }
            last = limit;
        }
    }
    if last.is_finite() { last } else { sum }
}

/// Integral over [a, b] on panels that grow with k, from `k_scale`/4 on.
fn graded(f: &impl Fn(f64) -> f64, a: f64, b: f64, k_scale: f64) -> f64 {
    let mut total = 0.0;
    let mut left = a;
    while left < b {
        let right = b.min(left + (0.5 * left).max(0.25 * k_scale));
        total += integrate(left, right, 1, f);
        left = right;
    }
    total
}

/// Wynn's epsilon algorithm: the limit of a sequence of partial sums.
fn epsilon(sums: &[f64]) -> f64 {
    let mut previous = vec![0.0; sums.len() + 1];
    let mut current = sums.to_vec();
    let mut best = *sums.last().expect("at least one sum");
    let mut column = 0;
    while current.len() > 1 {
        let next: Vec<f64> =
            (0..current.len() - 1).map(|i| previous[i + 1] + 1.0 / (current[i + 1] - current[i])).collect();
        if next.iter().any(|v| !v.is_finite()) {
            return best;
        }
        previous = current;
        current = next;
        column += 1;
        if column % 2 == 0 {
            best = *current.last().expect("the loop leaves one");
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_transform_as_in_closed_form() {
        // exp(-c k) <-> c / (2 pi (r² + c²)^{3/2}); encircled 1 - c / sqrt(r² + c²).
        let c = 0.3_f64;
        for r in [1e-3, 0.1, 1.0, 7.0] {
            let want = c / (2.0 * PI * (r * r + c * c).powf(1.5));
            let got = inverse_j0(|k| (-c * k).exp(), r, 1.0 / c);
            assert!((got - want).abs() < 1e-9 * (1.0 + want), "{r}: {got} {want}");
            let want = 1.0 - c / (r * r + c * c).sqrt();
            let got = encircled_j1(|k| (-c * k).exp(), r, 1.0 / c);
            assert!((got - want).abs() < 1e-9, "{r}: {got} {want}");
        }
    }

    #[test]
    fn a_tail_of_one_over_k_squared_is_summed() {
        // (1 - exp(-a k²))/(a k²) <-> E1(r²/4a)/(4 pi a); encircled: the integral of that, here by panels.
        let a = 0.4_f64;
        let f = |k: f64| if k == 0.0 { 1.0 } else { -(-a * k * k).exp_m1() / (a * k * k) };
        // E1(x) = ∫_0^∞ exp(-x e^v) dv, which is over where x e^v = 50.
        let e1 = |x: f64| integrate(0.0, (50.0 / x).ln(), 32, |v| (-x * v.exp()).exp());
        for r in [0.05, 0.5, 2.0] {
            let want = e1(r * r / (4.0 * a)) / (4.0 * PI * a);
            let got = inverse_j0(f, r, 1.0 / a.sqrt());
            assert!((got / want - 1.0).abs() < 1e-9, "{r}: {got} {want}");
        }
    }
}
