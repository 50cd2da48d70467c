//! Score tests of all causes of one scene.

use super::SIGNIFICANT;
use super::cause::Cause;
use super::columns::Columns;
use super::finding::Finding;
use super::frame::Frame;
use super::noise::Noise;
use super::projected::{Projected, pseudo_inverse};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Causes named one after the other, at most.
const MOST: usize = 6;
/// Share of the drop of chi² by the best cause with which another explains the same.
const AS_WELL: f64 = 0.6;
/// Standard deviations from which on a direction among the columns of a cause says something.
const TELLS: f64 = 3.0;
/// Share of the first cause's drop of chi² below which others may be what its own second order leaves.
const SECOND_ORDER: f64 = 0.01;
/// Share of the square of a column that must be left when what was fitted is taken out: renders are f32.
const LEFT: f64 = 1e-6;

/// Tests of one scene.
pub(super) struct Scores<'x> {
    causes: Vec<(Cause, Vec<usize>)>,
    errors: usize,
    projected: &'x Projected,
    /// Products of what is left of errors, causes and residual when the causes that were named are taken out, too.
    products: DMatrix<f64>,
    /// Variance of the noise along each cause.
    variances: Vec<f64>,
}

/// One cause, tested.
struct Test {
    number: usize,
    amplitudes: DVector<f64>,
    covariance: DMatrix<f64>,
    delta_chi2: f64,
    significance: f64,
}

impl<'x> Scores<'x> {
    pub(super) fn new(frame: &Frame, columns: &Columns, projected: &'x Projected, noise: &Noise) -> Self {
        let causes = columns.causes();
        let variance = |(_, numbers): &(Cause, Vec<usize>)| {
            let inflation = |&number: &usize| {
                let parts = DMatrix::from_columns(&[projected.column(number)]);
                let column = frame.combinations(&parts).remove(0);
                let square: f64 = column.iter().map(|v| v * v).sum();
                noise.covariance(frame, &column, &column) / square.max(f64::MIN_POSITIVE)
            };
            // Noise that alternates has next to none along a smooth column: a tenth of white noise at least.
            numbers.iter().map(inflation).fold(0.1 * noise.variance, f64::max)
        };
        let variances = if noise.is_white() {
            vec![noise.variance; causes.len()]
        } else {
            causes.iter().map(variance).collect()
        };
        Self {
            variances,
            causes,
            errors: columns.error_count(),
            projected,
            products: projected.products.clone(),
        }
    }

    /// The faults of scene number `scene`, the largest drop of chi² first.
    pub(super) fn findings(mut self, scene: usize) -> Vec<Finding> {
        let mut findings = Vec::new();
        while findings.len() < MOST {
            let tests: Vec<Test> = (0..self.causes.len()).filter_map(|number| self.test(number)).collect();
            // Known errors make every large score the same number of standard deviations: the drop of chi² ranks them.
            let significant = tests.iter().filter(|test| test.significance > SIGNIFICANT);
            let best = significant.max_by(|a, b| a.delta_chi2.total_cmp(&b.delta_chi2));
            let Some(best) = best else { break };
            let first = findings.first().map_or(0.0, |first: &Finding| first.delta_chi2);
            if best.delta_chi2 < SECOND_ORDER * first {
                break;
            }
            let numbers = self.causes[best.number].1.clone();
            self.take_out(&numbers);
            let as_well = |test: &&Test| {
                let after = self.test(test.number).map_or(0.0, |after| after.significance);
                test.number != best.number
                    && test.delta_chi2 > AS_WELL * best.delta_chi2
                    && after < test.significance.sqrt().max(SIGNIFICANT)
            };
            let alternatives = tests.iter().filter(as_well).map(|test| self.causes[test.number].0).collect();
            findings.push(self.finding(best, scene, alternatives));
        }
        findings
    }

