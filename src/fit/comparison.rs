//! A scene's filter beside its observation: from a medium to the sums that a fit needs, computed where the renders are.

use super::equations::Products;
use super::observed::Observed;
use crate::error::Result;
use crate::filter::gpu::GpuObservation;
use crate::filter::{Optics, Prepared};
use nalgebra::{Matrix6, Vector2};
use std::cell::Cell;

/// A prepared target and what its renders are compared with.
pub(super) struct Comparison<'a> {
    pub filter: Prepared<'a>,
    on_device: Option<OnDevice>,
}

struct OnDevice {
    observation: GpuObservation,
    /// Gain and veil of the last evaluation: the residual is formed with them, in f32, so they should be near.
    reference: Cell<Vector2<f64>>,
}

impl<'a> Comparison<'a> {
    pub(super) fn new(filter: Prepared<'a>, observed: &Observed) -> Result<Self> {
        let mut comparison = Self { filter, on_device: None };
        comparison.observe(observed)?;
        Ok(comparison)
    }

    /// Takes the pixels of `observed` that count now.
    pub(super) fn observe(&mut self, observed: &Observed) -> Result<()> {
        if let Prepared::Gpu(filter) = &self.filter {
            let observation = filter.observe(observed.values())?;
            let reference = Cell::new(observed.given_exposure());
            self.on_device = Some(OnDevice { observation, reference });
        }
        Ok(())
    }

    /// The sums of a render, with or without its derivatives.
    pub(super) fn products(
        &self,
        optics: &Optics,
        observed: &Observed,
        derivatives: bool,
    ) -> Result<Products> {
        match (&self.filter, &self.on_device) {
            (Prepared::Gpu(filter), Some(OnDevice { observation, reference })) => {
                let at = reference.get();
                let sums = filter.products(optics, observation, [at[0], at[1]], derivatives)?;
                // What the device used.
                let at = at.map(|v| f64::from(v as f32));
                let products = Products { reference: at, sums: Matrix6::from_fn(|i, j| sums[i][j]) };
                reference.set(observed.exposure(&products));
                Ok(products)
            }
            _ if derivatives => {
                let rendering = self.filter.render_with_gradient(optics)?;
                Ok(observed.products(&rendering.image, rendering.gradient.as_ref()))
            }
            _ => Ok(observed.products(&self.filter.render(optics)?, None)),
        }
    }
}
