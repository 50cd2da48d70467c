//! Products of renders and observation, computed on the graphics adapter that renders.

use super::products::{Exposure, Pixels, Products, Veil};
use super::quantity::{Quantity, State};
use crate::error::Result;
use crate::filter::gpu::GpuObservation;
use crate::filter::{Optics, Prepared};
use std::cell::Cell;

/// An observation on the device.
pub(super) struct OnDevice {
    observation: GpuObservation,
    /// Where residuals are formed: in f32, so it should be near the best exposure.
    reference: Cell<Exposure>,
}

impl OnDevice {
    /// `pixels` on the device of `filter`; `None` if it has none.
    pub(super) fn new(filter: &Prepared, pixels: &Pixels) -> Result<Option<Self>> {
        let Prepared::Gpu(filter) = filter else { return Ok(None) };
        // The device knows a constant veil alone.
        if pixels.veil_terms > 1 {
            return Ok(None);
        }
        let observation = filter.observe(pixels.values().into_iter())?;
        Ok(Some(Self { observation, reference: Cell::new(pixels.reference) }))
    }

    /// Products by `filter`, which made this; the derivatives count as 0 unless they are wanted.
    pub(super) fn products(
        &self,
        filter: &Prepared,
        optics: &Optics,
        state: &State,
        derivatives: bool,
    ) -> Result<Products> {
        let Prepared::Gpu(filter) = filter else { unreachable!("made by a filter on a device") };
        let Exposure { gain, veil: Veil([veil, ..]) } = self.reference.get();
        // The device holds f32.
        let [gain, veil] = [gain, veil].map(|v| f64::from(v as f32));
        let matrix = filter.products(optics, &self.observation, [gain, veil], derivatives, state.shift_px)?;
        let of_shift = if state.shift_px.is_some() { &Quantity::SHIFT[..] } else { &[] };
        let quantities = Quantity::MEDIUM.iter().chain(of_shift).copied().collect();
        Ok(Products::new(Exposure { gain, veil: Veil::constant(veil) }, quantities, matrix))
    }

    pub(super) fn refer_to(&self, exposure: Exposure) {
        self.reference.set(exposure);
    }
}
