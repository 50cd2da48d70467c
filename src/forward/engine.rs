//! What makes forward models.

use super::ForwardModel;
use super::imaged::{Imaged, Recorder};
use super::kernels::Filtered;
use super::quantity::State;
use super::replay::{self, Replayed, Tracing};
use crate::error::Result;
use crate::filter::{Backend, Optics, Target, hidden_share};
use crate::image::{Border, Image, View};
use crate::medium::Medium;
use crate::spread::Model;

/// Paths that are traced to see how long all of them take.
const SAMPLE_PATHS: u64 = 1 << 18;

/// How much farther than the state's shift a prepared model may be shifted, px: a fit starts from a shift known to less.
const SHIFT_MARGIN_PX: f64 = 2.0;

/// What makes forward models: a model, where it runs, and how many paths it traces if it does.
#[derive(Clone, Copy)]
pub struct Engine<'a> {
    /// The spread model.
    pub model: Model,
    /// What renders.
    pub backend: Backend<'a>,
    /// What the model `traced` traces.
    pub tracing: Tracing,
}

impl<'a> Engine<'a> {
    /// The forward model of `target`, scene number `scene`, made for the `state` and kernels up to `headroom` times as wide.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn prepare(
        &self,
        target: Target<'a>,
        state: &State,
        headroom: f64,
        scene: usize,
    ) -> Result<Box<dyn ForwardModel + 'a>> {
        if let Some(imaging) = &state.imaging {
            let recorder = Recorder::new(&target, imaging)?;
            let light = self.prepare(recorder.target(target), &state.without_imaging(), headroom, scene)?;
            return Ok(Box::new(Imaged::new(light, recorder)));
        }
        if self.model == Model::Traced {
            return Ok(Box::new(Replayed::new(target, state, self.tracing, scene as u64)?));
        }
        let farthest = state.shift_px.map_or(0.0, |[x, y]| x.abs().max(y.abs()) + SHIFT_MARGIN_PX);
        let optics = self.optics(state.medium);
        let filter = self.backend.prepare_for_shifts(target, &optics, headroom, farthest)?;
        Ok(Box::new(Filtered::new(self.model, filter)))
    }

    /// A rough forward model of `target` with at most `slices` depths and padding for kernels that reach `reach_px` pixels.
    ///
    /// # Errors
    /// If the device cannot hold it.
    pub fn prepare_roughly(
        &self,
        target: Target<'a>,
        slices: usize,
        reach_px: f64,
    ) -> Result<Box<dyn ForwardModel + 'a>> {
        let filter = self.backend.prepare_slices(target, slices, reach_px)?;
        Ok(Box::new(Filtered::new(self.model, filter)))
    }

    /// The share of hidden light of every pixel of `target`'s view at `state`; `None` where nothing is hidden. Where the model has
    /// no kernels, those of `small-angle` stand in.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn hidden_share(&self, target: Target<'a>, state: &State) -> Result<Option<Image>> {
        if let Some(imaging) = &state.imaging {
            let recorder = Recorder::new(&target, imaging)?;
            let share = self.hidden_share(recorder.target(target), &state.without_imaging())?;
            return recorder.share(share.as_ref(), imaging);
        }
        let hides = target.relief.is_some_and(|relief| relief.hides());
        hides.then(|| hidden_share(&target, &self.optics(state.medium), self.backend)).transpose()
    }

    /// The share of the light of every pixel of `target`'s view at `state` that comes from outside the clear image, where that is not
    /// known; `None` where it is. Of a pixel that looks outside itself it is all.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn outside_share(&self, target: Target<'a>, state: &State) -> Result<Option<Image>> {
        if target.border != Border::Unknown {
            return Ok(None);
        }
        let (width, height) = (target.radiance.width, target.radiance.height);
        let even = Image::filled(width, height, 1.0);
        let behind: Vec<Image> = target.behind.iter().map(|_| even.clone()).collect();
        let engine = self.without_noise();
        let lit = |border: Border| {
            let view = View::whole(width, height);
            let target = Target { radiance: &even, behind: &behind, border, view, relief: None, ..target };
            engine.image(target, &State::from(state.medium), 0, 1.0)
        };
        let (inside, all) = (lit(Border::Zero)?, lit(Border::Mirror)?);
        let of =
            |(inside, all): (&f32, &f32)| if *all > 0.0 { (1.0 - inside / all).clamp(0.0, 1.0) } else { 1.0 };
        let data = inside.data.iter().zip(&all.data).map(of).collect();
        Recorder::new(&target, &state.imaging.unwrap_or_default())?
            .outside(&Image { width, height, data }, state)
            .map(Some)
    }

    /// An independent image of `target`, scene number `scene`, at `state`. If the model traces, its paths have the shapes of
    /// those of a scene that is nearer by the factor `stretch`, so that both share their noise.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn image(&self, target: Target<'a>, state: &State, scene: usize, stretch: f64) -> Result<Image> {
        if let Some(imaging) = &state.imaging {
            let recorder = Recorder::new(&target, imaging)?;
            let light = self.image(recorder.target(target), &state.without_imaging(), scene, stretch)?;
            return recorder.image(&light, imaging);
        }
        if self.model == Model::Traced {
            return replay::render(target, state, self.tracing, (scene as u64, stretch));
        }
        self.prepare(target, state, 1.0, scene)?.image(state)
    }

    /// `target` through `medium`.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn render(&self, target: Target<'a>, medium: Medium) -> Result<Rendered> {
        let state = State::from(medium);
        if self.model == Model::Traced {
            return Ok(Rendered { image: self.image(target, &state, 0, 1.0)?, cut: false });
        }
        let model = self.prepare(target, &state, 1.0, 0)?;
        Ok(Rendered { cut: model.coverage(&state)?.cut, image: model.image(&state)? })
    }

    /// The object's light at `state` and at `others`, and the part of it that is not scattered, of `target`, by a model that has
    /// kernels.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn parts(&self, target: Target<'a>, state: &State, others: &[State]) -> Result<Parts> {
        if let Some(imaging) = &state.imaging {
            let recorder = Recorder::new(&target, imaging)?;
            let others: Vec<State> = others.iter().map(State::without_imaging).collect();
            let light = self.parts(recorder.target(target), &state.without_imaging(), &others)?;
            let recorded = |image: &Image| recorder.image(image, imaging);
            return Ok(Parts {
                whole: recorded(&light.whole)?,
                direct: recorded(&light.direct)?,
                others: light.others.iter().map(recorded).collect::<Result<_>>()?,
            });
        }
        let filter = self.backend.prepare(target, &self.optics(state.medium), 1.0)?;
        let model = Filtered::new(self.model, filter);
        let others = others.iter().map(|other| model.image(other)).collect::<Result<_>>()?;
        Ok(Parts { direct: model.direct(state)?, whole: model.image(state)?, others })
    }

    /// All light that arrives after the path length `z` from radiance 1 everywhere.
    ///
    /// # Errors
    /// As [`Model::kernel`].
    pub(crate) fn total(&self, state: &State, z: f64) -> Result<f64> {
        Ok(self.optics(state.medium).kernel(z)?.mtf(0.0).value)
    }

    /// The model `traced` in place of this one.
    pub(crate) fn traced(&self) -> Self {
        Self { model: Model::Traced, ..*self }
    }

    /// Seconds that the paths of a fit of `target` by `traced` take on this machine, its depths being a map: a sample of
    /// them is traced.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub(crate) fn tracing_seconds(&self, target: Target<'a>, state: &State) -> Result<f64> {
        let tracing = Tracing::new(Some(SAMPLE_PATHS), self.tracing.seed);
        let clock = std::time::Instant::now();
        Self { tracing, ..self.traced() }.image(target, state, 0, 1.0)?;
        let all = replay::surface_paths(self.tracing) as f64;
        Ok(clock.elapsed().as_secs_f64() * all / SAMPLE_PATHS as f64)
    }

    /// The model whose fit says where that of this one begins, if it needs one.
    pub fn pilot(&self) -> Option<Self> {
        (self.model == Model::Traced).then_some(Self { model: Model::SmallAngle, ..*self })
    }

    /// Whether the model renders shifted observations.
    pub fn renders_shifts(&self) -> bool {
        self.model != Model::Traced
    }

    /// The same with so few paths as are enough to seek the medium; `None` if there are none to be saved.
    pub fn scouting(&self) -> Option<Self> {
        (self.model == Model::Traced).then_some(Self { tracing: self.tracing.fewer(), ..*self })
    }

    /// The model with kernels that sees the same light: where noise of few paths would pass for want of information.
    pub fn without_noise(&self) -> Self {
        let model = if self.model == Model::Traced { Model::WideAngle } else { self.model };
        Self { model, ..*self }
    }

    fn optics(&self, medium: Medium) -> Optics {
        Optics { model: self.model, medium }
    }
}

/// A rendered scene.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The object's light through the medium, over the view.
    pub image: Image,
    /// Whether the kernels reach beyond the padding ([`Coverage::cut`](crate::filter::Coverage)).
    pub cut: bool,
}

/// Light of a scene.
#[derive(Debug, Clone)]
pub struct Parts {
    /// All of it.
    pub whole: Image,
    /// What is not scattered.
    pub direct: Image,
    /// All of it, at other states.
    pub others: Vec<Image>,
}
