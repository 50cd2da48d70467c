//! What is to be fitted, to what, and how.

use crate::error::Result;
use crate::fit::Settings;
use crate::fit::observation::{Observation, Observed};
use crate::fit::parameters::Parameters;
use crate::geometry::{PathLengths, path_lengths};
use crate::image::Image;
use crate::scene::FitOptions;

/// A fit of one channel.
#[derive(Clone, Copy)]
pub(crate) struct Task<'x, 'a> {
    /// The scenes.
    pub observations: &'x [Observation<'a>],
    /// The same, registered at first sight.
    pub registered: &'x [Observed<'x>],
    /// The shift of each observation at first sight, px; `None` where it is not to be registered.
    pub shifts_px: &'x [Option<[f64; 2]>],
    /// What the user asks for.
    pub options: &'x FitOptions,
    /// What to fit with.
    pub settings: &'x Settings<'a>,
    /// Called after every render.
    pub progress: &'x dyn Fn(),
}

impl<'x> Task<'x, '_> {
    /// Path lengths of all scenes.
    pub(crate) fn lengths(&self) -> PathLengths {
        let scenes: Vec<_> =
            self.observations.iter().map(|o| (o.target.geometry, o.target.radiance)).collect();
        path_lengths(&scenes)
    }

    /// Whether some observation is registered by the fit.
    pub(crate) fn registers(&self) -> bool {
        self.shifts_px.iter().any(Option::is_some)
    }

    /// Whether the noise of some scene is to be estimated.
    pub(crate) fn estimates_noise(&self) -> bool {
        self.observations.iter().any(|o| o.noise.is_none())
    }

    /// The parameters of the medium, values not yet chosen, and of the scenes, at first sight.
    ///
    /// # Errors
    /// As [`Parameters::new`].
    pub(crate) fn with_nuisances(&self, mut medium: Parameters) -> Parameters {
        for (scene, shift_px) in self.shifts_px.iter().enumerate() {
            if let Some(start_px) = shift_px {
                medium.add_shift(scene, self.shifts_px.len(), *start_px);
            }
        }
        medium
    }

    /// The registered observations with the noise that `observed` have now.
    pub(crate) fn weighted_as(&self, observed: &[Observed]) -> Vec<Observed<'x>> {
        let weighted = |(registered, observed): (&Observed<'x>, &Observed)| {
            let mut registered = registered.clone();
            registered.noise = observed.noise;
            registered
        };
        self.registered.iter().zip(observed).map(weighted).collect()
    }

    /// Each scene's share of hidden light.
    pub(crate) fn hidden_shares(&self, parameters: &Parameters) -> Result<Vec<Option<Image>>> {
        let (engine, medium) = (self.settings.engine(), parameters.medium()?);
        self.observations.iter().map(|o| engine.hidden_share(o.target, medium)).collect()
    }
}
