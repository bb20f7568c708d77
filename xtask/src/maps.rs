//! The shadow maps of a frame: drawn once, for whichever technique or backend reads them.

use std::time::Instant;

use clap::ValueEnum;
use scene::Light;
use shadowmap::{DepthMap, draw_maps_for};

use crate::failure::{Failure, Outcome};
use crate::scene_args::Setup;

/// Texels along a side where none are given (of each face for a point light).
pub(crate) const DEFAULT_SIDE: u32 = 1024;

/// Most texels of all maps of a frame together: 4 GiB, pyramids not counted.
const MOST_TEXELS: u64 = 1 << 30;

/// `--map-surface`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MapSurface {
    /// Texels are steps, as a lookup sees them.
    #[default]
    Step,
    /// Linear between texel centres, as a light volume encloses it.
    Linear,
}

impl MapSurface {
    /// The flag's value.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Linear => "linear",
        }
    }
}

impl From<MapSurface> for shadowmap::MapSurface {
    fn from(surface: MapSurface) -> Self {
        match surface {
            MapSurface::Step => Self::Step,
            MapSurface::Linear => Self::Linear,
        }
    }
}

/// How a frame's maps are drawn and read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct MapOptions {
    /// Texels along a side, of each face for a point light.
    pub(crate) side: u32,
    /// What the texels mean.
    pub(crate) surface: MapSurface,
}

impl Default for MapOptions {
    fn default() -> Self {
        Self { side: DEFAULT_SIDE, surface: MapSurface::Step }
    }
}

impl MapOptions {
    /// Fails if a map of this size encloses nothing in its meaning, or if the maps of all lights are too large together.
    pub(crate) fn check(&self, setup: &Setup) -> Outcome {
        if self.side < 2 && self.surface == MapSurface::Linear {
            return Err(Failure::input(format!(
                "--shadow-map {}: with --map-surface linear it takes at least 2",
                self.side
            )));
        }
        let faces = |light: &Light| if matches!(light, Light::Point(_)) { 6 } else { 1 };
        let texels = setup.lights.iter().map(faces).sum::<u64>() * u64::from(self.side).pow(2);
        if texels > MOST_TEXELS && setup.scene.triangle_count() > 0 {
            return Err(Failure::input(format!(
                "--shadow-map {}: the maps of all lights together need {texels} texels, more than {MOST_TEXELS}",
                self.side
            )));
        }
        Ok(())
    }
}

/// Maps of a frame's lights and what they cost.
#[derive(Debug, Clone)]
pub(crate) struct Maps {
    /// One for every light; `None` where nothing shadows it.
    pub(crate) maps: Vec<Option<DepthMap>>,
    /// Wall time of drawing them; units: ms.
    pub(crate) ms: f64,
}

impl Maps {
    /// No map for any of `lights` lights.
    pub(crate) fn none(lights: usize) -> Self {
        Self { maps: vec![None; lights], ms: 0.0 }
    }

    /// Draws a map for every light; none at all where there is nothing that casts a shadow.
    ///
    /// A spot's map has the frustum that its meaning needs: exactly around the cone for steps, a texel wider for the
    /// linear meaning, which would cut the cone otherwise.
    pub(crate) fn draw(setup: &Setup, options: &MapOptions) -> Outcome<Self> {
        options.check(setup)?;
        let started = Instant::now();
        let maps = draw_maps_for(&setup.lights, &setup.scene, options.side, options.surface.into())
            .map_err(|e| Failure::input(format!("--shadow-map {}: {e}", options.side)))?;
        Ok(Self { maps, ms: started.elapsed().as_secs_f64() * 1e3 })
    }

    /// Whether there is a map at all.
    pub(crate) fn any(&self) -> bool {
        self.maps.iter().any(Option::is_some)
    }

    /// Memory of the maps; units: bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.maps.iter().flatten().map(DepthMap::bytes).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_args::SceneArgs;

    #[test]
    fn a_map_a_light_and_none_without_triangles() {
        let options = MapOptions { side: 8, ..MapOptions::default() };
        let draw = |name: &str| {
            let setup = SceneArgs::default().resolve(name).unwrap();
            (setup.lights.len(), Maps::draw(&setup, &options).unwrap())
        };
        let (lights, maps) = draw("procedural:triangle");
        assert!(maps.any() && maps.maps.len() == lights, "{maps:?}");
        assert_eq!(maps.bytes(), lights * 6 * 8 * 8 * 4, "its lights are point lights");
        let (lights, none) = draw("procedural:empty");
        assert!(!none.any() && none.maps.len() == lights && none.bytes() == 0);
    }

    #[test]
    fn maps_without_a_meaning_or_without_end_are_refused() {
        let check = |name: &str, side, surface| {
            MapOptions { side, surface }.check(&SceneArgs::default().resolve(name).unwrap())
        };
        let triangle = "procedural:triangle";
        assert!(
            check(triangle, 1, MapSurface::Step).is_ok() && check(triangle, 2, MapSurface::Linear).is_ok()
        );
        assert_eq!(check(triangle, 1, MapSurface::Linear).unwrap_err().code(), 2);
        // six faces each
        assert_eq!(check(triangle, 16384, MapSurface::Step).unwrap_err().code(), 2);
        assert!(check("procedural:empty", 16384, MapSurface::Step).is_ok(), "nothing is drawn");
    }
}
