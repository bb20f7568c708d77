//! Texels from the CPU.

/// Writes all layers of a texture's finest level; `texel` is the bytes of one.
pub(crate) fn write_texture(queue: &wgpu::Queue, texture: &wgpu::Texture, bytes: &[u8], texel: u32) {
    write_texture_level(queue, texture, 0, bytes, texel);
}

/// Writes all layers of one level of a texture.
pub(crate) fn write_texture_level(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    level: u32,
    bytes: &[u8],
    texel: u32,
) {
    let size = wgpu::Extent3d {
        width: (texture.width() >> level).max(1),
        height: (texture.height() >> level).max(1),
        ..texture.size()
    };
    queue.write_texture(
        wgpu::TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(size.width * texel),
            rows_per_image: Some(size.height),
        },
        size,
    );
}
