//! `--backend`: where to compute, and why there.

use super::console::without_loader_noise;
use crate::error::Result;
use crate::filter::Backend;
use crate::gpu::{Gpu, adapters};
use crate::scene::Scene;
use clap::ValueEnum;

/// What the user wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Wanted {
    Auto,
    Cpu,
    /// A graphics adapter, even a software one.
    Gpu,
}

/// What a command computes with.
pub(super) struct Chosen {
    gpu: Option<Gpu>,
    /// Why, in words.
    pub reason: String,
}

/// Time that the CPU takes for one evaluation with derivatives, seconds per pixel, at one depth and over a depth map;
/// from `cargo bench --bench backends` on two cores.
const PIXEL_SECONDS: [f64; 2] = [4e-8, 3e-7];
/// Work for the CPU below which no device is opened: a few times what opening one and compiling the shaders takes.
const WORTHWHILE_SECONDS: f64 = 2.0;

/// Work for the CPU above which it is announced.
const LONG_SECONDS: f64 = 60.0;

impl Chosen {
    /// The choice for this number of `evaluations` of each channel of `scenes`, at one depth and over a depth map.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] or [`Error::Gpu`] if a graphics adapter is wanted and there is none, or it cannot be opened.
    pub(super) fn new<'s>(
        wanted: Wanted,
        scenes: impl IntoIterator<Item = &'s Scene>,
        evaluations: [u64; 2],
    ) -> Result<Self> {
        let cpu = |reason: String| Ok(Self { gpu: None, reason });
        match wanted {
            Wanted::Cpu => return cpu("as asked".into()),
            Wanted::Gpu => {
                return Ok(Self { gpu: Some(without_loader_noise(Gpu::open)?), reason: "as asked".into() });
            }
            Wanted::Auto => (),
        }
        let seconds = scenes.into_iter().map(|scene| seconds(scene, evaluations)).sum::<f64>();
        if seconds < WORTHWHILE_SECONDS {
            return cpu(format!(
                "about {seconds:.1} s of work, less than {WORTHWHILE_SECONDS} s for which a graphics adapter is opened"
            ));
        }
        let Some(best) = without_loader_noise(adapters).into_iter().next() else {
            return cpu("there is no graphics adapter".into());
        };
        if best.software {
            return cpu(format!("the only graphics adapter is {best}, slower than the CPU that it runs on"));
        }
        let reason = format!("about {seconds:.0} s of work for the CPU");
        match without_loader_noise(|| best.open()) {
            Ok(gpu) => Ok(Self { gpu: Some(gpu), reason }),
            Err(e) => cpu(e.to_string()),
        }
    }

    /// What makes this many evaluations of `scenes` take minutes, and about how many, if they do.
    pub(super) fn long(&self, scenes: &[&Scene], evaluations: [u64; 2]) -> Option<String> {
        let total: f64 = scenes.iter().map(|scene| seconds(scene, evaluations)).sum();
        let longest =
            scenes.iter().max_by(|a, b| seconds(a, evaluations).total_cmp(&seconds(b, evaluations)))?;
        let (width, height, channels) =
            (longest.geometry.width, longest.geometry.height, longest.object.len());
        (self.gpu.is_none() && total > LONG_SECONDS).then(|| {
            format!(
                "this may take {:.0} minutes or more: {width}x{height} px in {channels} channels of {} by some {} renders; a part of \
                 the images, or fewer pixels for the same scene, take less",
                (total / 60.0).ceil(),
                longest.path.display(),
                evaluations[usize::from(longest.geometry.path_lengths().len() > 1)]
            )
        })
    }

    pub(super) fn backend(&self) -> Backend<'_> {
        self.gpu.as_ref().map_or(Backend::Cpu, Backend::Gpu)
    }

    /// Backend, adapter and reason in a line.
    pub(super) fn describe(&self) -> String {
        match &self.gpu {
            None => format!("cpu ({})", self.reason),
            Some(gpu) => format!("gpu: {} ({})", gpu.adapter(), self.reason),
        }
    }
}

/// Time that `evaluations` of all channels take on the CPU.
fn seconds(scene: &Scene, evaluations: [u64; 2]) -> f64 {
    let pixels = (scene.geometry.width * scene.geometry.height * scene.object.len()) as f64;
    let kind = usize::from(scene.geometry.path_lengths().len() > 1);
    evaluations[kind] as f64 * pixels * PIXEL_SECONDS[kind]
}
