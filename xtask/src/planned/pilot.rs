//! What error a setting has on a scene, measured beforehand on few rays by the implementations of the CPU.
//!
//! The rays are those of a small picture by the same camera, so that they are spread evenly over the large one. Each
//! setting's airlight on them is compared with the exact one; how much the share of few rays may be off is part of the
//! answer. What interpolation between rays errs by is seen on neighbouring pixels alone: on tiles (`sampled.rs`).

use std::rc::Rc;
use std::time::Instant;

use glam::DVec3;
use hybrid_march::{Adaptive, Sampling};
use scene::Bvh;

use super::sampled::{Sampled, Tiles};

use crate::airlight::{Airlight, Stage};
use crate::failure::{Failure, Outcome};
use crate::maps::{MapOptions, Maps};
use crate::scene_args::Setup;
use crate::technique::{self, Options, Technique, VisibilitySource};
use crate::view_rays::ViewRays;

/// Rays of a pilot, about.
const RAYS: f64 = 16384.0;

/// The same where a setting's error is within the target on those, and not safely so.
const MORE_RAYS: f64 = 65536.0;

/// The same where the reference is a converged march.
const FEW_RAYS: f64 = 576.0;

/// Steps of that march: four times as many as any that is judged by it.
const CONVERGED: u32 = 8192;

/// Standard errors between what is found on few rays and what is taken for the picture's error.
const MARGIN: f64 = 3.0;

/// What a picture of the large size would take on the CPU; units: ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CpuTime {
    /// Whatever the number of rays: pyramids, meshes, silhouettes.
    prepared: f64,
    /// For a ray through every pixel.
    rays: f64,
}

impl CpuTime {
    /// Where a share of the rays is traced.
    pub(crate) fn of(self, traced: f64) -> f64 {
        self.prepared + traced * self.rays
    }
}

/// An error as a share of what the shadows change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Estimate {
    /// On the rays of the pilot.
    pub(crate) found: f64,
    /// What it is most likely below on all rays of the picture.
    pub(crate) upper: f64,
}

impl Estimate {
    /// The error of what is exact.
    pub(crate) const NONE: Self = Self { found: 0.0, upper: 0.0 };

    /// With an error of other origin beside it.
    pub(crate) fn with(self, other: Self) -> Self {
        Self { found: self.found.hypot(other.found), upper: self.upper.hypot(other.upper) }
    }

    /// The root of the share of `errors` in what `shadows` change, squares of each part of a sample that stands for `each` times
    /// as many parts. Where shadows change nothing it is the share in the airlight itself, `whole`.
    ///
    /// The standard error is that of a ratio of sums, e/s: that of the mean of (e − r s)/mean s.
    pub(super) fn of(errors: &[f64], shadows: &[f64], whole: &[f64], each: f64) -> Self {
        let sum = |squares: &[f64]| squares.iter().sum::<f64>();
        let weights = if sum(shadows) > 0.0 { shadows } else { whole };
        let (error, weight, count) = (sum(errors), sum(weights), errors.len() as f64);
        if error == 0.0 {
            return Self::NONE;
        }
        if !(weight > 0.0) {
            return Self { found: f64::INFINITY, upper: f64::INFINITY };
        }
        let share = error / weight;
        let deviations = errors.iter().zip(weights).map(|(e, s)| (e - share * s).powi(2));
        let spread = deviations.sum::<f64>().sqrt() / weight;
        // of a finite picture, of which the sample is a part
        let unseen = (1.0 - 1.0 / each.max(1.0)).sqrt();
        let ratio = count / (count - 1.0).max(1.0);
        Self { found: share.sqrt(), upper: (share + MARGIN * ratio.sqrt() * unseen * spread).sqrt() }
    }
}

