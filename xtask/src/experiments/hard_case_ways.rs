//! What `hard-cases` compares: the techniques, and on which side of them a map stands.

use std::sync::Arc;

use super::measure::Setting;
use super::{Context, Preset};
use crate::gpu;
use crate::maps::{MapOptions, MapSurface, Maps};
use crate::technique::{HybridOptions, Options, Technique, Tessellation, VisibilitySource};

/// Steps of both marches.
pub(super) const SAMPLES: u32 = 48;

/// Side of the maps of light volumes for others of `side` texels: every texel is two triangles, on a cube six times as many.
pub(super) fn volume_map(side: u32) -> u32 {
    (side / 4).max(128)
}

/// The map of light volumes.
fn linear_map(base: Options) -> MapOptions {
    MapOptions { side: volume_map(base.map.side), surface: MapSurface::Linear }
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    Traversal,
    Hybrid,
    PlainHybrid,
    March,
    HybridByRays,
    MarchByRays,
    LinearTraversal,
    LightVolume,
    StaticVolume,
    LightVolumeOnCpu,
    StaticVolumeOnCpu,
    Froxels,
    SharedGrid,
    FroxelsOnCpu,
    SharedGridOnCpu,
}

impl Way {
    pub(super) const ALL: [Self; 15] = [
        Self::Traversal,
        Self::Hybrid,
        Self::PlainHybrid,
        Self::March,
        Self::HybridByRays,
        Self::MarchByRays,
        Self::LinearTraversal,
        Self::LightVolume,
        Self::StaticVolume,
        Self::LightVolumeOnCpu,
        Self::StaticVolumeOnCpu,
        Self::Froxels,
        Self::SharedGrid,
        Self::FroxelsOnCpu,
        Self::SharedGridOnCpu,
    ];

    /// Those for which there is time.
    fn of(preset: Preset) -> &'static [Self] {
        match preset {
            Preset::Smoke => &[
                Self::Hybrid,
                Self::PlainHybrid,
                Self::March,
                Self::LightVolume,
                Self::FroxelsOnCpu,
                Self::SharedGridOnCpu,
            ],
            Preset::Quick => &[
                Self::Traversal,
                Self::Hybrid,
                Self::PlainHybrid,
                Self::March,
                Self::LightVolume,
                Self::StaticVolume,
                Self::Froxels,
                Self::SharedGrid,
            ],
            Preset::Standard | Preset::Paper => &Self::ALL,
        }
    }

    /// Those of a preset that differ from each other: without a GPU everything is on the CPU.
    pub(super) fn of_context(context: &Context) -> Vec<Self> {
        let of_preset = Self::of(context.preset).iter().copied();
        // the shortest preset has some on the CPU alone
        let alone = context.preset == Preset::Smoke;
        let differ = of_preset.filter(|way| context.gpu.is_some() || alone || !way.on_cpu());
        differ.filter(|way| *way != Self::StaticVolume || !Self::leaves_out_static(context)).collect()
    }

    /// Whether there is no time for light volumes of all texels, which in software take as long as everything else.
    pub(super) fn leaves_out_static(context: &Context) -> bool {
        context.preset == Preset::Quick && !context.gpu.as_ref().is_some_and(gpu::is_hardware)
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Traversal => "exact-shadow-map",
            Self::Hybrid => "hybrid",
            Self::PlainHybrid => "hybrid, not refined, faces by pixel",
            Self::March => "brute force",
            Self::HybridByRays => "hybrid, shadow rays",
            Self::MarchByRays => "brute force, shadow rays",
            Self::LinearTraversal => "exact-shadow-map, linear",
            Self::LightVolume => "light volume",
            Self::StaticVolume => "light volume, static",
            Self::LightVolumeOnCpu => "light volume, on the CPU",
            Self::StaticVolumeOnCpu => "light volume, static, on the CPU",
            Self::Froxels => "froxels",
            Self::SharedGrid => "shared grid",
            Self::FroxelsOnCpu => "froxels, on the CPU",
            Self::SharedGridOnCpu => "shared grid, on the CPU",
        }
    }

    pub(super) fn on_cpu(self) -> bool {
        matches!(
            self,
            Self::LightVolumeOnCpu | Self::StaticVolumeOnCpu | Self::FroxelsOnCpu | Self::SharedGridOnCpu
        )
    }

    /// Whether it ends with froxels, as what it is compared with.
    pub(super) fn has_froxels(self) -> bool {
        self.technique().has_froxels()
    }

    /// What a map means to it.
    pub(super) fn surface(self) -> MapSurface {
        match self {
            Self::LinearTraversal => MapSurface::Linear,
            way if way.technique() == Technique::LightVolume => MapSurface::Linear,
            _ => MapSurface::Step,
        }
    }

    pub(super) fn technique(self) -> Technique {
        match self {
            Self::Traversal | Self::LinearTraversal => Technique::ExactShadowMap,
            Self::Hybrid | Self::PlainHybrid | Self::HybridByRays => Technique::Hybrid,
            Self::March | Self::MarchByRays => Technique::BruteForce,
            Self::LightVolume | Self::StaticVolume | Self::LightVolumeOnCpu | Self::StaticVolumeOnCpu => {
                Technique::LightVolume
            }
            Self::Froxels | Self::FroxelsOnCpu => Technique::Froxel,
            Self::SharedGrid | Self::SharedGridOnCpu => Technique::SharedGrid,
        }
    }

    pub(super) fn reads_map(self) -> bool {
        !matches!(self, Self::HybridByRays | Self::MarchByRays) && !self.has_froxels()
    }

    pub(super) fn setting(self, base: Options, linear: &Arc<Maps>) -> Setting {
        let samples = Some(SAMPLES);
        let visibility = if self.reads_map() { VisibilitySource::Map } else { VisibilitySource::Bvh };
        let plain = HybridOptions { tile: 1, refine: 0, ..base.hybrid };
        let hybrid = if self == Self::PlainHybrid { plain } else { base.hybrid };
        let own_maps = (self.surface() == MapSurface::Linear).then(|| Arc::clone(linear));
        let map = if own_maps.is_some() { linear_map(base) } else { base.map };
        let tessellation = match self {
            Self::StaticVolume | Self::StaticVolumeOnCpu => Tessellation::Static { indexed: true },
            _ => base.tessellation,
        };
        let options = Options { samples, visibility, hybrid, map, tessellation, ..base };
        Setting { own_maps, ..Setting::new(self.name(), self.technique(), options) }
    }
}
