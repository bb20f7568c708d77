//! What the values of a host's depth buffer mean.
//!
//! With z the planar depth, n and f the near and far planes:
//!
//! | device depth | perspective | perspective, f = ∞ | orthographic |
//! | --- | --- | --- | --- |
//! | [`DepthOrder::Forward`] | f (z − n)/(z (f − n)) | 1 − n/z | (z − n)/(f − n) |
//! | [`DepthOrder::Reversed`] | n (f − z)/(z (f − n)) | n/z | (f − z)/(f − n) |
//!
//! These hold for clip spaces with depth in [0, 1] (WebGPU, Vulkan, Direct3D, Metal), and for what OpenGL writes to a
//! depth texture with its usual matrices. Values at the far end are what a cleared buffer holds: nothing was drawn, so
//! they become +∞.

use crate::{Projection, ProjectionKind, ShadowMapError};

/// Which end of [0, 1] is near.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DepthOrder {
    /// 0 is near, 1 is far.
    Forward,
    /// 1 is near, 0 is far.
    Reversed,
}

/// What the values of a depth buffer are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DepthEncoding {
    /// Metres along the face's axis; +∞ where nothing was drawn.
    Planar,
    /// Metres from the light (perspective and cube), or from the plane of depth 0 (orthographic), to the surface behind
    /// the texel's centre; +∞ where nothing was drawn.
    Distance,
    /// What a depth test compares, in [0, 1].
    Device {
        /// Which end is near.
        order: DepthOrder,
        /// Near plane of the matrix that drew it; units: m.
        near: f32,
        /// Far plane; units: m; may be infinite in perspective and cube maps.
        far: f32,
    },
}

impl DepthEncoding {
    /// Whether the encoding makes sense for a projection.
    ///
    /// # Errors
    /// [`ShadowMapError::Planes`] if no depth lies between the planes, or `far` is infinite in an orthographic map.
    pub fn check(self, projection: &Projection) -> Result<(), ShadowMapError> {
        self.check_planes(projection.kind() == ProjectionKind::Orthographic)
    }

    /// Turns raw values into planar depths, face after face.
    pub(crate) fn decode(
        self,
        projection: &Projection,
        size: (u32, u32),
        values: &mut [f32],
    ) -> Result<(), ShadowMapError> {
        let flat = projection.kind() == ProjectionKind::Orthographic;
        self.check_planes(flat)?;
        let texels = size.0 as usize * size.1 as usize;
        for (index, value) in values.iter_mut().enumerate() {
            let face = index / texels;
            let (x, y) = ((index % texels) % size.0 as usize, (index % texels) / size.0 as usize);
            let depth = match self {
                Self::Planar => Some(*value),
                Self::Distance => {
                    let position = (x as f64 + 0.5, y as f64 + 0.5);
                    let (_, along) = projection.faces()[face].line(position.0, position.1, size);
                    Some((f64::from(*value) / along.length()) as f32)
                }
                Self::Device { order, near, far } => {
                    let (n, f) = (f64::from(near), f64::from(far));
                    device_depth(f64::from(*value), order, n, f, flat)
                }
            };
            // written so that NaN is refused
            let valid = depth.filter(|&depth| if flat { depth >= 0.0 } else { depth > 0.0 });
            *value = valid.ok_or(ShadowMapError::Depth {
                face,
                x: x as u32,
                y: y as u32,
                value: *value,
                valid: match self {
                    Self::Device { .. } => "device depth lies in [0, 1]",
                    _ if flat => "orthographic depth is at least 0 m",
                    _ => "depth is more than 0 m",
                },
            })?;
        }
        Ok(())
    }

    pub(crate) fn check_planes(self, flat: bool) -> Result<(), ShadowMapError> {
        let Self::Device { near, far, .. } = self else {
            return Ok(());
        };
        let ordered = if flat { near >= 0.0 && far.is_finite() } else { near > 0.0 && near.is_finite() };
        if ordered && near < far {
            return Ok(());
        }
        let far_rule = if flat { "near may be 0, far must be finite" } else { "far may be infinite" };
        Err(ShadowMapError::Planes { near, far, far_rule })
    }
}

