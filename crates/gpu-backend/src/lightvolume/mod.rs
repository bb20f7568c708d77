//! Light volumes on the GPU: the surface that is extruded from a light's map, tessellated in compute, and drawn to find where
//! view rays enter and leave the light (Billeter, Sintorn and Assarsson 2010).
//!
//! A light that stands still keeps its tessellation. Twins of `shaders/lightvolume/`; the same on the CPU is in
//! `lightvolume`.

mod draw;
mod mesh;
mod tessellation;

pub use ::lightvolume::Criterion;
pub(crate) use draw::{LightVolumePasses, VolumeTarget, VolumeVariant, fitting, kept_bytes, sums_texture};
pub use mesh::LightMesh;
pub use tessellation::LeafCount;
pub(crate) use tessellation::{Leaves, Settings, TessellationPasses};

/// Most leaves of a tessellation unless told otherwise: 46 MB.
pub const DEFAULT_MOST_LEAVES: u32 = 1 << 20;

/// Crossings of a pixel, on average, for which there is room unless told otherwise.
pub(crate) const USUALLY_KEPT: u32 = 6;

/// How the surface of a light volume is divided into triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tessellation {
    /// Two triangles for each cell between the map's texels, without a vertex buffer: six vertices a cell.
    Grid,
    /// The same by indices, so that two vertices a cell are enough.
    IndexedGrid,
    /// Quads of a balanced quadtree, split where they are too coarse.
    Adaptive {
        /// What is compared with the threshold.
        criterion: Criterion,
        /// Units: m.
        threshold: f32,
        /// Most leaves that there is room for; where more are needed, the finest levels are left out, and the statistics
        /// say so.
        most_leaves: u32,
    },
    /// Triangles that were made beforehand, see [`ShadowMap::with_mesh`](crate::ShadowMap::with_mesh): for a spot or
    /// directional light that stands still.
    Mesh,
}

impl Default for Tessellation {
    /// By distance, a centimetre.
    fn default() -> Self {
        Self::Adaptive { criterion: Criterion::Distance, threshold: 0.01, most_leaves: DEFAULT_MOST_LEAVES }
    }
}
