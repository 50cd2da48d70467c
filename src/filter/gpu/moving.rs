//! Renders moved by a fraction of a pixel: light arrives on the whole canvas, is transformed, moved there (see
//! [`crate::filter::shift`]), transformed back and cropped to the view.
//!
//! Cost: 2 complex 2-D FFTs beside those of a render, 5 beside those of a render with derivatives.

use super::layout::{Crop, ShiftBy};
use super::render::Request;
use super::{GpuFilter, Resident, shaders};
use crate::error::Result;
use crate::filter::shift::Shift;
use crate::gpu::Recording;
use std::cell::RefCell;
use wgpu::Buffer;

/// Buffers that shifts take beside those of plain renders.
pub(super) struct Moving {
    /// What arrives on the canvas, in pairs as the renders, and working space; later the derivatives in the shift.
    arrived: RefCell<[Buffer; 3]>,
    /// Image, its derivatives in the medium and in the shift over the view.
    pub planes: Buffer,
}

impl GpuFilter<'_> {
    /// The buffers, allocated at the first shift.
    pub(super) fn moving(&self) -> Result<&Moving> {
        if let Some(moving) = self.moving.get() {
            return Ok(moving);
        }
        let pair = || self.gpu.empty::<[f32; 2]>("the padded image", self.canvas.pixels());
        let arrived = RefCell::new([pair()?, pair()?, pair()?]);
        let planes = self.gpu.empty::<f32>("the rendered image", 6 * self.plan.target.view.pixels())?;
        Ok(self.moving.get_or_init(|| Moving { arrived, planes }))
    }

    /// Collects light on the canvas, that of the obliquity number `before`.
    pub(super) fn arrive(
        &self,
        recording: &mut Recording,
        request: &Request,
        pairs: &[Buffer; 3],
        before: usize,
    ) -> Result<()> {
        let Resident { sources, weights, .. } = &self.resident;
        let arrived = self.moving()?.arrived.borrow();
        let buffers = [sources, weights, &pairs[0], &pairs[1], &arrived[0], &arrived[1]];
        let parameters = self.collecting(request, before);
        recording.dispatch(&self.gpu.stage(&shaders::ARRIVE), &parameters, &buffers, self.canvas.pixels());
        Ok(())
    }

    /// Moves what has arrived, and leaves it in the planes.
    pub(super) fn shift(&self, recording: &mut Recording, request: &Request, shift: &Shift) -> Result<()> {
        let Moving { arrived, planes } = self.moving()?;
        let (mut arrived, mut pairs) = (arrived.borrow_mut(), self.resident.pairs.borrow_mut());
        self.fft.record(recording, &mut arrived, request.pairs(), false);
        let factors: Vec<[f32; 4]> =
            shift.table().map(|[f, s]| [f.re, f.im, s.re, s.im].map(|v| v as f32)).collect();
        let factors = self.gpu.upload("the factors of the shift", &factors)?;
        let size = [self.canvas.fft.width as u32, self.canvas.fft.height as u32];
        let derivatives = u32::from(request.derivatives);
        let parameters = ShiftBy { size, derivatives, padding: 0 };
        let buffers = [&factors, &arrived[0], &arrived[1], &pairs[0], &pairs[1], &arrived[2]];
        recording.dispatch(&self.gpu.stage(&shaders::SHIFT), &parameters, &buffers, self.canvas.pixels());
        self.fft.record(recording, &mut pairs, request.pairs(), true);
        if request.derivatives {
            arrived.swap(0, 2);
            self.fft.record(recording, &mut arrived, &[0], true);
        }
        let view = self.plan.target.view;
        let margin = self.resident.layout.margin;
        let parameters = Crop {
            width: size[0],
            corner: [view.x as u32 + margin[0], view.y as u32 + margin[1]],
            view_size: [view.width as u32, view.height as u32],
            derivatives,
            padding: [0; 2],
        };
        let buffers = [&pairs[0], &pairs[1], &arrived[0], planes];
        recording.dispatch(&self.gpu.stage(&shaders::CROP), &parameters, &buffers, view.pixels());
        Ok(())
    }
}
