//! A compiled compute shader.

use std::borrow::Cow;
use wgpu::{ComputePipeline, Device};

/// One stage's source: WGSL with one compute entry point.
#[derive(Debug, Clone, Copy)]
pub struct Shader {
    /// Its file in `shaders/`, without the ending.
    pub name: &'static str,
    /// The text, after that of the files it shares with others.
    pub source: &'static [&'static str],
}

impl Shader {
    /// The whole text.
    pub fn text(&self) -> String {
        self.source.concat()
    }
}

/// Invocations of one workgroup, in every shader but `fft`.
pub const WORKGROUP: usize = 64;

/// A compiled shader.
pub struct Stage {
    pub(super) name: &'static str,
    pub(super) pipeline: ComputePipeline,
}

impl Stage {
    pub(super) fn new(device: &Device, shader: &Shader) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(shader.name),
            source: wgpu::ShaderSource::Wgsl(Cow::Owned(shader.text())),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(shader.name),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions {
                // Every shader writes its shared memory before it reads it.
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        });
        Self { name: shader.name, pipeline }
    }
}
