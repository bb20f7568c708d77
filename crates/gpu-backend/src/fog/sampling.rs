//! Adaptive sampling: view rays are traced where airlight changes across a picture. Twin of `shaders/sample/`; the same on
//! the CPU is `hybrid_march::Adaptive`.
//!
//! What is traced is found on the GPU, in lists that indirect dispatches go through, so that nothing waits for the CPU.

use bytemuck::{Pod, Zeroable};
use hybrid_march::{Adaptive, AdaptiveLevel};

use crate::checked::{check_size, filled_buffer, prepared};
use crate::pass::{ComputePass, Dispatch, Step, bind, compute_pipeline, storage_written, texture, uniform};
use crate::pipelines::Pipelines;
use crate::{CreateError, PrepareError};

/// `Level` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Level {
    stride: u32,
    spacing: u32,
    survey: u32,
    target_error: f32,
    budget: f32,
    share: f32,
    most: f32,
    most_traced: f32,
}

/// Bins of a histogram, and the one for what is too large for them.
const BINS_AND_REST: usize = 57;

/// `Sampling` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct State {
    found: u32,
    traced: u32,
    error: f32,
    unit: f32,
    groups: [u32; 3],
    left: f32,
    counts: [u32; BINS_AND_REST],
    _pad: [u32; 3],
}

/// Bytes in front of a list's pixels.
const LIST_HEAD: u64 = 16;

/// Where the rays traced so far stand in the state, and the groups of a dispatch over a list; units: bytes.
pub(super) const TRACED: u64 = std::mem::offset_of!(State, traced) as u64;
const GROUPS: u64 = std::mem::offset_of!(State, groups) as u64;

/// What a view's sampling is kept in.
#[derive(Debug)]
pub(crate) struct Samples {
    spacing: u32,
    rays: wgpu::Buffer,
    values: wgpu::Buffer,
    unshadowed: wgpu::Buffer,
    inverse_depths: wgpu::Buffer,
    pub(super) state: wgpu::Buffer,
}

impl Samples {
    /// For a picture of `size` pixels.
    pub(super) fn new(device: &wgpu::Device, size: (u32, u32), spacing: u32) -> Result<Self, PrepareError> {
        let what = "a view's adaptive sampling";
        let pixels = u64::from(padded(size.0)) * u64::from(size.1);
        let (columns, rows) = lattice(size, spacing);
        check_size(device, what, 16 * pixels)?;
        prepared(device, what, || {
            let buffer = |label, size, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size,
                    usage: wgpu::BufferUsages::STORAGE | usage,
                    mapped_at_creation: false,
                })
            };
            let none = wgpu::BufferUsages::empty();
            let state = wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_SRC;
            Self {
                spacing,
                rays: buffer("listed rays", LIST_HEAD + 4 * pixels, none),
                values: buffer("listed radiance", 16 * pixels, wgpu::BufferUsages::COPY_SRC),
                unshadowed: buffer("unshadowed lattice", 16 * u64::from(columns) * u64::from(rows), none),
                inverse_depths: buffer("inverse depths", 4 * pixels, none),
                state: buffer("adaptive sampling", size_of::<State>() as u64, state),
            }
        })
    }

    /// Whether it fits a lattice of that spacing.
    pub(super) fn fits(&self, spacing: u32) -> bool {
        self.spacing == spacing
    }

    /// The list and the radiance of its pixels, as passes over it are bound to them.
    pub(super) fn list(&self) -> [&wgpu::Buffer; 2] {
        [&self.rays, &self.values]
    }

    /// A dispatch over the list.
    pub(super) fn dispatch(&self) -> Dispatch {
        Dispatch::Indirect(self.state.clone(), GROUPS)
    }

    /// Memory; units: bytes.
    pub(super) fn bytes(&self) -> u64 {
        [&self.rays, &self.values, &self.unshadowed, &self.inverse_depths, &self.state]
            .into_iter()
            .map(wgpu::Buffer::size)
            .sum()
    }
}

/// Pixels of a row of an array that can be copied into a texture.
fn padded(width: u32) -> u32 {
    width.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT / 16)
}

/// Columns and rows of the first rays.
pub(super) fn lattice((width, height): (u32, u32), spacing: u32) -> (u32, u32) {
    (width.div_ceil(spacing), height.div_ceil(spacing))
}

/// A view that is sampled.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampledView<'a> {
    pub(super) uniform: &'a wgpu::Buffer,
    pub(super) size: (u32, u32),
    pub(super) ray_ends: &'a wgpu::TextureView,
    pub(super) samples: &'a Samples,
    /// What the airlight of all pixels goes into.
    pub(super) picture: &'a wgpu::Texture,
}

/// The passes that decide which rays are traced.
#[derive(Debug)]
pub(crate) struct SamplePasses {
    layout: wgpu::BindGroupLayout,
    lattice: wgpu::ComputePipeline,
    close: wgpu::ComputePipeline,
    keep: wgpu::ComputePipeline,
    budget: wgpu::ComputePipeline,
    survey: wgpu::ComputePipeline,
    tolerance: wgpu::ComputePipeline,
    refine: wgpu::ComputePipeline,
}

