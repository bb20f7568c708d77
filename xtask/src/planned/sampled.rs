//! What interpolation between few rays errs by on a scene, and how many rays are left: measured beforehand on tiles of the
//! picture at its own resolution, under exact shadows of a map.

use glam::DVec3;
use ground_truth::Reference;
use hybrid_march::{Adaptive, BruteForce, Tile};
use rayon::prelude::*;
use scene::Bvh;
use shadowmap::{Bias, ExactShadowMap};

use super::pilot::Estimate;
use crate::airlight;
use crate::failure::{Failure, Outcome};
use crate::maps::Maps;
use crate::scene_args::Setup;
use crate::technique::{Options, Technique};

/// A picture of at most so many pixels along a side is one tile.
const WHOLE: u32 = 1025;

/// Tiles along a side of a larger one, and their side: some spacings of the first rays, and one; units: pixels. Smaller ones
/// have more of these rays on their borders than a picture has, and err by less.
const TILES: u32 = 3;
const SIDE: u32 = 257;

/// How many times what tiles say a larger picture may err by: shafts are few and lie together. Measured on 12 pictures of 1024².
const SLACK: f64 = 1.3;

/// A tile, the airlight of its pixels, and what it would be if nothing cast a shadow.
struct Part {
    size: (u32, u32),
    ends: Vec<f32>,
    exact: Vec<DVec3>,
    open: Vec<DVec3>,
}

/// Tiles of a picture whose airlight is known at every pixel.
pub(crate) struct Tiles {
    whole: (u32, u32),
    parts: Vec<Part>,
}

/// What was found of a sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sampled {
    /// What interpolation errs by, as a share of what the shadows change.
    pub(crate) error: Estimate,
    /// Share of the view rays that are traced.
    pub(crate) traced: f64,
}

impl Tiles {
    /// Tiles of the picture of a setup, for a homogeneous medium. Fails where a map is none for its light.
    pub(crate) fn trace(setup: &Setup, bvh: &Bvh, options: &Options, maps: &Maps) -> Outcome<Self> {
        Self::at(&places(options.size), setup, bvh, options, maps)
    }

    fn at(places: &[Place], setup: &Setup, bvh: &Bvh, options: &Options, maps: &Maps) -> Outcome<Self> {
        let Setup { scene, medium, lights, camera, model, .. } = setup;
        let whole = options.size;
        let shadows = ExactShadowMap::new(&maps.maps, lights, options.map.surface.into(), Bias::NONE)
            .map_err(Failure::program)?;
        let settings = airlight::settings(setup, options);
        let reference = Reference::new(&scene.materials, bvh, medium, lights, settings)
            .map_err(Failure::input)?
            .with_shadows(&shadows);
        let samples = Technique::BruteForce.default_samples();
        let open = BruteForce { medium, lights, occluders: None, samples, model: *model };
        let range = options.froxels.range.map_or(options.max_distance, f64::from);
        let part = |&(first, size): &Place| {
            let pixels: Vec<(f32, DVec3, DVec3)> = (0..size.0 * size.1)
                .into_par_iter()
                .map(|i| {
                    let ray = camera.pixel_ray(first.0 + i % size.0, first.1 + i / size.0, whole);
                    let hit = bvh.closest_hit(&ray, f64::INFINITY);
                    let end = hit.map_or(options.max_distance, |hit| hit.distance).min(range);
                    let lit = reference.airlight(&ray, end);
                    (end as f32, lit, open.airlight(&ray, end).airlight.as_dvec3())
                })
                .collect();
            Part {
                size,
                ends: pixels.iter().map(|pixel| pixel.0).collect(),
                exact: pixels.iter().map(|pixel| pixel.1).collect(),
                open: pixels.iter().map(|pixel| pixel.2).collect(),
            }
        };
        Ok(Self { whole, parts: places.iter().map(part).collect() })
    }

