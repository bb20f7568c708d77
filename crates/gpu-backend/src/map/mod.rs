//! Shadow maps on the GPU: heights of a light's map, their pyramids and moments.
//!
//! A map comes from the CPU ([`ShadowMap::upload`]), from a depth buffer that a host's renderer drew
//! ([`ShadowMap::from_host`]), or is drawn here ([`DepthDrawer`](crate::DepthDrawer)). It is stored as heights
//! (`shaders/shared/shadow_map.wgsl`) in one r32float texture, a layer a face. What else a technique needs is made when
//! a frame first asks for it, and kept for as long as the map stays the same.

mod host;
mod pyramid;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use shadowmap::{Bias, DepthMap, MapSurface, Outside, Projection, ProjectionKind, VarianceMap};

pub use host::HostDepth;
pub(crate) use host::{HostConverter, check_depth_texture, height_of_device};
pub(crate) use pyramid::{Pyramid, PyramidBuilder};

use crate::checked::prepared;
use crate::lightvolume::{Leaves, Settings};
use crate::write_texture::write_texture;
use crate::{LeafCount, LightMesh, PrepareError, ReadError};

/// A light's shadow map on the GPU.
///
/// Cloning shares the textures.
#[derive(Debug, Clone)]
pub struct ShadowMap {
    projection: Projection,
    size: (u32, u32),
    outside: Outside,
    heights: wgpu::Texture,
    /// Grows with every change of the heights.
    version: Arc<AtomicU64>,
    pyramids: [Arc<OnceLock<Pyramid>>; 2],
    /// The tessellation that was asked for last.
    leaves: Arc<Mutex<Option<Leaves>>>,
    moments: Option<Moments>,
    mesh: Option<LightMesh>,
    /// What the heights are converted from, if they are a host's.
    host: Option<Arc<host::HostSource>>,
    /// Version of the heights that were converted last.
    converted: Arc<AtomicU64>,
}

/// Moments of depth on the GPU, for variance lookups.
#[derive(Debug, Clone)]
pub(crate) struct Moments {
    pub(crate) texture: wgpu::Texture,
    /// Depth of 1 (m), least variance, bleed reduction.
    pub(crate) parameters: [f32; 3],
}

impl ShadowMap {
    /// Uploads a map; only the constant part of `bias` counts in a medium.
    ///
    /// # Errors
    /// [`PrepareError::TooLarge`] if a side exceeds what the device's textures allow, [`PrepareError::Device`] if there
    /// is no memory or the device is lost.
    pub fn upload(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        map: &DepthMap,
        bias: Bias,
    ) -> Result<Self, PrepareError> {
        let mut uploaded = Self::empty(device, map.projection().clone(), map.size())?;
        uploaded.outside = map.outside();
        let heights = heights_of(map, bias);
        prepared(device, "the shadow map", || {
            write_texture(queue, &uploaded.heights, bytemuck::cast_slice(&heights), size_of::<f32>() as u32);
        })?;
        Ok(uploaded)
    }

