//! The contenders' own shaders and what they read.

use bytemuck::{Pod, Zeroable};
use narrowbeam::gpu::Shader;

/// Sums over a disc.
pub const TILE: Shader = Shader { name: "contender tile", source: &[include_str!("tile.wgsl")] };
/// One pass of a blur.
pub const BLUR: Shader = Shader { name: "contender blur", source: &[include_str!("blur.wgsl")] };
/// One pass to half the rate.
pub const HALVE: Shader = Shader { name: "contender halve", source: &[include_str!("halve.wgsl")] };
/// One pass to twice the rate.
pub const DOUBLE: Shader = Shader { name: "contender double", source: &[include_str!("double.wgsl")] };
/// What stays in its pixel.
pub const SHARP: Shader = Shader { name: "contender sharp", source: &[include_str!("sharp.wgsl")] };

/// Counterpart of `Tile` in tile.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Tile {
    pub size: [u32; 2],
    pub radius: u32,
    pub disc: u32,
    pub terms: u32,
    pub middle: f32,
    pub half_range: f32,
    pub sigma_t: f32,
}

/// Counterpart of `Blur` in blur.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Blur {
    pub n: u32,
    pub rows: u32,
    pub radius: u32,
    pub terms: u32,
    pub powers: u32,
    pub adds: u32,
    pub padding: [u32; 2],
    pub coefficients: [f32; 8],
}

/// Counterpart of `Halve` in halve.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Halve {
    pub n: u32,
    pub rows: u32,
    pub result: u32,
    pub margin: u32,
    pub planes: u32,
    pub powers: u32,
    pub padding: [u32; 2],
}

/// Counterpart of `Double` in double.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Double {
    pub n: u32,
    pub rows: u32,
    pub result: u32,
    pub margin: u32,
}

/// Counterpart of `Sharp` in sharp.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Sharp {
    pub pixels: u32,
    pub terms: u32,
    pub middle: f32,
    pub half_range: f32,
    pub sigma_t: f32,
    pub padding: [u32; 3],
    pub coefficients: [f32; 8],
}
