//! How a light sees: perspective (spot), orthographic (directional), cube (omni).

use glam::{DVec2, DVec3};
use scene::{Aabb, DRay, DirectionalLight, Light, PointLight, SpotLight};

use crate::cube;
use crate::face::{Face, MapPoint};
use crate::{MAX_SIDE, MapSurface, ShadowMapError};

/// Depth in front of which the rasteriser of a perspective map sees nothing unless told otherwise; units: m.
pub const DEFAULT_NEAR: f32 = 1e-5;

/// Smallest tangent of half an opening angle: a spot of no width still gets a map.
const LEAST_TANGENT: f64 = 1e-6;

/// Kind of projection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProjectionKind {
    /// One image, rays spread from the light.
    Perspective,
    /// One image, rays are parallel.
    Orthographic,
    /// Six images that look along ±X, ±Y, ±Z.
    Cube,
}

impl ProjectionKind {
    pub(crate) const fn article_name(self) -> &'static str {
        match self {
            Self::Perspective => "a perspective",
            Self::Orthographic => "an orthographic",
            Self::Cube => "a cube",
        }
    }
}

/// How a light sees the scene: the image planes of its map.
#[derive(Debug, Clone, PartialEq)]
pub struct Projection {
    kind: ProjectionKind,
    faces: Vec<Face>,
    near: f32,
}

/// Unit axes in `f64`: forward, right at right angles to it, and down.
fn axes(forward: DVec3, right: DVec3) -> Result<[DVec3; 3], ShadowMapError> {
    if !(forward.is_finite() && right.is_finite()) {
        return Err(ShadowMapError::Axes);
    }
    let forward = forward.normalize_or_zero();
    let right = right.normalize_or_zero();
    let right = right - right.dot(forward) * forward;
    if forward == DVec3::ZERO || right.length() < 1e-6 {
        return Err(ShadowMapError::Axes);
    }
    let right = right.normalize();
    Ok([forward, right, forward.cross(right)])
}

fn finite(position: DVec3) -> Result<(), ShadowMapError> {
    if position.is_finite() {
        Ok(())
    } else {
        Err(ShadowMapError::Position(position.x, position.y, position.z))
    }
}

fn extent(name: &'static str, value: f64) -> Result<(), ShadowMapError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ShadowMapError::Extent { name, value }) }
}

impl Projection {
    /// A perspective image from `position` along `forward` with `right` to the right; rays to its edges have the
    /// tangents `half_tangent` (horizontal, vertical) to the axis.
    ///
    /// # Errors
    /// [`ShadowMapError`] if a value is not finite, the axes are zero or parallel, or a tangent is not positive.
    pub fn perspective(
        position: DVec3,
        forward: DVec3,
        right: DVec3,
        half_tangent: DVec2,
    ) -> Result<Self, ShadowMapError> {
        finite(position)?;
        extent("the horizontal half tangent", half_tangent.x)?;
        extent("the vertical half tangent", half_tangent.y)?;
        let [forward, right, down] = axes(forward, right)?;
        let face = Face { origin: position, right, down, forward, half: half_tangent, perspective: true };
        Ok(Self { kind: ProjectionKind::Perspective, faces: vec![face], near: DEFAULT_NEAR })
    }

    /// The square frustum around a spot's outer cone, the square that its texture covers: same right, row 0 at the top.
    ///
    /// The cone touches the frustum's sides. Outside the texel *centres* (half a texel in from there) the linear
    /// meaning of a map encloses nothing; [`Projection::covering`] widens the frustum so that the centres enclose
    /// the cone.
    ///
    /// # Errors
    /// [`ShadowMapError`] if the light's fields were changed to something without meaning.
    pub fn spot(light: &SpotLight) -> Result<Self, ShadowMapError> {
        let tangent = f64::from(light.outer).tan().max(LEAST_TANGENT);
        Self::perspective(
            light.position.as_dvec3(),
            light.direction.as_dvec3(),
            light.right.as_dvec3(),
            DVec2::splat(tangent),
        )
    }

