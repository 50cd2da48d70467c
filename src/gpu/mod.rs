//! Compute on a graphics adapter: which adapter, buffers, shader stages, and their errors. It contains no optics.
//!
//! An error that the driver reports while work is recorded (too little memory, a lost device) is kept and returned by
//! the next [`Gpu::submit`] or [`Gpu::read`]: nothing panics.

mod adapter;
mod recording;
mod stage;

pub use adapter::{Adapter, adapters};
pub use recording::Recording;
pub use stage::{Shader, Stage};

use crate::error::{Error, Result};
use bytemuck::Pod;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::{Buffer, BufferUsages};

/// An open device.
pub struct Gpu {
    adapter: Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    stages: Mutex<HashMap<&'static str, Arc<Stage>>>,
    trouble: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the best adapter of this machine, even a software one.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] if there is none, [`Error::Gpu`] if it cannot be opened.
    pub fn open() -> Result<Self> {
        let best = adapters().into_iter().next().ok_or(Error::NoAdapter)?;
        best.open()
    }

    fn new(adapter: Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let trouble = Arc::new(Mutex::new(None));
        let keep = |trouble: &Arc<Mutex<Option<String>>>| {
            let trouble = Arc::clone(trouble);
            // The first report states the cause, later ones its consequences.
            move |report: String| _ = lock(&trouble).get_or_insert(report)
        };
        let (failed, lost) = (keep(&trouble), keep(&trouble));
        device.on_uncaptured_error(Arc::new(move |error| failed(reason(&error))));
        device.set_device_lost_callback(move |_, message| lost(format!("the device was lost: {message}")));
        Self { adapter, device, queue, stages: Mutex::default(), trouble }
    }

    /// The adapter of this device.
    pub fn adapter(&self) -> &Adapter {
        &self.adapter
    }

    /// The compiled `shader`, compiled at its first use.
    pub fn stage(&self, shader: &Shader) -> Arc<Stage> {
        let compile = || Arc::new(Stage::new(&self.device, shader));
        Arc::clone(lock(&self.stages).entry(shader.name).or_insert_with(compile))
    }

    /// Refuses a buffer of `what` that the adapter cannot bind.
    ///
    /// # Errors
    /// [`Error::Gpu`], which names both sizes.
    pub fn check_size(&self, what: &str, bytes: usize) -> Result<()> {
        let most = self.adapter.most_bytes;
        if bytes as u64 <= most {
            return Ok(());
        }
        Err(Error::Gpu(format!(
            "{what} takes {} MiB, and {} binds {} MiB at most; use fewer pixels",
            bytes.div_ceil(1 << 20),
            self.adapter.name,
            most >> 20
        )))
    }

    /// A buffer of `count` values of type `T`, all 0.
    ///
    /// # Errors
    /// As [`check_size`](Self::check_size).
    pub fn empty<T: Pod>(&self, what: &str, count: usize) -> Result<Buffer> {
        let bytes = count.max(1) * size_of::<T>();
        self.check_size(what, bytes)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let size = bytes.next_multiple_of(4) as u64;
        Ok(self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size,
            usage,
            mapped_at_creation: false,
        }))
    }

    /// A buffer that holds `values`.
    ///
    /// # Errors
    /// As [`check_size`](Self::check_size).
    pub fn upload<T: Pod>(&self, what: &str, values: &[T]) -> Result<Buffer> {
        let buffer = self.empty::<T>(what, values.len())?;
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(values));
        Ok(buffer)
    }

    /// Runs what was recorded.
    ///
    /// # Errors
    /// [`Error::Gpu`] if something has gone wrong on the device.
    pub fn submit(&self, recording: Recording) -> Result<()> {
        let commands = recording.finish();
        self.checked()?;
        self.queue.submit([commands]);
        self.checked()
    }

    /// Waits until all that was submitted is done.
    ///
    /// # Errors
    /// [`Error::Gpu`] if something has gone wrong on the device.
    pub fn wait(&self) -> Result<()> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.checked()?;
        waited.map(|_| ()).map_err(|e| self.error(&e.to_string()))
    }

    /// The first `count` values of `buffer`, when all that was submitted is done.
    ///
    /// # Errors
    /// [`Error::Gpu`] if something has gone wrong on the device.
    pub fn read<T: Pod>(&self, buffer: &Buffer, count: usize) -> Result<Vec<T>> {
        let size = (count * size_of::<T>()) as u64;
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut recording = self.record();
        recording.copy(buffer, &staging, size);
        self.submit(recording)?;
        let (send, receive) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| _ = send.send(result));
        self.wait()?;
        let failed = |why: &dyn std::fmt::Display| self.error(&why.to_string());
        let mapped = receive.recv().map_err(|e| failed(&e))?;
        mapped.map_err(|e| failed(&e))?;
        let bytes = staging.get_mapped_range(..).map_err(|e| failed(&e))?;
        Ok(bytemuck::pod_collect_to_vec(&bytes[..]))
    }

    /// Begins a list of dispatches.
    pub fn record(&self) -> Recording {
        Recording::new(&self.device, &self.queue)
    }

    /// Destroys the device; every later use is an error.
    pub fn destroy(&self) {
        self.device.destroy();
        lock(&self.trouble).get_or_insert("the device was destroyed".into());
    }

    fn checked(&self) -> Result<()> {
        match &*lock(&self.trouble) {
            None => Ok(()),
            Some(report) => Err(self.error(report)),
        }
    }

    fn error(&self, report: &str) -> Error {
        Error::Gpu(format!("{}: {report}; try again", self.adapter.name))
    }
}

fn reason(error: &wgpu::Error) -> String {
    match error {
        wgpu::Error::OutOfMemory { .. } => "it has too little memory for this scene".into(),
        other => other.to_string(),
    }
}

/// The value behind a lock, which is valid even if a thread panicked while it held the lock.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_little_memory_is_told_in_plain_words() {
        let error = wgpu::Error::OutOfMemory { source: "VK_ERROR_OUT_OF_DEVICE_MEMORY".into() };
        assert!(reason(&error).contains("too little memory"));
    }
}
