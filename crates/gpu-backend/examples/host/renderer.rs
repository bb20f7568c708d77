//! A renderer as small as it can be: one light, one shadow map, surfaces of one colour.

use glam::{DMat4, Vec3, Vec4};
use gpu_backend::wgpu::{self, util::DeviceExt};
use scene::Mesh;

pub(crate) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

const SURFACES: &str = "
    struct Globals { clip_from_world: mat4x4f, light_clip: mat4x4f, light: vec4f }
    @group(0) @binding(0) var<uniform> globals: Globals;
    @group(0) @binding(1) var map: texture_depth_2d;
    @group(0) @binding(2) var compare: sampler_comparison;
    struct Out { @builtin(position) position: vec4f, @location(0) world: vec3f }
    @vertex fn vs(@location(0) p: vec3f) -> Out { return Out(globals.clip_from_world * vec4f(p, 1.0), p); }
    @fragment fn fs(in: Out) -> @location(0) vec4f {
        let normal = normalize(cross(dpdx(in.world), dpdy(in.world)));
        let way = globals.light.xyz - in.world;
        let at = globals.light_clip * vec4f(in.world + 0.05 * normalize(way), 1.0);
        let uv = at.xy / at.w * vec2f(0.5, -0.5) + 0.5;
        var lit = textureSampleCompareLevel(map, compare, uv, at.z / at.w - 1e-5);
        lit *= step(length(uv - 0.5), 0.5);
        let irradiance = globals.light.w * lit * abs(dot(normal, normalize(way))) / dot(way, way);
        return vec4f(vec3f(0.3, 0.27, 0.24) * (irradiance / 3.14 + 0.02 + 0.01 * normal.y), 1.0);
    }";

pub(crate) struct Renderer {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    corners: wgpu::Buffer,
    count: u32,
}

impl Renderer {
    pub(crate) fn new(meshes: &[Mesh]) -> Result<Self, Box<dyn std::error::Error>> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
        let corners: Vec<Vec3> = meshes.iter().flat_map(Mesh::corners).flatten().collect();
        let count = corners.len() as u32;
        let corners = buffer(&device, bytemuck::cast_slice(&corners), wgpu::BufferUsages::VERTEX);
        Ok(Self { device, queue, corners, count })
    }

    /// Draws depth, and with a picture and the light's depth lit surfaces.
    pub(crate) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        clip: DMat4,
        light_clip: DMat4,
        light: Vec4,
        lit: Option<(&wgpu::Texture, &wgpu::Texture)>,
        depth: &wgpu::Texture,
    ) {
        let device = &self.device;
        let module = &device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SURFACES.into()),
        });
        let vertex = wgpu::VertexState {
            module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        };
        let targets = [Some(COLOR.into())];
        let fragment = wgpu::FragmentState {
            module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &targets,
        };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex,
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: lit.map(|_| fragment),
            multiview_mask: None,
            cache: None,
        });
        let mut globals = [clip.as_mat4().to_cols_array(), light_clip.as_mat4().to_cols_array()].concat();
        globals.extend(light.to_array());
        let globals = buffer(device, bytemuck::cast_slice(&globals), wgpu::BufferUsages::UNIFORM);
        let compare = device.create_sampler(&wgpu::SamplerDescriptor {
            compare: Some(wgpu::CompareFunction::Less),
            ..Default::default()
        });
        let map = lit.map(|(_, map)| map.create_view(&Default::default()));
        let mut bindings = vec![globals.as_entire_binding()];
        bindings.extend(map.iter().flat_map(|map| {
            [wgpu::BindingResource::TextureView(map), wgpu::BindingResource::Sampler(&compare)]
        }));
        let entries: Vec<_> = bindings
            .into_iter()
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let layout = &pipeline.get_bind_group_layout(0);
        let group =
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
        let mut pass = begin(encoder, lit.map(|(color, _)| color), depth, true);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_vertex_buffer(0, self.corners.slice(..));
        pass.draw(0..self.count, 0..1);
    }

    /// Waits for what was submitted and reads the picture.
    pub(crate) fn pixels(&self, picture: &wgpu::Texture) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
        // rows of a copy are a multiple of 256 bytes: 64 pixels
        let (width, height) = (picture.width(), picture.height());
        let (device, queue) = (&self.device, &self.queue);
        let readback = buffer(
            device,
            &vec![0; 4 * (width * height) as usize],
            wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        );
        let mut encoder = device.create_command_encoder(&Default::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &readback, layout },
            picture.size(),
        );
        queue.submit([encoder.finish()]);
        readback.map_async(wgpu::MapMode::Read, .., |_| ());
        device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(readback.get_mapped_range(..)?.to_vec())
    }
}

pub(crate) fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    color: Option<&wgpu::Texture>,
    depth: &wgpu::Texture,
    clear: bool,
) -> wgpu::RenderPass<'a> {
    let view = &color.unwrap_or(depth).create_view(&Default::default());
    let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    let color =
        color.map(|_| wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops });
    let load = if clear { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load };
    let depth_ops = Some(wgpu::Operations { load, store: wgpu::StoreOp::Store });
    let view = &depth.create_view(&Default::default());
    let depth = wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: color.map(Some).as_slice(),
        depth_stencil_attachment: Some(depth),
        ..Default::default()
    })
}

fn buffer(device: &wgpu::Device, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

pub(crate) fn texture(
    device: &wgpu::Device,
    (width, height): (u32, u32),
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        // the fog reads depth: `TEXTURE_BINDING`
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