    /// The six faces around `position`, along the axes of the world.
    ///
    /// # Errors
    /// [`ShadowMapError::Position`] if the position is not finite.
    pub fn cube(position: DVec3) -> Result<Self, ShadowMapError> {
        finite(position)?;
        Ok(Self { kind: ProjectionKind::Cube, faces: cube::faces(position).to_vec(), near: DEFAULT_NEAR })
    }

    /// The six faces around a point light.
    ///
    /// # Errors
    /// [`ShadowMapError::Position`] if the position is not finite.
    pub fn point(light: &PointLight) -> Result<Self, ShadowMapError> {
        Self::cube(light.position.as_dvec3())
    }

    /// An orthographic image along `forward`: depth 0 in the plane through `middle`, `half_extent` metres from there
    /// to its sides along `right` and down.
    ///
    /// # Errors
    /// [`ShadowMapError`] if a value is not finite, the axes are zero or parallel, or an extent is not positive.
    pub fn orthographic(
        middle: DVec3,
        forward: DVec3,
        right: DVec3,
        half_extent: DVec2,
    ) -> Result<Self, ShadowMapError> {
        finite(middle)?;
        extent("half the width", half_extent.x)?;
        extent("half the height", half_extent.y)?;
        let [forward, right, down] = axes(forward, right)?;
        let face = Face { origin: middle, right, down, forward, half: half_extent, perspective: false };
        Ok(Self { kind: ProjectionKind::Orthographic, faces: vec![face], near: 0.0 })
    }

    /// The orthographic image of a box, for a map of `size` (columns, rows).
    ///
    /// The outermost ring of texels lies outside the box, so that its centres see nothing and no shadow is cut off by
    /// the map's edge; depth 0 lies in front of the box. Right is `direction` × Y, or × Z when those are parallel. An
    /// empty box counts as a point at the origin. A box smaller than the scene, around what is in view, gives finer texels:
    /// what casts shadows into it from before the plane of depth 0 is drawn on that plane.
    ///
    /// # Errors
    /// [`ShadowMapError`] if the size is 0 or too large, or the light's or the box's values are not finite.
    pub fn directional(
        light: &DirectionalLight,
        bounds: &Aabb,
        size: (u32, u32),
    ) -> Result<Self, ShadowMapError> {
        check_size(size)?;
        let forward = light.direction.as_dvec3().normalize_or_zero();
        let right = [DVec3::Y, DVec3::Z].map(|axis| forward.cross(axis));
        let right = if right[0].length() > 1e-6 { right[0] } else { right[1] };
        let [forward, right, down] = axes(forward, right)?;
        let (min, max) = if bounds.is_empty() {
            (DVec3::ZERO, DVec3::ZERO)
        } else {
            (bounds.min.as_dvec3(), bounds.max.as_dvec3())
        };
        let (center, arm) = (0.5 * (min + max), 0.5 * (max - min));
        // half the extent of a box along an axis
        let reach = |axis: DVec3| axis.abs().dot(arm);
        let least = 1e-3 * arm.length() + 1e-6;
        let margin = |count: u32| {
            let count = f64::from(count);
            // one and a half texels on either side
            if count > 4.0 { count / (count - 3.0) } else { 4.0 }
        };
        let half =
            DVec2::new(reach(right).max(least) * margin(size.0), reach(down).max(least) * margin(size.1));
        let middle = center - (reach(forward) + least) * forward;
        Self::orthographic(middle, forward, right, half)
    }

    /// The projection that suits `light`, for a scene within `bounds` and a map of `size` (columns, rows).
    ///
    /// # Errors
    /// As the constructors for each kind of light.
    pub fn of_light(light: &Light, bounds: &Aabb, size: (u32, u32)) -> Result<Self, ShadowMapError> {
        match light {
            Light::Point(light) => Self::point(light),
            Light::Spot(light) => Self::spot(light),
            Light::Directional(light) => Self::directional(light, bounds, size),
        }
    }

