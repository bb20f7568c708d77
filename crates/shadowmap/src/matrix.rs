//! The matrix with which a renderer draws a face, so that its depth buffer can be taken back.

use glam::{DMat4, DVec3, DVec4};

use crate::{DepthEncoding, DepthOrder, Face, ShadowMapError};

impl Face {
    /// Clip space from world space, y up and depth in [0, 1], as [`DepthEncoding::Device`] with the same planes reads it;
    /// column vectors. Row 0 of the map is at the top. `far` may be infinite in perspective.
    ///
    /// The faces of a cube map are mirror images, as those of cube textures are: front faces appear as back faces.
    ///
    /// # Errors
    /// [`ShadowMapError::Planes`] if no depth lies between the planes.
    pub fn clip_from_world(&self, order: DepthOrder, near: f32, far: f32) -> Result<DMat4, ShadowMapError> {
        DepthEncoding::Device { order, near, far }.check_planes(!self.perspective)?;
        let (n, f) = (f64::from(near), f64::from(far));
        let range = f - n;
        // clip z = m·depth + t
        let (m, t) = match (self.perspective, order) {
            (false, DepthOrder::Forward) => (1.0 / range, -n / range),
            (false, DepthOrder::Reversed) => (-1.0 / range, f / range),
            (true, DepthOrder::Forward) if f.is_infinite() => (1.0, -n),
            (true, DepthOrder::Reversed) if f.is_infinite() => (0.0, n),
            (true, DepthOrder::Forward) => (f / range, -n * f / range),
            (true, DepthOrder::Reversed) => (-n / range, n * f / range),
        };
        // a row gives axis · (point − origin) + constant
        let row = |axis: DVec3, constant: f64| axis.extend(constant - axis.dot(self.origin));
        let w = if self.perspective { row(self.forward, 0.0) } else { DVec4::W };
        let rows = [
            row(self.right / self.half.x, 0.0),
            row(-self.down / self.half.y, 0.0),
            row(m * self.forward, t),
            w,
        ];
        Ok(DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DepthMap, Projection};
    use glam::DVec2;

    #[test]
    fn what_the_matrix_draws_the_encoding_reads() {
        let (o, z, x) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.3, -1.0, 0.2), DVec3::X);
        let half = DVec2::new(1.0, 0.7);
        let projections = [
            Projection::perspective(o, z, x, half).unwrap(),
            Projection::orthographic(o, z, x, half).unwrap(),
            Projection::cube(o).unwrap(),
        ];
        for projection in projections {
            for (index, face) in projection.faces().iter().enumerate() {
                for order in [DepthOrder::Forward, DepthOrder::Reversed] {
                    for far in [40.0, f32::INFINITY] {
                        let Ok(matrix) = face.clip_from_world(order, 0.5, far) else {
                            assert!(!face.perspective && far.is_infinite());
                            continue;
                        };
                        let (u, v, depth) = (1.3, 2.8, 7.0);
                        let clip = matrix * face.unproject(u, v, depth, (4, 4)).extend(1.0);
                        let (x, y, z) = (clip.x / clip.w, clip.y / clip.w, clip.z / clip.w);
                        assert!((x - (u / 2.0 - 1.0)).abs() < 1e-9 && (y - (1.0 - v / 2.0)).abs() < 1e-9);
                        let mut raw = vec![0.5; projection.faces().len()];
                        raw[index] = z as f32;
                        let encoding = DepthEncoding::Device { order, near: 0.5, far };
                        let map = DepthMap::from_host(projection.clone(), (1, 1), raw, encoding).unwrap();
                        assert!((f64::from(map.depth(index, 0, 0)) / depth - 1.0).abs() < 1e-5);
                    }
                }
                assert!(face.clip_from_world(DepthOrder::Forward, 2.0, 1.0).is_err());
            }
        }
    }
}
