//! The lights of a frame: checks, uniforms, and what their passes are bound to.

use std::sync::Arc;

use scene::{Light, LightTexture};
use shadowmap::{MapSurface, Outside, ProjectionKind};

use super::frame::{Frame, Lamp, Lookup, Shadows, Technique};
use super::layout::{Layouts, StandIns};
use super::plan::{Shader, Variant, Work};
use crate::checked::{filled_buffer, prepared};
use crate::layout::{Basis, LightUniform};
use crate::lightvolume::Settings;
use crate::write_texture::write_texture;
use crate::{GpuBvh, PrepareError, Tessellation};

/// Checks that every map can serve its light, and that the technique finds what it needs.
pub(super) fn check_maps(frame: &Frame<'_>) -> Result<(), PrepareError> {
    let variance = frame.technique.lookup() == Some(Lookup::Variance);
    let hybrid = matches!(frame.technique, Technique::Hybrid(_));
    for (index, lamp) in frame.lamps.iter().enumerate() {
        let Some(shadows) = lamp.shadows else { continue };
        if hybrid && lamp.volume.is_none() {
            return Err(PrepareError::NoVolume { light: index });
        }
        let Some(map) = shadows.map() else { continue };
        let projection = map.projection().kind();
        let (wanted, kind) = match lamp.light {
            Light::Point(_) => (ProjectionKind::Cube, "point"),
            Light::Spot(_) => (ProjectionKind::Perspective, "spot"),
            Light::Directional(_) => (ProjectionKind::Orthographic, "directional"),
        };
        if projection != wanted {
            let got = match projection {
                ProjectionKind::Perspective => "a perspective",
                ProjectionKind::Orthographic => "an orthographic",
                ProjectionKind::Cube => "a cube",
            };
            return Err(PrepareError::WrongMap { light: index, map: got, kind });
        }
        let from_mesh =
            matches!(frame.technique, Technique::LightVolume { tessellation: Tessellation::Mesh, .. });
        if from_mesh && map.mesh().is_none_or(|mesh| mesh.map_size() != map.size()) {
            return Err(PrepareError::NoMesh { light: index });
        }
        if variance && map.moments().is_none() {
            return Err(PrepareError::NoMoments { light: index });
        }
    }
    if let Some(Lookup::PercentageCloser { width }) = frame.technique.lookup() {
        shadowmap::Filter::pcf(width)?;
    }
    Ok(())
}

/// The meaning of the map that a variant reads.
pub(super) fn surface(variant: &Variant) -> MapSurface {
    if variant.linear { MapSurface::Linear } else { MapSurface::Step }
}

fn reads_pyramid(variant: &Variant) -> bool {
    variant.shader == Shader::Exact && variant.shadowed
}

/// A light's uniform for one view.
pub(super) fn uniform(device: &wgpu::Device, frame: &Frame<'_>, work: &Work, basis: &Basis) -> LightUniform {
    let Some(lamp) = work.lamp.map(|index| &frame.lamps[index]) else {
        // the medium's own glow: no light
        let mut uniform: LightUniform = bytemuck::Zeroable::zeroed();
        uniform.samples = work.samples;
        return uniform;
    };
    let mut uniform = LightUniform::new(basis, lamp.light);
    (uniform.samples, uniform.kernel, uniform.refine) = (work.samples, work.kernel, work.refine);
    uniform.lit_samples = work.lit_samples;
    uniform.table_end = table_end(frame, &uniform);
    if let Some(shadows) = lamp.shadows {
        uniform = uniform.with_occluders(basis, shadows.casters());
    }
    if let Some(map) = lamp.shadows.and_then(|shadows| shadows.map()) {
        uniform = uniform.with_map(basis, map.projection(), map.size());
        uniform.outside = u32::from(map.outside() == Outside::Lit);
        if let Some(moments) = map.moments() {
            uniform.variance[..3].copy_from_slice(&moments.parameters);
        }
        if reads_pyramid(&work.variant)
            && let Ok(pyramid) = map.pyramid(device, surface(&work.variant))
        {
            uniform.map_top = pyramid.top();
        }
    }
    uniform
}

/// Depth of an orthographic map that nothing in the scene comes near to, and that counts as infinite in a local light's:
/// ten thousand times the way to the far side of the casters; units: m.
pub(super) fn far_of(shadows: &Shadows<'_>) -> f32 {
    let Some(map) = shadows.map() else { return 1.0 };
    let (casters, origin) = (shadows.casters(), map.projection().faces()[0].origin);
    if casters.is_empty() {
        return 1e4;
    }
    let reach = (casters.center().as_dvec3() - origin).length() + f64::from(casters.diagonal());
    (1e4 * reach.max(1e-20)) as f32
}

/// What the tessellation of a light's volume depends on, where it is no plain grid.
pub(super) fn tessellation(frame: &Frame<'_>, work: &Work) -> Option<Settings> {
    let Some(Tessellation::Adaptive { criterion, threshold, most_leaves }) = work.tessellation else {
        return None;
    };
    let shadows = frame.lamps[work.lamp?].shadows?;
    Some(Settings { criterion, threshold, far: far_of(&shadows), most_leaves })
}

/// Distance at which a table as printed ends: e⁻⁸ of the light is left behind the light's distance there; units: m.
fn table_end(frame: &Frame<'_>, light: &LightUniform) -> f32 {
    let distance = glam::Vec3::from(light.to_light).length();
    let sigma_t = frame.medium.coefficients.sigma_t();
    let least = sigma_t.into_iter().filter(|&sigma_t| sigma_t > 0.0).fold(f32::INFINITY, f32::min);
    if least.is_finite() { distance + 8.0 / least } else { 100.0 * distance }
}

