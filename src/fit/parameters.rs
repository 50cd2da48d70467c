//! The three parameters: values, what is free, bounds, and the map to the coordinates that a solver moves in.
//!
//! Internally u = (ln sigma_s, sigma_a, ln B or ln(1 - g)): positive quantities of unknown magnitude in logarithms,
//! absorption linear because 0 is a value that it takes. The third is the shape of the phase function, whose
//! [`Family`] says how.

use super::PathLengths;
use crate::error::{Error, Result, in_range};
use crate::phase::Family;
use crate::scene::FitOptions;
use crate::spread::Model;

/// Names in the order used everywhere, of media with phase functions of `family`.
pub const fn names(family: Family) -> [&'static str; 3] {
    ["sigma_s", "sigma_a", family.parameter_name()]
}

/// Those with the Gaussian phase function.
pub const NAMES: [&str; 3] = names(Family::Gaussian);

/// Lower and upper bound of a parameter.
pub type Bounds = [f64; 2];

/// sigma_s (1/length), sigma_a (1/length), and the shape of the phase function: B (rad²) or g.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    family: Family,
    values: [f64; 3],
    fixed: [bool; 3],
    /// The shape of a model that has no width: a value that means nothing.
    unused_shape: bool,
    bounds: [Bounds; 3],
}

/// Default bounds of sigma_s and sigma_a in units of the median path length z.
const DEFAULT_BOUNDS: [Bounds; 2] = [[1e-4, 60.0], [0.0, 30.0]];

/// Default bounds of the shape: B up to a spread angle of 60°; g up to a lobe as narrow as B's, and down to where it is hardly
/// a lobe.
fn default_shapes(family: Family, model: Model) -> Bounds {
    match (family, model) {
        (Family::Gaussian, Model::Traced) => [1e-8, WIDEST],
        (Family::Gaussian, _) => [1e-8, 0.274],
        (Family::HenyeyGreenstein, _) => [0.3, 0.9999],
    }
}
/// Widest lobe of a model without a range of its own, rad²: the same in all directions to a tenth.
const WIDEST: f64 = 25.0;

impl Parameters {
    /// Parameters as the user asks for them, values not yet chosen where neither fixed nor started.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where a fixed or starting value lies outside its range, or a bound beyond what `model` has
    /// kernels for; [`Error::NothingToFit`] if all are fixed; those of [`Model::range`].
    pub fn new(options: &FitOptions, model: Model, lengths: PathLengths) -> Result<Self> {
        let family = options.family;
        let range = model.range(family)?;
        let limits: [Bounds; 3] =
            [[0.0, range.tau / lengths.longest], [0.0, range.absorption / lengths.longest], range.phase];
        let [of_sigma_s, of_sigma_a] = DEFAULT_BOUNDS.map(|pair| pair.map(|v| v / lengths.median));
        let mut bounds = [of_sigma_s, of_sigma_a, default_shapes(family, model)];
        let mut values = [0.0; 3];
        let mut fixed = [false; 3];
        for (i, name) in names(family).into_iter().enumerate() {
            let [least, largest] = limits[i];
            bounds[i] = [bounds[i][0].max(least), bounds[i][1].min(largest)];
            // The default bounds give way to a start that the user wants.
            let [low, high] = bounds[i];
            let start = options.start[i].filter(|s| s.is_finite()).unwrap_or(low);
            bounds[i] = options.bounds[i].unwrap_or([low.min(start), high.max(start)]);
            let [low, high] = bounds[i];
            let beyond = "what model wide-angle has kernels for: at the longest path, sigma_s z up to 12, sigma_a z up to 10; \
                          a spread angle up to 60 degrees, or g from .5 on; --model traced has no such end";
            let key = format!("[fit] bounds or start of {name}");
            in_range(&key, high, high <= largest, beyond)?;
            in_range(&key, low, low >= least, beyond)?;
            if let Some(value) = options.fixed[i] {
                let key = format!("[fit] fixed.{name}");
                in_range(&key, value, (least..=largest).contains(&value) || !value.is_finite(), beyond)?;
                let (ok, allowed) = match i {
                    2 => (family.allows(value), family.allowed()),
                    _ => (value.is_finite() && value >= 0.0, "finite and at least 0"),
                };
                values[i] = in_range(&key, value, ok, allowed)?;
                fixed[i] = true;
            } else {
                let start = options.start[i].unwrap_or(0.5 * (low + high));
                let key = format!("[fit] start.{name}");
                values[i] = in_range(&key, start, (low..=high).contains(&start), "within its bounds")?;
            }
        }
        let unused_shape = !model.spreads() && !fixed[2];
        fixed[2] |= unused_shape;
        if fixed.iter().all(|f| *f) {
            return Err(Error::NothingToFit("[fit] fixed: every parameter is fixed".into()));
        }
        Ok(Self { family, values, fixed, unused_shape, bounds })
    }

