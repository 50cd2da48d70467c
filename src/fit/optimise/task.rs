//! What is to be fitted, to what, and how.

use crate::error::Result;
use crate::fit::Settings;
use crate::fit::observation::{Alignment, Observation, Observed, Unseen};
use crate::fit::parameters::Parameters;
use crate::geometry::{PathLengths, path_lengths};
use crate::scene::FitOptions;

/// A fit of one channel.
#[derive(Clone, Copy)]
pub(crate) struct Task<'x, 'a> {
    /// The scenes.
    pub observations: &'x [Observation<'a>],
    /// The same, registered at first sight.
    pub registered: &'x [Observed<'x>],
    /// Where each observation lies at first sight; `None` where it is not to be registered.
    pub places: &'x [Option<Alignment>],
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

    /// Whether a fit has parameters of scenes beside those of the medium.
    pub(crate) fn has_nuisances(&self) -> bool {
        let has = |(o, place): (&Observation, &Option<Alignment>)| place.is_some() || o.imaging().is_some();
        self.observations.iter().zip(self.places).any(has)
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
        for (scene, (observation, place)) in self.observations.iter().zip(self.places).enumerate() {
            let begun = Alignment::begun(*place, observation.imaging());
            medium.add_scene(scene, self.places.len(), place.map(|p| p.shift_px), begun);
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

    /// Each scene's shares of light that no image shows.
    pub(crate) fn unseen(&self, parameters: &Parameters) -> Result<Vec<Unseen>> {
        let engine = self.settings.engine();
        let of = |(scene, o): (usize, &Observation)| {
            let state = parameters.state(scene)?;
            let hidden = engine.hidden_share(o.target, &state)?;
            Ok(Unseen { hidden, outside: engine.outside_share(o.target, &state)? })
        };
        self.observations.iter().enumerate().map(of).collect()
    }
}
