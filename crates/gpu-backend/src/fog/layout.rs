//! The bind groups of the scattering passes. Twins: `bindings_view.wgsl`, `bindings.wgsl` and `bindings_bvh.wgsl` in
//! `shaders/shared/`.

use crate::pass::{filtered_texture, sampler, storage, storage_texture, storage_written, texture, uniform};

/// Layouts of the view's group (with and without the texture that is written) and the light's.
#[derive(Debug)]
pub(crate) struct Layouts {
    pub(crate) view: wgpu::BindGroupLayout,
    /// The view's group of a pass over the pixels of a list.
    pub(crate) listed: wgpu::BindGroupLayout,
    pub(crate) composite: wgpu::BindGroupLayout,
    pub(crate) light: wgpu::BindGroupLayout,
    /// What is kept of the crossings with a light volume.
    pub(crate) crossings: wgpu::BindGroupLayout,
    /// The hierarchy of shadow rays.
    pub(crate) bvh: wgpu::BindGroupLayout,
}

/// Textures of one texel that stand in for what a scene lacks.
#[derive(Debug)]
pub(crate) struct StandIns {
    pub(crate) flat: wgpu::TextureView,
    pub(crate) array: wgpu::TextureView,
    pub(crate) volume: wgpu::TextureView,
    /// A texture that can be filtered.
    pub(crate) filtered: wgpu::TextureView,
    /// Linear between texels and sizes, clamped to the edge; no stand-in.
    pub(crate) sampler: wgpu::Sampler,
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let (flat, array) = (wgpu::TextureViewDimension::D2, wgpu::TextureViewDimension::D2Array);
        let volume = wgpu::TextureViewDimension::D3;
        let group = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let reads = [uniform(0), texture(1, flat), texture(2, flat), texture(4, volume)];
        let writes = storage_texture(3, wgpu::TextureFormat::Rgba32Float, flat);
        let drawn = reads.map(|mut entry| {
            entry.visibility = wgpu::ShaderStages::FRAGMENT;
            entry
        });
        Self {
            crossings: group("fog crossings", &[storage(0), uniform(1)]),
            bvh: group("fog bvh", &[storage(0), storage(1)]),
            view: group("fog view", &[reads[0], reads[1], reads[2], writes, reads[3]]),
            listed: group(
                "fog listed pixels",
                &[reads[0], reads[1], storage(2), storage_written(3), reads[3]],
            ),
            composite: group("fog composite", &drawn),
            light: group(
                "fog light",
                &[
                    uniform(0),
                    texture(1, array),
                    texture(2, array),
                    texture(3, array),
                    texture(4, flat),
                    texture(5, flat),
                    filtered_texture(6),
                    sampler(7),
                    texture(8, flat),
                ],
            ),
        }
    }
}

impl StandIns {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let view = |format, dimension, view| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("stand-in"),
                size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor { dimension: Some(view), ..Default::default() })
        };
        use wgpu::{TextureDimension as Dimension, TextureViewDimension as ViewDimension};
        let float = wgpu::TextureFormat::R32Float;
        Self {
            flat: view(float, Dimension::D2, ViewDimension::D2),
            array: view(float, Dimension::D2, ViewDimension::D2Array),
            volume: view(float, Dimension::D3, ViewDimension::D3),
            filtered: view(wgpu::TextureFormat::Rgba16Float, Dimension::D2, ViewDimension::D2),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("light texture"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
        }
    }
}
