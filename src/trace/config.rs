//! What a traced image is made of.

use crate::error::{Result, in_range};
use crate::geometry::{Field, Geometry};
use crate::image::{Border, Image, View};
use crate::medium::Medium;
use crate::phase::Phase;

/// What to trace. A colour object is traced one channel at a time, each with its own medium.
#[derive(Debug, Clone, Copy)]
pub struct ImageConfig<'a, P = Phase> {
    /// Camera, object distance, medium surface.
    pub geometry: &'a Geometry,
    /// Clear radiance of the object, the size of `geometry`.
    pub radiance: &'a Image,
    /// Clear radiance of each of the geometry's further layers.
    pub behind: &'a [Image],
    /// What lies outside the object image, for every layer.
    pub border: Border,
    /// The part of the object image to trace.
    pub view: View,
    /// The medium between surface and object.
    pub medium: Medium<P>,
    /// Paths per pixel, at least 2.
    pub samples: u32,
    /// Seed of the random numbers. Channels and scenes that are to be independent need different ones.
    pub seed: u64,
}

impl<P> ImageConfig<'_, P> {
    pub(super) fn check(&self) -> Result<()> {
        let (g, size) = (self.geometry, (self.geometry.width, self.geometry.height));
        let same = |name: &str, image: &Image| {
            let ok = (image.width, image.height) == size;
            in_range(
                &format!("width of the {name}, px"),
                image.width as f64,
                ok,
                "the size of the object image",
            )
        };
        let count = self.behind.len() as f64;
        let each = self.behind.len() == g.behind.len();
        in_range("radiance images of further layers", count, each, "one for each of the geometry's")?;
        for image in [self.radiance].into_iter().chain(self.behind) {
            same("radiance image", image)?;
        }
        let distances = g.behind.iter().map(|field| ("depth map of a further layer", field));
        for (name, field) in
            [("depth map", &g.depth), ("surface map", &g.surface)].into_iter().chain(distances)
        {
            if let Field::Map(map) = field {
                same(name, map)?;
            }
        }
        let inside = self.view.fits(size.0, size.1);
        in_range("width of the view, px", self.view.width as f64, inside, "inside the object image")?;
        let enough = "at least 2: the variance is estimated from their differences";
        in_range("samples", f64::from(self.samples), self.samples >= 2, enough)?;
        g.check()
    }
}
