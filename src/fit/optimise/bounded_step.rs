//! The step of a Levenberg-Marquardt iteration within bounds.

use crate::fit::parameters::Bounds;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Rounds after which the search for the active bounds is given up, for each coordinate.
const MOST_ROUNDS: usize = 4;

/// The least of g·s + ½ s·Ms over the steps s within `bounds`, which hold 0.
///
/// Cutting the unbounded step at the bounds will not do: where two parameters make nearly the same image, the rest of a step,
/// one of them cut, leads uphill. So this is an active-set search (Stark and Parker 1995): coordinates on a bound are let go
/// if the gradient leads inwards, and a step that would leave the bounds ends at the first that it meets.
pub(super) fn least_within(
    bounds: &[Bounds],
    gradient: &DVector<f64>,
    matrix: &DMatrix<f64>,
) -> DVector<f64> {
    let movable: Vec<usize> = (0..bounds.len()).filter(|&i| bounds[i][0] < bounds[i][1]).collect();
    let matrix = &positive(matrix, &movable);
    let mut step = DVector::zeros(bounds.len());
    let mut free = movable.clone();
    for _ in 0..MOST_ROUNDS * bounds.len() {
        let target = minimum(&free, &step, gradient, matrix);
        let limit =
            free.iter().filter_map(|&i| reach(&bounds[i], step[i], target[i]).map(|share| (share, i)));
        match limit.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((share, stopped)) => {
                let [low, high] = bounds[stopped];
                let bound = if target[stopped] < low { low } else { high };
                step += (target - &step) * share;
                step[stopped] = bound;
                free.retain(|&i| i != stopped);
            }
            None => {
                step = target;
                let slope = gradient + matrix * &step;
                let inward = |i: usize| if step[i] <= bounds[i][0] { -slope[i] } else { slope[i] };
                let held = movable.iter().copied().filter(|i| !free.contains(i));
                match held.filter(|&i| inward(i) > 0.0).max_by(|&a, &b| inward(a).total_cmp(&inward(b))) {
                    Some(released) => free.push(released),
                    None => return step,
                }
            }
        }
    }
    step
}

/// The minimum over the coordinates `free`, the others held where `step` has them.
fn minimum(
    free: &[usize],
    step: &DVector<f64>,
    gradient: &DVector<f64>,
    matrix: &DMatrix<f64>,
) -> DVector<f64> {
    let mut held = step.clone();
    free.iter().for_each(|&i| held[i] = 0.0);
    let slope = gradient + matrix * &held;
    let system = matrix.select_rows(free).select_columns(free);
    let found = solve(system, &-slope.select_rows(free));
    free.iter().zip(&found).for_each(|(&i, v)| held[i] = *v);
    held
}

/// Share of the way from `from` to `to` after which a bound is met; `None` if none is.
fn reach([low, high]: &Bounds, from: f64, to: f64) -> Option<f64> {
    if to < *low {
        Some((low - from) / (to - from))
    } else if to > *high {
        Some((high - from) / (to - from))
    } else {
        None
    }
}

/// `matrix`, whose block of the coordinates `movable` is positive: a matrix of products of noisy renders need not be, and a step
/// along a direction of negative curvature would lead uphill. There the magnitude of the curvature counts.
fn positive(matrix: &DMatrix<f64>, movable: &[usize]) -> DMatrix<f64> {
    let block = matrix.select_rows(movable).select_columns(movable);
    let mut positive = matrix.clone();
    if block.clone().cholesky().is_some() {
        return positive;
    }
    let eigen = SymmetricEigen::new(block);
    let least = f64::EPSILON * eigen.eigenvalues.amax().max(f64::MIN_POSITIVE);
    let curvatures = DMatrix::from_diagonal(&eigen.eigenvalues.map(|v| v.abs().max(least)));
    let block = &eigen.eigenvectors * curvatures * eigen.eigenvectors.transpose();
    for (i, &row) in movable.iter().enumerate() {
        for (j, &column) in movable.iter().enumerate() {
            positive[(row, column)] = block[(i, j)];
        }
    }
    positive
}

