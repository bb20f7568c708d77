//! How a map's surface is cut into triangles.

use crate::LightVolumeError;

/// What makes a quad of the adaptive tessellation too coarse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// The paper's edge map: the greatest Laplacian of the heights within the quad.                  (BSA10 §4.1)
    ///
    /// In metres at the node where it is greatest, but no bound on anything: a slope that bends a little at every node
    /// passes any threshold, and a saddle has no Laplacian at all.
    Laplacian,
    /// A bound on the distance along the light's axis between the quad and the surface of all nodes.
    ///
    /// What the tessellation moves of the surface is then at most the threshold, measured as planar depth, with depths
    /// taken no farther than [`Options::far`].
    Distance,
}

/// How the surface between a map's nodes is cut into triangles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Tessellation {
    /// Two triangles for each cell between four nodes: exact.                                          (BSA10 §4)
    #[default]
    Static,
    /// A balanced quadtree whose leaves are stitched together.                                        (BSA10 §4.1)
    Adaptive {
        /// What is compared with the threshold.
        criterion: Criterion,
        /// A quad above it is split; units: m.
        threshold: f32,
    },
    /// Delaunay triangles of the nodes that matter most, added one by one. Slow: for a light that stays where it is.
    Delaunay {
        /// Farthest that the surface may pass from a node, along the light's axis; units: m.
        bound: f32,
    },
}

/// What a light volume is built with.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// How the surface is cut into triangles.
    pub tessellation: Tessellation,
    /// Depth beyond which nothing matters; units: m.
    ///
    /// An orthographic volume ends there. In perspective and cube maps only the criteria use it: they take depths to
    /// be no farther. `None`: 10⁴ times the diameter of an orthographic map's prism (its sides, and its largest finite
    /// depth), or 10⁴ times the largest finite depth of another.
    pub far: Option<f32>,
}

impl Options {
    /// A tessellation with the default far plane.
    pub const fn new(tessellation: Tessellation) -> Self {
        Self { tessellation, far: None }
    }

    pub(crate) fn check(&self) -> Result<(), LightVolumeError> {
        let distance = |name, value: f32| {
            let fine = value.is_finite() && value >= 0.0;
            if fine { Ok(()) } else { Err(LightVolumeError::Threshold { name, value }) }
        };
        match self.tessellation {
            Tessellation::Static => {}
            Tessellation::Adaptive { threshold, .. } => distance("the threshold", threshold)?,
            Tessellation::Delaunay { bound } => distance("the bound", bound)?,
        }
        match self.far {
            Some(value) if !(value > 0.0 && value.is_finite()) => Err(LightVolumeError::Far { value }),
            _ => Ok(()),
        }
    }
}
