//! Where each method fails, and whether it reports that.
//!
//! Images are traced: paths in three dimensions, which have nothing in common with the models but the medium. A *silent failure*
//! is an estimate without a warning that is farther from the truth than four standard errors and the stated model error
//! together (added as in `ci95`), and neither undetermined nor refused.

use super::setting::Setting;
use crate::error::Result;
use crate::filter::{Backend, Filter};
use crate::fit::{
    Id, Method as Solver, Parameter, SceneFit, Settings, Severity, WarningCode, fit_scenes, free_camera,
    select,
};
use crate::forward::Quantity;
use crate::imaging::Choice;
use crate::scene::{ObservedScene, Veil};
use crate::spread::Model;
use std::time::Instant;

/// Standard errors beyond which an error cannot be due to chance.
const FAILURE: f64 = 4.0;
/// Standard errors within which an estimate is right.
const RIGHT: f64 = 3.0;
/// Warnings that a scene is outside the range of the model: its angles, its table, or a view that shows too little of the
/// kernel.
const OUTSIDE: [WarningCode; 4] = [
    WarningCode::OutsideValidity,
    WarningCode::ModelError,
    WarningCode::ModelErrorUnknown,
    WarningCode::WideKernel,
];
/// `--tolerance` of the automatic choice of a model.
const TOLERANCE: f64 = 0.01;

/// A model, or the automatic choice of one, with a solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// `None` lets the program choose.
    pub model: Option<Model>,
    /// The optimiser.
    pub solver: Solver,
    /// Whether what its camera does is left to the fit: registration, blur, gain field and veil.
    pub frees_camera: bool,
}

impl Method {
    /// `model` with Levenberg-Marquardt.
    pub const fn of(model: Model) -> Self {
        Self { model: Some(model), solver: Solver::LevenbergMarquardt, frees_camera: false }
    }

    /// The automatic choice with Levenberg-Marquardt.
    pub const AUTO: Self = Self { model: None, solver: Solver::LevenbergMarquardt, frees_camera: false };

    /// The same, with the camera.
    pub const CAMERA: Self = Self { frees_camera: true, ..Self::AUTO };

    /// `model` with Nelder and Mead's simplex.
    pub const fn simplex(model: Model) -> Self {
        Self { solver: Solver::NelderMead, ..Self::of(model) }
    }

    /// Name in tables and maps.
    pub fn name(self) -> String {
        let model = self.model.map_or("auto", Model::name);
        match self.solver {
            _ if self.frees_camera => format!("{model}, camera"),
            Solver::LevenbergMarquardt => model.to_string(),
            Solver::NelderMead => format!("{model}, nelder-mead"),
        }
    }

    /// Fits `scene`.
    ///
    /// # Errors
    /// As [`fit_scenes`].
    pub fn fit(self, scene: &ObservedScene, backend: Backend) -> Result<SceneFit> {
        let settings = Settings {
            model: self.model.unwrap_or(Model::SmallAngle),
            backend,
            method: self.solver,
            gram: self.solver == Solver::LevenbergMarquardt,
            ..Settings::default()
        };
        let fit = |scenes: &[ObservedScene]| match self.model {
            Some(_) => fit_scenes(scenes, &settings, Filter::Auto, &|| ()),
            None => select(scenes, &settings, Filter::Auto, TOLERANCE, &|| ()),
        };
        if !self.frees_camera {
            return fit(std::slice::from_ref(scene));
        }
        let exact = Settings { model: self.model.unwrap_or(Model::WideAngle), ..settings };
        let probe = |scenes: &[ObservedScene]| fit_scenes(scenes, &exact, Filter::Auto, &|| ());
        free_camera(&mut [opened(scene)], fit, probe)
    }

    /// Fits `scene` and compares the outcome with the truth, for the parameters `compared`.
    pub fn try_on(self, scene: &ObservedScene, setting: &Setting, compared: &[Quantity]) -> Outcome {
        let clock = Instant::now();
        let mut outcome = Outcome::new(self.fit(scene, Backend::Cpu), setting, compared);
        outcome.seconds = clock.elapsed().as_secs_f64();
        outcome
    }
}

/// `scene` with all of its camera left to the fit.
fn opened(scene: &ObservedScene) -> ObservedScene {
    let mut scene = scene.clone();
    let observation = &mut scene.observation;
    (observation.registration, observation.blur) = (Choice::Auto, Choice::Auto);
    (observation.gain_field, observation.veil) = (Choice::Auto, Veil::Auto);
    scene
}

/// What is known of one parameter after a fit; errors in ln sigma_s, sigma_a z and ln B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The parameter.
    pub quantity: Quantity,
    /// Estimate minus truth.
    pub error: f64,
    /// Standard error due to the noise and to errors of the input.
    pub std_error: f64,
    /// Stated error of the model.
    pub model_error: f64,
    /// Whether the 95 % interval contains the truth.
    pub held: bool,
}

