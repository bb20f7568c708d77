//! What is asked of a device, what is used where it is there, and which paths a device gets.

use crate::CreateError;

/// Features without which nothing runs: none beyond core WebGPU.
pub const fn required_features() -> wgpu::Features {
    wgpu::Features::empty()
}

/// Features that are used where a device has them: times of each pass, blending in 32 bits (the frontmost and backmost faces
/// of shadow volumes in one draw instead of two, the terms of light volumes without fixed point), and light textures
/// filtered in 32 bits instead of 16.
pub const fn optional_features() -> wgpu::Features {
    wgpu::Features::TIMESTAMP_QUERY
        .union(wgpu::Features::FLOAT32_BLENDABLE)
        .union(wgpu::Features::FLOAT32_FILTERABLE)
}

/// The limits that the passes stay within: WebGPU's defaults.
pub fn required_limits() -> wgpu::Limits {
    wgpu::Limits::default()
}

/// What a device can do, and so which path it gets.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Capabilities {
    /// Whether each pass can be timed on the GPU; without it only the wall clock around a submission is left.
    pub pass_times: bool,
    /// Whether 32-bit floats blend: the outermost faces of a shadow volume are then found in one draw instead of two, and
    /// terms of light volumes are summed as floats instead of in fixed point.
    pub blends_float32: bool,
    /// Longest side of a shadow map; units: texels.
    pub largest_map: u32,
    /// Longest side of a view; units: pixels.
    pub largest_view: u32,
    /// Largest buffer that a shader can be given; units: bytes.
    pub largest_binding: u64,
}

impl Capabilities {
    /// Capabilities of a device.
    pub fn of(device: &wgpu::Device) -> Self {
        let limits = device.limits();
        Self {
            pass_times: device.features().contains(wgpu::Features::TIMESTAMP_QUERY),
            blends_float32: device.features().contains(wgpu::Features::FLOAT32_BLENDABLE),
            largest_map: limits.max_texture_dimension_2d,
            largest_view: limits.max_texture_dimension_2d,
            largest_binding: limits.max_storage_buffer_binding_size,
        }
    }
}

/// Checks that a host's device was made with what the passes need.
pub(crate) fn check_limits(device: &wgpu::Device) -> Result<(), CreateError> {
    let got = device.limits();
    let needed: [(&'static str, u32, u32); 8] = [
        ("max_bind_groups", 4, got.max_bind_groups),
        ("max_storage_buffers_per_shader_stage", 8, got.max_storage_buffers_per_shader_stage),
        ("max_sampled_textures_per_shader_stage", 10, got.max_sampled_textures_per_shader_stage),
        ("max_storage_textures_per_shader_stage", 4, got.max_storage_textures_per_shader_stage),
        ("max_uniform_buffers_per_shader_stage", 4, got.max_uniform_buffers_per_shader_stage),
        ("max_compute_invocations_per_workgroup", 256, got.max_compute_invocations_per_workgroup),
        ("max_compute_workgroup_size_x", 64, got.max_compute_workgroup_size_x),
        ("max_compute_workgroup_storage_size", 16_384, got.max_compute_workgroup_storage_size),
    ];
    for (name, needed, got) in needed {
        if got < needed {
            return Err(CreateError::Limit { name, needed: needed.into(), got: got.into() });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn core_limits_are_enough() {
        let limits = required_limits();
        assert_eq!(limits, wgpu::Limits::default());
        assert!(limits.max_storage_textures_per_shader_stage >= 4);
    }
}
