//! The stages of the filter on a graphics adapter, one WGSL file each.

use crate::gpu::Shader;

macro_rules! shader {
    ($name:literal $(, $shared:literal)*) => {
        Shader {
            name: $name,
            source: &[
                $(include_str!(concat!("../../../shaders/shared/", $shared, ".wgsl")),)*
                include_str!(concat!("../../../shaders/", $name, ".wgsl")),
            ],
        }
    };
}

/// The stage `sums` of a number of images that its compiler knows, so that it unrolls the loops.
macro_rules! sums {
    ($name:literal, $images:literal) => {
        Shader {
            name: $name,
            source: &[
                concat!("const IMAGES: u32 = ", $images, ";\n"),
                include_str!("../../../shaders/shared/two_sum.wgsl"),
                include_str!("../../../shaders/sums.wgsl"),
            ],
        }
    };
}

/// The object weighted for two slices.
pub const WEIGH: Shader = shader!("weigh", "workgroup", "canvas");
/// Fourier transforms of lines.
pub const FFT: Shader = shader!("fft", "workgroup", "complex");
/// Two spectra out of a common transform.
pub const SPLIT: Shader = shader!("split", "workgroup", "complex", "store");
/// The source of the slope term.
pub const SLOPE_CORRECTION: Shader = shader!("slope_correction", "workgroup", "complex", "store");
/// Scattered light on its way to an occluder or to the camera.
pub const GATHER: Shader = shader!("gather", "workgroup", "complex");
/// Light through an occluder.
pub const PASS: Shader = shader!("pass", "workgroup", "canvas", "direct");
/// What arrives at the camera.
pub const COLLECT: Shader = shader!("collect", "workgroup", "canvas", "direct", "arriving");
/// What arrives there on the whole canvas.
pub const ARRIVE: Shader = shader!("arrive", "workgroup", "canvas", "direct", "arriving");
/// Spectra of images that move, and of their derivatives in the shift.
pub const SHIFT: Shader = shader!("shift", "workgroup", "complex");
/// The view's part of the canvas.
pub const CROP: Shader = shader!("crop", "workgroup");
/// Sums of products over the pixels that count, of the six images of a render that stands still.
pub const SUMS: Shader = sums!("sums", "6u");
/// The same of the eight images of one that moves.
pub const SUMS_OF_EIGHT: Shader = sums!("sums of eight", "8u");
/// Their total over all workgroups.
pub const TOTAL: Shader = shader!("total", "two_sum");

/// All of them, in the order of a render.
pub const ALL: [Shader; 13] = [
    WEIGH,
    FFT,
    SPLIT,
    SLOPE_CORRECTION,
    GATHER,
    PASS,
    COLLECT,
    ARRIVE,
    SHIFT,
    CROP,
    SUMS,
    SUMS_OF_EIGHT,
    TOTAL,
];