/// The pictures of a frame's lights: as they are, and at every size.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightPictures<'a> {
    pub(super) plain: &'a [Option<wgpu::TextureView>],
    pub(super) mips: &'a [Option<wgpu::TextureView>],
}

/// What a light's pass is bound to.
pub(super) fn group<'a>(
    device: &wgpu::Device,
    layouts: &Layouts,
    stand_ins: &'a StandIns,
    frame: &Frame<'_>,
    work: &Work,
    uniform: &LightUniform,
    pictures: LightPictures<'a>,
    [faces, table]: [Option<&'a wgpu::TextureView>; 2],
) -> wgpu::BindGroup {
    let buffer = filled_buffer(device, "fog light", bytemuck::bytes_of(uniform), wgpu::BufferUsages::UNIFORM);
    let map = work.lamp.and_then(|index| frame.lamps[index].shadows).and_then(|shadows| shadows.map());
    let array = |texture: &wgpu::Texture| {
        texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        })
    };
    let spare = || stand_ins.array.clone();
    let heights = map.map_or_else(spare, |map| array(map.heights()));
    let pyramid = map
        .filter(|_| reads_pyramid(&work.variant))
        .and_then(|map| map.pyramid(device, surface(&work.variant)).ok())
        .map_or_else(spare, |pyramid| pyramid.view());
    let moments = map
        .and_then(|map| map.moments())
        .filter(|_| work.variant.lookup == 2)
        .map_or_else(spare, |moments| array(&moments.texture));
    let of_lamp = |views: &'a [Option<wgpu::TextureView>]| work.lamp.and_then(|index| views[index].as_ref());
    let picture = of_lamp(pictures.plain).unwrap_or(&stand_ins.flat);
    let mips = of_lamp(pictures.mips).unwrap_or(&stand_ins.filtered);
    let faces = faces.unwrap_or(&stand_ins.flat);
    let table = table.unwrap_or(&stand_ins.flat);
    let textures = [&heights, &pyramid, &moments, picture, faces, mips, table];
    light_group(device, layouts, &stand_ins.sampler, &buffer, textures)
}

/// A light's group: its uniform, then its map's heights, pyramid and moments, its picture, the faces of its volume, its
/// picture at every size and the frame's table.
pub(crate) fn light_group(
    device: &wgpu::Device,
    layouts: &Layouts,
    sampler: &wgpu::Sampler,
    uniform: &wgpu::Buffer,
    textures: [&wgpu::TextureView; 7],
) -> wgpu::BindGroup {
    let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }];
    let views = textures.map(wgpu::BindingResource::TextureView);
    entries.extend(
        // the sampler is the seventh
        views
            .into_iter()
            .zip([1, 2, 3, 4, 5, 6, 8])
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource }),
    );
    entries.push(wgpu::BindGroupEntry { binding: 7, resource: wgpu::BindingResource::Sampler(sampler) });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("fog light"),
        layout: &layouts.light,
        entries: &entries,
    })
}

/// The hierarchy that a light's shadow rays go through.
pub(super) fn bvh_group(
    device: &wgpu::Device,
    layouts: &Layouts,
    frame: &Frame<'_>,
    work: &Work,
) -> Option<wgpu::BindGroup> {
    Some(rays_group(device, layouts, frame.lamps[work.lamp?].shadows?.bvh()?))
}

/// The group of a hierarchy.
pub(crate) fn rays_group(device: &wgpu::Device, layouts: &Layouts, bvh: &GpuBvh) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("fog bvh"),
        layout: &layouts.bvh,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: bvh.nodes().as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: bvh.triangles().as_entire_binding() },
        ],
    })
}

/// Pictures of spot lights on the GPU; one that several lights or frames share is uploaded once.
#[derive(Debug, Default)]
pub(crate) struct Pictures {
    known: Vec<(Arc<LightTexture>, wgpu::TextureView)>,
}

impl Pictures {
    /// The picture of each light, if it has one; those that no light has any more are dropped.
    pub(crate) fn of(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        lamps: &[Lamp<'_>],
    ) -> Result<Vec<Option<wgpu::TextureView>>, PrepareError> {
        let wanted = |lamp: &Lamp<'_>| match lamp.light {
            Light::Spot(spot) => spot.texture.clone(),
            Light::Point(_) | Light::Directional(_) => None,
        };
        let mut kept: Vec<(Arc<LightTexture>, wgpu::TextureView)> = Vec::new();
        let mut views = Vec::new();
        for lamp in lamps {
            let Some(picture) = wanted(lamp) else {
                views.push(None);
                continue;
            };
            let known = kept.iter().chain(&self.known).find(|(known, _)| Arc::ptr_eq(known, &picture));
            let view = match known {
                Some((_, view)) => view.clone(),
                None => upload(device, queue, &picture)?,
            };
            kept.push((picture, view.clone()));
            views.push(Some(view));
        }
        self.known = kept;
        Ok(views)
    }

    /// Memory; units: bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.known.iter().map(|(picture, _)| 16 * picture.texels.len() as u64).sum()
    }
}

fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    picture: &LightTexture,
) -> Result<wgpu::TextureView, PrepareError> {
    let limit = device.limits().max_texture_dimension_2d;
    let side = picture.width.max(picture.height);
    if side > limit {
        return Err(PrepareError::TooLarge {
            what: "the light texture's side",
            needed: side.into(),
            limit: limit.into(),
            unit: "texels",
        });
    }
    prepared(device, "the light texture", || {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("light texture"),
            size: wgpu::Extent3d { width: picture.width, height: picture.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let texels: Vec<[f32; 4]> = picture.texels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        write_texture(queue, &texture, bytemuck::cast_slice(&texels), 16);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    })
}
