//! Spread kernels through the depth-dependent filter.

use super::products::{Pixels, Products};
use super::quantity::State;
use super::{ForwardModel, Rendering};
#[cfg(feature = "gpu")]
use super::{device::OnDevice, products::Exposure};
use crate::error::Result;
use crate::filter::{Coverage, Optics, Prepared};
use crate::image::Image;
use crate::spread::Model;
use std::cell::RefCell;
use std::rc::Rc;

/// A scene prepared for the filter.
pub(super) struct Filtered<'a> {
    model: Model,
    filter: Prepared<'a>,
    /// The latest state, and what was rendered there with derivatives: an optimum is looked at more than once.
    latest: RefCell<Option<(State, Rc<Rendering>)>>,
    #[cfg(feature = "gpu")]
    on_device: Option<OnDevice>,
}

impl<'a> Filtered<'a> {
    pub(super) fn new(model: Model, filter: Prepared<'a>) -> Self {
        Self {
            model,
            filter,
            latest: RefCell::new(None),
            #[cfg(feature = "gpu")]
            on_device: None,
        }
    }

    fn optics(&self, state: &State) -> Optics {
        Optics { model: self.model, medium: state.medium }
    }

    /// The light that arrives unscattered.
    pub(super) fn direct(&self, state: &State) -> Result<Image> {
        self.render(&Optics { model: Model::BeerLambert, medium: state.medium }, state)
    }

    fn render(&self, optics: &Optics, state: &State) -> Result<Image> {
        match state.shift_px {
            Some(shift_px) => self.filter.render_shifted(optics, shift_px),
            None => self.filter.render(optics),
        }
    }

    fn rendered(&self, state: &State) -> Result<Rc<Rendering>> {
        if let Some((of, rendering)) = &*self.latest.borrow()
            && of == state
        {
            return Ok(Rc::clone(rendering));
        }
        let optics = self.optics(state);
        let rendering = match state.shift_px {
            Some(shift_px) => self.filter.render_shifted_with_gradient(&optics, shift_px)?,
            None => self.filter.render_with_gradient(&optics)?,
        };
        let rendering = Rc::new(Rendering::from(rendering));
        *self.latest.borrow_mut() = Some((*state, Rc::clone(&rendering)));
        Ok(rendering)
    }

    /// The products computed on the device, if the filter is there.
    #[cfg(feature = "gpu")]
    fn on_device(&self, state: &State, derivatives: bool) -> Option<Result<Products>> {
        let on_device = self.on_device.as_ref()?;
        Some(on_device.products(&self.filter, &self.optics(state), state, derivatives))
    }

    #[cfg(not(feature = "gpu"))]
    fn on_device(&self, _state: &State, _derivatives: bool) -> Option<Result<Products>> {
        None
    }
}

impl ForwardModel for Filtered<'_> {
    fn image(&self, state: &State) -> Result<Image> {
        match &*self.latest.borrow() {
            Some((of, rendering)) if of == state => Ok(rendering.image.clone()),
            _ => self.render(&self.optics(state), state),
        }
    }

    fn rendering(&self, state: &State) -> Result<Rendering> {
        Ok((*self.rendered(state)?).clone())
    }

    fn products(&self, state: &State, pixels: &Pixels) -> Result<Products> {
        if let Some(products) = self.on_device(state, true) {
            return products;
        }
        Ok(Products::over(pixels, &*self.rendered(state)?))
    }

    fn levels(&self, state: &State, pixels: &Pixels) -> Result<Products> {
        if let Some(products) = self.on_device(state, false) {
            return products;
        }
        let image = self.render(&self.optics(state), state)?;
        Ok(Products::over(pixels, &Rendering::level(image)))
    }

    #[cfg(feature = "gpu")]
    fn observe(&mut self, pixels: &Pixels) -> Result<()> {
        self.on_device = OnDevice::new(&self.filter, pixels)?;
        Ok(())
    }

    #[cfg(feature = "gpu")]
    fn refer_to(&self, exposure: Exposure) {
        if let Some(on_device) = &self.on_device {
            on_device.refer_to(exposure);
        }
    }

    fn coverage(&self, state: &State) -> Result<Coverage> {
        self.filter.coverage(&self.optics(state))
    }

    fn transforms(&self) -> usize {
        self.filter.transforms().1
    }
}
