//! Perspective cameras.

use crate::{Aabb, DRay, SceneError};
use glam::{DVec2, DVec3, Vec3};

/// Least field of view, and least distance from a half turn: neighbouring view rays still differ; units: rad.
const LEAST_FOV: f32 = 1.7e-5;

/// A perspective camera: right-handed, looking along `forward`, image row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Name in the file, if any.
    pub name: Option<String>,
    /// Eye; units: m.
    pub position: Vec3,
    /// Unit vector to the right of the image.
    pub right: Vec3,
    /// Unit vector to the top of the image.
    pub up: Vec3,
    /// Unit vector into the image.
    pub forward: Vec3,
    /// Vertical field of view; units: rad.
    pub fov_y: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target` with `up` pointing upwards in the image; `fov_y` in radians.
    ///
    /// # Errors
    /// [`SceneError::Camera`] if a value is not finite, eye and target coincide, `up` is parallel to the view
    /// direction or the field of view is outside (0, π).
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, fov_y: f32) -> Result<Self, SceneError> {
        let bad = |why: &str| Err(SceneError::Camera(why.into()));
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return bad("eye, target and up must be finite");
        }
        if !(LEAST_FOV..std::f32::consts::PI - LEAST_FOV).contains(&fov_y) {
            return bad(
                "the field of view must lie between 0 and 180 degrees, at least a thousandth away from both",
            );
        }
        // f64, so that a tiny or a huge scene does not lose its axes to rounding
        let forward = (target.as_dvec3() - eye.as_dvec3()).normalize_or_zero();
        if forward == DVec3::ZERO {
            return bad("eye and target coincide");
        }
        let right = forward.cross(up.as_dvec3().normalize_or_zero());
        if right.length() < 1e-6 {
            return bad("up is zero or parallel to the view direction");
        }
        let right = right.normalize();
        Ok(Self {
            name: None,
            position: eye,
            right: right.as_vec3(),
            up: right.cross(forward).as_vec3(),
            forward: forward.as_vec3(),
            fov_y,
        })
    }

    /// A camera that has the whole box in view, from above and in front; a box of no extent is seen from 1 m.
    pub fn framing(bounds: &Aabb, fov_y: f32) -> Self {
        let (center, radius) =
            if bounds.is_empty() { (Vec3::ZERO, 0.5) } else { (bounds.center(), 0.5 * bounds.diagonal()) };
        let radius = radius.max(1e-6);
        let direction = Vec3::new(0.35, 0.3, 1.0).normalize();
        let eye = center + direction * (1.05 * radius / (0.5 * fov_y).sin());
        Self::look_at(eye, center, Vec3::Y, fov_y).unwrap_or(Self {
            name: None,
            position: eye,
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            fov_y,
        })
    }

    /// The view ray through image position `pixel` (column, row; pixel centres at +0.5) of an image of `size`.
    pub fn ray(&self, pixel: DVec2, size: (u32, u32)) -> DRay {
        let half = (0.5 * f64::from(self.fov_y)).tan();
        let size = DVec2::new(f64::from(size.0), f64::from(size.1));
        let ndc = 2.0 * pixel / size - 1.0;
        let direction = self.forward.as_dvec3() + ndc.x * half * (size.x / size.y) * self.right.as_dvec3()
            - ndc.y * half * self.up.as_dvec3();
        DRay { origin: self.position.as_dvec3(), direction: direction.normalize() }
    }

    /// The view ray through the centre of the pixel in column `x` and row `y`.
    pub fn pixel_ray(&self, x: u32, y: u32, size: (u32, u32)) -> DRay {
        self.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_by_hand() {
        let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, std::f32::consts::FRAC_PI_2).unwrap();
        let corner = camera.ray(DVec2::new(0.0, 0.0), (200, 100)).direction;
        assert!((corner - DVec3::new(-2.0, 1.0, -1.0).normalize()).length() < 1e-7);
        let middle = camera.pixel_ray(1, 1, (3, 3)).direction;
        assert!((middle - DVec3::NEG_Z).length() < 1e-7);
    }

    #[test]
    fn nonsense_is_refused() {
        let fov = 0.8;
        assert!(Camera::look_at(Vec3::ONE, Vec3::ONE, Vec3::Y, fov).is_err());
        assert!(Camera::look_at(Vec3::ZERO, Vec3::Y, Vec3::Y, fov).is_err());
        assert!(Camera::look_at(Vec3::NAN, Vec3::Z, Vec3::Y, fov).is_err());
        for fov in [0.0, -1.0, 3.2, f32::NAN] {
            assert!(Camera::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, fov).is_err());
        }
    }

    #[test]
    fn framing_sees_every_corner() {
        let b = Aabb { min: Vec3::new(-1.0, 0.0, -3.0), max: Vec3::new(2.0, 1.0, 0.5) };
        let camera = Camera::framing(&b, 0.8);
        for i in 0..8 {
            let pick = |bit: u32, axis: usize| if i >> bit & 1 == 0 { b.min[axis] } else { b.max[axis] };
            let v = Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2)) - camera.position;
            let z = v.dot(camera.forward);
            let half = (0.4_f32).tan();
            assert!(v.dot(camera.up).abs() <= half * z && v.dot(camera.right).abs() <= half * z);
        }
    }
}