/// Solution of a symmetric positive system.
fn solve(matrix: DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let size = right.len();
    matrix.cholesky().map_or_else(|| DVector::zeros(size), |cholesky| cholesky.solve(right))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(gradient: &DVector<f64>, matrix: &DMatrix<f64>, s: &DVector<f64>) -> f64 {
        gradient.dot(s) + 0.5 * (matrix * s).dot(s)
    }

    #[test]
    fn a_step_to_a_bound_leads_downhill() {
        // Of a fit at tau 12: ln sigma_s and sigma_a correlated to 0.997. The free step (0.58, -0.14, 0), cut, would lead uphill.
        let matrix = DMatrix::from_row_slice(
            3,
            3,
            &[365_905.0, 1_474_454.0, 0.0, 1_474_454.0, 5_976_552.0, 0.0, 0.0, 0.0, 1.0],
        );
        let gradient = DVector::from_vec(vec![-2735.0, -6057.0, 0.0]);
        let bounds = [[-0.139, 0.139], [-0.0972, 0.7], [0.0, 0.0]];
        let free = solve(matrix.clone(), &-&gradient);
        let cut = DVector::from_fn(3, |i, _| free[i].clamp(bounds[i][0], bounds[i][1]));
        assert!(model(&gradient, &matrix, &cut) > 0.0, "{cut}");
        let found = least_within(&bounds, &gradient, &matrix);
        // sigma_s on its bound, and sigma_a where the gradient then vanishes.
        assert!(
            (found[0] - 0.139).abs() < 1e-12 && (&gradient + &matrix * &found)[1].abs() < 1e-6,
            "{found}"
        );
        let wide = [[-1.0, 1.0], [-1.0, 1.0], [0.0, 0.0]];
        assert!((least_within(&wide, &gradient, &matrix) - free).norm() < 1e-9);
        let grid = (-20..=20).flat_map(|i| (-20..=20).map(move |j| [i, j]));
        for [i, j] in grid {
            let s =
                DVector::from_vec(vec![0.139 * f64::from(i) / 20.0, 0.3 + 0.4 * f64::from(j) / 20.0, 0.0]);
            assert!(
                s[1] < bounds[1][0] || model(&gradient, &matrix, &s) >= model(&gradient, &matrix, &found)
            );
        }
    }

    #[test]
    fn negative_curvature_leads_downhill_all_the_same() {
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 3.0, 3.0, 1.0]);
        let gradient = DVector::from_vec(vec![1.0, -0.5]);
        let step = least_within(&[[-0.1, 0.1], [-0.1, 0.1]], &gradient, &matrix);
        assert!(gradient.dot(&step) < 0.0 && step.amax() <= 0.1, "{step}");
    }

    #[test]
    fn five_coordinates_end_where_no_feasible_neighbour_is_lower() {
        let n = 5;
        let root = DMatrix::from_fn(n, n, |i, j| ((3 * i + 7 * j + i * j) % 11) as f64 / 11.0 - 0.4);
        let matrix = &root * root.transpose() + DMatrix::identity(n, n) * 0.05;
        for turn in 0..20 {
            let gradient = DVector::from_fn(n, |i, _| ((5 * i + 3 * turn) % 13) as f64 - 6.0);
            let bounds = [[-0.5, 0.8], [0.0, 1.0], [-2.0, 0.0], [-0.1, 0.1], [-1.0, 3.0]];
            let found = least_within(&bounds, &gradient, &matrix);
            let slope = &gradient + &matrix * &found;
            for (i, [low, high]) in bounds.into_iter().enumerate() {
                assert!((low..=high).contains(&found[i]), "{i}: {found}");
                // The conditions of Karush, Kuhn and Tucker: no way leads down.
                assert!(found[i] <= low || slope[i] < 1e-9, "{i}: {slope}");
                assert!(found[i] >= high || slope[i] > -1e-9, "{i}: {slope}");
            }
        }
    }
}
