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

/// The object weighted for two slices.
pub const WEIGH: Shader = shader!("weigh", "workgroup", "canvas");
/// Fourier transforms of lines.
pub const FFT: Shader = shader!("fft", "workgroup", "complex");
/// Two spectra out of a common transform.
pub const SPLIT: Shader = shader!("split", "workgroup", "complex", "store");
/// The source of the slope term.
pub const BEND: Shader = shader!("bend", "workgroup", "complex", "store");
/// Scattered light on its way to a screen or to the camera.
pub const GATHER: Shader = shader!("gather", "workgroup", "complex");
/// Light through a screen.
pub const PASS: Shader = shader!("pass", "workgroup", "canvas", "direct");
/// What arrives at the camera.
pub const COLLECT: Shader = shader!("collect", "workgroup", "canvas", "direct");
/// Sums of products over the pixels that count.
pub const SUMS: Shader = shader!("sums", "two_sum");
/// Their total over all workgroups.
pub const TOTAL: Shader = shader!("total", "two_sum");

/// All of them, in the order of a render.
pub const ALL: [Shader; 9] = [WEIGH, FFT, SPLIT, BEND, GATHER, PASS, COLLECT, SUMS, TOTAL];