/// A small picture of a setup, with what is exact there.
pub(crate) struct Pilot<'a> {
    setup: &'a Setup,
    bvh: &'a Bvh,
    base: Options,
    rays: ViewRays,
    /// How many rays of the picture each of the pilot stands for.
    rays_each: f64,
    exact: Vec<DVec3>,
    unshadowed: Vec<DVec3>,
    maps: Vec<(MapOptions, Rc<Maps>)>,
    /// Tiles of the picture, by the map that shadows them; without any where nothing is exact on a map.
    tiles: Vec<(MapOptions, Option<Tiles>)>,
    no_maps: Maps,
    /// The picture's size, and its rays where they were asked for.
    whole: (u32, u32),
    all_rays: Option<ViewRays>,
    /// What was judged, by technique and options.
    known: Vec<(String, (Estimate, CpuTime))>,
    /// With [`MORE_RAYS`], where it was asked.
    finer: Option<Box<Self>>,
    on_map: bool,
    /// What one exact picture of the large size would take on the CPU; units: ms.
    pub(crate) exact_ms: f64,
    started: Instant,
}

impl<'a> Pilot<'a> {
    /// Traces the rays and computes what is exact on them: a converged march in media without analytic integral.
    ///
    /// Where `on_map`, what is exact is so with respect to the map of the options.
    pub(crate) fn new(setup: &'a Setup, bvh: &'a Bvh, options: &Options, on_map: bool) -> Outcome<Self> {
        let rays = if setup.medium.is_homogeneous() { RAYS } else { FEW_RAYS };
        Self::with_rays(setup, bvh, options, on_map, rays, Vec::new())
    }

    fn with_rays(
        setup: &'a Setup,
        bvh: &'a Bvh,
        options: &Options,
        on_map: bool,
        rays: f64,
        maps: Vec<(MapOptions, Rc<Maps>)>,
    ) -> Outcome<Self> {
        let started = Instant::now();
        let analytic = setup.medium.is_homogeneous();
        let size = smaller(options.size, rays);
        let base = Options { size, sampling: Sampling::Pixels, ..*options };
        let rays = ViewRays::trace(&setup.camera, bvh, size);
        let rays = match options.froxels.range {
            Some(range) => rays.up_to(range),
            None => rays,
        };
        let area = |(width, height): (u32, u32)| f64::from(width) * f64::from(height);
        let rays_each = area(options.size) / area(size);
        let (exact, unshadowed, exact_ms) = (Vec::new(), Vec::new(), 0.0);
        let (tiles, known, whole) = (Vec::new(), Vec::new(), options.size);
        let mut pilot = Self {
            setup,
            bvh,
            base,
            rays,
            rays_each,
            exact,
            unshadowed,
            maps,
            tiles,
            no_maps: Maps::none(setup.lights.len()),
            whole,
            all_rays: None,
            known,
            finer: None,
            on_map,
            exact_ms,
            started,
        };
        let (technique, reference) = if analytic && on_map {
            (Technique::ExactShadowMap, base)
        } else if analytic {
            (Technique::Exact, base)
        } else {
            let visibility = VisibilitySource::Bvh;
            (Technique::BruteForce, Options { samples: Some(CONVERGED), visibility, ..base })
        };
        let found = pilot.run(technique, &reference)?;
        (pilot.exact, pilot.exact_ms) = (found.radiance, found.ms * rays_each);
        let open = Options { shadows_in_medium: false, ..reference };
        pilot.unshadowed = pilot.run(technique, &open)?.radiance;
        Ok(pilot)
    }

    /// The error of a setting, and what its picture of the large size would take on the CPU.
    ///
    /// Fails where a map cannot be drawn.
    pub(crate) fn judge(&mut self, technique: Technique, options: &Options) -> Outcome<(Estimate, CpuTime)> {
        let sampling = Sampling::Pixels;
        let options = Options { size: self.base.size, sampling, ..options.of(technique) };
        let key = format!("{technique:?} {options:?}");
        if let Some((_, known)) = self.known.iter().find(|(known, _)| *known == key) {
            return Ok(*known);
        }
        let mut smaller_tiles = options;
        // tiles cover as much of the picture as they will
        let shrink = self.rays_each.sqrt();
        smaller_tiles.hybrid.tile = ((f64::from(options.hybrid.tile) / shrink).round() as u32).max(1);
        let found = self.run(technique, &smaller_tiles)?;
        let error = estimate(&found.radiance, &self.exact, &self.unshadowed, self.rays_each);
        let prepared = (found.ms - found.rays_ms).max(0.0);
        let judged = (error, CpuTime { prepared, rays: found.rays_ms * self.rays_each });
        self.known.push((key, judged));
        Ok(judged)
    }

