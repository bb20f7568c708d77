//! Light sources.

use crate::SceneError;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Which light of a scene is meant: its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightId(pub usize);

/// A light source.
#[derive(Debug, Clone, PartialEq)]
pub enum Light {
    /// Shines alike in all directions from a point.
    Point(PointLight),
    /// Shines into a cone from a point, maybe through a picture.
    Spot(SpotLight),
    /// Shines everywhere along one direction.
    Directional(DirectionalLight),
}

/// A light that shines alike in all directions from a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    /// Position; units: m.
    pub position: Vec3,
    /// Radiant intensity; units: W/sr.
    pub intensity: Vec3,
}

/// A light that shines into a cone.
#[derive(Debug, Clone, PartialEq)]
pub struct SpotLight {
    /// Position; units: m.
    pub position: Vec3,
    /// Unit vector along the cone's axis, the way the light travels.
    pub direction: Vec3,
    /// Unit vector to the right of the light's picture, seen along `direction`.
    pub right: Vec3,
    /// Half-angle inside which the light is at full intensity; units: rad.
    pub inner: f32,
    /// Half-angle outside which there is no light; units: rad; `inner` ≤ `outer` < π/2.
    pub outer: f32,
    /// Radiant intensity along the axis, before the texture; units: W/sr.
    pub intensity: Vec3,
    /// Picture that multiplies the intensity; it covers the square around the outer cone.
    pub texture: Option<Arc<LightTexture>>,
}

/// A light that shines everywhere along one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Unit vector along which the light travels.
    pub direction: Vec3,
    /// Irradiance on a surface that faces the light; units: W/m².
    pub irradiance: Vec3,
}

/// How a [`LightTexture`] is read between texel centres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TextureFilter {
    /// The texel that the point falls in.
    Nearest,
    /// Bilinear between the four nearest texel centres.
    #[default]
    Linear,
}

/// A picture in front of a spot light: linear RGB factors, row 0 at the top, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct LightTexture {
    /// Width; units: texels.
    pub width: u32,
    /// Height; units: texels.
    pub height: u32,
    /// `width`·`height` texels.
    pub texels: Vec<[f32; 3]>,
    /// How it is read between texel centres.
    pub filter: TextureFilter,
}

fn check_power(name: &str, value: Vec3) -> Result<(), SceneError> {
    if value.is_finite() && value.min_element() >= 0.0 {
        Ok(())
    } else {
        Err(SceneError::Light(format!("{name} must be finite and at least 0, got {value}")))
    }
}

/// Farthest that a local light may be from the origin: its square is still far from overflowing; units: m.
const FARTHEST: f32 = 1e15;

fn check_position(value: Vec3) -> Result<(), SceneError> {
    if value.is_finite() && value.abs().max_element() <= FARTHEST {
        Ok(())
    } else {
        Err(SceneError::Light(format!("position must be finite and within {FARTHEST:e} m, got {value}")))
    }
}

fn unit(value: Vec3) -> Result<DVec3, SceneError> {
    let unit = value.as_dvec3().normalize_or_zero();
    if value.is_finite() && unit != DVec3::ZERO {
        Ok(unit)
    } else {
        Err(SceneError::Light(format!("direction must be finite and not zero, got {value}")))
    }
}

impl PointLight {
    /// A point light; `intensity` in W/sr.
    ///
    /// # Errors
    /// [`SceneError::Light`] if a value is not finite or the intensity is negative.
    pub fn new(position: Vec3, intensity: Vec3) -> Result<Self, SceneError> {
        check_position(position)?;
        check_power("intensity", intensity)?;
        Ok(Self { position, intensity })
    }
}

impl Light {
    /// The cone of a spot light.
    pub fn cone(&self) -> Option<SpotCone<'_>> {
        if let Self::Spot(light) = self { Some(light.cone()) } else { None }
    }
}

impl SpotLight {
    /// A spot light at `position` that shines along `direction`; half-angles in radians, `intensity` in W/sr.
    ///
    /// The picture's right is `direction` × Y, or `direction` × Z when those are parallel; [`SpotLight::right`] may be
    /// set to another unit vector at right angles to `direction` afterwards.
    ///
    /// # Errors
    /// [`SceneError::Light`] if a value is not finite, the direction is zero, the intensity is negative, or the
    /// angles do not satisfy 0 ≤ inner ≤ outer < π/2.
    pub fn new(
        position: Vec3,
        direction: Vec3,
        inner: f32,
        outer: f32,
        intensity: Vec3,
    ) -> Result<Self, SceneError> {
        check_position(position)?;
        check_power("intensity", intensity)?;
        let direction = unit(direction)?;
        if !(0.0 <= inner && inner <= outer && outer < std::f32::consts::FRAC_PI_2) {
            let (inner, outer) = (inner.to_degrees(), outer.to_degrees());
            return Err(SceneError::Light(format!(
                "cone half-angles must satisfy 0 <= inner <= outer < 90 degrees, got {inner} and {outer}"
            )));
        }
        let right = [DVec3::Y, DVec3::Z].map(|axis| direction.cross(axis));
        let right = if right[0].length() > 1e-6 { right[0] } else { right[1] };
        Ok(Self {
            position,
            direction: direction.as_vec3(),
            right: right.normalize().as_vec3(),
            inner,
            outer,
            intensity,
            texture: None,
        })
    }

