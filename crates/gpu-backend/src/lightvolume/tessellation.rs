//! The tessellation of a map in compute: which quads are too coarse, which are split, their leaves. Twin of
//! `shaders/lightvolume/{criterion,hierarchy,leaves}.wgsl`.

use std::sync::{Arc, Mutex, PoisonError};

use bytemuck::{Pod, Zeroable};
use shadowmap::ProjectionKind;

use super::Criterion;
use crate::checked::{check_size, filled_buffer, prepared, read_buffer};
use crate::pass::{
    ComputePass, Dispatch, Step, compute_pipeline, storage, storage_written, texture, uniform,
};
use crate::pipelines::Pipelines;
use crate::{CreateError, PrepareError, ReadError, ShadowMap};

/// Cells along the side of what a workgroup judges.
const TILE: u32 = 64;

/// Level whose quads are such tiles.
const TILE_LEVEL: u32 = 6;

/// Words in front of the leaves: `Head` in the shaders.
const HEAD: [u32; 8] = [0, 1, 0, 0, 0, 0, 0, 0];

/// Where the arguments of the indexed draw begin; units: bytes.
pub(super) const DRAW_AT: u64 = 0;

/// Indices of a leaf, at most on average: two triangles, and as many more as edges have a finer neighbour, which are no more
/// than leaves, since each of those edges has two leaves on its other side, and each leaf two edges to other parents.
const INDICES_PER_LEAF: u64 = 9;

/// `Tree` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Tree {
    last: [u32; 2],
    top: u32,
    face_words: u32,
    threshold: f32,
    far: f32,
    _pad2: u32,
    flat: u32,
    seams: u32,
    most_leaves: u32,
    _pad0: u32,
    _pad1: u32,
    starts: [u32; 16],
}

impl Tree {
    fn new(map: &ShadowMap, settings: &Settings) -> Self {
        let (columns, rows) = map.size();
        let kind = map.projection().kind();
        let last = [columns.saturating_sub(1), rows.saturating_sub(1)];
        let top = last[0].max(last[1]).max(1).next_power_of_two().trailing_zeros();
        let mut starts = [0; 16];
        let mut words = 0;
        for level in 1..=top {
            starts[level as usize] = words;
            let side = 1 << (top - level);
            words += side * (side / 32).max(1);
        }
        let faces = map.projection().faces().len() as u32;
        Self {
            last,
            top,
            face_words: words.max(1),
            threshold: settings.threshold,
            far: settings.far,
            _pad2: 0,
            flat: u32::from(kind == ProjectionKind::Orthographic),
            seams: u32::from(kind == ProjectionKind::Cube),
            most_leaves: settings.most_leaves / faces,
            _pad0: 0,
            _pad1: 0,
            starts,
        }
    }

    /// Quads of level 6 and above, of a face.
    fn coarse_quads(&self) -> u64 {
        let side = 1_u64 << self.top.saturating_sub(TILE_LEVEL);
        (4 * side * side - 1) / 3
    }
}

/// What a tessellation depends on beside the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settings {
    pub(crate) criterion: Criterion,
    /// Units: m.
    pub(crate) threshold: f32,
    /// Depth that counts as infinite; units: m.
    pub(crate) far: f32,
    pub(crate) most_leaves: u32,
}

/// The leaves of a map's tessellation. Cloning shares the buffers.
#[derive(Debug, Clone)]
pub(crate) struct Leaves {
    settings: Settings,
    tree: Tree,
    faces: u32,
    pub(super) head: wgpu::Buffer,
    fresh_head: wgpu::Buffer,
    marks: wgpu::Buffer,
    coarse: wgpu::Buffer,
    splits: wgpu::Buffer,
    pub(super) leaves: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    /// Version of the map that the leaves are of.
    built: Arc<Mutex<u64>>,
}

/// What a tessellation came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeafCount {
    /// Leaves.
    pub leaves: u32,
    /// Triangles, walls included.
    pub triangles: u32,
    /// Finest levels that were left out for want of room, on the face of the map where they were most.
    pub left_out: u32,
}

