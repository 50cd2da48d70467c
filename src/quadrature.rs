//! Gauss-Legendre panels, shared by everything that integrates numerically.

use gauss_quad::legendre::GaussLegendre;
use std::num::NonZeroUsize;
use std::sync::LazyLock;

const NODES: NonZeroUsize = NonZeroUsize::new(16).unwrap();
static RULE: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(NODES));

/// Integral of `f` over [a, b] by 16 Gauss-Legendre nodes on each of `panels` equal panels.
pub(crate) fn integrate(a: f64, b: f64, panels: usize, f: impl Fn(f64) -> f64) -> f64 {
    let h = (b - a) / panels as f64;
    (0..panels)
        .map(|i| {
            let left = a + h * i as f64;
            RULE.integrate(left, left + h, &f)
        })
        .sum()
}

/// Nodes and weights of the same rule, for integrands with several values.
pub(crate) fn nodes(a: f64, b: f64, panels: usize) -> Vec<(f64, f64)> {
    let h = (b - a) / panels as f64;
    (0..panels)
        .flat_map(|i| {
            let middle = a + h * (i as f64 + 0.5);
            RULE.iter().map(move |&(x, w)| (middle + 0.5 * h * x, 0.5 * h * w))
        })
        .collect()
}
