//! Work on the device with its complaints turned into errors, and buffers read back.

use crate::GpuError;

/// Runs `work` and turns what wgpu complains about into an error of `pass`.
pub(crate) fn checked<T>(
    device: &wgpu::Device,
    pass: &'static str,
    work: impl FnOnce() -> T,
) -> Result<T, GpuError> {
    let scopes = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation]
        .map(|filter| device.push_error_scope(filter));
    let result = work();
    let mut error = None;
    // innermost first
    for scope in scopes.into_iter().rev() {
        error = pollster::block_on(scope.pop()).or(error);
    }
    match error {
        None => Ok(result),
        Some(error) => Err(GpuError::Pass { pass, reason: error.to_string() }),
    }
}

/// Waits for the device and copies the first `bytes` of a buffer for reading, which is then free for the next copy.
pub(crate) fn read<T: bytemuck::Pod>(
    device: &wgpu::Device,
    pass: &'static str,
    buffer: &wgpu::Buffer,
    bytes: u64,
) -> Result<Vec<T>, GpuError> {
    let failed = |reason: String| GpuError::Pass { pass, reason };
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

/// [`GpuError::TooLarge`] if a storage buffer of `bytes` is more than the device allows.
pub(crate) fn check_size(device: &wgpu::Device, what: &'static str, bytes: u64) -> Result<(), GpuError> {
    let limits = device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if bytes > limit { Err(GpuError::TooLarge { what, bytes, limit }) } else { Ok(()) }
}
