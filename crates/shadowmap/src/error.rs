//! What can be wrong with a map.

use thiserror::Error;

/// A value that makes no sense for a shadow map.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum ShadowMapError {
    /// A map without texels, or with more than an index reaches.
    #[error("a shadow map must have 1 to {} texels a side, got {width} x {height}", crate::MAX_SIDE)]
    Size {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// The faces of a cube are squares.
    #[error("the faces of a cube map must be square, got {width} x {height}")]
    NotSquare {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// The data does not fill the map.
    #[error("{faces} face(s) of {width} x {height} texels need {expected} values, got {got}")]
    Length {
        /// Faces of the projection.
        faces: usize,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Values that would fill it.
        expected: usize,
        /// Values given.
        got: usize,
    },
    /// A texel that is no depth.
    #[error("face {face}, column {x}, row {y}: {value} is no depth; {valid}")]
    Depth {
        /// Face of the texel.
        face: usize,
        /// Column of the texel.
        x: u32,
        /// Row of the texel.
        y: u32,
        /// The value as it was given.
        value: f32,
        /// What would have been one.
        valid: &'static str,
    },
    /// Planes between which no depth lies.
    #[error("depth planes must satisfy 0 < near < far ({far_rule}), got near {near} and far {far}")]
    Planes {
        /// Near plane; units: m.
        near: f32,
        /// Far plane; units: m.
        far: f32,
        /// Whether an infinite far plane would do.
        far_rule: &'static str,
    },
    /// Axes that are not finite, zero or parallel.
    #[error("a projection needs a finite, nonzero direction and a right vector that is not parallel to it")]
    Axes,
    /// A position that is not finite.
    #[error("a projection's position must be finite, got ({0}, {1}, {2})")]
    Position(f64, f64, f64),
    /// An extent that is not positive.
    #[error("{name} must be positive and finite, got {value}")]
    Extent {
        /// Which extent.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A setting outside its range.
    #[error("{name} must {valid}, got {value}")]
    Setting {
        /// Which setting.
        name: &'static str,
        /// Its value.
        value: f32,
        /// What it must be.
        valid: &'static str,
    },
    /// There must be one entry per light.
    #[error("{lights} light(s) need as many maps (`None` where nothing casts shadows), got {maps}")]
    Count {
        /// Lights of the scene.
        lights: usize,
        /// Maps given.
        maps: usize,
    },
    /// A map that was made for another kind of light.
    #[error("light {light}: {map} map cannot serve a {kind} light")]
    WrongMap {
        /// Index of the light.
        light: usize,
        /// What kind of map it was given.
        map: &'static str,
        /// What kind of light it is.
        kind: &'static str,
    },
}
