//! All scenes of a fit, planned and rendered.

use super::comparison::Comparison;
use super::equations::Products;
use super::observed::Observed;
use super::{Datum, Exposure, HEADROOM, Parameters, Settings, with_optics};
use crate::error::Result;
use crate::filter::Coverage;
use crate::image::Image;

/// All scenes, prepared and beside their observations.
pub(super) struct Renders<'a> {
    scenes: Vec<Comparison<'a>>,
}

impl<'a> Renders<'a> {
    /// Plans `data` for kernels about as wide as those of `parameters`.
    pub(super) fn new(
        data: &[Datum<'a>],
        observed: &[Observed],
        parameters: &Parameters,
        settings: &Settings<'a>,
    ) -> Result<Self> {
        let scenes = with_optics(parameters, settings.model, |optics| {
            let scene = |(d, o): (&Datum<'a>, &Observed)| {
                Comparison::new(settings.backend.prepare(d.target, optics, HEADROOM)?, o)
            };
            data.iter().zip(observed).map(scene).collect()
        })?;
        Ok(Self { scenes })
    }

    /// Takes the pixels of scene `i` that count now.
    pub(super) fn observe(&mut self, i: usize, observed: &Observed) -> Result<()> {
        self.scenes[i].observe(observed)
    }

    /// What the fit needs of every scene at `parameters`.
    pub(super) fn products(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        observed: &[Observed],
    ) -> Result<Vec<Products>> {
        let products = |(scene, observed): (&Comparison, &Observed)| {
            let products = scene.products(parameters, settings, observed);
            (settings.progress)();
            products
        };
        self.scenes.iter().zip(observed).map(products).collect()
    }

    /// The same without derivatives.
    pub(super) fn levels(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        observed: &[Observed],
    ) -> Result<Vec<Products>> {
        with_optics(parameters, settings.model, |optics| {
            let products = |(scene, observed): (&Comparison, &Observed)| {
                let products = scene.levels(optics, observed);
                (settings.progress)();
                products
            };
            self.scenes.iter().zip(observed).map(products).collect()
        })
    }

    /// Every scene at `parameters`, exposed and veiled as it was observed.
    pub(super) fn exposed(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        exposures: &[Exposure],
        data: &[Datum],
    ) -> Result<Vec<Image>> {
        let scenes = self.scenes.iter().zip(exposures).zip(data);
        let exposed = |((scene, exposure), datum): ((&Comparison, &Exposure), &Datum)| {
            Ok(exposure.apply(scene.image(parameters, settings)?, datum.veil))
        };
        scenes.map(exposed).collect()
    }

    /// How far the plans serve the kernels of `parameters` too.
    pub(super) fn coverage(&self, parameters: &Parameters, settings: &Settings) -> Result<Coverage> {
        with_optics(parameters, settings.model, |optics| {
            let mut all = Coverage { served: true, cut: false };
            for scene in &self.scenes {
                let coverage = scene.filter.coverage(optics)?;
                all = Coverage { served: all.served && coverage.served, cut: all.cut || coverage.cut };
            }
            Ok(all)
        })
    }

    /// 2-D FFTs of one evaluation with derivatives.
    pub(super) fn transforms(&self) -> usize {
        self.scenes.iter().map(|s| s.filter.transforms().1).sum()
    }
}
