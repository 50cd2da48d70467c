//! How far an estimate moves when the images that it is made from change, to first order: one Gauss-Newton step.

use super::observed::Observed;
use super::renders::Renders;
use super::{Datum, Exposure, Parameters, Problem, Settings, Source, Uncertainty};
use crate::error::Result;
use crate::image::Image;
use nalgebra::Vector3;

/// A fit at its optimum.
pub(super) struct Displacement<'x, 'a> {
    pub data: &'x [Datum<'a>],
    pub observed: &'x [Observed<'a>],
    pub renders: &'x mut Renders<'a>,
    pub parameters: &'x Parameters,
    pub uncertainty: &'x Uncertainty,
    pub exposures: &'x [Exposure],
    pub settings: &'x Settings<'a>,
}

impl Displacement<'_, '_> {
    /// What happens to the coordinates if the object light of every scene is that of `images`; and the root mean square
    /// difference of these from the best fit, in units of a pixel's noise.
    pub fn towards(&mut self, images: Vec<Image>) -> Result<(Vector3<f64>, f64)> {
        let scenes = images.into_iter().zip(self.exposures).zip(self.data);
        let exposed: Vec<Image> = scenes.map(|((i, e), d)| e.apply(i, d.veil)).collect();
        let seen: Vec<Observed> = self.observed.iter().zip(&exposed).map(|(o, i)| o.seen_as(i)).collect();
        for (i, seen) in seen.iter().enumerate() {
            self.renders.observe(i, seen)?;
        }
        let problem = Problem::new(Source::Renders(self.renders), &seen, self.parameters, self.settings);
        let equations = problem.equations(&self.parameters.internal())?;
        let image = (2.0 * equations.cost.max(0.0) / equations.pixels.max(1) as f64).sqrt();
        Ok((self.uncertainty.step(&equations.gradient), image))
    }

    /// Where one batch of the paths of the model `traced` would lead the coordinates.
    pub fn by_batch(&self, batch: usize) -> Result<Vector3<f64>> {
        let source = Source::Batch(self.renders, batch);
        let problem = Problem::new(source, self.observed, self.parameters, self.settings);
        Ok(self.uncertainty.step(&problem.equations(&self.parameters.internal())?.gradient))
    }
}
