//! How much of each pixel's light may come from where no image shows anything.

use super::{Backend, Optics, Target};
use crate::error::Result;
use crate::geometry::median;
use crate::image::Image;
use crate::spread::Model;

/// Share of the light of every pixel of the view that comes from inpainted surfaces behind near
/// surfaces: the light that it would send if everything there had radiance 1, over exp(-sigma_a z). Where there is no
/// object, z is the median path length. For the model `traced`, which has no kernels, those of `small-angle` tell.
///
/// # Errors
/// As [`Optics::kernel`], and [`Error::Gpu`](crate::Error::Gpu) if the device fails.
pub fn hidden_share<'a>(target: &Target<'a>, optics: &Optics, backend: Backend<'a>) -> Result<Image> {
    let (view, geometry) = (target.view, target.geometry);
    let nothing = Image::filled(view.width, view.height, 0.0);
    let Some(relief) = target.relief.filter(|r| r.hides()) else { return Ok(nothing) };
    if optics.model == Model::BeerLambert {
        return Ok(nothing);
    }
    let optics = match optics.model {
        Model::Traced => &Optics { model: Model::SmallAngle, ..*optics },
        _ => optics,
    };
    let light = backend.prepare_hidden(*target, relief, optics)?.render(optics)?;
    let typical = median(geometry.path_lengths());
    Ok(Image::from_fn(view.width, view.height, |x, y| {
        let z = geometry.path_length(view.x + x, view.y + y).unwrap_or(typical);
        let share = light.at(x, y) * (optics.medium.sigma_a() * z).exp() as f32;
        share.clamp(0.0, 1.0)
    }))
}
