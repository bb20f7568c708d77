//! The exact traversal as the answer to "which pieces of this ray do the lights reach".

use scene::{DRay, Interval, Light, LightId, LitIntervals};

use crate::{Bias, DepthMap, MapSurface, MapTraversal, ProjectionKind, ShadowMapError};

/// Exact lit intervals of view rays against the maps of a scene's lights.
///
/// A spot's cone is taken into account: outside of it nothing is lit. A light without a map has no shadows.
#[derive(Debug)]
pub struct ExactShadowMap<'a> {
    lights: &'a [Light],
    maps: Vec<Option<MapTraversal<'a>>>,
}

impl<'a> ExactShadowMap<'a> {
    /// Prepares the traversal of one map per light, `None` for a light that nothing shadows.
    ///
    /// # Errors
    /// [`ShadowMapError::Count`] unless there are as many maps as lights; [`ShadowMapError::WrongMap`] if a point light
    /// has a map other than a cube, or a directional light one that is not orthographic.
    pub fn new(
        maps: &'a [Option<DepthMap>],
        lights: &'a [Light],
        surface: MapSurface,
        bias: Bias,
    ) -> Result<Self, ShadowMapError> {
        check_maps(maps, lights)?;
        let maps = maps.iter().map(|map| map.as_ref().map(|map| MapTraversal::new(map, surface, bias)));
        Ok(Self { lights, maps: maps.collect() })
    }

    /// Memory of pyramids and seams, beside the maps' own; units: bytes.
    pub fn bytes(&self) -> usize {
        self.maps.iter().flatten().map(MapTraversal::bytes).sum()
    }
}

/// Checks that every light has a map that can serve it.
pub(crate) fn check_maps(maps: &[Option<DepthMap>], lights: &[Light]) -> Result<(), ShadowMapError> {
    if maps.len() != lights.len() {
        return Err(ShadowMapError::Count { lights: lights.len(), maps: maps.len() });
    }
    for (index, (map, light)) in maps.iter().zip(lights).enumerate() {
        let Some(map) = map else { continue };
        let projection = map.projection().kind();
        let (serves, kind) = match light {
            Light::Point(_) => (projection == ProjectionKind::Cube, "point"),
            Light::Spot(_) => (projection != ProjectionKind::Orthographic, "spot"),
            Light::Directional(_) => (projection == ProjectionKind::Orthographic, "directional"),
        };
        if !serves {
            return Err(ShadowMapError::WrongMap { light: index, map: projection.article_name(), kind });
        }
    }
    Ok(())
}

impl LitIntervals for ExactShadowMap<'_> {
    fn lit_intervals(&self, ray: &DRay, span: Interval, light: LightId, out: &mut Vec<Interval>) {
        let span = match &self.lights[light.0] {
            Light::Spot(spot) => spot.clip(ray, span),
            Light::Point(_) | Light::Directional(_) => span,
        };
        match &self.maps[light.0] {
            Some(traversal) => traversal.lit(ray, span, out),
            None => {
                out.clear();
                if !span.is_empty() {
                    out.push(span);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Projection;
    use glam::{DVec2, DVec3, Vec3};
    use scene::{DirectionalLight, PointLight, SpotLight};

    const ALL: Interval = Interval::new(0.0, f64::INFINITY);

    /// A map at the origin that looks down −Z with a right angle between its sides.
    fn perspective(size: (u32, u32), depths: Vec<f32>) -> DepthMap {
        let projection = Projection::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
        DepthMap::new(projection, size, depths).unwrap()
    }

    #[test]
    fn lights_and_maps_belong_together() {
        let one = Vec3::ONE;
        let lights = [
            Light::Point(PointLight::new(Vec3::ZERO, one).unwrap()),
            Light::Directional(DirectionalLight::new(Vec3::NEG_Y, one).unwrap()),
            Light::Spot(SpotLight::new(Vec3::ZERO, Vec3::NEG_Z, 0.0, 0.7, one).unwrap()),
        ];
        let exact = |maps: &[Option<DepthMap>]| {
            ExactShadowMap::new(maps, &lights, MapSurface::Step, Bias::NONE).map(|_| ()).unwrap_err()
        };
        assert_eq!(exact(&[None]), ShadowMapError::Count { lights: 3, maps: 1 });
        let spot = || Some(perspective((1, 1), vec![5.0]));
        assert!(matches!(exact(&[spot(), None, None]), ShadowMapError::WrongMap { light: 0, .. }));
        let error = exact(&[None, spot(), None]);
        assert_eq!(error.to_string(), "light 1: a perspective map cannot serve a directional light");

        let maps = [None, None, spot()];
        let exact = ExactShadowMap::new(&maps, &lights, MapSurface::Step, Bias::NONE).unwrap();
        let ray = DRay { origin: DVec3::new(-9.0, 0.0, -2.0), direction: DVec3::X };
        let mut out = Vec::new();
        exact.lit_intervals(&ray, ALL, LightId(0), &mut out);
        assert_eq!(out, [ALL]);
        // the cone is narrower than the map
        exact.lit_intervals(&ray, ALL, LightId(2), &mut out);
        assert!((out[0].start - (9.0 - 2.0 * f64::from(0.7_f32).tan())).abs() < 1e-9);
    }
}
