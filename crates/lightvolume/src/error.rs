//! What can be wrong with a request for a light volume.

use thiserror::Error;

/// A map or an option from which no light volume can be built.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum LightVolumeError {
    /// A threshold or bound that is no distance.
    #[error("{name} must be finite and at least 0 m, got {value}")]
    Threshold {
        /// Which value.
        name: &'static str,
        /// What it is; units: m.
        value: f32,
    },
    /// A far plane that is none.
    #[error("the far plane must be positive and finite, got {value}")]
    Far {
        /// What was given; units: m.
        value: f32,
    },
    /// A map whose outside would have to be part of the volume, which it cannot enclose.
    #[error("a light volume of {map} map needs an outside that is {needed}")]
    Outside {
        /// What kind of map.
        map: &'static str,
        /// What its outside must be.
        needed: &'static str,
    },
    /// Delaunay triangulations are made of single images.
    #[error("a Delaunay tessellation takes a map of one image, not a cube; use a static or adaptive one")]
    Cube,
    /// The triangulation refused a vertex.
    #[error("the Delaunay triangulation refused the node in column {x}, row {y}")]
    Insertion {
        /// Column of the node.
        x: u32,
        /// Row of the node.
        y: u32,
    },
    /// More vertices than an index can tell apart.
    #[error("a light volume has at most {} vertices, this one would have {vertices}", u32::MAX)]
    TooLarge {
        /// How many there would be.
        vertices: u64,
    },
    /// There must be one entry per light.
    #[error(
        "{lights} light(s) need as many light volumes (`None` where nothing casts shadows), got {volumes}"
    )]
    Count {
        /// Lights of the scene.
        lights: usize,
        /// Volumes given.
        volumes: usize,
    },
    /// A volume that was made for another kind of light.
    #[error("light {light}: the volume of {map} map cannot serve a {kind} light")]
    WrongVolume {
        /// Index of the light.
        light: usize,
        /// What kind of map the volume was made from.
        map: &'static str,
        /// What kind of light it is.
        kind: &'static str,
    },
}
