//! What the shaders read: the counterparts of the structures in `shaders/`.

use super::super::canvas::Canvas as Padded;
use super::super::slices::Slices;
use super::super::sources::Layer;
use crate::image::Border;
use bytemuck::{Pod, Zeroable};

/// Counterpart of `Canvas` in shaders/shared/canvas.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Canvas {
    /// Size of the padded image, px.
    pub size: [u32; 2],
    /// Size of the object image, px.
    pub object: [u32; 2],
    /// Where the object image begins, px.
    pub margin: [u32; 2],
    /// 0 zero, 1 clamp, 2 mirror.
    pub border: u32,
    /// Sources for each object pixel.
    pub layers: u32,
}

impl Canvas {
    pub(super) fn new(canvas: &Padded, border: Border, layers: usize) -> Self {
        let [across, down] = canvas.padded;
        Self {
            size: [across.size as u32, down.size as u32],
            object: canvas.object.map(|n| n as u32),
            margin: [across.margin as u32, down.margin as u32],
            border: match border {
                Border::Zero => 0,
                Border::Clamp => 1,
                Border::Mirror | Border::Unknown => 2,
            },
            layers: layers as u32,
        }
    }
}

/// In place of a number: none.
pub const NOTHING: u32 = u32::MAX;

/// Counterpart of `Source` in shaders/shared/canvas.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Source {
    /// Clear radiance.
    pub light: f32,
    /// Where it lies among the slices, along z and along the magnification.
    pub along: [f32; 2],
    /// Path length along the camera's axis, length.
    pub z: f32,
    /// Cosine of the ray off the axis.
    pub cosine: f32,
    /// Slope of its surface along x and y, length per pixel.
    pub slope: [f32; 2],
    /// Occluders that its light must pass, [`NOTHING`] if there is no source.
    pub slab: u32,
}

/// All sources, layer after layer.
pub(super) fn sources(layers: &[Layer], slices: &[Option<Slices>]) -> Vec<Source> {
    let source = |source: &Option<super::super::sources::Source>| {
        let Some(s) = source else {
            return Source { slab: NOTHING, cosine: 1.0, ..Source::zeroed() };
        };
        let place = slices[s.occluders].as_ref().map_or([0.0; 2], |slices| slices.place(s.node));
        Source {
            light: s.light,
            along: place.map(|v| v as f32),
            z: s.node.z as f32,
            cosine: s.cosine as f32,
            slope: s.slope,
            slab: s.occluders as u32,
        }
    };
    layers.iter().flatten().map(source).collect()
}

/// Counterpart of `Weigh` in shaders/weigh.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Weigh {
    /// The padded image.
    pub canvas: Canvas,
    /// Occluders that the sources' light must pass.
    pub slab: u32,
    /// 1 where the place along z is the number of the slice.
    pub exact: u32,
    /// Slices along z and along the magnification.
    pub counts: [u32; 2],
    /// The slices; the second may be [`NOTHING`].
    pub slices: [u32; 2],
    /// 1 for the source of the first slice's slope term.
    pub sloping: u32,
    /// Fills the structure up.
    pub padding: u32,
}

/// Counterpart of `Store` in shaders/shared/store.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Store {
    /// Size of the padded image, px.
    pub size: [u32; 2],
    /// First column to be stored.
    pub begin: u32,
    /// Columns to be stored.
    pub columns: u32,
    /// Spectra stored for each column.
    pub planes: u32,
    /// Where the spectra belong among them; the stage `slope_correction` reads the first alone, the second may be [`NOTHING`].
    pub places: [u32; 2],
    /// Fills the structure up.
    pub padding: u32,
}

/// Counterpart of `Gather` in shaders/gather.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Gather {
    /// Size of the padded image, px.
    pub size: [u32; 2],
    /// First column of this part.
    pub begin: u32,
    /// Columns of this part.
    pub columns: u32,
    /// Number of slices.
    pub slices: u32,
    /// 1 if there is a slope term.
    pub sloping: u32,
    /// 1 if light comes from farther occluders.
    pub carried: u32,
    /// 1 if there is an occluder to pass.
    pub occluded: u32,
    /// 1 if derivatives are wanted.
    pub derivatives: u32,
    /// Where the table of the divisor's scale begins.
    pub scale: u32,
    /// Its entries per rad/px.
    pub scale_per_w: f32,
    /// Fills the structure up.
    pub padding: u32,
}

/// Counterpart of `Pass` in shaders/pass.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Pass {
    /// The padded image.
    pub canvas: Canvas,
    /// Occluders that the sources' light must pass.
    pub slab: u32,
    /// The occluder's bit among the opaque ones.
    pub bit: u32,
    /// Path length along the axis at the occluder, length.
    pub z: f32,
    /// Extinction coefficient, 1/length.
    pub sigma_t: f32,
    /// Unit of the derivatives in sigma_s and sigma_a, length.
    pub unit: f32,
    /// 1 if there are derivatives.
    pub derivatives: u32,
    /// Fills the structure up.
    pub padding: [u32; 2],
}

/// Counterpart of `Collect` in shaders/shared/collect.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Collect {
    /// The padded image.
    pub canvas: Canvas,
    /// First column and row of the view, px.
    pub view: [u32; 2],
    /// Size of the view, px.
    pub view_size: [u32; 2],
    /// Extinction coefficient, 1/length.
    pub sigma_t: f32,
    /// Unit of the derivatives in sigma_s and sigma_a, length.
    pub unit: f32,
    /// 1 if there are derivatives.
    pub derivatives: u32,
    /// Obliquities collected before this one.
    pub before: u32,
    /// 1 to add direct light.
    pub direct: u32,
    /// Fills the structure up.
    pub padding: [u32; 3],
}

/// Counterpart of `Sums` in shaders/sums.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Sums {
    /// Pixels of the view.
    pub pixels: u32,
    /// Gain of the reference exposure.
    pub gain: f32,
    /// Veil of the reference exposure.
    pub veil: f32,
    /// 1 if there are derivatives.
    pub derivatives: u32,
    /// 0, which the shader's compiler must not know.
    pub zero: u32,
    /// Fills the structure up.
    pub padding: [u32; 3],
}

/// Counterpart of `Total` in shaders/total.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Total {
    /// Workgroups that left sums.
    pub groups: u32,
    /// Sums of each.
    pub products: u32,
    /// 0, which the shader's compiler must not know.
    pub zero: u32,
    /// Fills the structure up.
    pub padding: u32,
}

/// Counterpart of `Shift` in shaders/shift.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct ShiftBy {
    /// Size of the padded image, px.
    pub size: [u32; 2],
    /// 1 if there are derivatives.
    pub derivatives: u32,
    /// Fills the structure up.
    pub padding: u32,
}

/// Counterpart of `Crop` in shaders/crop.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Crop {
    /// Columns of the padded image, px.
    pub width: u32,
    /// First column and row of the view on it, px.
    pub corner: [u32; 2],
    /// Size of the view, px.
    pub view_size: [u32; 2],
    /// 1 if there are derivatives.
    pub derivatives: u32,
    /// Fills the structure up.
    pub padding: [u32; 2],
}

/// Products of `images`, each pair once.
pub const fn products(images: usize) -> usize {
    images * (images + 1) / 2
}