impl SamplePasses {
    pub(super) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let flat = wgpu::TextureViewDimension::D2;
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("adaptive sampling"),
            entries: &[
                uniform(0),
                texture(1, flat),
                storage_written(2),
                storage_written(3),
                uniform(4),
                storage_written(5),
                storage_written(6),
                storage_written(7),
            ],
        });
        let pipeline = |name: &str| compute_pipeline(pipelines, &format!("sample/{name}"), &[&layout], &[]);
        Ok(Self {
            lattice: pipeline("lattice")?,
            close: pipeline("close")?,
            keep: pipeline("keep")?,
            budget: pipeline("budget")?,
            survey: pipeline("survey")?,
            tolerance: pipeline("tolerance")?,
            refine: pipeline("refine")?,
            layout,
        })
    }

    /// The steps that sample a view. `trace` are the passes over the list that give its pixels their airlight, `unlit` the same
    /// as if nothing cast a shadow.
    pub(super) fn steps(
        &self,
        device: &wgpu::Device,
        view: &SampledView<'_>,
        adaptive: &Adaptive,
        trace: &[ComputePass],
        unlit: &[ComputePass],
    ) -> Vec<Step> {
        let pass = |name: &str, pipeline: &wgpu::ComputePipeline, group: &wgpu::BindGroup, groups| {
            Step::Compute(ComputePass {
                label: name.to_owned(),
                pipeline: pipeline.clone(),
                groups: vec![group.clone()],
                dispatch: Dispatch::Groups(groups),
            })
        };
        let over = |(columns, rows): (u32, u32)| [columns.div_ceil(8), rows.div_ceil(8), 1];
        let first = lattice(view.size, adaptive.spacing);
        let mut steps = Vec::new();
        for (index, level) in adaptive.levels(view.size).enumerate() {
            let group = self.group(device, view, adaptive, &level);
            if index == 0 {
                steps.push(pass("sampling, lattice", &self.lattice, &group, over(view.size)));
                steps.push(pass("sampling, list", &self.close, &group, [1, 1, 1]));
                steps.extend(unlit.iter().cloned().map(Step::Compute));
                steps.push(pass("sampling, unshadowed", &self.keep, &group, over(first)));
                steps.extend(trace.iter().cloned().map(Step::Compute));
                steps.push(pass("sampling, budget", &self.budget, &group, [1, 1, 1]));
            }
            let [columns, rows, _] = over(lattice(view.size, level.stride));
            let surveyed = [columns.div_ceil(level.survey), rows, 1];
            steps.push(pass("sampling, survey", &self.survey, &group, surveyed));
            steps.push(pass("sampling, tolerance", &self.tolerance, &group, [1, 1, 1]));
            steps.push(pass("sampling, refine", &self.refine, &group, [columns, rows, 1]));
            steps.push(pass("sampling, list", &self.close, &group, [1, 1, 1]));
            steps.extend(trace.iter().cloned().map(Step::Compute));
        }
        steps.push(Step::CopyToTexture {
            from: view.samples.values.clone(),
            bytes_per_row: 16 * padded(view.size.0),
            to: view.picture.clone(),
        });
        steps
    }

    fn group(
        &self,
        device: &wgpu::Device,
        view: &SampledView<'_>,
        adaptive: &Adaptive,
        level: &AdaptiveLevel,
    ) -> wgpu::BindGroup {
        let level = Level {
            stride: level.stride,
            spacing: adaptive.spacing,
            survey: level.survey,
            target_error: adaptive.target_error,
            budget: adaptive.budget(view.size) as f32,
            share: level.share as f32,
            most: adaptive.most_estimate(view.size) as f32,
            most_traced: level.most_traced as f32,
        };
        let bytes = bytemuck::bytes_of(&level);
        let level = filled_buffer(device, "sampling level", bytes, wgpu::BufferUsages::UNIFORM);
        let samples = view.samples;
        bind(
            device,
            "adaptive sampling",
            &self.layout,
            [
                view.uniform.as_entire_binding(),
                wgpu::BindingResource::TextureView(view.ray_ends),
                samples.rays.as_entire_binding(),
                samples.values.as_entire_binding(),
                level.as_entire_binding(),
                samples.state.as_entire_binding(),
                samples.unshadowed.as_entire_binding(),
                samples.inverse_depths.as_entire_binding(),
            ],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shaders_read_what_rust_writes() {
        let (fields, span) = wgsl_struct("sample/refine", "Level");
        assert_eq!(span as usize, size_of::<Level>());
        assert_eq!(
            fields,
            offsets!(Level: stride, spacing, survey, target_error, budget, share, most, most_traced)
        );
        let (fields, span) = wgsl_struct("sample/refine", "Sampling");
        assert_eq!(span as usize, size_of::<State>());
        assert_eq!(fields, offsets!(State: found, traced, error, unit, groups, left, counts, _pad));
        let (fields, _) = wgsl_struct("sample/refine", "RayList");
        assert!(fields.iter().any(|(name, at)| name == "pixels" && u64::from(*at) == LIST_HEAD));
    }
}