    /// What a sampling of the picture errs by and traces.
    pub(crate) fn judge(&self, adaptive: &Adaptive) -> Outcome<Sampled> {
        let tiles: Vec<Tile<'_>> =
            self.parts.iter().map(|part| Tile { size: part.size, ends: &part.ends }).collect();
        let pick = |of: &[DVec3], width: u32, pixels: &[(u32, u32)]| -> Vec<DVec3> {
            pixels.iter().map(|&(x, y)| of[(y * width + x) as usize]).collect()
        };
        let lit = |tile: usize, pixels: &[(u32, u32)]| {
            pick(&self.parts[tile].exact, self.parts[tile].size.0, pixels)
        };
        let open = |tile: usize, pixels: &[(u32, u32)]| {
            pick(&self.parts[tile].open, self.parts[tile].size.0, pixels)
        };
        let found = adaptive.tiles(self.whole, &tiles, lit, open).map_err(Failure::input)?;
        let squares = |a: &[DVec3], b: &[DVec3]| -> f64 {
            a.iter().zip(b).map(|(a, b)| (*a - *b).length_squared()).sum()
        };
        let errors: Vec<f64> = self
            .parts
            .iter()
            .zip(&found.pictures)
            .map(|(part, picture)| squares(picture, &part.exact))
            .collect();
        let weights: Vec<f64> = self.parts.iter().map(|part| squares(&part.open, &part.exact)).collect();
        let whole: Vec<f64> =
            self.parts.iter().map(|part| part.exact.iter().map(|b| b.length_squared()).sum()).collect();
        let pixels: usize = self.parts.iter().map(|part| part.exact.len()).sum();
        let each = f64::from(self.whole.0) * f64::from(self.whole.1) / pixels as f64;
        let error = Estimate::of(&errors, &weights, &whole, each);
        let slack = if self.parts.len() > 1 { SLACK } else { 1.0 };
        Ok(Sampled {
            error: Estimate { upper: slack * error.upper, ..error },
            traced: found.traced as f64 / pixels as f64,
        })
    }
}

/// First pixel and size of a tile.
type Place = ((u32, u32), (u32, u32));

/// All of a small picture, else tiles that are spread evenly over it.
fn places((width, height): (u32, u32)) -> Vec<Place> {
    if width.max(height) <= WHOLE {
        return vec![((0, 0), (width, height))];
    }
    let along = |length: u32| -> Vec<(u32, u32)> {
        if length <= SIDE * TILES {
            return vec![(0, length)];
        }
        // in the middle of each part
        (0..TILES).map(|i| ((2 * i + 1) * length / (2 * TILES) - SIDE / 2, SIDE)).collect()
    };
    let columns = along(width);
    let rows = along(height).into_iter();
    rows.flat_map(|(y, h)| columns.iter().map(move |&(x, w)| ((x, y), (w, h)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::{MapOptions, MapSurface};
    use crate::scene_args::SceneArgs;

    #[test]
    fn tiles_lie_inside_and_apart() {
        assert_eq!(places((200, 100)), [((0, 0), (200, 100))]);
        for size in [(1200, 1200), (1920, 1080), (1100, 200)] {
            let all = places(size);
            assert!(all.iter().all(|((x, y), (w, h))| x + w <= size.0 && y + h <= size.1), "{all:?}");
            let apart = all.windows(2).all(|pair| {
                let [((x, y), (w, _)), ((next, below), _)] = [pair[0], pair[1]];
                x + w <= next || y < below
            });
            assert!(apart && all.len() >= 3, "{all:?}");
        }
    }

    #[test]
    fn tiles_foretell_what_the_picture_errs_by() {
        let setup = SceneArgs::default().resolve("procedural:hall").unwrap();
        let bvh = Bvh::build(&setup.scene).unwrap();
        let mut options = Options { airlight_only: true, ..Options::new((1032, 400)) };
        options.map = MapOptions { side: 128, surface: MapSurface::Step };
        let maps = Maps::draw(&setup, &options.map).unwrap();
        let tiles = Tiles::trace(&setup, &bvh, &options, &maps).unwrap();
        let whole = Tiles::at(&[((0, 0), options.size)], &setup, &bvh, &options, &maps).unwrap();
        assert!(tiles.parts.len() == 3 && whole.parts.len() == 1);
        for target in [0.002, 0.01, 0.05] {
            let adaptive = Adaptive::new(target, options.size);
            let (found, all) = (tiles.judge(&adaptive).unwrap(), whole.judge(&adaptive).unwrap());
            // a picture that is one tile is no sample
            assert_eq!(all.error.found, all.error.upper);
            let error = all.error.found;
            assert!(error < found.error.upper && found.error.upper < 3.0 * error, "{found:?} {all:?}");
            assert!((found.traced / all.traced - 1.0).abs() < 0.3, "{found:?} {all:?}");
        }
    }
}
