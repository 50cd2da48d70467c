//! A list of dispatches and copies, to be submitted together.

use super::stage::{Stage, WORKGROUP};
use bytemuck::Pod;
use wgpu::{
    BindGroupEntry, Buffer, BufferDescriptor, BufferUsages, CommandBuffer, CommandEncoder, Device, Queue,
};

/// Workgroups along one dimension that every adapter takes.
const MOST_GROUPS: usize = 65535;

/// Dispatches in order; each sees what those before it wrote.
pub struct Recording {
    device: Device,
    queue: Queue,
    encoder: CommandEncoder,
}

impl Recording {
    pub(super) fn new(device: &Device, queue: &Queue) -> Self {
        let encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        Self { device: device.clone(), queue: queue.clone(), encoder }
    }

    /// Runs `stage` with at least `invocations` invocations. Binding 0 are the `parameters` (uniform), bindings 1 and on
    /// the `buffers`.
    pub fn dispatch<P: Pod>(
        &mut self,
        stage: &Stage,
        parameters: &P,
        buffers: &[&Buffer],
        invocations: usize,
    ) {
        self.dispatch_groups(stage, parameters, buffers, invocations.div_ceil(WORKGROUP));
    }

    /// Runs `stage` with at least `groups` workgroups, numbered along x, then y.
    pub fn dispatch_groups<P: Pod>(
        &mut self,
        stage: &Stage,
        parameters: &P,
        buffers: &[&Buffer],
        groups: usize,
    ) {
        let uniform = self.device.create_buffer(&BufferDescriptor {
            label: Some(stage.name),
            size: size_of::<P>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(parameters));
        let bound = std::iter::once(&uniform).chain(buffers.iter().copied()).zip(0..);
        let entries: Vec<_> = bound
            .map(|(buffer, binding)| BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let bind_group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(stage.name),
            layout: &stage.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&stage.pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        let across = groups.clamp(1, MOST_GROUPS);
        pass.dispatch_workgroups(across as u32, groups.div_ceil(across).max(1) as u32, 1);
    }

    /// Copies the first `size` bytes.
    pub fn copy(&mut self, from: &Buffer, to: &Buffer, size: u64) {
        self.encoder.copy_buffer_to_buffer(from, 0, to, 0, size);
    }

    /// Sets all of `buffer` to 0.
    pub fn clear(&mut self, buffer: &Buffer) {
        self.encoder.clear_buffer(buffer, 0, None);
    }

    pub(super) fn finish(self) -> CommandBuffer {
        self.encoder.finish()
    }
}