    /// The error of a setting on more rays than [`Self::judge`] has, in media where those are exact; else the same.
    ///
    /// Fails where a map cannot be drawn.
    pub(crate) fn judge_closely(&mut self, technique: Technique, options: &Options) -> Outcome<Estimate> {
        if self.rays_each <= 1.0 || !self.setup.medium.is_homogeneous() {
            return Ok(self.judge(technique, options)?.0);
        }
        let mut finer = match self.finer.take() {
            Some(finer) => finer,
            None => {
                let base = Options { size: self.whole, ..self.base };
                let Self { setup, bvh, on_map, ref maps, .. } = *self;
                Box::new(Self::with_rays(setup, bvh, &base, on_map, MORE_RAYS, maps.clone())?)
            }
        };
        // those that were drawn since
        finer.maps.clone_from(&self.maps);
        let judged = finer.judge(technique, options);
        self.finer = Some(finer);
        Ok(judged?.0)
    }

    /// What a sampling errs by and traces under a map; `None` in media and under lights where nothing is exact on one.
    ///
    /// Fails where a map cannot be drawn.
    pub(crate) fn sampled(&mut self, map: MapOptions, adaptive: &Adaptive) -> Outcome<Option<Sampled>> {
        if !self.tiles.iter().any(|(known, _)| *known == map) {
            let exact = self.setup.medium.is_homogeneous()
                && technique::check(self.setup, Technique::ExactShadowMap, "").is_ok();
            let tiles = if exact {
                self.draw(map)?;
                let options = Options { size: self.whole, map, ..self.base };
                let drawn = self.maps.iter().find(|(drawn, _)| *drawn == map);
                let trace =
                    |(_, maps): &(MapOptions, Rc<Maps>)| Tiles::trace(self.setup, self.bvh, &options, maps);
                drawn.map(trace).transpose()?
            } else {
                None
            };
            self.tiles.push((map, tiles));
        }
        let tiles = self.tiles.iter().find(|(known, _)| *known == map).and_then(|(_, tiles)| tiles.as_ref());
        tiles.map(|tiles| tiles.judge(adaptive)).transpose()
    }

    /// Traces the view rays of the whole picture, and draws the maps that a technique reads.
    ///
    /// Fails where a map cannot be drawn.
    pub(crate) fn make_ready(&mut self, technique: Technique, options: &Options) -> Outcome<()> {
        if options.shadows_in_medium && technique.reads_maps(options.visibility) {
            self.draw(options.map)?;
        }
        self.all_rays.get_or_insert_with(|| {
            let rays = ViewRays::trace(&self.setup.camera, self.bvh, self.whole);
            self.base.froxels.range.map(|range| rays.up_to(range)).unwrap_or(rays)
        });
        Ok(())
    }

    /// What [`Self::make_ready`] made for a technique; fails where it was not asked.
    pub(crate) fn full_size(&self, technique: Technique, options: &Options) -> Outcome<(&ViewRays, &Maps)> {
        let unready = || Failure::program("the pilot's picture is not ready");
        let rays = self.all_rays.as_ref().ok_or_else(unready)?;
        if !options.shadows_in_medium || !technique.reads_maps(options.visibility) {
            return Ok((rays, &self.no_maps));
        }
        let drawn = self.maps.iter().find(|(drawn, _)| *drawn == options.map);
        Ok((rays, &drawn.ok_or_else(unready)?.1))
    }

    /// What is pictured.
    pub(crate) fn setup(&self) -> &'a Setup {
        self.setup
    }

    /// The hierarchy around it.
    pub(crate) fn bvh(&self) -> &'a Bvh {
        self.bvh
    }

    /// Time since the pilot began; units: ms.
    pub(crate) fn ms(&self) -> f64 {
        self.started.elapsed().as_secs_f64() * 1e3
    }

    fn draw(&mut self, map: MapOptions) -> Outcome<()> {
        if self.maps.iter().all(|(drawn, _)| *drawn != map) {
            self.maps.push((map, Rc::new(Maps::draw(self.setup, &map)?)));
        }
        Ok(())
    }

    fn run(&mut self, technique: Technique, options: &Options) -> Outcome<Airlight> {
        let wanted = options.map;
        let reads = options.shadows_in_medium && technique.reads_maps(options.visibility);
        if reads {
            self.draw(wanted)?;
        }
        let drawn = self.maps.iter().find(|(drawn, _)| reads && *drawn == wanted);
        let maps = drawn.map_or(&self.no_maps, |(_, maps)| maps);
        let Self { setup, bvh, rays, .. } = self;
        Stage { setup, bvh, options, rays, maps, further: &[], tick: &|_| () }.run(technique)
    }
}

