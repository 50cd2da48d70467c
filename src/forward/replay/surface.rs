//! Any surface: paths of its own for every pixel, followed to the real surface with its edges, slopes and layers.

use super::{Paths, Tracing, of_family};
use crate::error::Result;
use crate::filter::Target;
use crate::forward::Rendering;
use crate::medium::Medium;
use crate::trace::{BATCHES, Hits, ImageConfig, Likelihood};
use std::ops::Range;

/// Paths of all pixels of a scene together, 12 to 28 bytes for each that meets light: at 128² px as noisy as an observation of 1 %.
pub(super) const SURFACE_PATHS: u64 = 1 << 24;

/// Traces the paths of all pixels of `target`'s view.
pub(super) fn traced<P: Likelihood>(
    target: Target,
    medium: &Medium<P>,
    tracing: Tracing,
    seed: u64,
) -> Result<Hits<P>> {
    let samples = tracing.count(SURFACE_PATHS).div_ceil(target.view.pixels() as u64) as u32;
    let config = ImageConfig {
        geometry: target.geometry,
        radiance: target.radiance,
        behind: target.behind,
        border: target.border,
        view: target.view,
        medium: *medium,
        samples: samples.max(2 * BATCHES as u32),
        seed,
    };
    Hits::trace(&config, &|_| ())
}

impl<P: Likelihood> Paths for Hits<P> {
    fn render(&self, medium: &Medium, batches: Range<usize>) -> Result<Rendering> {
        let [image, sigma_s, sigma_a, phase] = self.image(&of_family(medium)?, batches)?;
        Ok(Rendering::of_medium(image, [sigma_s, sigma_a, phase]))
    }

    fn relative_sample_size(&self, medium: &Medium) -> Result<f64> {
        Ok(Hits::relative_sample_size(self, &of_family(medium)?))
    }

    fn information(&self) -> [f64; 3] {
        let [sigma_s, _, phase] = Hits::information(self).of_a_path();
        // Absorption takes no part in the drawing of the paths: any serves.
        [sigma_s, 0.0, phase]
    }

    fn farthest(&self) -> f64 {
        P::FARTHEST
    }

    fn count(&self) -> u64 {
        self.paths()
    }
}