    /// Replaces the depths by those of another map of the same light; pyramids are rebuilt when next asked for.
    ///
    /// # Errors
    /// [`PrepareError::Texture`] if the map has another size or kind, else as [`ShadowMap::upload`].
    pub fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        map: &DepthMap,
        bias: Bias,
    ) -> Result<(), PrepareError> {
        self.check_same(map.size(), map.projection())?;
        self.projection = map.projection().clone();
        self.host = None;
        let heights = heights_of(map, bias);
        prepared(device, "the shadow map", || {
            write_texture(queue, &self.heights, bytemuck::cast_slice(&heights), size_of::<f32>() as u32);
        })?;
        self.touch();
        Ok(())
    }

    /// Refuses a map that does not fit in the place of this one.
    fn check_same(&self, size: (u32, u32), projection: &Projection) -> Result<(), PrepareError> {
        if size == self.size && projection.kind() == self.projection.kind() {
            return Ok(());
        }
        let text = |(width, height): (u32, u32), projection: &Projection| {
            format!("{width} x {height} texels, {:?}", projection.kind())
        };
        Err(PrepareError::Texture {
            what: "the new map",
            got: text(size, projection),
            wanted: text(self.size, &self.projection),
        })
    }

    /// With the moments that variance lookups need.
    ///
    /// # Errors
    /// [`PrepareError::Texture`] if the moments have another size, [`PrepareError::Device`] as [`ShadowMap::upload`].
    pub fn with_moments(
        mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        moments: &VarianceMap,
    ) -> Result<Self, PrepareError> {
        let texels = self.size.0 as usize * self.size.1 as usize * self.projection.faces().len();
        if moments.moments().len() != texels {
            return Err(PrepareError::Texture {
                what: "the variance map",
                got: format!("{} texels", moments.moments().len()),
                wanted: format!("{texels} texels"),
            });
        }
        let texture = prepared(device, "the moments", || {
            let texture = self.texture(device, "shadow map moments", wgpu::TextureFormat::Rg32Float);
            write_texture(queue, &texture, bytemuck::cast_slice(moments.moments()), 8);
            texture
        })?;
        let parameters = [moments.far(), moments.least_variance(), moments.bleed_reduction()];
        self.moments = Some(Moments { texture, parameters });
        Ok(self)
    }

    /// With the triangles of its light volume, for [`Tessellation::Mesh`](crate::Tessellation::Mesh).
    #[must_use]
    pub fn with_mesh(mut self, mesh: LightMesh) -> Self {
        self.mesh = Some(mesh);
        self
    }

    /// The triangles that [`ShadowMap::with_mesh`] was given.
    pub fn mesh(&self) -> Option<&LightMesh> {
        self.mesh.as_ref()
    }

    /// The same map with another answer for what it does not see.
    #[must_use]
    pub fn with_outside(mut self, outside: Outside) -> Self {
        self.outside = outside;
        self
    }

    /// A map whose heights are not written yet.
    pub(crate) fn empty(
        device: &wgpu::Device,
        projection: Projection,
        size: (u32, u32),
    ) -> Result<Self, PrepareError> {
        check_side(device, "the shadow map's side", size, "texels")?;
        let (width, height) = size;
        if width == 0 || height == 0 {
            return Err(shadowmap::ShadowMapError::Size { width, height }.into());
        }
        if projection.kind() == ProjectionKind::Cube && width != height {
            return Err(shadowmap::ShadowMapError::NotSquare { width, height }.into());
        }
        let outside = match projection.kind() {
            ProjectionKind::Perspective => Outside::Dark,
            ProjectionKind::Orthographic | ProjectionKind::Cube => Outside::Lit,
        };
        let heights = prepared(device, "the shadow map", || {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("shadow map heights"),
                size: extent(&projection, size),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::STORAGE_BINDING
                    | wgpu::TextureUsages::COPY_DST
                    | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        })?;
        Ok(Self {
            projection,
            size,
            outside,
            heights,
            version: Arc::new(AtomicU64::new(1)),
            pyramids: Default::default(),
            leaves: Arc::default(),
            moments: None,
            mesh: None,
            host: None,
            converted: Arc::default(),
        })
    }

    fn texture(&self, device: &wgpu::Device, label: &str, format: wgpu::TextureFormat) -> wgpu::Texture {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: extent(&self.projection, self.size),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    /// Says that the heights have changed: pyramids are rebuilt by the next frame that asks for them.
    pub fn touch(&self) {
        self.version.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn version(&self) -> u64 {
        self.version.load(Ordering::Relaxed)
    }

    /// How the light sees.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// Columns and rows of a face.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// What holds for points that the map does not see.
    pub fn outside(&self) -> Outside {
        self.outside
    }

    /// Memory of heights, moments and the pyramids that have been asked for; units: bytes.
    pub fn bytes(&self) -> u64 {
        let texels = u64::from(self.size.0) * u64::from(self.size.1) * self.projection.faces().len() as u64;
        let pyramids = self.pyramids.iter().filter_map(|pyramid| pyramid.get()).map(Pyramid::bytes);
        let leaves = self.tessellated().map_or(0, |leaves| leaves.bytes())
            + self.mesh.as_ref().map_or(0, LightMesh::bytes);
        texels * if self.moments.is_some() { 12 } else { 4 } + pyramids.sum::<u64>() + leaves
    }

    fn tessellated(&self) -> Option<Leaves> {
        self.leaves.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The map's tessellation with its buffers, made if they are not there; its leaves may be old.
    pub(crate) fn tessellation(
        &self,
        device: &wgpu::Device,
        settings: Settings,
    ) -> Result<Leaves, PrepareError> {
        if let Some(leaves) = self.tessellated().filter(|leaves| *leaves.settings() == settings) {
            return Ok(leaves);
        }
        let leaves = Leaves::new(device, self, settings)?;
        *self.leaves.lock().unwrap_or_else(PoisonError::into_inner) = Some(leaves.clone());
        Ok(leaves)
    }

    /// What the tessellation of the last frame came to, once it is submitted; submits a copy and waits for it.
    ///
    /// # Errors
    /// [`ReadError::Nothing`] if no frame has tessellated the map, [`ReadError::Device`] if the device is lost.
    pub fn read_leaf_count(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<LeafCount, ReadError> {
        self.tessellated().ok_or(ReadError::Nothing("tessellation"))?.read_count(device, queue)
    }

    /// The leaves of the last frame's tessellation in no order, once it is submitted; submits a copy and waits for it.
    /// Column and row (16 bits each); level (8 bits), edges with a finer neighbour (8 bits: 1 top, 2 right, 4 bottom,
    /// 8 left), face.
    ///
    /// # Errors
    /// As [`ShadowMap::read_leaf_count`].
    pub fn read_leaves(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Vec<[u32; 2]>, ReadError> {
        self.tessellated().ok_or(ReadError::Nothing("tessellation"))?.read_leaves(device, queue)
    }

    pub(crate) fn heights(&self) -> &wgpu::Texture {
        &self.heights
    }

    pub(crate) fn moments(&self) -> Option<&Moments> {
        self.moments.as_ref()
    }

    /// What the heights have to be converted from before this version of them can be read.
    pub(crate) fn unconverted(&self) -> Option<&host::HostSource> {
        let stale = self.converted.load(Ordering::Relaxed) != self.version();
        self.host.as_deref().filter(|_| stale)
    }

    /// Says that `version` is converted, once the pass is encoded.
    pub(crate) fn mark_converted(&self, version: u64) {
        self.converted.store(version, Ordering::Relaxed);
    }

    /// The pyramid of a meaning of the map, with its textures, made if they are not there; its ranges may be old.
    pub(crate) fn pyramid(
        &self,
        device: &wgpu::Device,
        surface: MapSurface,
    ) -> Result<Pyramid, PrepareError> {
        let slot = &self.pyramids[usize::from(surface == MapSurface::Linear)];
        if let Some(pyramid) = slot.get() {
            return Ok(pyramid.clone());
        }
        let made = prepared(device, "the map's pyramid", || Pyramid::new(device, self, surface))?;
        Ok(slot.get_or_init(|| made).clone())
    }
}

/// [`PrepareError::TooLarge`] if a texture's side is more than the device allows.
pub(crate) fn check_side(
    device: &wgpu::Device,
    what: &'static str,
    size: (u32, u32),
    unit: &'static str,
) -> Result<(), PrepareError> {
    let (needed, limit) = (size.0.max(size.1), device.limits().max_texture_dimension_2d);
    if needed > limit {
        return Err(PrepareError::TooLarge { what, needed: needed.into(), limit: limit.into(), unit });
    }
    Ok(())
}

fn extent(projection: &Projection, size: (u32, u32)) -> wgpu::Extent3d {
    wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: projection.faces().len() as u32 }
}

/// Height of a texel that nothing stops light in, in an orthographic map: `NOTHING` of the shaders.
pub(crate) const NOTHING: f32 = -3e38;

/// The heights that the shaders compare with: 1/depth, or −depth in orthographic maps, with the bias.
fn heights_of(map: &DepthMap, bias: Bias) -> Vec<f32> {
    let (flat, bias) = (map.projection().kind() == ProjectionKind::Orthographic, bias.in_medium());
    let height = |&depth: &f32| {
        let depth = f64::from(depth) + bias;
        match (flat, depth.is_finite()) {
            (true, false) => NOTHING,
            (true, true) => -depth as f32,
            (false, _) => (1.0 / depth) as f32,
        }
    };
    map.depths().iter().map(height).collect()
}
