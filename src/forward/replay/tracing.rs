//! How many paths are traced, and by which random numbers.

/// Most that are traced for a scene, for the sake of memory.
pub const MOST_PATHS: u64 = 1 << 26;
/// Share of them with which the medium is sought.
const FEW: f64 = 0.125;

/// What the model `traced` traces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracing {
    /// Paths a scene, at most [`MOST_PATHS`]; `None` leaves it to the program.
    pub paths: Option<u64>,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Share of the paths that is traced.
    share: f64,
}

impl Tracing {
    /// So many `paths` a scene, by random numbers of this `seed`.
    pub fn new(paths: Option<u64>, seed: u64) -> Self {
        Self { paths, seed, share: 1.0 }
    }

    pub(crate) fn fewer(self) -> Self {
        Self { share: FEW, ..self }
    }

    pub(super) fn are_few(self) -> bool {
        self.share < 1.0
    }

    pub(super) fn count(self, default: u64) -> u64 {
        (self.share * self.paths.unwrap_or(default).min(MOST_PATHS) as f64).ceil() as u64
    }
}

impl Default for Tracing {
    fn default() -> Self {
        Self::new(None, 1)
    }
}
