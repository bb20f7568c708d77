//! The min-max pyramid of a map on the GPU, built in one dispatch, or two for maps of more than 512 texels a side.
//!
//! Twin of `shaders/map/pyramid.wgsl`. Every second level is built: blocks grow four times a side. They lie in the mips
//! of one texture, whose sides are padded so that each mip holds all of its level's blocks.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use shadowmap::MapSurface;

use super::ShadowMap;
use crate::CreateError;
use crate::checked::{created, filled_buffer};
use crate::pass::{ComputePass, Dispatch, compute_pipeline, storage_texture, texture, uniform};
use crate::pipelines::Pipelines;

const PASS: &str = "map/pyramid";

/// Level whose blocks the first dispatch ends with.
const FINE_TOP: u32 = 6;

/// Blocks along a side of the coarsest level, at most: a ray crosses few of them, and small maps need one dispatch.
const TOP_BLOCKS: u32 = 8;

/// Texels along a side that a workgroup takes.
const TILE: u32 = 64;

/// The textures of a pyramid, and which version of the map they are of.
#[derive(Debug, Clone)]
pub(crate) struct Pyramid {
    texture: wgpu::Texture,
    top: u32,
    surface: MapSurface,
    cells: (u32, u32),
    built: Arc<AtomicU64>,
}

impl Pyramid {
    pub(super) fn new(device: &wgpu::Device, map: &ShadowMap, surface: MapSurface) -> Self {
        let shrink = u32::from(surface == MapSurface::Linear);
        let cells = (map.size().0.saturating_sub(shrink), map.size().1.saturating_sub(shrink));
        let side = cells.0.max(cells.1).max(1);
        let mut top = FINE_TOP;
        while side.div_ceil(1 << top) > TOP_BLOCKS {
            top += 2;
        }
        let padded = |count: u32| count.max(1).div_ceil(1 << top) << top;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow map pyramid"),
            size: wgpu::Extent3d {
                width: padded(cells.0),
                height: padded(cells.1),
                depth_or_array_layers: map.projection().faces().len() as u32,
            },
            mip_level_count: top + 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rg32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
            view_formats: &[],
        });
        Self { texture, top, surface, cells, built: Arc::new(AtomicU64::new(0)) }
    }

    /// Coarsest level.
    pub(crate) fn top(&self) -> u32 {
        self.top
    }

    /// All levels, for the walk.
    pub(crate) fn view(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("shadow map pyramid"),
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        })
    }

    fn level(&self, level: u32) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("shadow map pyramid level"),
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            base_mip_level: level,
            mip_level_count: Some(1),
            ..Default::default()
        })
    }

    /// Memory of all mips; units: bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let size = self.texture.size();
        let level = |l: u32| u64::from(size.width >> l) * u64::from(size.height >> l) * 8;
        (0..=self.top).map(level).sum::<u64>() * u64::from(size.depth_or_array_layers)
    }

    /// Whether the ranges are those of the map's `version`.
    pub(crate) fn is_current(&self, version: u64) -> bool {
        self.built.load(Ordering::Relaxed) == version
    }

    /// Says that the ranges are those of the map's `version`, once the passes are encoded.
    pub(crate) fn mark(&self, version: u64) {
        self.built.store(version, Ordering::Relaxed);
    }
}

/// The pipelines that build pyramids.
#[derive(Debug)]
pub(crate) struct PyramidBuilder {
    layout: wgpu::BindGroupLayout,
    /// Of steps, of cells between centres, and of ranges.
    pipelines: [wgpu::ComputePipeline; 3],
    /// Stand in for levels that a pyramid does not have.
    spares: [wgpu::TextureView; 3],
}

impl PyramidBuilder {
    pub(crate) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let array = wgpu::TextureViewDimension::D2Array;
        let output = |binding| storage_texture(binding, wgpu::TextureFormat::Rg32Float, array);
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(PASS),
            entries: &[texture(0, array), output(1), output(2), output(3), output(4), uniform(5)],
        });
        let pipeline = |linear: f64, coarse: f64| {
            compute_pipeline(pipelines, PASS, &[&layout], &[("LINEAR", linear), ("COARSE", coarse)])
        };
        let pipelines = [pipeline(0.0, 0.0)?, pipeline(1.0, 0.0)?, pipeline(0.0, 1.0)?];
        let spare = || {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("spare pyramid level"),
                size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rg32Float,
                usage: wgpu::TextureUsages::STORAGE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor { dimension: Some(array), ..Default::default() })
        };
        // three: one texture must not be bound twice where it is written
        let spares = created(device, PASS, || [spare(), spare(), spare()])?;
        Ok(Self { layout, pipelines, spares })
    }

    /// The passes that build `pyramid` from `map`.
    pub(crate) fn passes(
        &self,
        device: &wgpu::Device,
        map: &ShadowMap,
        pyramid: &Pyramid,
    ) -> Vec<ComputePass> {
        let heights = map.heights().create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let faces = map.projection().faces().len() as u32;
        let linear = usize::from(pyramid.surface == MapSurface::Linear);
        let mut passes = vec![self.pass(
            device,
            "pyramid, fine",
            linear,
            &heights,
            [0, 2, 4, 6].map(|level| pyramid.level(level)),
            pyramid.cells,
            faces,
        )];
        if pyramid.top > FINE_TOP {
            let blocks = |count: u32| count.div_ceil(1 << FINE_TOP);
            let level = |level: u32, spare: usize| {
                if level <= pyramid.top { pyramid.level(level) } else { self.spares[spare].clone() }
            };
            passes.push(self.pass(
                device,
                "pyramid, coarse",
                2,
                &pyramid.level(FINE_TOP),
                [self.spares[0].clone(), pyramid.level(8), level(10, 1), level(12, 2)],
                (blocks(pyramid.cells.0), blocks(pyramid.cells.1)),
                faces,
            ));
        }
        passes
    }

    fn pass(
        &self,
        device: &wgpu::Device,
        label: &'static str,
        pipeline: usize,
        input: &wgpu::TextureView,
        outputs: [wgpu::TextureView; 4],
        cells: (u32, u32),
        faces: u32,
    ) -> ComputePass {
        let size = filled_buffer(
            device,
            "pyramid size",
            bytemuck::cast_slice(&[cells.0, cells.1, 0, 0]),
            wgpu::BufferUsages::UNIFORM,
        );
        let mut entries =
            vec![wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(input) }];
        entries.extend(outputs.iter().zip(1..).map(|(view, binding)| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::TextureView(view),
        }));
        entries.push(wgpu::BindGroupEntry { binding: 5, resource: size.as_entire_binding() });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &self.layout,
            entries: &entries,
        });
        ComputePass {
            label: label.to_owned(),
            pipeline: self.pipelines[pipeline].clone(),
            groups: vec![group],
            dispatch: Dispatch::Groups([cells.0.max(1).div_ceil(TILE), cells.1.max(1).div_ceil(TILE), faces]),
        }
    }
}
