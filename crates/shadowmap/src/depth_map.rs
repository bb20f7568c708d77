//! The map itself: one planar depth per texel, with the projection that it belongs to.
//!
//! A map stores *planar* depth, along the face's axis, not the distance from the light. A plane in the world is then
//! linear over the texels (1/z in perspective, z in orthographic), so that the surface between texel centres, a
//! triangle in the world, is found by linear interpolation alone and a view ray meets it where a linear function of
//! the distance along the ray changes its sign. It is also what depth buffers hold, up to a monotone function of each
//! value by itself.

use glam::DVec3;

use crate::encoding::DepthEncoding;
use crate::projection::check_size;
use crate::{MapPoint, Projection, ProjectionKind, ShadowMapError};

/// What holds for points that a map does not see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// Nothing shadows them: right for a directional map, which has the whole scene inside.
    Lit,
    /// No light gets there: right for a spot, whose cone ends inside the map.
    Dark,
}

/// Planar depths in metres, row-major, row 0 at the top; the faces of a cube follow each other.
///
/// +∞ means that nothing stops the light. Every value is at least 0, in perspective and cube maps more than 0.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthMap {
    projection: Projection,
    size: (u32, u32),
    depths: Vec<f32>,
    outside: Outside,
}

/// Number of values that a map of `size` holds.
pub(crate) fn count(projection: &Projection, size: (u32, u32)) -> Result<usize, ShadowMapError> {
    check_size(size)?;
    if projection.kind() == ProjectionKind::Cube && size.0 != size.1 {
        return Err(ShadowMapError::NotSquare { width: size.0, height: size.1 });
    }
    Ok(projection.faces().len() * size.0 as usize * size.1 as usize)
}

impl DepthMap {
    /// A map of `size` (columns, rows) from planar depths in metres; a cube holds six faces one after the other.
    ///
    /// Outside of it points are dark for a perspective and lit for an orthographic projection; a cube has no outside.
    ///
    /// # Errors
    /// [`ShadowMapError`] if a side is 0 or too large, the faces of a cube are not square, the number of values does
    /// not match, or a value is NaN, negative, or 0 in a perspective or cube map.
    pub fn new(projection: Projection, size: (u32, u32), depths: Vec<f32>) -> Result<Self, ShadowMapError> {
        Self::from_host(projection, size, depths, DepthEncoding::Planar)
    }

    /// A map from what a renderer's depth buffer holds; `encoding` says what that is. The values are converted once.
    ///
    /// # Errors
    /// As [`DepthMap::new`]; also if the encoding's planes have no depth between them, do not suit the projection, or
    /// a value lies outside the encoding's range. The error names the first such texel and its raw value.
    pub fn from_host(
        projection: Projection,
        size: (u32, u32),
        raw: Vec<f32>,
        encoding: DepthEncoding,
    ) -> Result<Self, ShadowMapError> {
        let expected = count(&projection, size)?;
        let faces = projection.faces().len();
        if raw.len() != expected {
            let (width, height) = size;
            return Err(ShadowMapError::Length { faces, width, height, expected, got: raw.len() });
        }
        let mut depths = raw;
        encoding.decode(&projection, size, &mut depths)?;
        let outside = match projection.kind() {
            ProjectionKind::Perspective => Outside::Dark,
            ProjectionKind::Orthographic | ProjectionKind::Cube => Outside::Lit,
        };
        Ok(Self { projection, size, depths, outside })
    }

    /// A map of one depth everywhere, in metres; +∞ shadows nothing.
    ///
    /// # Errors
    /// As [`DepthMap::new`].
    pub fn uniform(projection: Projection, size: (u32, u32), depth: f32) -> Result<Self, ShadowMapError> {
        let count = count(&projection, size)?;
        Self::new(projection, size, vec![depth; count])
    }

    /// From values that are known to be valid.
    pub(crate) fn trusted(projection: Projection, size: (u32, u32), depths: Vec<f32>) -> Self {
        let outside = match projection.kind() {
            ProjectionKind::Perspective => Outside::Dark,
            ProjectionKind::Orthographic | ProjectionKind::Cube => Outside::Lit,
        };
        Self { projection, size, depths, outside }
    }

    /// The same map with another answer for what it does not see.
    #[must_use]
    pub fn with_outside(mut self, outside: Outside) -> Self {
        self.outside = outside;
        self
    }

