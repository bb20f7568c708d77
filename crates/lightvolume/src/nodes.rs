//! The nodes of a map's surface: the texel centres, with a height that is linear over triangles.
//!
//! | map | height | unit |
//! | --- | --- | --- |
//! | perspective, cube | 1/depth, 0 where that is infinite | m⁻¹ |
//! | orthographic | −depth, no farther than `far` | m |
//!
//! More height is nearer to the light. A plane of the world is linear in texel coordinates in either.

use shadowmap::{DepthMap, ProjectionKind};

use crate::{LightVolumeError, Options};

/// Share of a map's size beyond which the default far plane lies.
const FAR: f64 = 1e4;

/// The nodes of a map.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nodes<'a> {
    pub(crate) map: &'a DepthMap,
    /// Whether heights are 1/depth.
    pub(crate) perspective: bool,
    /// Depth beyond which nothing matters; units: m.
    pub(crate) far: f32,
}

impl<'a> Nodes<'a> {
    /// The nodes of `map`, with the far plane of `options`.
    ///
    /// # Errors
    /// [`LightVolumeError::Far`] if an orthographic map is so large that its default far plane is not finite.
    pub(crate) fn new(map: &'a DepthMap, options: &Options) -> Result<Self, LightVolumeError> {
        let perspective = map.projection().kind() != ProjectionKind::Orthographic;
        let far = options.far.unwrap_or_else(|| default_far(map, perspective));
        if !(far > 0.0 && far.is_finite()) {
            return Err(LightVolumeError::Far { value: far });
        }
        Ok(Self { map, perspective, far })
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> (u32, u32) {
        self.map.size()
    }

    /// Planar depth of a node, in an orthographic map no farther than `far`; units: m.
    #[inline]
    pub(crate) fn depth(&self, face: usize, x: u32, y: u32) -> f32 {
        let depth = self.map.depth(face, x, y);
        if self.perspective { depth } else { depth.min(self.far) }
    }

    /// Height of a node.
    #[inline]
    pub(crate) fn height(&self, face: usize, x: u32, y: u32) -> f32 {
        height_of(self.depth(face, x, y), self.perspective)
    }

    /// Heights of all nodes of a face, row-major.
    pub(crate) fn heights(&self, face: usize) -> Vec<f32> {
        let depth = |&depth: &f32| if self.perspective { depth } else { depth.min(self.far) };
        self.map.face(face).iter().map(|d| height_of(depth(d), self.perspective)).collect()
    }
}

/// Height of a depth, computed in `f64` and rounded; finite for every depth of a map.
#[inline]
pub(crate) fn height_of(depth: f32, perspective: bool) -> f32 {
    if perspective { ((1.0 / f64::from(depth)) as f32).min(f32::MAX) } else { -depth }
}

/// The depth beyond which nothing matters; units: m.
fn default_far(map: &DepthMap, perspective: bool) -> f32 {
    let finite = map.depths().iter().copied().filter(|depth| depth.is_finite());
    let deepest = f64::from(finite.fold(0.0, f32::max));
    let size = if perspective {
        deepest
    } else {
        let half = map.projection().faces()[0].half;
        (2.0 * half).length().hypot(deepest)
    };
    // a map that nothing is drawn on has no size of its own
    let far = if size > 0.0 { FAR * size } else { FAR };
    (far as f32).min(f32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};
    use shadowmap::Projection;

    #[test]
    fn heights_by_hand() {
        let far = f32::INFINITY;
        let perspective = Projection::perspective(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE).unwrap();
        let map = DepthMap::new(perspective, (2, 2), vec![1.0, 3.0, far, 1e-45]).unwrap();
        let nodes = Nodes::new(&map, &Options::default()).unwrap();
        assert_eq!(nodes.heights(0), [1.0, 1.0 / 3.0, 0.0, f32::MAX]);
        assert_eq!(nodes.far, 3e4);
        let flat = Projection::orthographic(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::new(1.0, 2.0)).unwrap();
        let map = DepthMap::new(flat, (2, 2), vec![0.0, 4.0, far, 1.0]).unwrap();
        let nodes = Nodes::new(&map, &Options::default()).unwrap();
        // a prism of 2 m × 4 m × 4 m has a diameter of 6 m
        assert_eq!(nodes.heights(0), [-0.0, -4.0, -6e4, -1.0]);
        assert_eq!((0..2).map(|x| nodes.height(0, x, 1)).collect::<Vec<_>>(), [-6e4, -1.0]);
    }
}
