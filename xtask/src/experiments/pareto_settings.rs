//! The settings of `pareto`: every technique with what trades its time for error.

use hybrid_march::{Adaptive, Sampling};

use super::measure::{Arena, Rebuild, Setting};
use super::pareto_picks::Metric;
use crate::maps::{MapOptions, MapSurface};
use crate::technique::{Options, Technique, Tessellation};

/// What is swept.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sweep {
    /// Side of the map that is given, on which errors on the map are.
    pub(super) map: u32,
    /// Sides of the maps of which one may be chosen; without any, nothing is against the geometry.
    pub(super) maps: &'static [u32],
    /// Steps of marches over the light's extent.
    pub(super) samples: &'static [u32],
    /// Steps between the faces of shadow volumes.
    pub(super) hybrid: &'static [u32],
    /// Thresholds of light volumes, as shares of the scene's diagonal.
    pub(super) thresholds: &'static [f32],
    /// Pixels a side of the blocks that airlight is computed for.
    pub(super) scales: &'static [u32],
    /// Errors down to which rays are traced where airlight changes.
    pub(super) adaptive: &'static [f32],
    /// Pixels a side of froxels.
    pub(super) tiles: &'static [u32],
    /// Whether froxels of a shared grid are measured.
    pub(super) grid: bool,
}

impl Sweep {
    /// What is of interest.
    pub(super) fn metrics(&self) -> &'static [Metric] {
        if self.maps.is_empty() { &[Metric::Map] } else { &Metric::ALL }
    }
}

/// Steps of the march and of the hybrid that are also measured for blocks of pixels.
const IN_BLOCKS: [u32; 2] = [64, 16];

/// Name of a technique with a setting that is no number of it.
pub(super) fn family(setting: &Setting) -> String {
    let Setting { technique, options, .. } = setting;
    let mut name = technique.name();
    if let (Technique::LightVolume, Tessellation::Static { .. }) = (technique, options.tessellation) {
        name += ", static";
    }
    if options.map.surface == MapSurface::Linear && *technique == Technique::ExactShadowMap {
        name += ", linear";
    }
    match technique.sampling(options.sampling) {
        Sampling::Pixels => (),
        Sampling::Blocks { scale, .. } => name += &format!(", blocks of {scale}"),
        Sampling::Adaptive(_) => name += ", adaptive",
    }
    name
}

/// A share in per cent, to as many digits as one would write.
pub(super) fn percent(share: f32) -> f64 {
    (1e5 * f64::from(share)).round() / 1e3
}

/// All settings of a scene.
pub(super) fn all(sweep: &Sweep, arena: &Arena) -> Vec<Setting> {
    let base = arena.base;
    let with_map = |side, surface| Options { map: MapOptions { side, surface }, ..base };
    let given = with_map(sweep.map, MapSurface::Step);
    let mut all = Vec::new();
    if !sweep.maps.is_empty() {
        all.push(Setting::new("exact, on the CPU", Technique::Exact, base));
    }
    for &side in sweep.maps {
        let mut exact = |surface: MapSurface| {
            let name = format!("exact-shadow-map, {side}² {}", surface.name());
            all.push(Setting::new(name, Technique::ExactShadowMap, with_map(side, surface)));
        };
        exact(MapSurface::Step);
        exact(MapSurface::Linear);
    }
    for (technique, samples) in [(Technique::BruteForce, sweep.samples), (Technique::Hybrid, sweep.hybrid)] {
        for &samples in samples {
            let options = Options { samples: Some(samples), ..given };
            all.push(Setting::new(format!("{}, {samples} samples", technique.name()), technique, options));
        }
    }
    for &scale in sweep.scales {
        for (technique, samples) in [Technique::BruteForce, Technique::Hybrid].into_iter().zip(IN_BLOCKS) {
            let options = Options {
                samples: Some(samples),
                sampling: Sampling::Blocks { scale, anew_at_edges: true },
                ..given
            };
            let name = format!("{}, {samples} samples, blocks of {scale}", technique.name());
            all.push(Setting::new(name, technique, options));
        }
    }
    for &target in sweep.adaptive {
        let sampling = Sampling::Adaptive(Adaptive::new(target, base.size));
        let mut adaptive = |technique: Technique, options: Options, what: String| {
            let name = format!("{}, {what}, adaptive {} %", technique.name(), percent(target));
            all.push(Setting::new(name, technique, Options { sampling, ..options }));
        };
        for &side in sweep.maps.iter().chain([&sweep.map]) {
            let map = with_map(side, MapSurface::Step);
            adaptive(Technique::ExactShadowMap, map, format!("{side}² step"));
        }
        for (technique, samples) in [Technique::BruteForce, Technique::Hybrid].into_iter().zip(IN_BLOCKS) {
            let options = Options { samples: Some(samples), ..given };
            adaptive(technique, options, format!("{samples} samples"));
        }
    }
    let linear = with_map(sweep.map, MapSurface::Linear);
    let diagonal = arena.bvh.bounds().diagonal();
    let volumes = sweep.thresholds.iter().map(|&share| {
        let tessellation = Tessellation::Adaptive {
            criterion: lightvolume::Criterion::Distance,
            threshold: Some(share * diagonal),
        };
        (format!("adaptive by {} % of the diagonal", 100.0 * share), tessellation)
    });
    let whole = ("static".to_owned(), Tessellation::Static { indexed: true });
    for (name, tessellation) in volumes.chain([whole]) {
        let options = Options { tessellation, ..linear };
        all.push(Setting::new(format!("light-volume, {name}"), Technique::LightVolume, options));
    }
    let grids = sweep.grid.then_some(Technique::SharedGrid);
    for (technique, &tile) in std::iter::once(Technique::Froxel)
        .chain(grids)
        .flat_map(|technique| sweep.tiles.iter().map(move |tile| (technique, tile)))
    {
        let mut options = given;
        options.froxels.tile = tile;
        // a frame of froxels keeps nothing of the one before
        let name = format!("{}, tiles of {tile}", technique.name());
        all.push(Setting { rebuild: Rebuild::Always, ..Setting::new(name, technique, options) });
    }
    all
}