    /// Unit vector to the top of the light's picture.
    pub fn top(&self) -> Vec3 {
        self.right.cross(self.direction)
    }

    /// What its angles make, for many directions.
    pub fn cone(&self) -> SpotCone<'_> {
        let direction = self.direction.as_dvec3();
        let right = self.right.as_dvec3();
        SpotCone {
            light: self,
            direction,
            right,
            top: right.cross(direction),
            cos_inner: f64::from(self.inner).cos(),
            cos_outer: f64::from(self.outer).cos(),
            tan_outer: f64::from(self.outer).tan(),
        }
    }

    /// [`SpotCone::texture_coordinates`] of a single direction.
    pub fn texture_coordinates(&self, w: DVec3) -> (f64, f64) {
        self.cone().texture_coordinates(w)
    }

    /// [`SpotCone::falloff`] of a single angle.
    pub fn falloff(&self, cos_angle: f64) -> f64 {
        self.cone().falloff(cos_angle)
    }

    /// [`SpotCone::intensity_towards`] of a single direction.
    pub fn intensity_towards(&self, w: DVec3) -> DVec3 {
        self.cone().intensity_towards(w)
    }
}

/// A [`SpotLight`] with the cosines and the tangent of its angles, which an integral along a ray takes at every node.
#[derive(Debug, Clone, Copy)]
pub struct SpotCone<'a> {
    light: &'a SpotLight,
    direction: DVec3,
    right: DVec3,
    top: DVec3,
    cos_inner: f64,
    cos_outer: f64,
    tan_outer: f64,
}

impl SpotCone<'_> {
    /// Coordinates on the light's picture of a direction `w` away from the light (any length): u to the right and v
    /// downwards, both 0 to 1 inside the square around the outer cone.
    pub fn texture_coordinates(&self, w: DVec3) -> (f64, f64) {
        let k = self.tan_outer * w.dot(self.direction);
        (0.5 + 0.5 * w.dot(self.right) / k, 0.5 - 0.5 * w.dot(self.top) / k)
    }

    /// glTF's falloff for the cosine of the angle to the axis: clamp((cos a − cos outer)/max(cos inner − cos outer,
    /// 0.001), 0, 1)².
    pub fn falloff(&self, cos_angle: f64) -> f64 {
        // rounded above 1 it would be inside a cone of no width; what is no number stays none
        let above = cos_angle.clamp(-1.0, 1.0) - self.cos_outer;
        (above / (self.cos_inner - self.cos_outer).max(0.001)).clamp(0.0, 1.0).powi(2)
    }

    /// Radiant intensity towards `w`, a direction of any length away from the light; units: W/sr.
    pub fn intensity_towards(&self, w: DVec3) -> DVec3 {
        let falloff = self.falloff(w.dot(self.direction) / w.length());
        // also false for the direction of no length
        if !(falloff > 0.0) {
            return DVec3::ZERO;
        }
        let colour = self.light.texture.as_ref().map_or(DVec3::ONE, |texture| {
            let (u, v) = self.texture_coordinates(w);
            texture.sample(u, v)
        });
        falloff * colour * self.light.intensity.as_dvec3()
    }
}

impl DirectionalLight {
    /// A directional light that travels along `direction`; `irradiance` in W/m².
    ///
    /// # Errors
    /// [`SceneError::Light`] if a value is not finite, the direction is zero or the irradiance is negative.
    pub fn new(direction: Vec3, irradiance: Vec3) -> Result<Self, SceneError> {
        check_power("irradiance", irradiance)?;
        Ok(Self { direction: unit(direction)?.as_vec3(), irradiance })
    }
}

