//! What the experiments of Billeter, Sintorn and Assarsson 2010 share: light volumes as settings, by their names.

use lightvolume::Criterion;

use super::Context;
use super::measure::{Arena, Measured, Rebuild, Setting, base};
use super::wyman_bench::{source, thin};
use crate::failure::Outcome;
use crate::maps::{MapOptions, MapSurface};
use crate::scene_args::Setup;
use crate::setups::LightKind;
use crate::technique::{Options, Technique, Tessellation};

/// Options of a square picture of the airlight alone, with a map in the meaning that a light volume encloses.
pub(super) fn linear(side: u32, map: u32) -> Options {
    Options { map: MapOptions { side: map, surface: MapSurface::Linear }, ..base(side, map) }
}

/// The paper's scenes that are one model: sponza and Yeah Right, or what stands in for them.
pub(super) const SCENES: [&str; 2] = ["sponza", "yeahright-188k"];

/// A scene's title and its set-up under a light of `kind` in the thin medium; `None` without such a light.
pub(super) fn lit(context: &Context, id: &str, kind: LightKind) -> Outcome<Option<(String, Setup)>> {
    let source = source(context, id)?;
    let setup = source.setup_lit(thin(context), kind)?;
    Ok(setup.map(|setup| (source.title(), setup)))
}

/// How a surface is divided, with thresholds as shares of the scene's diagonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Division {
    /// All cells, two vertices each by indices.
    Indexed,
    /// All cells, six vertices each without a vertex buffer.
    SixVertices,
    /// A quadtree whose distance from the whole surface is bounded.
    Distance(f32),
    /// A quadtree by the paper's edge map.
    Laplacian(f32),
    /// Delaunay triangles, made beforehand.
    Delaunay(f32),
}

impl Division {
    /// Name in the tables.
    pub(super) fn name(self) -> String {
        let percent = |share: f32| format!("{:.2} % of the diagonal", 100.0 * share);
        match self {
            Self::Indexed => "static, indexed".into(),
            Self::SixVertices => "static, six vertices a cell".into(),
            Self::Distance(share) => format!("adaptive by distance, {}", percent(share)),
            Self::Laplacian(share) => format!("adaptive by Laplacian, {}", percent(share)),
            Self::Delaunay(share) => format!("Delaunay, {}", percent(share)),
        }
    }

    /// Whether it has all cells of the map.
    pub(super) fn is_static(self) -> bool {
        matches!(self, Self::Indexed | Self::SixVertices)
    }

    /// Whether it is a quadtree.
    pub(super) fn is_adaptive(self) -> bool {
        matches!(self, Self::Distance(_) | Self::Laplacian(_))
    }

    fn tessellation(self, diagonal: f32) -> Tessellation {
        let adaptive =
            |criterion, share| Tessellation::Adaptive { criterion, threshold: Some(share * diagonal) };
        match self {
            Self::Indexed => Tessellation::Static { indexed: true },
            Self::SixVertices => Tessellation::Static { indexed: false },
            Self::Distance(share) => adaptive(Criterion::Distance, share),
            Self::Laplacian(share) => adaptive(Criterion::Laplacian, share),
            Self::Delaunay(share) => Tessellation::Delaunay { bound: Some(share * diagonal) },
        }
    }

    /// The light volume as a setting: a quadtree is timed made anew and kept, and Delaunay triangles are kept.
    pub(super) fn setting(self, arena: &Arena, options: Options) -> Setting {
        let tessellation = self.tessellation(arena.bvh.bounds().diagonal());
        let rebuild = match self {
            Self::Delaunay(_) => Rebuild::Never,
            _ if self.is_adaptive() => Rebuild::Both,
            _ => Rebuild::Always,
        };
        let options = Options { tessellation, ..options };
        Setting { rebuild, ..Setting::new(self.name(), Technique::LightVolume, options) }
    }
}

/// The faster of some measurements.
pub(super) fn fastest<'a>(all: impl Iterator<Item = &'a Measured>) -> Option<&'a Measured> {
    all.min_by(|a, b| a.ms().total_cmp(&b.ms()))
}

/// Time of one measurement over another's.
pub(super) fn time_ratio(slow: Option<&Measured>, fast: Option<&Measured>) -> Option<f64> {
    Some(slow?.ms() / fast?.ms())
}