    /// As [`Projection::of_light`], for a map that is read in the meaning of `surface`.
    ///
    /// In the linear meaning a spot's frustum is widened ([`Projection::covering`]), lest the half texel outside the
    /// outermost centres, which encloses nothing, cuts into the cone where it touches the frustum's sides. The other
    /// kinds need no such thing: an orthographic map has a ring of centres around the scene, and a cube no edge.
    ///
    /// # Errors
    /// As [`Projection::of_light`].
    pub fn of_light_for(
        light: &Light,
        bounds: &Aabb,
        size: (u32, u32),
        surface: MapSurface,
    ) -> Result<Self, ShadowMapError> {
        let projection = Self::of_light(light, bounds, size)?;
        Ok(match (light, surface) {
            (Light::Spot(_), MapSurface::Linear) => projection.covering(size),
            _ => projection,
        })
    }

    /// Widened so that the outermost texel *centres* of a map of `size` lie where its edges lay; a cube stays as it is.
    #[must_use]
    pub fn covering(mut self, size: (u32, u32)) -> Self {
        if self.kind != ProjectionKind::Cube {
            let widen = |count: u32| f64::from(count) / f64::from(count.max(2) - 1);
            for face in &mut self.faces {
                face.half *= DVec2::new(widen(size.0), widen(size.1));
            }
        }
        self
    }

    /// With another near plane: what lies before it is not drawn. Has no effect on orthographic maps, which draw
    /// everything and move what lies before the plane of depth 0 onto it.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] if `near` is not positive and finite.
    pub fn with_near(mut self, near: f32) -> Result<Self, ShadowMapError> {
        if !(near > 0.0 && near.is_finite()) {
            let valid = "be positive and finite";
            return Err(ShadowMapError::Setting { name: "the near plane", value: near, valid });
        }
        if self.kind != ProjectionKind::Orthographic {
            self.near = near;
        }
        Ok(self)
    }

    /// Side of a texel of a map of `size` (columns, rows): a tangent, that is per metre of depth, or without perspective
    /// units: m. Shadows of the map stick out of those of the geometry by no more.
    pub fn texel(&self, size: (u32, u32)) -> f64 {
        let half = self.faces()[0].half;
        2.0 * (half.x / f64::from(size.0)).max(half.y / f64::from(size.1))
    }

    /// Which kind this is.
    pub fn kind(&self) -> ProjectionKind {
        self.kind
    }

    /// Depth in front of which nothing is drawn; units: m.
    pub fn near(&self) -> f32 {
        self.near
    }

    /// The image planes: one, or for a cube six in the order +X, −X, +Y, −Y, +Z, −Z.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The face that sees `point`, and where it falls on a map of `size`; `None` outside a perspective or
    /// orthographic image, and at the light itself.
    #[inline]
    pub fn locate(&self, point: DVec3, size: (u32, u32)) -> Option<MapPoint> {
        let face = match self.kind {
            ProjectionKind::Cube => cube::face_towards(point - self.faces[0].origin),
            _ => 0,
        };
        let [u, v, w, depth] = self.faces[face].project(point, size);
        if !(w > 0.0) {
            return None;
        }
        let (u, v) = (u / w, v / w);
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let inside = u >= 0.0 && u <= width && v >= 0.0 && v <= height;
        match self.kind {
            // the largest component decided: what is outside is so by rounding
            ProjectionKind::Cube => {
                Some(MapPoint { face, u: u.clamp(0.0, width), v: v.clamp(0.0, height), depth })
            }
            _ => inside.then_some(MapPoint { face, u, v, depth }),
        }
    }

    /// Light's ray through the centre of a texel.
    pub fn texel_ray(&self, face: usize, x: u32, y: u32, size: (u32, u32)) -> DRay {
        self.faces[face].ray(f64::from(x) + 0.5, f64::from(y) + 0.5, size)
    }
}