impl Leaves {
    /// Makes room for the leaves of `map`.
    pub(crate) fn new(
        device: &wgpu::Device,
        map: &ShadowMap,
        settings: Settings,
    ) -> Result<Self, PrepareError> {
        let tree = Tree::new(map, &settings);
        let faces = map.projection().faces().len() as u32;
        let cells = u64::from(tree.last[0]) * u64::from(tree.last[1]) * u64::from(faces);
        // at the seams there are cells whatever is asked for, and each face has a leaf
        let seams = if tree.seams == 1 { 64 * u64::from(faces) * u64::from(tree.last[0].max(1)) } else { 0 };
        let room =
            u64::from(settings.most_leaves).max(u64::from(faces)).max(seams).min(cells.max(faces.into()));
        let borders = 12 * u64::from(tree.last[0] + tree.last[1] + 2);
        let index_bytes = 4 * (INDICES_PER_LEAF * room + borders);
        check_size(device, "the triangles of a tessellation", index_bytes)?;
        let tree = Tree { most_leaves: (room / u64::from(faces)) as u32, ..tree };
        let buffer = |label, size: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size.max(16),
                usage: usage | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let words = 4 * u64::from(tree.face_words) * u64::from(faces);
        prepared(device, "a tessellation", || {
            let first = bytemuck::cast_slice(&HEAD);
            let usage = Usage::STORAGE | Usage::INDIRECT | Usage::COPY_DST | Usage::COPY_SRC;
            Self {
                settings,
                tree,
                faces,
                head: filled_buffer(device, "tessellation head", first, usage),
                fresh_head: filled_buffer(device, "tessellation first head", first, Usage::COPY_SRC),
                marks: buffer("tessellation marks", words, Usage::COPY_DST),
                coarse: buffer(
                    "tessellation tiles",
                    8 * tree.coarse_quads() * u64::from(faces),
                    Usage::empty(),
                ),
                splits: buffer("tessellation splits", words, Usage::empty()),
                leaves: buffer("tessellation leaves", 8 * room, Usage::empty()),
                indices: buffer("tessellation indices", index_bytes, Usage::INDEX),
                built: Arc::default(),
            }
        })
    }

    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Memory; units: bytes.
    pub(crate) fn bytes(&self) -> u64 {
        [&self.head, &self.fresh_head, &self.marks, &self.coarse, &self.splits, &self.leaves, &self.indices]
            .map(wgpu::Buffer::size)
            .iter()
            .sum()
    }

    /// Whether the leaves are those of the map's `version`.
    pub(crate) fn is_current(&self, version: u64) -> bool {
        *self.built.lock().unwrap_or_else(PoisonError::into_inner) == version
    }

    /// Says which version of the map the leaves are of, once the passes are encoded.
    pub(crate) fn mark(&self, version: u64) {
        *self.built.lock().unwrap_or_else(PoisonError::into_inner) = version;
    }

    /// What the last submitted frame came to; submits a copy and waits for it.
    pub(crate) fn read_count(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<LeafCount, ReadError> {
        let head: Vec<u32> = self.read(device, queue, &self.head)?;
        Ok(LeafCount { leaves: head[5], triangles: head[0] / 3, left_out: head[7] })
    }

    /// The leaves of the last submitted frame in no order: column and row (16 bits each); level (8 bits), edges with a
    /// finer neighbour (8 bits), face.
    pub(crate) fn read_leaves(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Vec<[u32; 2]>, ReadError> {
        let count = self.read_count(device, queue)?.leaves as usize;
        let mut leaves: Vec<[u32; 2]> = self.read(device, queue, &self.leaves)?;
        leaves.truncate(count);
        Ok(leaves)
    }

    fn read<T: Pod>(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        buffer: &wgpu::Buffer,
    ) -> Result<Vec<T>, ReadError> {
        const WHAT: &str = "the tessellation";
        let readback = prepared(device, WHAT, || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(WHAT),
                size: buffer.size(),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })
        .map_err(|error| ReadError::Device { what: WHAT, reason: error.to_string() })?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &readback, 0, buffer.size());
        queue.submit([encoder.finish()]);
        read_buffer(device, &readback, buffer.size(), WHAT)
    }
}