impl Found {
    /// The largest error that agrees with the stated ones.
    fn allowed(&self) -> f64 {
        FAILURE * self.std_error + self.model_error
    }
}

/// How a fit ended.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outcome {
    /// The model that was fitted or chosen.
    pub model: String,
    /// Each parameter that was determined and has a truth.
    pub found: Vec<Found>,
    /// Whether some parameter was reported as undetermined.
    pub undetermined: bool,
    /// Codes of warnings that are a caution or worse, except `undetermined`.
    pub warnings: Vec<WarningCode>,
    /// Why there is no fit.
    pub refused: Option<String>,
    /// Time that it took, seconds.
    pub seconds: f64,
}

impl Outcome {
    fn new(fit: Result<SceneFit>, setting: &Setting, compared: &[Quantity]) -> Self {
        let fit = match fit {
            Ok(fit) => fit,
            Err(error) => return Self { refused: Some(error.to_string()), ..Self::default() },
        };
        let channel = &fit.channels[0].1;
        let found = |(id, parameter): (Id, &Parameter)| {
            let quantity = parameter.descriptor().quantity;
            let std_error = channel.covariance.std_error(id).filter(|_| compared.contains(&quantity))?;
            let (along, truth) = (channel.parameters.along(id), setting.truth(quantity));
            let input_error = channel.input_error.variance_of(&along).sqrt();
            let parts = channel.model_errors(&along);
            let model_error = parts.iter().map(|(_, error)| error * error).sum::<f64>().sqrt();
            // Of sigma_a the scale is 1 over the path length.
            let scale = parameter.scale();
            Some(Found {
                quantity,
                error: (parameter.coordinate() - parameter.coordinate_of(truth)) / scale,
                std_error: std_error.hypot(input_error) / scale,
                model_error: model_error / scale,
                held: fit.report.parameters[parameter.name()]
                    .ci95
                    .is_some_and(|[low, high]| low <= truth && truth <= high),
            })
        };
        let serious = fit.report.warnings.iter().filter(|w| w.severity >= Severity::Caution);
        let codes = serious.map(|w| w.code);
        Self {
            model: fit.report.model.clone(),
            found: channel.parameters.of_medium().filter_map(found).collect(),
            undetermined: channel.covariance.leaves_open(),
            warnings: codes.filter(|&code| code != WarningCode::Undetermined).collect(),
            refused: None,
            seconds: 0.0,
        }
    }

    /// The result for `quantity`.
    pub fn of(&self, quantity: Quantity) -> Option<&Found> {
        self.found.iter().find(|found| found.quantity == quantity)
    }

    /// The largest error of a parameter; `None` if none was determined.
    pub fn worst(&self) -> Option<f64> {
        self.found.iter().map(|f| f.error.abs()).reduce(f64::max)
    }

    /// What is allowed for the parameter with the largest error.
    pub fn allowed(&self) -> Option<f64> {
        let worst = self.found.iter().max_by(|a, b| a.error.abs().total_cmp(&b.error.abs()))?;
        Some(worst.allowed())
    }

    /// Whether an estimate is wrong without a warning.
    pub fn is_silent_failure(&self) -> bool {
        self.warnings.is_empty() && self.found.iter().any(|f| f.error.abs() > f.allowed())
    }

    /// Whether everything is determined and right to within the noise, so that no warning is needed.
    pub fn is_right(&self) -> bool {
        self.refused.is_none()
            && !self.undetermined
            && self.found.iter().all(|f| f.error.abs() <= RIGHT * f.std_error)
    }

    /// Whether everything is right but there is a warning, other than that the model is outside its range.
    pub fn is_false_alarm(&self) -> bool {
        self.is_right() && !self.warnings.is_empty() && !self.warnings.iter().any(|w| OUTSIDE.contains(w))
    }

    /// The kind of outcome, for maps and tables.
    pub fn kind(&self) -> OutcomeKind {
        match self {
            _ if self.refused.is_some() => OutcomeKind::Refused,
            _ if self.is_silent_failure() => OutcomeKind::Silent,
            _ if self.is_false_alarm() => OutcomeKind::FalseAlarm,
            _ if !self.warnings.is_empty() => OutcomeKind::Warned,
            _ if self.undetermined => OutcomeKind::Undetermined,
            _ => OutcomeKind::Right,
        }
    }
}

/// The kinds of outcomes of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum OutcomeKind {
    /// Within the stated errors.
    Right,
    /// Within three standard errors, but with a warning.
    FalseAlarm,
    /// Reported as undetermined.
    Undetermined,
    /// With a warning.
    Warned,
    /// Not fitted, with a reason.
    Refused,
    /// Wrong, without a warning.
    Silent,
}

impl OutcomeKind {
    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::FalseAlarm => "right, but warned of",
            Self::Undetermined => "undetermined",
            Self::Warned => "warned of",
            Self::Refused => "refused",
            Self::Silent => "silent failure",
        }
    }
}
