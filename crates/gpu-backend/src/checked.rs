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
    let lost = is_lost(device);
    let mut error = None;
    // innermost first
    for scope in scopes.into_iter().rev() {
        error = pollster::block_on(scope.pop()).or(error);
    }
    match error {
        Some(error) => Err(error.to_string()),
        None if lost => Err("the device is lost".to_owned()),
        None => Ok(result),
    }
}

/// Whether the device is gone, or has no memory for four bytes: such a device refuses to map a new buffer.
///
/// Error scopes say nothing of a lost device, and its callback is the host's.
fn is_lost(device: &wgpu::Device) -> bool {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("is the device there"),
        size: wgpu::COPY_BUFFER_ALIGNMENT,
        usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: true,
    });
    buffer.get_mapped_range_mut(..).is_err()
}

/// A buffer with contents, to be made inside of [`caught`], which then knows if there was no memory for it.
///
/// wgpu's own `create_buffer_init` panics where the buffer cannot be mapped.
pub(crate) fn filled_buffer(
    device: &wgpu::Device,
    label: &str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: (contents.len() as u64).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT),
        usage,
        mapped_at_creation: true,
    });
    if let Ok(mut mapped) = buffer.get_mapped_range_mut(..) {
        mapped.slice(..contents.len()).copy_from_slice(contents);
        drop(mapped);
        buffer.unmap();
    }
    buffer
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

/// Waits for all that was submitted.
pub(crate) fn wait(device: &wgpu::Device, what: &'static str) -> Result<(), ReadError> {
    let failed = |reason: String| ReadError::Device { what, reason };
    // to wait for a device that is gone ends the program
    caught(device, || ()).map_err(failed)?;
    device.poll(wgpu::PollType::wait_indefinitely()).map(|_| ()).map_err(|e| failed(e.to_string()))
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
    caught(device, || ()).map_err(failed)?;
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
        // nobody waits any more if the receiver is gone
        let _ = sender.send(result);
    });
    wait(device, what)?;
    receiver.recv().map_err(|e| failed(e.to_string()))?.map_err(|e| failed(e.to_string()))?;
    let view = buffer.get_mapped_range(..bytes).map_err(|e| failed(e.to_string()))?;
    let values = bytemuck::pod_collect_to_vec(&view);
    drop(view);
    buffer.unmap();
    Ok(values)
}

pub(crate) fn read_words(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    from: &wgpu::Buffer,
    what: &'static str,
) -> Result<Vec<u32>, ReadError> {
    let readback = caught(device, || {
        let readback = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("words readback"),
            size: from.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder =
            device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("words readback") });
        encoder.copy_buffer_to_buffer(from, 0, &readback, 0, from.size());
        queue.submit([encoder.finish()]);
        readback
    })
    .map_err(|reason| ReadError::Device { what, reason })?;
    read_buffer(device, &readback, from.size(), what)
}

/// [`PrepareError::TooLarge`] if a buffer of `needed` bytes is more than the device allows.
pub(crate) fn check_buffer(
    device: &wgpu::Device,
    what: &'static str,
    needed: u64,
) -> Result<(), PrepareError> {
    let limit = device.limits().max_buffer_size;
    if needed > limit { Err(PrepareError::TooLarge { what, needed, limit, unit: "bytes" }) } else { Ok(()) }
}

/// [`PrepareError::TooLarge`] if a storage buffer of `needed` bytes is more than the device allows.
pub(crate) fn check_size(device: &wgpu::Device, what: &'static str, needed: u64) -> Result<(), PrepareError> {
    let limits = device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if needed > limit { Err(PrepareError::TooLarge { what, needed, limit, unit: "bytes" }) } else { Ok(()) }
}
