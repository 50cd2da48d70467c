//! The step of a Levenberg-Marquardt iteration within bounds.

use super::parameters::Bounds;
use nalgebra::{Matrix3, Vector3};

/// The least of g·s + ½ s·Ms over the steps s within `bounds`, which hold 0.
///
/// Cutting the unbounded step at the bounds will not do: where two parameters make nearly the same image, the rest of a step,
/// one of them cut, leads uphill. So each coordinate is tried free and on either bound.
pub(super) fn least_within(
    bounds: &[Bounds; 3],
    gradient: &Vector3<f64>,
    matrix: &Matrix3<f64>,
) -> Vector3<f64> {
    let model = |s: &Vector3<f64>| gradient.dot(s) + 0.5 * (matrix * s).dot(s);
    let within = |s: &Vector3<f64>| (0..3).all(|i| (bounds[i][0]..=bounds[i][1]).contains(&s[i]));
    let mut best = Vector3::zeros();
    for pick in 0..27 {
        let place = [pick % 3, pick / 3 % 3, pick / 9];
        let on = |i: usize| (place[i] < 2).then(|| bounds[i][place[i]]);
        let bound = Vector3::from_fn(|i, _| on(i).unwrap_or(0.0));
        if !bound.iter().all(|b| b.is_finite()) {
            continue;
        }
        let (mut system, mut right) = (*matrix, -(gradient + matrix * bound));
        for i in (0..3).filter(|&i| on(i).is_some()) {
            system.fill_row(i, 0.0);
            system.fill_column(i, 0.0);
            system[(i, i)] = 1.0;
            right[i] = 0.0;
        }
        let step = bound + solve(&system, &right);
        if within(&step) && model(&step) < model(&best) {
            best = step;
        }
    }
    best
}

/// Solution of a symmetric system, by Cholesky where it is positive and by the pseudo-inverse where it is not.
fn solve(matrix: &Matrix3<f64>, right: &Vector3<f64>) -> Vector3<f64> {
    match matrix.cholesky() {
        Some(cholesky) => cholesky.solve(right),
        None => {
            matrix.pseudo_inverse(f64::EPSILON).map_or_else(|_| Vector3::zeros(), |inverse| inverse * right)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_to_a_bound_leads_downhill() {
        // Of a fit at tau 12: ln sigma_s and sigma_a correlated to .997. The free step (.58, -.14, 0), cut, would lead uphill.
        let matrix = Matrix3::new(365_905.0, 1_474_454.0, 0.0, 1_474_454.0, 5_976_552.0, 0.0, 0.0, 0.0, 1.0);
        let gradient = Vector3::new(-2735.0, -6057.0, 0.0);
        let bounds = [[-0.139, 0.139], [-0.0972, 0.7], [0.0, 0.0]];
        let model = |s: &Vector3<f64>| gradient.dot(s) + 0.5 * (matrix * s).dot(s);
        let free = solve(&matrix, &-gradient);
        let cut = Vector3::from_fn(|i, _| free[i].clamp(bounds[i][0], bounds[i][1]));
        assert!(model(&cut) > 0.0, "{cut}");
        let found = least_within(&bounds, &gradient, &matrix);
        // sigma_s on its bound, and sigma_a where the gradient then vanishes.
        assert!((found[0] - 0.139).abs() < 1e-12 && (gradient + matrix * found)[1].abs() < 1e-6, "{found}");
        let wide = [[-1.0, 1.0], [-1.0, 1.0], [0.0, 0.0]];
        assert!((least_within(&wide, &gradient, &matrix) - free).norm() < 1e-9);
        let grid = (-20..=20).flat_map(|i| (-20..=20).map(move |j| [i, j]));
        for [i, j] in grid {
            let s = Vector3::new(0.139 * f64::from(i) / 20.0, 0.3 + 0.4 * f64::from(j) / 20.0, 0.0);
            assert!(s[1] < bounds[1][0] || model(&s) >= model(&found));
        }
    }
}
