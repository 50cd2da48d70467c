//! What to fit with.

use super::optimise::Method;
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