    /// The same map with nothing farther than `far` metres of planar depth: light ends there.
    ///
    /// For techniques that need every depth finite, and for a light whose reach is limited.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] if `far` is NaN or not positive.
    pub fn clamped(mut self, far: f32) -> Result<Self, ShadowMapError> {
        if !(far > 0.0) {
            return Err(ShadowMapError::Setting { name: "far", value: far, valid: "be positive" });
        }
        for depth in &mut self.depths {
            *depth = depth.min(far);
        }
        Ok(self)
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

    /// All depths; units: m.
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// Depths of one face; units: m.
    ///
    /// # Panics
    /// If the projection has no such face.
    #[inline]
    pub fn face(&self, face: usize) -> &[f32] {
        let count = self.size.0 as usize * self.size.1 as usize;
        &self.depths[face * count..(face + 1) * count]
    }

    /// Depth of a texel; units: m.
    ///
    /// # Panics
    /// If there is no such texel.
    #[inline]
    pub fn depth(&self, face: usize, x: u32, y: u32) -> f32 {
        self.face(face)[y as usize * self.size.0 as usize + x as usize]
    }

    /// Where a point falls on the map; `None` if the map does not see it.
    #[inline]
    pub fn locate(&self, point: DVec3) -> Option<MapPoint> {
        self.projection.locate(point, self.size)
    }

    /// The point at a texel's centre and depth, a vertex of the surface in [`MapSurface::Linear`]; not finite where
    /// the depth is infinite.
    ///
    /// [`MapSurface::Linear`]: crate::MapSurface::Linear
    ///
    /// # Panics
    /// If there is no such texel.
    pub fn vertex(&self, face: usize, x: u32, y: u32) -> DVec3 {
        let depth = f64::from(self.depth(face, x, y));
        self.projection.faces()[face].unproject(f64::from(x) + 0.5, f64::from(y) + 0.5, depth, self.size)
    }

    /// Memory of the depths; units: bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.depths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn square() -> Projection {
        Projection::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap()
    }

    #[test]
    fn vertices_by_hand() {
        let map = DepthMap::new(square(), (2, 2), vec![1.0, 2.0, 3.0, f32::INFINITY]).unwrap();
        assert_eq!(map.vertex(0, 0, 0), DVec3::new(-0.5, 0.5, -1.0));
        assert_eq!(map.vertex(0, 1, 0), DVec3::new(1.0, 1.0, -2.0));
        assert_eq!(map.vertex(0, 0, 1), DVec3::new(-1.5, -1.5, -3.0));
        assert!(!map.vertex(0, 1, 1).is_finite());
        assert_eq!((map.outside(), map.bytes()), (Outside::Dark, 16));
        let clamped = map.clamped(2.5).unwrap();
        assert_eq!(clamped.depths(), [1.0, 2.0, 2.5, 2.5]);
        assert!(clamped.clamped(f32::NAN).is_err());
    }

    #[test]
    fn nonsense_is_refused_with_its_place() {
        let refused = |size, values: Vec<f32>| DepthMap::new(square(), size, values).unwrap_err();
        assert!(matches!(refused((0, 1), vec![]), ShadowMapError::Size { .. }));
        assert!(matches!(refused((u32::MAX, 1), vec![]), ShadowMapError::Size { .. }));
        assert!(matches!(refused((2, 1), vec![1.0]), ShadowMapError::Length { expected: 2, got: 1, .. }));
        for bad in [f32::NAN, -1.0, 0.0, f32::NEG_INFINITY] {
            let error = refused((2, 2), vec![1.0, 1.0, bad, 1.0]);
            assert!(matches!(error, ShadowMapError::Depth { face: 0, x: 0, y: 1, .. }), "{error}");
            assert!(error.to_string().contains(&bad.to_string()));
        }
        let cube = || Projection::cube(DVec3::ZERO).unwrap();
        let error = DepthMap::uniform(cube(), (2, 3), 1.0).unwrap_err();
        assert_eq!(error, ShadowMapError::NotSquare { width: 2, height: 3 });
        assert_eq!(DepthMap::uniform(cube(), (3, 3), f32::INFINITY).unwrap().depths().len(), 54);
        let flat = Projection::orthographic(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE).unwrap();
        assert!(DepthMap::uniform(flat, (1, 1), 0.0).is_ok(), "depth 0 is a place in an orthographic map");
    }
}
