//! Maps as the answer to "does this light reach this point", for a march.

use glam::Vec3;
use scene::{LightId, Visibility};

use crate::{Bias, DepthMap, Filter, MapTraversal, VarianceMap};

/// Visibility by lookups in the maps of a scene's lights. A light without a map is visible from everywhere.
#[derive(Debug, Clone, Copy)]
pub struct MapVisibility<'a> {
    maps: &'a [Option<DepthMap>],
    filter: Filter,
    bias: Bias,
}

impl<'a> MapVisibility<'a> {
    /// Lookups in one map per light, `None` for a light that nothing shadows.
    pub fn new(maps: &'a [Option<DepthMap>], filter: Filter, bias: Bias) -> Self {
        Self { maps, filter, bias }
    }
}

/// The map of a light; a light beyond the maps has none.
fn of_light<T>(maps: &[Option<T>], light: LightId) -> Option<&T> {
    maps.get(light.0).and_then(Option::as_ref)
}

impl Visibility for MapVisibility<'_> {
    fn visibility(&self, point: Vec3, light: LightId) -> f32 {
        of_light(self.maps, light).map_or(1.0, |map| map.visibility(point.as_dvec3(), self.filter, self.bias))
    }
}

/// Visibility by variance maps, one per light.
#[derive(Debug, Clone, Copy)]
pub struct VarianceVisibility<'a> {
    maps: &'a [Option<VarianceMap>],
}

impl<'a> VarianceVisibility<'a> {
    /// Lookups in one map per light, `None` for a light that nothing shadows.
    pub fn new(maps: &'a [Option<VarianceMap>]) -> Self {
        Self { maps }
    }
}

impl Visibility for VarianceVisibility<'_> {
    fn visibility(&self, point: Vec3, light: LightId) -> f32 {
        of_light(self.maps, light).map_or(1.0, |map| map.visibility(point.as_dvec3()))
    }
}

/// Visibility by either meaning of a map: what a march needs that is compared with a traversal of the same.
#[derive(Debug)]
pub struct SurfaceVisibility<'a> {
    maps: Vec<Option<MapTraversal<'a>>>,
}

impl<'a> SurfaceVisibility<'a> {
    /// Lookups in one map per light, `None` for a light that nothing shadows.
    pub fn new(maps: &'a [Option<DepthMap>], surface: crate::MapSurface, bias: Bias) -> Self {
        let maps = maps.iter().map(|map| map.as_ref().map(|map| MapTraversal::new(map, surface, bias)));
        Self { maps: maps.collect() }
    }
}

impl Visibility for SurfaceVisibility<'_> {
    fn visibility(&self, point: Vec3, light: LightId) -> f32 {
        let lit = of_light(&self.maps, light).is_none_or(|map| map.is_lit(point.as_dvec3()));
        f32::from(u8::from(lit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MapSurface, Projection};
    use glam::DVec3;

    #[test]
    fn lights_without_maps_shine_everywhere() {
        let cube = DepthMap::uniform(Projection::cube(DVec3::ZERO).unwrap(), (8, 8), 2.0).unwrap();
        let moments = [None, Some(VarianceMap::new(&cube, 10.0).unwrap())];
        let maps = [None, Some(cube)];
        let steps = MapVisibility::new(&maps, Filter::Nearest, Bias::NONE);
        let surface = SurfaceVisibility::new(&maps, MapSurface::Linear, Bias::NONE);
        let variance = VarianceVisibility::new(&moments);
        let all: [&dyn Visibility; 3] = [&steps, &surface, &variance];
        for visibility in all {
            let ask = |x: f32, light| visibility.visibility(Vec3::new(x, 0.1, 0.2), LightId(light));
            assert_eq!((ask(1.9, 1), ask(9.0, 0), ask(9.0, 2)), (1.0, 1.0, 1.0));
            assert!(ask(9.0, 1) < 1e-3);
        }
    }
}
