//! The silhouette of casters in the light of one light. Twin of `shaders/volume/silhouette.wgsl`.

use std::sync::{Arc, Mutex, PoisonError};

use bytemuck::{Pod, Zeroable};
use scene::Light;

use super::casters::ShadowCasters;
use super::{compute, spread};
use crate::checked::{filled_buffer, prepared};
use crate::pass::{ComputePass, Dispatch, Step, compute_pipeline, storage, storage_written, uniform};
use crate::pipelines::Pipelines;
use crate::{CreateError, PrepareError, ReadError};

const PASS: &str = "volume/silhouette";

/// Words in front of the list: see `Head` in the shader.
const HEAD: [u32; 8] = [0, 0, 1, 1, 6, 0, 0, 0];

/// Where the arguments of a dispatch over the list begin; units: bytes.
pub(super) const DISPATCH_AT: u64 = 4;

/// Where the arguments of a draw of the list begin; units: bytes.
pub(super) const DRAW_AT: u64 = 16;

/// What a silhouette depends on beside the mesh.
pub(crate) type Key = [u32; 4];

/// The shadow volume of casters in the light of one light: its silhouette is found when a frame first asks for it, and
/// again when the light has moved.
///
/// Cloning shares the buffers.
#[derive(Debug, Clone)]
pub struct ShadowVolume {
    pub(super) casters: Arc<ShadowCasters>,
    pub(super) head: wgpu::Buffer,
    fresh_head: wgpu::Buffer,
    pub(super) found: wgpu::Buffer,
    /// The light that the list is for.
    built: Arc<Mutex<Option<Key>>>,
}

impl ShadowVolume {
    /// Makes room for the silhouette of `casters`; nothing is found yet.
    ///
    /// # Errors
    /// [`PrepareError::Device`] if there is no memory or the device is lost.
    pub fn new(device: &wgpu::Device, casters: Arc<ShadowCasters>) -> Result<Self, PrepareError> {
        use wgpu::BufferUsages as Usage;
        let list = 8 * u64::from(casters.edge_count.max(2));
        let (head, fresh_head, found) = prepared(device, "a shadow volume", || {
            let words = bytemuck::cast_slice(&HEAD);
            let head = Usage::STORAGE | Usage::INDIRECT | Usage::COPY_DST | Usage::COPY_SRC;
            let found = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("silhouette"),
                size: list,
                usage: Usage::STORAGE,
                mapped_at_creation: false,
            });
            let fresh = filled_buffer(device, "silhouette's first head", words, Usage::COPY_SRC);
            (filled_buffer(device, "silhouette's head", words, head), fresh, found)
        })?;
        Ok(Self { casters, head, fresh_head, found, built: Arc::default() })
    }

    /// The casters.
    pub fn casters(&self) -> &ShadowCasters {
        &self.casters
    }

    /// Says that the light has moved: the silhouette is found again when next asked for.
    pub fn touch(&self) {
        *self.built.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Silhouette edges of the last frame, once it is submitted; submits a copy and waits for it.
    ///
    /// # Errors
    /// [`ReadError::Device`] if the device is lost.
    pub fn read_edge_count(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<u32, ReadError> {
        const WHAT: &str = "the silhouette's size";
        let readback = prepared(device, WHAT, || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(WHAT),
                size: 4,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })
        .map_err(|error| ReadError::Device { what: WHAT, reason: error.to_string() })?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&self.head, 0, &readback, 0, 4);
        queue.submit([encoder.finish()]);
        let words: Vec<u32> = crate::checked::read_buffer(device, &readback, 4, WHAT)?;
        Ok(words[0])
    }

    /// Memory of the silhouette, the casters not counted; units: bytes.
    pub fn bytes(&self) -> u64 {
        self.head.size() + self.fresh_head.size() + self.found.size()
    }

    pub(crate) fn is_current(&self, key: &Key) -> bool {
        self.built.lock().unwrap_or_else(PoisonError::into_inner).as_ref() == Some(key)
    }

    /// Says which light the list is for, once the passes are encoded.
    pub(crate) fn mark(&self, key: Key) {
        *self.built.lock().unwrap_or_else(PoisonError::into_inner) = Some(key);
    }
}

/// Position of a local light, or direction of another, with a word that tells them apart.
pub(crate) fn key_of(light: &Light) -> Key {
    let (at, kind) = match light {
        Light::Point(light) => (light.position, 0),
        Light::Spot(light) => (light.position, 0),
        Light::Directional(light) => (light.direction, 1),
    };
    [at.x.to_bits(), at.y.to_bits(), at.z.to_bits(), kind]
}

/// `Source` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Source {
    light: [f32; 4],
    edges: u32,
    _pad0: u32,
    _pad1: u32,
    _pad2: u32,
}

/// The pass that finds a silhouette.
#[derive(Debug)]
pub(super) struct SilhouettePass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl SilhouettePass {
    pub(super) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(PASS),
            entries: &[uniform(0), storage(1), storage(2), storage_written(3), storage_written(4)],
        });
        let pipeline = compute_pipeline(pipelines, PASS, &[&layout], &[])?;
        Ok(Self { layout, pipeline })
    }

    pub(super) fn steps(&self, device: &wgpu::Device, volume: &ShadowVolume, light: &Light) -> Vec<Step> {
        let casters = &volume.casters;
        let from_middle = |p: glam::Vec3| (p.as_dvec3() - casters.middle).as_vec3();
        let light = match light {
            Light::Point(light) => from_middle(light.position).extend(1.0),
            Light::Spot(light) => from_middle(light.position).extend(1.0),
            Light::Directional(light) => (-light.direction).extend(0.0),
        };
        let source = Source { light: light.to_array(), edges: casters.edge_count, ..Source::zeroed() };
        let source = filled_buffer(
            device,
            "silhouette's light",
            bytemuck::bytes_of(&source),
            wgpu::BufferUsages::UNIFORM,
        );
        let entries = [&source, &casters.planes, &casters.edges, &volume.head, &volume.found];
        let entries: Vec<_> = entries
            .into_iter()
            .zip(0..)
            .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(PASS),
            layout: &self.layout,
            entries: &entries,
        });
        vec![
            Step::Copy { from: volume.fresh_head.clone(), to: volume.head.clone() },
            compute(ComputePass {
                label: "silhouette".into(),
                pipeline: self.pipeline.clone(),
                groups: vec![group],
                dispatch: Dispatch::Groups(spread(casters.edge_count.div_ceil(64))),
            }),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct(PASS, "Source");
        assert_eq!(span as usize, size_of::<Source>());
        assert_eq!(fields, offsets!(Source: light, edges, _pad0, _pad1, _pad2));
        let (fields, span) = wgsl_struct(PASS, "Head");
        assert_eq!(span as usize, size_of_val(&HEAD));
        let at = |name: &str| fields.iter().find(|(field, _)| field == name).unwrap().1;
        assert_eq!((u64::from(at("groups")), u64::from(at("vertices"))), (DISPATCH_AT, DRAW_AT));
    }
}