pub(crate) fn check_size(size: (u32, u32)) -> Result<(), ShadowMapError> {
    let fits = |side: u32| (1..=MAX_SIDE).contains(&side);
    if fits(size.0) && fits(size.1) {
        Ok(())
    } else {
        Err(ShadowMapError::Size { width: size.0, height: size.1 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_spot_map_covers_what_its_texture_covers() {
        let mut light =
            SpotLight::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.3, -1.0, 0.2), 0.1, 0.6, Vec3::ONE).unwrap();
        for right in [light.right, light.top()] {
            light.right = right;
            let projection = Projection::spot(&light).unwrap();
            for w in [DVec3::new(0.2, -1.0, 0.1), DVec3::new(0.5, -1.0, 0.5), DVec3::new(0.3, -2.0, -0.4)] {
                let (u, v) = light.texture_coordinates(w);
                let at = projection.locate(light.position.as_dvec3() + w, (10, 10)).unwrap();
                assert!((at.u - 10.0 * u).abs() < 1e-5 && (at.v - 10.0 * v).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_directional_map_has_the_box_inside_its_outermost_ring() {
        let light = DirectionalLight::new(Vec3::new(0.4, -1.0, 0.3), Vec3::ONE).unwrap();
        let bounds = Aabb { min: Vec3::new(-3.0, 0.0, 1.0), max: Vec3::new(5.0, 2.0, 1.5) };
        for n in [1, 2, 5, 64] {
            let projection = Projection::directional(&light, &bounds, (n, n)).unwrap();
            for i in 0..8 {
                let pick = |bit: u32, a: f32, b: f32| f64::from(if i >> bit & 1 == 0 { a } else { b });
                let (lo, hi) = (bounds.min, bounds.max);
                let p = DVec3::new(pick(0, lo.x, hi.x), pick(1, lo.y, hi.y), pick(2, lo.z, hi.z));
                let at = projection.locate(p, (n, n)).unwrap();
                assert!(at.depth > 0.0);
                let ring = if n > 4 { 1.49 } else { 0.0 };
                let inside = ring..=f64::from(n) - ring;
                assert!(inside.contains(&at.u) && inside.contains(&at.v), "{n}: {at:?}");
            }
        }
        assert!(Projection::directional(&light, &Aabb::EMPTY, (8, 8)).is_ok());
    }

    #[test]
    fn covering_moves_the_outermost_centres_to_the_edge() {
        let light = SpotLight::new(Vec3::ZERO, Vec3::NEG_Z, 0.0, 0.5, Vec3::ONE).unwrap();
        let wide = Projection::spot(&light).unwrap().covering((8, 8));
        let at = wide.locate(DVec3::new(f64::from(0.5_f32).tan(), 0.0, -1.0), (8, 8)).unwrap();
        assert!((at.u - 7.5).abs() < 1e-9 && (at.v - 4.0).abs() < 1e-9);
    }

    #[test]
    fn nonsense_is_refused() {
        let (o, z, x, one) = (DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE);
        assert!(Projection::perspective(o, z, x, one).is_ok());
        assert_eq!(Projection::perspective(o, z, z, one), Err(ShadowMapError::Axes));
        assert_eq!(Projection::perspective(o, o, x, one), Err(ShadowMapError::Axes));
        assert!(Projection::perspective(DVec3::NAN, z, x, one).is_err());
        assert!(Projection::perspective(o, z, x, DVec2::new(0.0, 1.0)).is_err());
        assert!(Projection::orthographic(o, z, x, DVec2::new(1.0, f64::INFINITY)).is_err());
        assert!(Projection::cube(DVec3::new(0.0, f64::INFINITY, 0.0)).is_err());
        assert!(Projection::cube(o).unwrap().with_near(0.0).is_err());
        assert!(Projection::cube(o).unwrap().locate(o, (4, 4)).is_none());
        let sun = DirectionalLight::new(Vec3::X, Vec3::ONE).unwrap();
        assert!(Projection::directional(&sun, &Aabb::EMPTY, (0, 8)).is_err());
    }
}