/// The pipelines that tessellate a map.
#[derive(Debug)]
pub(crate) struct TessellationPasses {
    /// By Laplacian, by distance.
    criterion: [(wgpu::BindGroupLayout, wgpu::ComputePipeline); 2],
    hierarchy: [(wgpu::BindGroupLayout, wgpu::ComputePipeline); 2],
    leaves: (wgpu::BindGroupLayout, wgpu::ComputePipeline),
}

impl TessellationPasses {
    pub(crate) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let pass = |name: &'static str, entries: &[wgpu::BindGroupLayoutEntry], constants: &[(&str, f64)]| {
            let layout = device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries });
            let pipeline = compute_pipeline(pipelines, name, &[&layout], constants)?;
            Ok::<_, CreateError>((layout, pipeline))
        };
        let map = texture(1, wgpu::TextureViewDimension::D2Array);
        let (w2, w3, w4) = (storage_written(2), storage_written(3), storage_written(4));
        let criterion =
            |of: f64| pass("lightvolume/criterion", &[uniform(0), map, w2, w3], &[("CRITERION", of)]);
        let hierarchy = |of: f64| {
            let entries = [uniform(0), map, w2, w3, w4, storage_written(5)];
            pass("lightvolume/hierarchy", &entries, &[("CRITERION", of)])
        };
        Ok(Self {
            criterion: [criterion(0.0)?, criterion(1.0)?],
            hierarchy: [hierarchy(0.0)?, hierarchy(1.0)?],
            leaves: pass("lightvolume/leaves", &[uniform(0), storage(1), w2, w3, w4], &[])?,
        })
    }

    /// The steps that tessellate `map`.
    pub(crate) fn steps(&self, device: &wgpu::Device, map: &ShadowMap, to: &Leaves) -> Vec<Step> {
        let tree =
            filled_buffer(device, "tessellation", bytemuck::bytes_of(&to.tree), wgpu::BufferUsages::UNIFORM);
        let heights = map.heights().create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let heights = wgpu::BindingResource::TextureView(&heights);
        let [tree, marks, coarse, splits, head, leaves, indices] =
            [&tree, &to.marks, &to.coarse, &to.splits, &to.head, &to.leaves, &to.indices]
                .map(wgpu::Buffer::as_entire_binding);
        let pass = |label: &str,
                    (layout, pipeline): &(wgpu::BindGroupLayout, wgpu::ComputePipeline),
                    resources: &[&wgpu::BindingResource<'_>],
                    groups| {
            let entries: Vec<_> = resources
                .iter()
                .zip(0..)
                .map(|(&resource, binding)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
                .collect();
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout,
                entries: &entries,
            });
            Step::Compute(ComputePass {
                label: label.to_owned(),
                pipeline: pipeline.clone(),
                groups: vec![group],
                dispatch: Dispatch::Groups(groups),
            })
        };
        let by = usize::from(to.settings.criterion == Criterion::Distance);
        let tiles = to.tree.last.map(|last| last.max(1).div_ceil(TILE));
        let [x, y, _] = crate::volume::spread(to.tree.face_words.div_ceil(64));
        vec![
            Step::Copy { from: to.fresh_head.clone(), to: to.head.clone() },
            Step::Clear(to.marks.clone()),
            pass(
                "tessellation, criterion",
                &self.criterion[by],
                &[&tree, &heights, &marks, &coarse],
                [tiles[0], tiles[1], to.faces],
            ),
            pass(
                "tessellation, hierarchy",
                &self.hierarchy[by],
                &[&tree, &heights, &marks, &coarse, &splits, &head],
                [1, 1, to.faces],
            ),
            pass(
                "tessellation, leaves",
                &self.leaves,
                &[&tree, &splits, &head, &leaves, &indices],
                [x, y, to.faces],
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct("lightvolume/leaves", "Tree");
        assert_eq!(span as usize, size_of::<Tree>());
        let ours = offsets!(Tree: last, top, face_words, threshold, far, _pad2, flat, seams, most_leaves, _pad0,
            _pad1, starts);
        assert_eq!(fields, ours);
        let (fields, span) = wgsl_struct("lightvolume/leaves", "Head");
        assert_eq!(span as usize, size_of_val(&HEAD));
        let at = |name: &str| fields.iter().find(|(field, _)| field == name).unwrap().1;
        assert_eq!((at("indices"), at("leaves"), at("left_out")), (DRAW_AT as u32, 20, 28));
    }
}
