//! The density of a medium as a texture.

use scene::{Density, DensityGrid, Medium};

use super::layout::StandIns;
use crate::PrepareError;
use crate::checked::prepared;
use crate::write_texture::write_texture;

/// The grid of the last frame that had one.
#[derive(Debug, Default)]
pub(crate) struct DensityTexture {
    known: Option<(DensityGrid, wgpu::TextureView)>,
}

impl DensityTexture {
    /// The texture of a medium's density grid; uploaded again only if the grid is another one.
    pub(crate) fn of(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        medium: &Medium,
        stand_ins: &StandIns,
    ) -> Result<wgpu::TextureView, PrepareError> {
        let Some(Density::Grid(grid)) = &medium.density else {
            return Ok(stand_ins.volume.clone());
        };
        if let Some((known, view)) = &self.known
            && known == grid
        {
            return Ok(view.clone());
        }
        let [x, y, z] = grid.size;
        let limit = device.limits().max_texture_dimension_3d;
        if x.max(y).max(z) > limit {
            return Err(PrepareError::TooLarge {
                what: "the density grid's side",
                needed: x.max(y).max(z).into(),
                limit: limit.into(),
                unit: "cells",
            });
        }
        let view = prepared(device, "the density grid", || {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("density grid"),
                size: wgpu::Extent3d { width: x, height: y, depth_or_array_layers: z },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format: wgpu::TextureFormat::R32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            write_texture(queue, &texture, bytemuck::cast_slice(&grid.values), 4);
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        })?;
        self.known = Some((grid.clone(), view.clone()));
        Ok(view)
    }
}
