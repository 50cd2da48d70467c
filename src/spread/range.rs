//! How far a model goes.

/// The media for which a model has kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Largest sigma_s z.
    pub tau: f64,
    /// Largest sigma_a z.
    pub absorption: f64,
    /// Least and largest parameter of the phase function, B (rad²) or g.
    pub phase: [f64; 2],
}