    /// The family of the phase function.
    pub fn family(&self) -> Family {
        self.family
    }

    /// Names of the parameters.
    pub fn names(&self) -> [&'static str; 3] {
        names(self.family)
    }

    /// sigma_s, sigma_a and the shape.
    pub fn values(&self) -> [f64; 3] {
        self.values
    }

    /// Whether parameter `i` is held.
    pub fn is_fixed(&self, i: usize) -> bool {
        self.fixed[i]
    }

    /// Whether parameter `i` is none of the model's and was not given either.
    pub fn is_placeholder(&self, i: usize) -> bool {
        i == 2 && self.unused_shape
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

    /// Coordinate of parameter `i` at `value`.
    pub fn coordinate(&self, i: usize, value: f64) -> f64 {
        match i {
            0 => value.ln(),
            1 => value,
            _ => self.family.coordinate(value),
        }
    }

    /// Value of parameter `i` at the coordinate `u`.
    pub fn value_at(&self, i: usize, u: f64) -> f64 {
        match i {
            0 => u.exp(),
            1 => u,
            _ => self.family.parameter_at(u),
        }
    }

    /// d value / d coordinate of parameter `i` where it is; below 0 for g, whose coordinate falls.
    pub fn slope(&self, i: usize) -> f64 {
        match i {
            0 => self.values[0],
            1 => 1.0,
            _ => self.family.slope(self.values[2]),
        }
    }

    /// Coordinates (ln sigma_s, sigma_a, ln B or ln(1 - g)).
    pub(super) fn internal(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.coordinate(i, self.values[i]))
    }

    /// Bounds of the coordinates.
    pub(super) fn internal_bounds(&self) -> [Bounds; 3] {
        std::array::from_fn(|i| {
            let [low, high] = self.bounds[i].map(|v| self.coordinate(i, v));
            if low <= high { [low, high] } else { [high, low] }
        })
    }

    /// Takes the free values from coordinates.
    pub(super) fn set_internal(&mut self, u: &[f64; 3]) {
        for (i, &u) in u.iter().enumerate() {
            self.set(i, self.value_at(i, u));
        }
    }

    /// These parameters at other coordinates.
    pub(super) fn at(&self, u: &[f64; 3]) -> Self {
        let mut other = self.clone();
        other.set_internal(u);
        other
    }

    /// These parameters with another shape, be it free or not.
    pub(super) fn with_shape(&self, shape: f64) -> Self {
        let mut other = self.clone();
        other.values[2] = shape;
        other
    }

    /// d value / d coordinate at `u`; 0 for a fixed parameter.
    pub(super) fn chain(&self, u: &[f64; 3]) -> [f64; 3] {
        let there = self.at(u);
        std::array::from_fn(|i| if self.fixed[i] { 0.0 } else { there.slope(i) })
    }

    /// Whether the coordinate of parameter `i` is a logarithm.
    pub fn is_logarithmic(i: usize) -> bool {
        i != 1
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
