//! The adapters of this machine, best first.

use super::Gpu;
use crate::error::{Error, Result};
use std::fmt;
use wgpu::{Backends, DeviceType};

/// Native interfaces only: wgpu's fallback to GL lacks what compute needs.
const BACKENDS: Backends = Backends::PRIMARY;

/// A graphics adapter, or a software one.
#[derive(Debug, Clone)]
pub struct Adapter {
    /// Its name according to the driver.
    pub name: String,
    /// The interface: Vulkan, Metal or Dx12.
    pub interface: String,
    /// Whether it is a program that runs on the CPU.
    pub software: bool,
    /// Largest buffer that a shader can be given, bytes.
    pub most_bytes: u64,
    handle: wgpu::Adapter,
}

/// All adapters, hardware first, software last.
pub fn adapters() -> Vec<Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: BACKENDS,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut all = pollster::block_on(instance.enumerate_adapters(BACKENDS));
    let rank = |adapter: &wgpu::Adapter| match adapter.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu | DeviceType::Other => 2,
        DeviceType::Cpu => 3,
    };
    all.sort_by_key(rank);
    all.into_iter().map(Adapter::new).collect()
}

impl Adapter {
    fn new(handle: wgpu::Adapter) -> Self {
        let (info, limits) = (handle.get_info(), handle.limits());
        Self {
            name: info.name,
            interface: format!("{:?}", info.backend),
            software: info.device_type == DeviceType::Cpu,
            most_bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            handle,
        }
    }

    /// Opens it, with all its limits.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the driver refuses.
    pub fn open(self) -> Result<Gpu> {
        let request = self.handle.request_device(&wgpu::DeviceDescriptor {
            label: Some("narrowbeam"),
            required_limits: self.handle.limits(),
            ..Default::default()
        });
        match pollster::block_on(request) {
            Ok((device, queue)) => Ok(Gpu::new(self, device, queue)),
            Err(e) => Err(Error::Gpu(format!("{}: cannot be opened: {e}", self.name))),
        }
    }
}

impl fmt::Display for Adapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let software = if self.software { ", software" } else { "" };
        write!(f, "{} ({}{software})", self.name, self.interface)
    }
}
