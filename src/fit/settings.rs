//! What to fit with. Every room of `fit` may read it; it knows none.

use crate::filter::Backend;
use crate::forward::{Engine, Tracing};
use crate::spread::Model;

/// What to fit with.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// The spread model.
    pub model: Model,
    /// What renders.
    pub backend: Backend<'a>,
    /// The optimiser.
    pub method: Method,
    /// Iterations after which a fit is given up.
    pub max_iterations: u64,
    /// Whether to find the optimum by Gram matrices where a scene allows it, instead of by renders.
    pub gram: bool,
    /// What the model `traced` traces.
    pub tracing: Tracing,
}

impl<'a> Settings<'a> {
    /// What makes the forward models.
    pub(super) fn engine(&self) -> Engine<'a> {
        Engine { model: self.model, backend: self.backend, tracing: self.tracing }
    }

    /// The same with the model and what it needs from `engine`.
    pub(super) fn with(&self, engine: Engine<'a>) -> Self {
        let Engine { model, backend, tracing } = engine;
        Self { model, backend, tracing, ..*self }
    }
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self {
            model: Model::SmallAngle,
            backend: Backend::Cpu,
            method: Method::LevenbergMarquardt,
            max_iterations: 200,
            gram: true,
            tracing: Tracing::default(),
        }
    }
}

/// Choice of optimiser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// Damped Gauss-Newton with analytic derivatives (Levenberg 1944, Marquardt 1963).
    LevenbergMarquardt,
    /// Simplex without derivatives (Nelder and Mead 1965).
    NelderMead,
}

impl Method {
    /// All optimisers.
    pub const ALL: [Method; 2] = [Method::LevenbergMarquardt, Method::NelderMead];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Method::LevenbergMarquardt => "levenberg-marquardt",
            Method::NelderMead => "nelder-mead",
        }
    }
}
