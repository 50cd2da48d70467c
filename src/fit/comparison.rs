//! A scene's filter beside its observation: from a medium to the sums that a fit needs, computed where the renders are.

use super::equations::Products;
use super::observed::Observed;
use super::{Parameters, Settings, with_optics};
use crate::error::Result;
use crate::filter::cpu::Rendering;
use crate::filter::gpu::GpuObservation;
use crate::filter::{Optics, Prepared};
use crate::image::Image;
use nalgebra::{Matrix6, Vector2};
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// A prepared target and what its renders are compared with.
pub(super) struct Comparison<'a> {
    pub filter: Prepared<'a>,
    /// Parameter values, and what the CPU rendered there with derivatives: an optimum is looked at more than once.
    latest: RefCell<Option<([f64; 3], Rc<Rendering>)>>,
    on_device: Option<OnDevice>,
}

struct OnDevice {
    observation: GpuObservation,
    /// Gain and veil of the last evaluation: the residual is formed with them, in f32, so they should be near.
    reference: Cell<Vector2<f64>>,
}

impl<'a> Comparison<'a> {
    pub(super) fn new(filter: Prepared<'a>, observed: &Observed) -> Result<Self> {
        let mut comparison = Self { filter, latest: RefCell::new(None), on_device: None };
        comparison.observe(observed)?;
        Ok(comparison)
    }

    /// Takes the pixels of `observed` that count now.
    pub(super) fn observe(&mut self, observed: &Observed) -> Result<()> {
        if let Prepared::Gpu(filter) = &self.filter {
            let observation = filter.observe(observed.values().into_iter())?;
            let reference = Cell::new(observed.given_exposure());
            self.on_device = Some(OnDevice { observation, reference });
        }
        Ok(())
    }

    /// The sums of a render and its derivatives at `parameters`.
    pub(super) fn products(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        observed: &Observed,
    ) -> Result<Products> {
        if self.on_device.is_some() {
            return with_optics(parameters, settings.model, |optics| self.on_device(optics, observed, true));
        }
        let rendering = self.rendering(parameters, settings)?;
        Ok(observed.products(&rendering.image, rendering.gradient.as_ref()))
    }

    /// The sums of a render alone.
    pub(super) fn levels(&self, optics: &Optics, observed: &Observed) -> Result<Products> {
        if self.on_device.is_some() {
            return self.on_device(optics, observed, false);
        }
        Ok(observed.products(&self.filter.render(optics)?, None))
    }

    /// The image at `parameters`.
    pub(super) fn image(&self, parameters: &Parameters, settings: &Settings) -> Result<Image> {
        if self.on_device.is_some() {
            return with_optics(parameters, settings.model, |optics| self.filter.render(optics));
        }
        Ok(self.rendering(parameters, settings)?.image.clone())
    }

    fn rendering(&self, parameters: &Parameters, settings: &Settings) -> Result<Rc<Rendering>> {
        let values = parameters.values();
        if let Some((of, rendering)) = &*self.latest.borrow()
            && *of == values
        {
            return Ok(Rc::clone(rendering));
        }
        let render = |optics: &Optics| self.filter.render_with_gradient(optics);
        let rendering = Rc::new(with_optics(parameters, settings.model, render)?);
        *self.latest.borrow_mut() = Some((values, Rc::clone(&rendering)));
        Ok(rendering)
    }

    fn on_device(&self, optics: &Optics, observed: &Observed, derivatives: bool) -> Result<Products> {
        let (Prepared::Gpu(filter), Some(on_device)) = (&self.filter, &self.on_device) else {
            unreachable!("asked for where there is a device");
        };
        let OnDevice { observation, reference } = on_device;
        // The device holds f32.
        let at = reference.get().map(|v| f64::from(v as f32));
        let sums = filter.products(optics, observation, [at[0], at[1]], derivatives, None)?;
        let products = Products { reference: at, sums: Matrix6::from_fn(|i, j| sums[(i, j)]) };
        reference.set(observed.exposure(&products));
        Ok(products)
    }
}
