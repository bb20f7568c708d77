//! The six faces of a cube map: order, axes, and which face sees a direction.
//!
//! Order and orientation are those of cube textures in Vulkan, Direct3D and WebGPU, so that a host's cube map can be
//! taken as it is:
//!
//! | face | forward | right (columns) | down (rows) |
//! | --- | --- | --- | --- |
//! | 0 | +X | −Z | −Y |
//! | 1 | −X | +Z | −Y |
//! | 2 | +Y | +X | +Z |
//! | 3 | −Y | +X | −Z |
//! | 4 | +Z | +X | −Y |
//! | 5 | −Z | −X | −Y |

use glam::{DVec2, DVec3};

use crate::face::Face;

/// Forward, right and down of every face.
const AXES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y],
    [DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y],
    [DVec3::Y, DVec3::X, DVec3::Z],
    [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::Z, DVec3::X, DVec3::NEG_Y],
    [DVec3::NEG_Z, DVec3::NEG_X, DVec3::NEG_Y],
];

/// The faces around `origin`.
pub(crate) fn faces(origin: DVec3) -> [Face; 6] {
    AXES.map(|[forward, right, down]| Face {
        origin,
        right,
        down,
        forward,
        half: DVec2::ONE,
        perspective: true,
    })
}

/// The face that sees direction `w`: that of its largest component; on an edge the one of lower index.
#[inline]
pub(crate) fn face_towards(w: DVec3) -> usize {
    let a = w.abs();
    let axis = if a.x >= a.y && a.x >= a.z { 0 } else { 1 + usize::from(a.z > a.y) };
    face_of(axis, w[axis] < 0.0)
}

/// The face that looks along an axis.
#[inline]
pub(crate) const fn face_of(axis: usize, negative: bool) -> usize {
    2 * axis + negative as usize
}

/// Axis and sign (±1) along which a face looks.
#[inline]
pub(crate) const fn axis_of(face: usize) -> (usize, f64) {
    (face / 2, if face.is_multiple_of(2) { 1.0 } else { -1.0 })
}

/// Column and row of the texel of `face` whose centre lies in direction `w`, on a face of `n` texels a side.
pub(crate) fn texel_at(face: usize, w: DVec3, n: u32) -> (u32, u32) {
    let [forward, right, down] = AXES[face];
    let z = w.dot(forward);
    let index = |x: f64| ((0.5 + 0.5 * x / z) * f64::from(n)).clamp(0.0, f64::from(n) - 1.0) as u32;
    (index(w.dot(right)), index(w.dot(down)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_those_of_cube_textures() {
        // (direction, face, u, v) from the selection table of the Vulkan specification
        for (w, face, u, v) in [
            (DVec3::new(2.0, 1.0, -0.5), 0, 0.625, 0.25),
            (DVec3::new(-2.0, 1.0, -0.5), 1, 0.375, 0.25),
            (DVec3::new(0.5, 2.0, 1.0), 2, 0.625, 0.75),
            (DVec3::new(0.5, -2.0, 1.0), 3, 0.625, 0.25),
            (DVec3::new(0.5, 1.0, 2.0), 4, 0.625, 0.25),
            (DVec3::new(0.5, 1.0, -2.0), 5, 0.375, 0.25),
        ] {
            assert_eq!(face_towards(w), face);
            let [x, y, z, depth] = faces(DVec3::ZERO)[face].project(w, (1, 1));
            assert_eq!((x / z, y / z, depth), (u, v, 2.0));
        }
    }

    #[test]
    fn a_direction_finds_its_texel_again() {
        for (face, frame) in faces(DVec3::ONE).iter().enumerate() {
            let (axis, sign) = axis_of(face);
            assert_eq!(frame.forward[axis], sign);
            assert_eq!(face_of(axis, sign < 0.0), face);
            for (x, y) in [(0, 0), (3, 1), (4, 4), (2, 0)] {
                let ray = frame.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, (5, 5));
                assert_eq!(face_towards(ray.direction), face);
                assert_eq!(texel_at(face, ray.direction, 5), (x, y));
            }
        }
    }
}