    fn finding(&self, test: &Test, scene: usize, alternatives: Vec<Cause>) -> Finding {
        let (cause, numbers) = &self.causes[test.number];
        let amplitude = test.amplitudes.norm();
        let along = &test.amplitudes / amplitude.max(f64::MIN_POSITIVE);
        let first = numbers.iter().zip(&test.amplitudes);
        let mut bias: DVector<f64> = first.map(|(&i, a)| self.projected.bias.column(i) * *a).sum();
        if *cause == Cause::Shift {
            bias += self.blur_of(amplitude);
        }
        Finding {
            cause: *cause,
            alternatives,
            scene,
            amplitude: if numbers.len() == 1 { test.amplitudes[0] } else { amplitude },
            std_error: along.dot(&(&test.covariance * &along)).max(0.0).sqrt(),
            delta_chi2: test.delta_chi2,
            significance: test.significance,
            bias,
        }
    }

    /// What a shift by `px` adds to the coordinates in second order: to first order it is all but orthogonal to the medium, but half its
    /// square is the variance of a blur.
    fn blur_of(&self, px: f64) -> DVector<f64> {
        let blur = self.causes.iter().find(|(cause, _)| *cause == Cause::Blur);
        let column = |number: usize| self.projected.bias.column(number) * (0.5 * px * px);
        blur.map_or_else(|| DVector::zeros(self.projected.bias.nrows()), |(_, numbers)| column(numbers[0]))
    }

    /// The test of cause number `number`; `None` if what was fitted leaves nothing of its columns.
    fn test(&self, number: usize) -> Option<Test> {
        let numbers = &self.causes[number].1;
        let residual = self.projected.count();
        let is_left = |&i: &usize| self.products[(i, i)] > LEFT * self.projected.squares[i];
        if !numbers.iter().all(is_left) {
            return None;
        }
        let score =
            DVector::from_iterator(numbers.len(), numbers.iter().map(|&i| self.products[(i, residual)]));
        let information = self.products.select_rows(numbers).select_columns(numbers);
        let by_errors = self.products.select_rows(numbers).columns(0, self.errors).into_owned();
        let covariance = &information * self.variances[number] + &by_errors * by_errors.transpose();
        let statistic = score.dot(&(pseudo_inverse(covariance.clone()) * &score));
        let inverse = pseudo_inverse(information.clone());
        let amplitudes = shown(&information, &score, self.variances[number]);
        Some(Test {
            number,
            delta_chi2: score.dot(&(&inverse * &score)),
            covariance: &inverse * covariance * &inverse,
            amplitudes,
            significance: significance(statistic, numbers.len() as f64),
        })
    }

    /// Projects the columns `numbers` out of all others.
    fn take_out(&mut self, numbers: &[usize]) {
        let across = self.products.select_rows(numbers);
        let inverse = pseudo_inverse(across.select_columns(numbers));
        self.products -= across.transpose() * inverse * &across;
    }
}

/// The amplitudes that a `score` shows, by its `information` and the variance of its noise. Directions in which it says nothing have none: they would
/// only carry noise into what is said of the estimates.
fn shown(information: &DMatrix<f64>, score: &DVector<f64>, variance: f64) -> DVector<f64> {
    let scale = information.diagonal().map(|v| 1.0 / v.sqrt());
    let scaled = DMatrix::from_diagonal(&scale) * information * DMatrix::from_diagonal(&scale);
    let (eigen, score) = (SymmetricEigen::new(scaled), score.component_mul(&scale));
    let mut amplitudes = DVector::zeros(score.len());
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        let along = vector.dot(&score);
        if *value > LEFT && along.abs() > TELLS * (value * variance).sqrt() {
            amplitudes += vector * (along / value);
        }
    }
    amplitudes.component_mul(&scale)
}

/// A chi² with `freedom` degrees of freedom as a quantile of the normal distribution, by Chernoff's bound of its tail.
fn significance(chi2: f64, freedom: f64) -> f64 {
    (chi2 - (freedom - 1.0) * (1.0 + (chi2 / freedom).max(1.0).ln())).max(0.0).sqrt()
}