/// Planar depth of a device depth; `None` outside [0, 1].
fn device_depth(device: f64, order: DepthOrder, n: f64, f: f64, flat: bool) -> Option<f32> {
    if !(0.0..=1.0).contains(&device) {
        return None;
    }
    // r falls from 1 at the near plane to 0 at the far plane; kept as given where that is the reversed form, whose
    // small values a subtraction from 1 would round away
    let (r, rest) = match order {
        DepthOrder::Forward => (1.0 - device, device),
        DepthOrder::Reversed => (device, 1.0 - device),
    };
    if r == 0.0 {
        return Some(f32::INFINITY);
    }
    let depth = if flat {
        f * rest + n * r
    } else if f.is_infinite() {
        n / r
    } else {
        n * f / (n * rest + f * r)
    };
    Some(depth as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DepthMap;
    use glam::{DVec2, DVec3};

    fn projections() -> [Projection; 2] {
        let (o, z, x) = (DVec3::ZERO, DVec3::NEG_Z, DVec3::X);
        [
            Projection::perspective(o, z, x, DVec2::new(1.0, 0.7)).unwrap(),
            Projection::orthographic(o, z, x, DVec2::new(2.0, 1.0)).unwrap(),
        ]
    }

    #[test]
    fn device_depths_of_matrices_come_back() {
        let depths = [0.5_f32, 0.7, 1.0, 3.0, 17.0, 39.0];
        for (flat, projection) in projections().into_iter().enumerate() {
            for order in [DepthOrder::Forward, DepthOrder::Reversed] {
                for far in [40.0, f32::INFINITY] {
                    if flat == 1 && far.is_infinite() {
                        continue;
                    }
                    // a reversed matrix is the forward one with its planes exchanged
                    let (a, b) = if order == DepthOrder::Forward { (0.5, far) } else { (far, 0.5) };
                    // clip-space z is m·(view z) + t, in which view z is −depth
                    let (m, t) = match (flat == 1, far.is_infinite(), order) {
                        (true, ..) => (1.0 / (a - b), a / (a - b)),
                        (false, false, _) => (b / (a - b), a * b / (a - b)),
                        (false, true, DepthOrder::Forward) => (-1.0, -a),
                        (false, true, DepthOrder::Reversed) => (0.0, b),
                    };
                    let device = |z: f32| (t - m * z) / if flat == 1 { 1.0 } else { z };
                    let raw: Vec<f32> = depths.map(|z| device(z).clamp(0.0, 1.0)).to_vec();
                    let encoding = DepthEncoding::Device { order, near: 0.5, far };
                    let map = DepthMap::from_host(projection.clone(), (6, 1), raw, encoding).unwrap();
                    for (got, want) in map.depths().iter().zip(depths) {
                        let tolerance = if order == DepthOrder::Forward && flat == 0 { 2e-5 } else { 2e-6 };
                        assert!((got / want - 1.0).abs() < tolerance, "{order:?} {far}: {got} {want}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_cleared_buffer_shadows_nothing() {
        for projection in projections() {
            for (order, clear, near_value) in
                [(DepthOrder::Forward, 1.0, 0.0), (DepthOrder::Reversed, 0.0, 1.0)]
            {
                let encoding = DepthEncoding::Device { order, near: 0.5, far: 40.0 };
                let raw = vec![clear, near_value];
                let map = DepthMap::from_host(projection.clone(), (2, 1), raw, encoding).unwrap();
                assert_eq!(map.depths(), [f32::INFINITY, 0.5]);
            }
        }
    }

    #[test]
    fn distances_become_planar() {
        let [perspective, orthographic] = projections();
        let map = DepthMap::from_host(perspective, (2, 1), vec![3.0, f32::INFINITY], DepthEncoding::Distance);
        let map = map.unwrap();
        // the centre lies at x = −½, y = 0 of the plane at depth 1
        assert!((map.depths()[0] - 3.0 / 1.25_f32.sqrt()).abs() < 1e-6 && map.depths()[1].is_infinite());
        assert!((map.vertex(0, 0, 0).length() - 3.0).abs() < 1e-6);
        let map = DepthMap::from_host(orthographic, (1, 1), vec![3.0], DepthEncoding::Distance).unwrap();
        assert_eq!(map.depths(), [3.0]);
    }

    #[test]
    fn nonsense_is_refused() {
        let [perspective, orthographic] = projections();
        let device = |near, far| DepthEncoding::Device { order: DepthOrder::Forward, near, far };
        let take = |projection: &Projection, raw: f32, encoding| {
            DepthMap::from_host(projection.clone(), (1, 1), vec![raw], encoding).map(|_| ())
        };
        for raw in [-0.1, 1.1, f32::NAN] {
            let error = take(&perspective, raw, device(0.1, 1.0)).unwrap_err();
            assert!(matches!(error, ShadowMapError::Depth { .. }), "{error}");
        }
        for (near, far) in [(0.0, 1.0), (2.0, 1.0), (1.0, 1.0), (f32::NAN, 1.0), (0.1, f32::NAN)] {
            let error = take(&perspective, 0.5, device(near, far)).unwrap_err();
            assert!(matches!(error, ShadowMapError::Planes { .. }), "{error}");
        }
        assert!(take(&orthographic, 0.5, device(0.0, f32::INFINITY)).is_err());
        assert!(take(&orthographic, 0.5, device(0.0, 1.0)).is_ok());
    }
}