/// A size with the same proportions and about so many pixels; the size itself where it has fewer.
fn smaller((width, height): (u32, u32), pixels: f64) -> (u32, u32) {
    let shrink = (pixels / (f64::from(width) * f64::from(height))).sqrt();
    if shrink >= 1.0 {
        return (width, height);
    }
    let side = |length: u32| ((f64::from(length) * shrink).round() as u32).max(1);
    (side(width), side(height))
}

/// ‖a − b‖/‖u − b‖ over the rays of a sample that stand for `rays_each` each, and how large it may be over all.
fn estimate(a: &[DVec3], exact: &[DVec3], unshadowed: &[DVec3], rays_each: f64) -> Estimate {
    let squares = |x: &[DVec3], y: &[DVec3]| -> Vec<f64> {
        x.iter().zip(y).map(|(x, y)| (*x - *y).length_squared()).collect()
    };
    let whole: Vec<f64> = exact.iter().map(|b| b.length_squared()).collect();
    Estimate::of(&squares(a, exact), &squares(unshadowed, exact), &whole, rays_each)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame;
    use crate::image_file::Image;
    use crate::maps::MapSurface;
    use crate::metrics;
    use crate::scene_args::SceneArgs;

    #[test]
    fn sizes_keep_their_proportions() {
        assert_eq!(smaller((512, 256), 512.0), (32, 16));
        assert_eq!((smaller((8, 8), 100.0), smaller((4000, 1), 100.0).1), ((8, 8), 1));
    }

    #[test]
    fn margins_shrink_with_what_is_seen() {
        let (b, u) = ([DVec3::ONE; 100], [DVec3::splat(3.0); 100]);
        let mut a = b;
        a[..10].fill(DVec3::splat(1.5));
        let all = estimate(&a, &b, &u, 1.0);
        assert!((all.found - (10.0 * 0.25 / 400.0_f64).sqrt()).abs() < 1e-12 && all.upper == all.found);
        let few = estimate(&a, &b, &u, 1e9);
        assert!(
            few.found == all.found && few.upper > 1.1 * few.found && few.upper < 1.4 * few.found,
            "{few:?}"
        );
        assert_eq!(estimate(&b, &b, &u, 9.0), Estimate::NONE);
        assert_eq!(estimate(&a, &b, &b, 1.0).found, (10.0 * 0.25 / 100.0_f64).sqrt(), "of the airlight");
        assert_eq!(estimate(&u, &[DVec3::ZERO; 100], &[DVec3::ZERO; 100], 1.0).found, f64::INFINITY);
    }

    #[test]
    fn a_pilot_foretells_the_error_of_the_picture() {
        let setup = SceneArgs::default().resolve("procedural:hall").unwrap();
        let bvh = Bvh::build(&setup.scene).unwrap();
        let mut options = Options { airlight_only: true, ..Options::new((192, 192)) };
        options.map.surface = MapSurface::Step;
        let mut pilot = Pilot::new(&setup, &bvh, &options, false).unwrap();
        let picture = |technique, options: &Options| -> Image {
            frame::render(&setup, &bvh, technique, options, None, "").unwrap().image
        };
        let exact = picture(Technique::Exact, &options);
        let open = picture(Technique::Exact, &Options { shadows_in_medium: false, ..options });
        for side in [64, 256] {
            options.map.side = side;
            let (found, _) = pilot.judge(Technique::ExactShadowMap, &options).unwrap();
            let whole = picture(Technique::ExactShadowMap, &options);
            let error = metrics::compare(&whole, &exact, Some(&open), None).unwrap().shadow_err.unwrap();
            assert!(error < found.upper && found.upper < 1.5 * error, "{side}: {error} against {found:?}");
            // those are all rays of so small a picture
            let close = pilot.judge_closely(Technique::ExactShadowMap, &options).unwrap();
            assert!(close.upper == close.found && (close.found / error - 1.0).abs() < 1e-3, "{close:?}");
        }
    }
}
