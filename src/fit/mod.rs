//! Fitting a medium to observed images: sigma_s, sigma_a and B or g of one channel from any number of scenes.
//!
//! The residual of a pixel is r = (gain · I + veil - observed) / noise, I being the rendered object light, and noise one number a
//! scene or the root of each pixel's variance. A free gain or veil enters linearly and is eliminated at every step (variable
//! projection, Golub and Pereyra 1973); the rest is a damped Gauss-Newton iteration in the [coordinates](Coordinate) of the
//! parameters.
//!
//! Data go one way: [`Observation`] → forward model ([`crate::forward`]) → normal equations → optimum (`optimise`) → what is
//! known ([`ChannelFit`], `inference`) → [`Fit`], the report. [`select()`] chooses a model, [`forecast()`] and [`advise`] plan
//! measurements.

mod channel;
mod design;
mod inference;
mod interval;
mod observation;
mod optimise;
mod parameters;
mod report;
mod scenes;
mod select;
mod settings;
mod slips;

pub use channel::fit_channel;
pub use design::{Advice, Plan, add_advice, advise, forecast};
pub use inference::{
    Cause, ChannelFit, Combination, Covariance, ErrorSource, ExposureEstimate, Finding, InputError,
    ModelError, Status,
};
pub use interval::{Draws, Intervals, bootstrap, profile};
pub use observation::{NoiseTerm, Observation, VeilTerm, white_noise as noise};
pub use optimise::{HEADROOM, PathsUsed};
pub use parameters::{Bounds, Coordinate, Descriptor, Id, Parameter, Parameters, Role};
pub use report::{
    AdviceReport, BackendReport, BlurReport, CameraStep, Candidate, Derived, Determined, DiagnosisReport,
    Estimate, ExposureReport, FieldReport, Fit, InputFile, Provenance, Regime, RegistrationErrors,
    RegistrationReport, ResolvedSettings, Severity, Summary, Term, TracedSummary, Warning, WarningCode, Ways,
};
pub use scenes::{SceneFit, check_scenes, fit_scenes};
pub use select::{
    SEQUENCE, filter_is_weak, free_camera, leave_out_tracing, select, trace_instead, tracing_seconds,
};
pub use settings::{Method, Settings};
pub use slips::slips;
