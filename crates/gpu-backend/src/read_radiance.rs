//! Radiance from a texture on the GPU to a list on the CPU.

use crate::ReadError;
use crate::checked::{caught, read_buffer};

/// The first three channels of [`read_texels`].
pub(crate) fn read_radiance(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    what: &'static str,
) -> Result<Vec<[f32; 3]>, ReadError> {
    let texels = read_texels(device, queue, texture, what)?;
    Ok(texels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect())
}

/// An rgba32float texture, row by row from the top; submits a copy and waits for it. `what` names the picture in errors.
pub(crate) fn read_texels(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    what: &'static str,
) -> Result<Vec<[f32; 4]>, ReadError> {
    let (width, height) = (texture.width(), texture.height());
    // rows of a copy are a multiple of 256 bytes
    let stride = (16 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let readback = caught(device, || {
        let readback = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("radiance readback"),
            size: u64::from(stride) * u64::from(height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("radiance readback") });
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &readback,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride),
                    rows_per_image: Some(height),
                },
            },
            texture.size(),
        );
        queue.submit([encoder.finish()]);
        readback
    })
    .map_err(|reason| ReadError::Device { what, reason })?;
    let bytes: Vec<u8> = read_buffer(device, &readback, u64::from(stride) * u64::from(height), what)?;
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for row in bytes.chunks_exact(stride as usize) {
        pixels.extend(bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&row[..16 * width as usize]));
    }
    Ok(pixels)
}
