//! The parameters of the medium, as the user asks for them.

use super::Coordinate;
use super::parameter::{Bounds, Descriptor, Parameter, Role};
use crate::error::{Result, in_range};
use crate::forward::Quantity;
use crate::geometry::PathLengths;
use crate::phase::Family;
use crate::scene::{FitOptions, ParameterOptions};
use crate::spread::Model;

/// Default bounds of sigma_s and sigma_a in units of 1 over the median path length z.
const SIGMA_S: Bounds = [1e-4, 60.0];
const SIGMA_A: Bounds = [0.0, 30.0];

/// Default bounds of B: up to a spread angle of 60°.
const B: Bounds = [1e-8, 0.274];
/// The same of a model that has no range of its own: the widest is the same in all directions to a tenth.
const B_OF_ANY_ANGLE: Bounds = [1e-8, 25.0];
/// Default bounds of g: from where forward scattering begins to stand out, up to a phase function as narrow as B's.
const G: Bounds = [0.3, 0.9999];

/// Longest step in a logarithm; that of sigma_a is set by its bounds.
const LONGEST_STEP: f64 = 1.5;

const BEYOND: &str = "what model wide-angle has kernels for: at the longest path, sigma_s z up to 12, sigma_a z up to 10; \
                      a spread angle up to 60 degrees, or g from 0.5 on; model traced has no such end";

/// What one parameter of a medium may be.
struct Allowed {
    quantity: Quantity,
    name: &'static str,
    unit: &'static str,
    coordinate: Coordinate,
    /// Default bounds, and the ends of what the model has kernels for.
    default: Bounds,
    limits: Bounds,
    scale: f64,
    longest_step: f64,
}

/// sigma_s, sigma_a and the parameter of the phase function; values not yet chosen where neither fixed nor started.
pub(super) fn medium(options: &FitOptions, model: Model, lengths: PathLengths) -> Result<Vec<Parameter>> {
    let family = options.family;
    let range = model.range(family)?;
    let per_length = |bounds: Bounds| bounds.map(|v| v / lengths.median);
    let phase = match (family, model) {
        (Family::Gaussian, Model::Traced) => B_OF_ANY_ANGLE,
        (Family::Gaussian, _) => B,
        (Family::HenyeyGreenstein, _) => G,
    };
    let all = [
        (
            &options.sigma_s,
            Allowed {
                quantity: Quantity::SigmaS,
                name: "sigma_s",
                unit: "1/length",
                coordinate: Coordinate::Logarithm,
                default: per_length(SIGMA_S),
                limits: [0.0, range.tau / lengths.longest],
                scale: 1.0,
                longest_step: LONGEST_STEP,
            },
        ),
        (
            &options.sigma_a,
            Allowed {
                quantity: Quantity::SigmaA,
                name: "sigma_a",
                unit: "1/length",
                coordinate: Coordinate::Linear,
                default: per_length(SIGMA_A),
                limits: [0.0, range.absorption / lengths.longest],
                scale: 1.0 / lengths.median,
                longest_step: f64::INFINITY,
            },
        ),
        (
            &options.phase,
            Allowed {
                quantity: Quantity::Phase,
                name: family.parameter_name(),
                unit: family.unit(),
                coordinate: Coordinate::Phase(family),
                default: phase,
                limits: range.phase,
                scale: 1.0,
                longest_step: LONGEST_STEP,
            },
        ),
    ];
    all.into_iter().map(|(wanted, allowed)| allowed.parameter(wanted, family, model)).collect()
}

impl Allowed {
    fn parameter(self, wanted: &ParameterOptions, family: Family, model: Model) -> Result<Parameter> {
        let Self { quantity, name, .. } = self;
        let bounds = self.bounds(wanted)?;
        let (role, value) = match wanted.fixed {
            Some(value) => (Role::Fixed, self.fixed(value, family)?),
            None => {
                let [low, high] = bounds;
                let start = wanted.start.unwrap_or(0.5 * (low + high));
                let inside = (low..=high).contains(&start);
                (Role::Free, in_range(&format!("start.{name}"), start, inside, "within its bounds")?)
            }
        };
        let unused = quantity == Quantity::Phase && !model.spreads() && role == Role::Free;
        let descriptor = Descriptor {
            name: name.into(),
            unit: self.unit,
            quantity,
            scene: None,
            coordinate: self.coordinate,
            bounds,
            role: if unused { Role::Absent } else { role },
            scale: self.scale,
            longest_step: self.longest_step,
        };
        Ok(Parameter::new(descriptor, value))
    }

    /// The bounds that are wanted, or the default ones, which give way to a start.
    fn bounds(&self, wanted: &ParameterOptions) -> Result<Bounds> {
        let [least, largest] = self.limits;
        let (low, high) = (self.default[0].max(least), self.default[1].min(largest));
        let start = wanted.start.filter(|s| s.is_finite()).unwrap_or(low);
        let [low, high] = wanted.bounds.unwrap_or([low.min(start), high.max(start)]);
        let key = format!("bounds or start of {}", self.name);
        in_range(&key, high, high <= largest, BEYOND)?;
        in_range(&key, low, low >= least, BEYOND)?;
        Ok([low, high])
    }

    fn fixed(&self, value: f64, family: Family) -> Result<f64> {
        let key = format!("fixed.{}", self.name);
        let [least, largest] = self.limits;
        in_range(&key, value, (least..=largest).contains(&value) || !value.is_finite(), BEYOND)?;
        match self.quantity {
            Quantity::Phase => in_range(&key, value, family.allows(value), family.allowed()),
            _ => in_range(&key, value, value.is_finite() && value >= 0.0, "finite and at least 0"),
        }
    }
}