impl LightTexture {
    /// A texture of `width` × `height` linear RGB texels, row 0 at the top.
    ///
    /// # Errors
    /// [`SceneError::Light`] if a side is 0, the number of texels does not match, or a texel is negative or not
    /// finite.
    pub fn new(
        width: u32,
        height: u32,
        texels: Vec<[f32; 3]>,
        filter: TextureFilter,
    ) -> Result<Self, SceneError> {
        if width == 0 || height == 0 || texels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(SceneError::Light(format!(
                "a light texture of {width} x {height} cannot have {} texels",
                texels.len()
            )));
        }
        if texels.iter().flatten().any(|&t| !(t.is_finite() && t >= 0.0)) {
            return Err(SceneError::Light("a light texture's texels must be finite and at least 0".into()));
        }
        Ok(Self { width, height, texels, filter })
    }

    /// Colour at (`u`, `v`), clamped to the edge texels outside [0, 1].
    pub fn sample(&self, u: f64, v: f64) -> DVec3 {
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        let texel = |x: f64, y: f64| {
            // saturating: the cast of a negative number is 0
            let (x, y) =
                ((x as usize).min(self.width as usize - 1), (y as usize).min(self.height as usize - 1));
            DVec3::from_array(self.texels[y * self.width as usize + x].map(f64::from))
        };
        match self.filter {
            TextureFilter::Nearest => texel(u * w, v * h),
            TextureFilter::Linear => {
                let (x, y) = (u * w - 0.5, v * h - 0.5);
                let (x0, y0) = (x.floor(), y.floor());
                let (fx, fy) = (x - x0, y - y0);
                let row = |y: f64| texel(x0, y).lerp(texel(x0 + 1.0, y), fx);
                row(y0).lerp(row(y0 + 1.0), fy)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spot_axes_and_coordinates() {
        let spot = SpotLight::new(Vec3::ZERO, Vec3::NEG_Z, 0.0, 45_f32.to_radians(), Vec3::ONE).unwrap();
        // looking down −Z with Y up, right is +X and top is +Y
        assert_eq!((spot.right, spot.top()), (Vec3::X, Vec3::Y));
        let (u, v) = spot.texture_coordinates(DVec3::new(0.5, 1.0, -1.0));
        assert!((u - 0.75).abs() < 1e-7 && v.abs() < 1e-7);
        let down = SpotLight::new(Vec3::ZERO, Vec3::NEG_Y, 0.1, 0.2, Vec3::ONE).unwrap();
        assert!(down.right.dot(down.direction).abs() < 1e-6 && down.right == Vec3::NEG_X);
    }

    #[test]
    fn falloff_is_one_inside_and_zero_outside() {
        let spot = SpotLight::new(Vec3::ZERO, Vec3::X, 0.3, 0.6, Vec3::ONE).unwrap();
        assert_eq!(spot.falloff(0.2_f64.cos()), 1.0);
        assert_eq!(spot.falloff(0.7_f64.cos()), 0.0);
        assert_eq!(spot.intensity_towards(DVec3::NEG_X), DVec3::ZERO);
        assert_eq!(spot.intensity_towards(DVec3::ZERO), DVec3::ZERO);
    }

    #[test]
    fn texture_reads() {
        let texels = vec![[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]];
        let nearest = LightTexture::new(2, 2, texels.clone(), TextureFilter::Nearest).unwrap();
        assert_eq!(nearest.sample(0.9, 0.1).x, 1.0);
        assert_eq!(nearest.sample(-5.0, 7.0).x, 2.0);
        let linear = LightTexture::new(2, 2, texels, TextureFilter::Linear).unwrap();
        assert_eq!(linear.sample(0.5, 0.5).x, 1.5);
        assert_eq!(linear.sample(0.0, 0.0).x, 0.0);
        assert!(LightTexture::new(2, 2, vec![[1.0; 3]; 3], TextureFilter::Linear).is_err());
        assert!(LightTexture::new(1, 1, vec![[f32::NAN; 3]], TextureFilter::Linear).is_err());
    }

    #[test]
    fn a_cone_of_no_width_lights_nothing() {
        let mut light = SpotLight::new(Vec3::ZERO, Vec3::new(1.0, 3.0, 3.0), 0.0, 0.0, Vec3::ONE).unwrap();
        let texture = LightTexture::new(2, 2, vec![[1.0; 3]; 4], TextureFilter::Linear).unwrap();
        light.texture = Some(Arc::new(texture));
        let axis = light.direction.as_dvec3();
        for length in 1..2000 {
            let nearly = f64::from(length) * (axis + 1e-9 * DVec3::splat(f64::from(length % 7)));
            assert_eq!(light.intensity_towards(nearly), DVec3::ZERO);
        }
        assert_eq!(light.falloff(1.0 + 1e-15), 0.0);
    }

    #[test]
    fn nonsense_is_refused() {
        let one = Vec3::ONE;
        assert!(PointLight::new(Vec3::ZERO, Vec3::new(1.0, -1.0, 0.0)).is_err());
        assert!(PointLight::new(Vec3::NAN, one).is_err());
        assert!(DirectionalLight::new(Vec3::ZERO, one).is_err());
        assert!(DirectionalLight::new(Vec3::X, Vec3::INFINITY).is_err());
        for (inner, outer) in [(0.5, 0.2), (-0.1, 0.2), (0.0, 1.6), (f32::NAN, 0.2), (0.1, f32::NAN)] {
            assert!(SpotLight::new(Vec3::ZERO, Vec3::X, inner, outer, one).is_err());
        }
    }
}
