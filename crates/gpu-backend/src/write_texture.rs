//! Texels from the CPU.

/// Writes all layers of a texture's finest level; `texel` is the bytes of one.
pub(crate) fn write_texture(queue: &wgpu::Queue, texture: &wgpu::Texture, bytes: &[u8], texel: u32) {
    queue.write_texture(
        texture.as_image_copy(),
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(texture.width() * texel),
            rows_per_image: Some(texture.height()),
        },
        texture.size(),
    );
}
