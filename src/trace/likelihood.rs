//! The likelihood of a path under other media: what has to be recorded of it, and how its weight follows.
//!
//! The likelihood of a path with n scatterings by the angles theta_i and the length L is
//! sigma_s^n exp(-(sigma_s + sigma_a) L) prod p(theta_i) times factors that depend on no parameter. So the ratio of the likelihoods in
//! two media needs n, L and the change of sum ln p(theta_i), which is linear in what a path records of its deflections:
//!
//! - *Gaussian*, p = N(B) exp(-theta²/4B): the sum S of theta_i² is a sufficient statistic for every B.
//! - *Henyey-Greenstein* is no exponential family. A path records the change of its log-density at a few nodes of
//!   ln(1 - g) around that of its medium; between the nodes it is interpolated.

use crate::chebyshev::Chebyshev;
use crate::error::Result;
use crate::medium::Medium;
use crate::phase::{Gaussian, HenyeyGreenstein, PhaseFunction};
use std::fmt::Debug;

/// A phase function whose paths can be replayed with others of its family.
pub trait Likelihood: PhaseFunction + Copy + PartialEq {
    /// What a path records of its deflections, an array of f32.
    type Memory: AsRef<[f32]> + AsMut<[f32]> + Default + Copy + PartialEq + Debug + Send + Sync;

    /// This family's phase function of another parameter, B (rad²) or g.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if there is none.
    fn of_parameter(parameter: f64) -> Result<Self>;

    /// Largest difference in ln B or ln(1 - g) to another phase function with which paths of this one can be replayed.
    const FARTHEST: f64;

    /// Returns a function that adds a deflection to a path's memory.
    fn recorder(&self) -> impl Fn(f32, &mut Self::Memory) + Send + Sync;

    /// The change of a path's log-density from this phase function to another, no farther than [`FARTHEST`](Self::FARTHEST).
    fn change(&self, to: &Self) -> Change;
}

/// A change of log-density that is linear in n and in the path's memory: for each the coefficient, and its derivative
/// in the parameter of the phase function that it leads to.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    per_scattering: [f64; 2],
    per_memory: Vec<[f64; 2]>,
}

impl Likelihood for Gaussian {
    type Memory = [f32; 1];
    const FARTHEST: f64 = f64::INFINITY;

    fn of_parameter(parameter: f64) -> Result<Self> {
        Gaussian::new(parameter)
    }

    fn recorder(&self) -> impl Fn(f32, &mut Self::Memory) + Send + Sync {
        |angle, memory| memory[0] += angle * angle
    }

    fn change(&self, to: &Self) -> Change {
        let b = to.b();
        Change {
            per_scattering: [(to.eval(1.0) / self.eval(1.0)).ln(), -0.25 * to.mean_square_angle() / (b * b)],
            per_memory: vec![[0.25 / self.b() - 0.25 / b, 0.25 / (b * b)]],
        }
    }
}

/// Nodes of ln(1 - g) at which a path is recorded, and how far the outermost lie from its own. ln p has its singularities pi/2 off
/// the real axis of ln(1 - g), so five nodes leave an error of 1e-4 per scattering.
const NODES: usize = 5;
const HALF_WIDTH: f64 = 0.5;
/// Largest ln(1 - g) of a node: g stays above 0.
const MOST: f64 = -1e-3;

impl HenyeyGreenstein {
    fn nodes(&self) -> Chebyshev {
        let own = (1.0 - self.mean_cosine()).ln();
        Chebyshev::new(NODES, own - HALF_WIDTH, (own + HALF_WIDTH).min(MOST.max(own)))
    }
}

/// ln p of Henyey and Greenstein's phase function of mean cosine `g` at 1 - cos theta = `m`.
fn log_density(g: f64, m: f64) -> f64 {
    (1.0 - g * g).ln() - 1.5 * ((1.0 - g) * (1.0 - g) + 2.0 * g * m).ln()
}

impl Likelihood for HenyeyGreenstein {
    type Memory = [f32; NODES];
    const FARTHEST: f64 = HALF_WIDTH;

    fn of_parameter(parameter: f64) -> Result<Self> {
        HenyeyGreenstein::new(parameter)
    }

    fn recorder(&self) -> impl Fn(f32, &mut Self::Memory) + Send + Sync {
        let own = self.mean_cosine();
        let nodes: [f64; NODES] = std::array::from_fn(|i| -self.nodes().x[i].exp_m1());
        move |angle, memory| {
            let m = 2.0 * (0.5 * f64::from(angle)).sin().powi(2);
            let here = log_density(own, m);
            memory.iter_mut().zip(nodes).for_each(|(sum, g)| *sum += (log_density(g, m) - here) as f32);
        }
    }

