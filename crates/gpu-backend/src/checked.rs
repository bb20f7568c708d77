//! wgpu's complaints as values, and waiting for results.

use crate::{CreateError, PrepareError, ReadError};

/// Runs `work` and returns what wgpu complains about, in its words.
///
/// Only calls that the caller's own checks should have made impossible to refuse come here; the scopes keep what is
/// left (a lost device, no memory) from reaching the host's handler, which by default ends the program.
pub(crate) fn caught<T>(device: &wgpu::Device, work: impl FnOnce() -> T) -> Result<T, String> {
    let scopes = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation]
        .map(|filter| device.push_error_scope(filter));
    let result = work();
    let mut error = None;
    // innermost first
    for scope in scopes.into_iter().rev() {
        error = pollster::block_on(scope.pop()).or(error);
    }
    error.map_or(Ok(result), |error| Err(error.to_string()))
}

/// [`caught`] for a pipeline of `pass`.
pub(crate) fn created<T>(
    device: &wgpu::Device,
    pass: &str,
    work: impl FnOnce() -> T,
) -> Result<T, CreateError> {
    caught(device, work).map_err(|reason| CreateError::Pipeline { pass: pass.to_owned(), reason })
}

/// [`caught`] for the resources of a frame.
pub(crate) fn prepared<T>(
    device: &wgpu::Device,
    what: &'static str,
    work: impl FnOnce() -> T,
) -> Result<T, PrepareError> {
    caught(device, work).map_err(|reason| PrepareError::Device { what, reason })
}

/// Waits for the device and copies the first `bytes` of a buffer that was made to be mapped, which is then free for the
/// next copy.
pub(crate) fn read_buffer<T: bytemuck::Pod>(
    device: &wgpu::Device,
    buffer: &wgpu::Buffer,
    bytes: u64,
    what: &'static str,
) -> Result<Vec<T>, ReadError> {
    let failed = |reason: String| ReadError::Device { what, reason };
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
        // nobody waits any more if the receiver is gone
        let _ = sender.send(result);
    });
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(e.to_string()))?;
    receiver.recv().map_err(|e| failed(e.to_string()))?.map_err(|e| failed(e.to_string()))?;
    let view = buffer.get_mapped_range(..bytes).map_err(|e| failed(e.to_string()))?;
    let values = bytemuck::pod_collect_to_vec(&view);
    drop(view);
    buffer.unmap();
    Ok(values)
}

/// [`PrepareError::TooLarge`] if a storage buffer of `needed` bytes is more than the device allows.
pub(crate) fn check_size(device: &wgpu::Device, what: &'static str, needed: u64) -> Result<(), PrepareError> {
    let limits = device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if needed > limit { Err(PrepareError::TooLarge { what, needed, limit, unit: "bytes" }) } else { Ok(()) }
}
