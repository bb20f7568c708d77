//! The light volume: a closed mesh around what a map's light reaches, or around its shadow.

use glam::DVec4;
use shadowmap::{DepthMap, Outside, Projection, ProjectionKind};

use crate::builder::Builder;
use crate::hierarchy::Hierarchy;
use crate::nodes::Nodes;
use crate::quads::Quads;
use crate::vertex::Frame;
use crate::{Leaf, LightVolumeError, Options, Tessellation, Vertex, closure, delaunay};

/// A closed mesh whose inside is what the light of a map reaches, or for an orthographic map what it does not.
///
/// Its surface between the texel centres is the one of [`MapSurface::Linear`](shadowmap::MapSurface::Linear).
///
/// | map | inside | closed by |
/// | --- | --- | --- |
/// | perspective | light | walls to the light |
/// | cube | light | strips between the faces, triangles at the corners |
/// | orthographic | shadow | skirts down to the far plane and a cap there |
///
/// Where a node of a perspective or cube map is infinitely far, so is the vertex: the volume is closed at infinity.
///
/// All triangles are oriented alike: a ray that leaves light meets their back, that is the right-hand rule's normal
/// points along the ray. In perspective and orthographic maps a surface triangle turns from columns to rows.
#[derive(Debug, Clone)]
pub struct LightVolume {
    frame: Frame,
    far: f32,
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    surface: usize,
    leaves: Vec<Leaf>,
}

impl LightVolume {
    /// Builds the volume of `map`.
    ///
    /// A map of one column or row encloses nothing and has no triangles: in perspective all is dark, in an orthographic
    /// one all is lit.
    ///
    /// # Errors
    /// [`LightVolumeError`] if a threshold or far plane makes no sense, the map's outside cannot be outside (an
    /// orthographic one must be lit there, a perspective one dark), or a cube is to be tessellated by Delaunay.
    pub fn build(map: &DepthMap, options: &Options) -> Result<Self, LightVolumeError> {
        options.check()?;
        let kind = map.projection().kind();
        check_outside(kind, map.outside())?;
        // the border's feet and two more beside the nodes
        let vertices = map.depths().len() as u64 + 2 * (u64::from(map.size().0) + u64::from(map.size().1));
        if vertices >= u64::from(u32::MAX) {
            return Err(LightVolumeError::TooLarge { vertices });
        }
        let frame = Frame::new(map.projection(), map.size());
        let nodes = Nodes::new(map, options)?;
        let mut builder = Builder::new(nodes, kind == ProjectionKind::Cube);
        if let Some(quads) = Quads::new(map.size()) {
            tessellate(&mut builder, quads, &options.tessellation)?;
        }
        let surface = builder.triangles.len();
        match kind {
            ProjectionKind::Cube => closure::seams(&mut builder, &frame),
            _ if surface == 0 => {}
            ProjectionKind::Perspective => closure::walls(&mut builder),
            ProjectionKind::Orthographic => closure::skirts(&mut builder),
        }
        let Builder { vertices, triangles, leaves, .. } = builder;
        Ok(Self { frame, far: nodes.far, vertices, triangles, surface, leaves })
    }

    /// The vertices, each place once, all of them in use.
    pub fn vertices(&self) -> &[Vertex] {
        &self.vertices
    }

    /// Indices of each triangle's vertices; first those of the map's surface, then those that close it.
    ///
    /// In the order of a quadtree, so that neighbours in the list are near each other.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// How many of the triangles are surface: between nodes of one face.
    pub fn surface_count(&self) -> usize {
        self.surface
    }

    /// The leaves of an adaptive tessellation, face by face, in the order of the quadtree: upper left, upper right, lower
    /// left, lower right. Empty for another tessellation.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    /// Homogeneous world positions of the vertices: xyz/w; units: m. A point at infinity has w = 0 and lies towards xyz.
    ///
    /// In perspective and cube volumes w is the height 1/depth and xyz is light·w + direction, so that all of it is finite.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = DVec4> + '_ {
        self.vertices.iter().map(|vertex| self.frame.world(vertex))
    }

    /// Whether the inside is the shadow, not the light: for orthographic maps, which are lit all around.
    ///
    /// The sum over the boundaries of such a volume lacks the light of the whole ray, L(0, end).
    pub fn is_shadow(&self) -> bool {
        self.projection().kind() == ProjectionKind::Orthographic
    }

    /// How the light sees.
    pub fn projection(&self) -> &Projection {
        self.frame.projection()
    }

    /// Columns and rows of the map's faces.
    pub fn map_size(&self) -> (u32, u32) {
        self.frame.size()
    }

    /// Depth at which an orthographic volume ends, and that the criteria take for infinity; units: m.
    pub fn far(&self) -> f32 {
        self.far
    }

    /// Memory of vertices, triangles and leaves; units: bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.vertices) + size_of_val(&*self.triangles) + size_of_val(&*self.leaves)
    }

    pub(crate) fn frame(&self) -> &Frame {
        &self.frame
    }

    #[cfg(test)]
    pub(crate) fn triangles_mut(&mut self) -> &mut Vec<[u32; 3]> {
        &mut self.triangles
    }
}

fn check_outside(kind: ProjectionKind, outside: Outside) -> Result<(), LightVolumeError> {
    match (kind, outside) {
        (ProjectionKind::Perspective, Outside::Lit) => {
            Err(LightVolumeError::Outside { map: "a perspective", needed: "dark" })
        }
        (ProjectionKind::Orthographic, Outside::Dark) => {
            Err(LightVolumeError::Outside { map: "an orthographic", needed: "lit" })
        }
        _ => Ok(()),
    }
}

fn tessellate(
    builder: &mut Builder<'_>,
    quads: Quads,
    tessellation: &Tessellation,
) -> Result<(), LightVolumeError> {
    let faces = builder.nodes.map.projection().faces().len();
    match *tessellation {
        Tessellation::Static => (0..faces).for_each(|face| builder.cells(face, &quads)),
        Tessellation::Adaptive { criterion, threshold } => {
            for face in 0..faces {
                let hierarchy = Hierarchy::new(&builder.nodes, face, quads, criterion, threshold, faces > 1);
                builder.leaves(face, &hierarchy);
            }
        }
        Tessellation::Delaunay { .. } if faces > 1 => return Err(LightVolumeError::Cube),
        Tessellation::Delaunay { bound } => delaunay::triangulate(builder, bound)?,
    }
    Ok(())
}