    fn change(&self, to: &Self) -> Change {
        let (nodes, x) = (self.nodes(), (1.0 - to.mean_cosine()).ln());
        let rate = -1.0 / (1.0 - to.mean_cosine());
        let weights = nodes.basis(x).into_iter().zip(nodes.basis_slope(x));
        Change { per_scattering: [0.0; 2], per_memory: weights.map(|(w, slope)| [w, slope * rate]).collect() }
    }
}

/// Replays paths traced in one medium in another: gives their weights there.
#[derive(Debug, Clone)]
pub struct Replay {
    phase: Change,
    per_scattering: f64,
    per_length: f64,
    sigma_s: f64,
}

/// A path's weight in the other medium, and the derivatives of its logarithm in sigma_s, sigma_a and the phase-function
/// parameter.
#[derive(Debug, Clone, Copy)]
pub struct Weight {
    /// Ratio of the likelihoods.
    pub ratio: f64,
    /// d ln ratio.
    pub slopes: [f64; 3],
}

impl Replay {
    /// From the medium that the paths were traced in to another, its phase function no farther than
    /// [`FARTHEST`](Likelihood::FARTHEST).
    pub fn new<P: Likelihood>(from: &Medium<P>, to: &Medium<P>) -> Self {
        let phase = from.phase().change(to.phase());
        Self {
            per_scattering: (to.sigma_s() / from.sigma_s()).ln() + phase.per_scattering[0],
            per_length: from.sigma_s() + from.sigma_a() - to.sigma_s() - to.sigma_a(),
            sigma_s: to.sigma_s(),
            phase,
        }
    }

    /// The weight of a path with this number of `scatterings` and this `length`.
    #[inline]
    pub fn weight(&self, scatterings: u32, length: f32, memory: &[f32]) -> Weight {
        let (n, length) = (f64::from(scatterings), f64::from(length));
        let mut exponent = n * self.per_scattering + length * self.per_length;
        let mut parameter = n * self.phase.per_scattering[1];
        for (memory, [value, slope]) in memory.iter().zip(&self.phase.per_memory) {
            exponent += f64::from(*memory) * value;
            parameter += f64::from(*memory) * slope;
        }
        Weight { ratio: exponent.exp(), slopes: [n / self.sigma_s - length, -length, parameter] }
    }
}

/// How well paths of one medium serve another: the share of as many equally weighted paths that would give the same
/// variance.
#[derive(Debug, Clone, Copy, Default)]
pub struct EffectiveSampleSize {
    light: f64,
    weighted: f64,
    squared: f64,
}

impl EffectiveSampleSize {
    /// Counts a path that carries `light` in its own medium.
    pub fn add(&mut self, light: f64, ratio: f64) {
        self.light += light;
        self.weighted += light * ratio;
        self.squared += light * ratio * ratio;
    }

    /// Both samples together.
    pub fn and(self, other: Self) -> Self {
        Self {
            light: self.light + other.light,
            weighted: self.weighted + other.weighted,
            squared: self.squared + other.squared,
        }
    }

    /// Relative effective sample size (sum w)²/(N sum w²): 1 in the paths' own medium. Trace again where it is small.
    pub fn relative(&self) -> f64 {
        self.weighted * self.weighted / (self.light * self.squared).max(f64::MIN_POSITIVE)
    }
}

/// Variance of the [`slopes`](Weight::slopes) over paths: the Fisher information of a path about the medium.
#[derive(Debug, Clone, Copy, Default)]
pub struct Information {
    light: f64,
    sums: [[f64; 2]; 3],
}

impl Information {
    /// Counts a path that carries `light`.
    pub fn add(&mut self, light: f64, slopes: [f64; 3]) {
        self.light += light;
        for (sums, slope) in self.sums.iter_mut().zip(slopes) {
            sums[0] += light * slope;
            sums[1] += light * slope * slope;
        }
    }

    /// Both samples together.
    pub fn and(mut self, other: Self) -> Self {
        self.light += other.light;
        for (mine, theirs) in self.sums.iter_mut().flatten().zip(other.sums.iter().flatten()) {
            *mine += theirs;
        }
        self
    }

    /// The information of one path about sigma_s, sigma_a and the phase-function parameter.
    pub fn of_a_path(&self) -> [f64; 3] {
        let light = self.light.max(f64::MIN_POSITIVE);
        self.sums.map(|[sum, squares]| (squares / light - (sum / light).powi(2)).max(0.0))
    }
}
