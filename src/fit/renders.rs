//! All scenes of a fit, planned and rendered.

use super::equations::Products;
use super::observed::Observed;
use super::{Datum, Exposure, HEADROOM, Parameters, Settings, with_optics};
use crate::error::Result;
use crate::filter::cpu::{Coverage, CpuFilter, Rendering};
use crate::image::Image;
use std::cell::RefCell;
use std::rc::Rc;

/// Parameter values, and the renders there with derivatives.
type Latest = ([f64; 3], Rc<Vec<Rendering>>);

/// Filters of all scenes, and what they rendered last.
pub(super) struct Renders<'a> {
    filters: Vec<CpuFilter<'a>>,
    /// An optimum is looked at more than once.
    latest: RefCell<Option<Latest>>,
}

impl<'a> Renders<'a> {
    /// Plans `data` for kernels about as wide as those of `parameters`.
    pub(super) fn new(data: &[Datum<'a>], parameters: &Parameters, settings: &Settings) -> Result<Self> {
        let filters = with_optics(parameters, settings.model, |optics| {
            data.iter().map(|d| CpuFilter::new(d.target, optics, HEADROOM)).collect()
        })?;
        Ok(Self { filters, latest: RefCell::new(None) })
    }

    /// Every scene at `parameters`, with derivatives.
    fn at(&self, parameters: &Parameters, settings: &Settings) -> Result<Rc<Vec<Rendering>>> {
        let values = parameters.values();
        if let Some((of, renderings)) = &*self.latest.borrow()
            && *of == values
        {
            return Ok(Rc::clone(renderings));
        }
        let renderings = with_optics(parameters, settings.model, |optics| {
            let render = |filter: &CpuFilter| {
                let rendering = filter.render_with_gradient(optics);
                (settings.progress)();
                rendering
            };
            self.filters.iter().map(render).collect::<Result<Vec<_>>>()
        })?;
        let renderings = Rc::new(renderings);
        *self.latest.borrow_mut() = Some((values, Rc::clone(&renderings)));
        Ok(renderings)
    }

    /// What the fit needs of every scene at `parameters`.
    pub(super) fn products(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        observed: &[Observed],
    ) -> Result<Vec<Products>> {
        let renderings = self.at(parameters, settings)?;
        let pairs = observed.iter().zip(renderings.iter());
        Ok(pairs.map(|(o, r)| o.products(&r.image, r.gradient.as_ref())).collect())
    }

    /// The same without derivatives.
    pub(super) fn levels(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        observed: &[Observed],
    ) -> Result<Vec<Products>> {
        with_optics(parameters, settings.model, |optics| {
            let products = |(filter, observed): (&CpuFilter, &Observed)| {
                let products = observed.products(&filter.render(optics)?, None);
                (settings.progress)();
                Ok(products)
            };
            self.filters.iter().zip(observed).map(products).collect()
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
        let renderings = self.at(parameters, settings)?;
        let scenes = renderings.iter().zip(exposures).zip(data);
        Ok(scenes.map(|((r, exposure), datum)| exposure.apply(r.image.clone(), datum.veil)).collect())
    }

    /// How far the plans serve the kernels of `parameters` too.
    pub(super) fn coverage(&self, parameters: &Parameters, settings: &Settings) -> Result<Coverage> {
        with_optics(parameters, settings.model, |optics| {
            let mut all = Coverage { served: true, cut: false };
            for filter in &self.filters {
                let coverage = filter.coverage(optics)?;
                all = Coverage { served: all.served && coverage.served, cut: all.cut || coverage.cut };
            }
            Ok(all)
        })
    }

    /// Real 2-D FFTs of one evaluation with derivatives.
    pub(super) fn transforms(&self) -> usize {
        self.filters.iter().map(|f| f.transforms().1).sum()
    }
}
