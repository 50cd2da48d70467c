//! The optimisation problem: from parameters to normal equations, by renders or by sums.

use super::equations::{NormalEquations, Products};
use super::observed::Observed;
use super::renders::{self, Renders};
use super::sums::Sums;
use super::{Bounds, Parameters, Settings};
use crate::error::{Error, Result};
use crate::filter::Optics;
use crate::medium::Medium;
use crate::spread::Model;

/// What the sums of products of a problem come from.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    Renders(&'a Renders<'a>),
    /// One batch of the paths of the model `traced` against all others.
    Batch(&'a Renders<'a>, usize),
    Sums(&'a [Sums<'a>]),
}

/// The optimisation problem handed to a solver: parameters in, normal equations out.
pub(crate) struct Problem<'a> {
    source: Source<'a>,
    observed: &'a [Observed<'a>],
    parameters: &'a Parameters,
    settings: &'a Settings<'a>,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        source: Source<'a>,
        observed: &'a [Observed<'a>],
        parameters: &'a Parameters,
        settings: &'a Settings<'a>,
    ) -> Self {
        Self { source, observed, parameters, settings }
    }

    pub(crate) fn parameters(&self) -> &Parameters {
        self.parameters
    }

    /// Bounds of the coordinates, and of what is trusted of the source.
    pub(crate) fn bounds(&self) -> [Bounds; 3] {
        let bounds = self.parameters.internal_bounds();
        match self.source {
            Source::Renders(renders) => renders::within(bounds, renders.trust()),
            _ => bounds,
        }
    }

    /// Cost, gradient and Gauss-Newton matrix at the internal point `u`.
    pub(crate) fn equations(&self, u: &[f64; 3]) -> Result<NormalEquations> {
        let parameters = self.parameters.at(u);
        let products = match self.source {
            Source::Renders(renders) => renders.products(&parameters, self.settings, self.observed)?,
            Source::Batch(renders, batch) => renders.products_of_batch(&parameters, self.observed, batch)?,
            Source::Sums(sums) => with_optics(&parameters, self.settings.model, |optics| {
                sums.iter().map(|s| s.products(optics)).collect()
            })?,
        };
        finite(self.compare(&products, self.parameters.chain(u)), &parameters)
    }

    /// Cost alone at the internal point `u`.
    pub(crate) fn cost(&self, u: &[f64; 3]) -> Result<f64> {
        match self.source {
            Source::Renders(renders) => {
                let products = renders.levels(&self.parameters.at(u), self.settings, self.observed)?;
                Ok(self.compare(&products, [0.0; 3]).cost)
            }
            Source::Batch(..) | Source::Sums(_) => Ok(self.equations(u)?.cost),
        }
    }

    fn compare(&self, products: &[Products], chain: [f64; 3]) -> NormalEquations {
        let mut sum = NormalEquations::default();
        for (observed, products) in self.observed.iter().zip(products) {
            sum.add(observed.compare(products, chain));
        }
        sum
    }
}

fn finite(equations: NormalEquations, parameters: &Parameters) -> Result<NormalEquations> {
    if equations.is_finite() {
        Ok(equations)
    } else {
        let place: Vec<String> =
            parameters.names().iter().zip(parameters.values()).map(|(n, v)| format!("{n} = {v}")).collect();
        Err(Error::NotFinite(format!("the cost is not finite at {}", place.join(", "))))
    }
}

/// Calls `f` with the optics that the parameter values describe.
pub(crate) fn with_optics<T>(
    parameters: &Parameters,
    model: Model,
    f: impl FnOnce(&Optics) -> Result<T>,
) -> Result<T> {
    let [sigma_s, sigma_a, shape] = parameters.values();
    f(&Optics { model, medium: Medium::new(sigma_s, sigma_a, parameters.family().phase(shape)?)? })
}
