//! The three parameters: values, what is free, bounds, and the map to the coordinates that a solver moves in.
//!
//! Internally u = (ln sigma_s, sigma_a, ln B): positive quantities of unknown magnitude in logarithms, absorption
//! linear because 0 is a value that it takes.

use crate::error::{Error, Result, in_range};
use crate::scene::FitOptions;
use crate::spread::Model;

/// Names in the order used everywhere.
pub const NAMES: [&str; 3] = ["sigma_s", "sigma_a", "b"];

/// Whether a parameter moves in logarithm.
const LOGARITHMIC: [bool; 3] = [true, false, true];

/// Lower and upper bound of a parameter.
pub type Bounds = [f64; 2];

/// sigma_s (1/length), sigma_a (1/length), B (rad²).
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    values: [f64; 3],
    fixed: [bool; 3],
    /// B of a model that has no width: a value that means nothing.
    unused_b: bool,
    bounds: [Bounds; 3],
}

/// Path lengths of all pixels of all scenes, length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLengths {
    /// Their median.
    pub median: f64,
    /// The longest.
    pub longest: f64,
}

/// Default bounds in units of the median path length z: sigma_s z, sigma_a z; and B in rad² (a spread angle of 60°).
const DEFAULT_BOUNDS: [Bounds; 3] = [[1e-4, 60.0], [0.0, 30.0], [1e-8, 0.274]];
/// Widest default lobe of a model that is right at every angle, rad²: the same in all directions to a tenth.
const WIDEST: f64 = 25.0;

impl Parameters {
    /// Parameters as the user asks for them, values not yet chosen where neither fixed nor started.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where a fixed or starting value lies outside its range, or a bound beyond what `model` has
    /// kernels for; [`Error::NothingToFit`] if all are fixed.
    pub fn new(options: &FitOptions, model: Model, lengths: PathLengths) -> Result<Self> {
        let mut largest = model.largest();
        largest[..2].iter_mut().for_each(|v| *v /= lengths.longest);
        let mut values = [0.0; 3];
        let mut fixed = [false; 3];
        let mut bounds = DEFAULT_BOUNDS;
        if model == Model::Traced {
            bounds[2][1] = WIDEST;
        }
        for i in 0..3 {
            if i < 2 {
                bounds[i] = bounds[i].map(|v| v / lengths.median);
            }
            bounds[i][1] = bounds[i][1].min(largest[i]);
            // The default bounds give way to a start that the user wants.
            let [low, high] = bounds[i];
            let start = options.start[i].filter(|s| s.is_finite()).unwrap_or(low);
            bounds[i] = options.bounds[i].unwrap_or([low.min(start), high.max(start)]);
            let [low, high] = bounds[i];
            let beyond = "what model wide-angle has kernels for: at the longest path, sigma_s z up to 12, sigma_a z up to 10; \
                          a spread angle up to 60 degrees; --model traced has no such end";
            let name = format!("[fit] bounds or start of {}", NAMES[i]);
            in_range(&name, high, high <= largest[i], beyond)?;
            if let Some(value) = options.fixed[i] {
                in_range(
                    &format!("[fit] fixed.{}", NAMES[i]),
                    value,
                    value <= largest[i] || !value.is_finite(),
                    beyond,
                )?;
                let ok = value.is_finite() && if i == 2 { value > 0.0 } else { value >= 0.0 };
                let allowed = if i == 2 { "finite and above 0" } else { "finite and at least 0" };
                values[i] = in_range(&format!("[fit] fixed.{}", NAMES[i]), value, ok, allowed)?;
                fixed[i] = true;
            } else {
                let start = options.start[i].unwrap_or(0.5 * (low + high));
                let name = format!("[fit] start.{}", NAMES[i]);
                values[i] = in_range(&name, start, (low..=high).contains(&start), "within its bounds")?;
            }
        }
        let unused_b = !model.spreads() && !fixed[2];
        fixed[2] |= unused_b;
        if fixed.iter().all(|f| *f) {
            return Err(Error::NothingToFit("[fit] fixed: every parameter is fixed".into()));
        }
        Ok(Self { values, fixed, unused_b, bounds })
    }

    /// sigma_s, sigma_a, B.
    pub fn values(&self) -> [f64; 3] {
        self.values
    }

    /// Whether parameter `i` is held.
    pub fn is_fixed(&self, i: usize) -> bool {
        self.fixed[i]
    }

    /// Whether parameter `i` is none of the model's and was not given either.
    pub fn is_placeholder(&self, i: usize) -> bool {
        i == 2 && self.unused_b
    }

    /// Number of free parameters.
    pub fn free_count(&self) -> usize {
        self.fixed.iter().filter(|f| !**f).count()
    }

    /// Bounds of parameter `i`.
    pub fn bounds(&self, i: usize) -> Bounds {
        self.bounds[i]
    }

    /// Sets the value of parameter `i`, moved into its bounds; a fixed one keeps its value.
    pub(super) fn set(&mut self, i: usize, value: f64) {
        if !self.fixed[i] {
            self.values[i] = value.clamp(self.bounds[i][0], self.bounds[i][1]);
        }
    }

    /// Coordinates (ln sigma_s, sigma_a, ln B).
    pub(super) fn internal(&self) -> [f64; 3] {
        std::array::from_fn(|i| if LOGARITHMIC[i] { self.values[i].ln() } else { self.values[i] })
    }

    /// Bounds of the coordinates.
    pub(super) fn internal_bounds(&self) -> [Bounds; 3] {
        std::array::from_fn(|i| if LOGARITHMIC[i] { self.bounds[i].map(f64::ln) } else { self.bounds[i] })
    }

    /// Takes the free values from coordinates.
    pub(super) fn set_internal(&mut self, u: &[f64; 3]) {
        for i in 0..3 {
            self.set(i, if LOGARITHMIC[i] { u[i].exp() } else { u[i] });
        }
    }

    /// These parameters at other coordinates.
    pub(super) fn at(&self, u: &[f64; 3]) -> Self {
        let mut other = self.clone();
        other.set_internal(u);
        other
    }

    /// These parameters with another B, be it free or not.
    pub(super) fn with_b(&self, b: f64) -> Self {
        let mut other = self.clone();
        other.values[2] = b;
        other
    }

    /// d value / d coordinate at `u`; 0 for a fixed parameter.
    pub(super) fn chain(&self, u: &[f64; 3]) -> [f64; 3] {
        let values = self.at(u).values;
        std::array::from_fn(|i| match (self.fixed[i], LOGARITHMIC[i]) {
            (true, _) => 0.0,
            (false, true) => values[i],
            (false, false) => 1.0,
        })
    }

    /// Whether parameter `i` moves in logarithm.
    pub fn is_logarithmic(i: usize) -> bool {
        LOGARITHMIC[i]
    }

    /// Free parameters that lie on one of their bounds.
    pub fn at_bound(&self) -> Vec<usize> {
        let on = |i: usize| {
            let [low, high] = self.bounds[i];
            self.values[i] <= low * (1.0 + 1e-9) || self.values[i] >= high * (1.0 - 1e-9)
        };
        (0..3).filter(|&i| !self.fixed[i] && on(i)).collect()
    }
}
