//! What a frame costs: operations counted from what is known of it, times what one takes on a device.

use super::{Candidate, Facts, LightFacts, LightKind, ShadowFacts};
use crate::{Adaptive, Technique, Tessellation};
use shadowmap::MapSurface;

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Operation {
    /// A pass or dispatch by itself.
    Pass,
    /// A closed form of airlight along a ray that nothing shadows.
    ClosedForm,
    /// A ray that walks over a map, as far as it does not depend on the map.
    Walk,
    /// A block of a map's pyramid that such a ray visits; they grow with the root of the map's side.
    Block,
    /// The same where texels are joined by a surface.
    LinearBlock,
    /// A texel of a map whose pyramid is built.
    PyramidTexel,
    /// A ray that marches, as far as it does not depend on its steps.
    March,
    /// A step with a lookup.
    Step,
    /// A step whose airlight is evaluated by itself: under a picture, in a medium without closed form.
    VaryingStep,
    /// A step with a shadow ray.
    ShadowRay,
    /// A ray that marches between faces, as far as it does not depend on its steps.
    Hybrid,
    /// A step between faces.
    HybridStep,
    /// A triangle whose edges may be part of a silhouette.
    SilhouetteTriangle,
    /// A ray that crosses a light volume, as far as it does not depend on its triangles.
    VolumeRay,
    /// A texel of a map all of whose cells are drawn.
    VolumeTexel,
    /// The same where a quadtree draws few.
    TreeTexel,
    /// A froxel under a light, its shadow included.
    Froxel,
    /// A pixel of a picture of which few rays are traced: its error is estimated, and it is interpolated.
    Interpolation,
}

impl Operation {
    /// All of them, in the order of [`Costs`]' columns.
    pub const ALL: [Self; 18] = [
        Self::Pass,
        Self::ClosedForm,
        Self::Walk,
        Self::Block,
        Self::LinearBlock,
        Self::PyramidTexel,
        Self::March,
        Self::Step,
        Self::VaryingStep,
        Self::ShadowRay,
        Self::Hybrid,
        Self::HybridStep,
        Self::SilhouetteTriangle,
        Self::VolumeRay,
        Self::VolumeTexel,
        Self::TreeTexel,
        Self::Froxel,
        Self::Interpolation,
    ];
}

/// Pieces between a picture's texels, as many as a ray meets that walks over the map behind it.
const PICTURE_PIECES: f64 = 100.0;

/// Passes of adaptive sampling, beside those that trace.
const ADAPTIVE_PASSES: f64 = 25.0;

/// Rays that are usually traced of a picture with so many pixels along a side, in mean rays: those beside edges cost more.
///
/// Measured on 16 set-ups of 256², 512² and 1024² pixels; scenes are up to twice above and below.
fn traced_share(adaptive: &Adaptive, side: f64) -> f64 {
    let lattice = f64::from(adaptive.spacing).powi(-2);
    let target = 0.01 / f64::from(adaptive.target_error);
    let growth = if target < 1.0 { target.powf(0.55) } else { target.powf(0.9) };
    let between = 1.0 - (-TRACED_AT_ONE_PERCENT * growth * (1024.0 / side).powf(1.4)).exp();
    // then the last level traces all
    let is_all =
        adaptive.levels((side as u32, side as u32)).last().is_some_and(|level| between > level.most_traced);
    mean_rays(adaptive, if is_all { 1.0 } else { lattice + between * (1.0 - lattice) })
}

/// So many rays of a picture, as a share of its pixels, in mean rays.
fn mean_rays(adaptive: &Adaptive, traced: f64) -> f64 {
    let lattice = f64::from(adaptive.spacing).powi(-2).min(traced);
    let each = if traced > MOST_LISTED { LISTED_AT_ONCE } else { LISTED };
    lattice + each * (traced - lattice)
}

/// What it is for 1 % of a picture of 1024², without the lattice.
const TRACED_AT_ONE_PERCENT: f64 = 0.021;

/// Cost of a ray of a list, in mean rays: beside an edge, and where all are listed.
const LISTED: f64 = 1.4;

/// Share of a picture's rays above which its last level traces all.
const MOST_LISTED: f64 = 0.7;
const LISTED_AT_ONCE: f64 = 1.2;

/// Nanoseconds of each operation on a device, by kind of light: columns as [`LightKind::ALL`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Costs {
    nanoseconds: [[f64; 3]; Operation::ALL.len()],
    /// How much longer a device takes for all of them.
    scale: f64,
}

impl Costs {
    /// Lavapipe on two cores of a server CPU, with nothing else running.
    ///
    /// Fitted by least squares of relative errors to five set-ups of `repro pareto --preset quick` (256² pixels) and laid between
    /// those and eight of 1024² pixels, whose rays are more coherent and take two thirds of the time. Passes and what
    /// interpolation takes a pixel are what is left over between the two sizes. Varying steps, shadow rays and closed forms
    /// come from single measurements, and are rougher.
    pub const SOFTWARE: Self = Self {
        nanoseconds: [
            [2.2e5, 2.2e5, 2.2e5],  // Pass
            [60.0, 90.0, 10.0],     // ClosedForm
            [230.0, 280.0, 130.0],  // Walk
            [13.0, 7.0, 11.0],      // Block
            [50.0, 32.0, 37.0],     // LinearBlock
            [5.0, 5.8, 5.0],        // PyramidTexel
            [100.0, 180.0, 50.0],   // March
            [4.0, 2.5, 2.8],        // Step
            [30.0, 30.0, 30.0],     // VaryingStep
            [500.0, 500.0, 500.0],  // ShadowRay
            [175.0, 210.0, 100.0],  // Hybrid
            [6.0, 4.3, 3.4],        // HybridStep
            [70.0, 95.0, 110.0],    // SilhouetteTriangle
            [1300.0, 790.0, 620.0], // VolumeRay
            [60.0, 75.0, 65.0],     // VolumeTexel
            [2.0, 2.0, 2.0],        // TreeTexel
            [470.0, 450.0, 410.0],  // Froxel
            [22.0, 22.0, 22.0],     // Interpolation
        ],
        scale: 1.0,
    };

    /// What `operation` takes under a light of `kind`; units: ms.
    fn of(&self, operation: Operation, kind: LightKind) -> f64 {
        1e-6 * self.scale * self.nanoseconds[operation as usize][kind as usize]
    }

    /// Predicted time of a frame's fog by a candidate; units: ms.
    pub fn predict(&self, facts: &Facts<'_>, candidate: &Candidate) -> f64 {
        let views = f64::from(facts.views.max(1));
        let side = (facts.pixels as f64 / views).sqrt();
        let traced = candidate.sampling.adaptive().map_or(1.0, |adaptive| traced_share(adaptive, side));
        self.of_rays(facts, candidate, traced)
    }

    /// The same where it is known which share of its view rays a candidate with adaptive sampling traces, from 0 to 1.
    pub fn predict_traced(&self, facts: &Facts<'_>, candidate: &Candidate, traced: f64) -> f64 {
        let rays = candidate.sampling.adaptive().map_or(1.0, |adaptive| mean_rays(adaptive, traced));
        self.of_rays(facts, candidate, rays)
    }

    /// Predicted time where as many mean rays are traced, as a share of the pixels.
    fn of_rays(&self, facts: &Facts<'_>, candidate: &Candidate, share: f64) -> f64 {
        let of_light = |light: &LightFacts| {
            let operations = operations(facts, light, candidate, share);
            operations.map(|(operation, count)| count * self.of(operation, light.kind)).sum::<f64>()
        };
        facts.lights.iter().map(of_light).sum()
    }

    /// The same costs as seen on a device where a frame predicted to take `predicted` ms took `measured`.
    ///
    /// One frame tells how fast a device is; ratios between operations stay those of the table.
    #[must_use]
    pub fn scaled(&self, predicted: f64, measured: f64) -> Self {
        let ratio = measured / predicted;
        let scale = if ratio.is_finite() && ratio > 0.0 { self.scale * ratio } else { self.scale };
        Self { scale, ..*self }
    }
}

/// What a light of a frame takes by a candidate.
fn operations(
    facts: &Facts<'_>,
    light: &LightFacts,
    candidate: &Candidate,
    share: f64,
) -> impl Iterator<Item = (Operation, f64)> {
    use Operation as Op;
    let pixels = facts.pixels as f64;
    let adaptive = candidate.sampling.adaptive();
    let views = f64::from(facts.views);
    let rays = pixels * share;
    let closed = facts.medium.is_closed(light.kind) && !light.textured;
    let (map_side, changed) = light.map().map_or((0.0, false), |map| (f64::from(map.side), map.changed));
    let texels = map_side * map_side * f64::from(light.kind.faces());
    let made = if changed { texels } else { 0.0 };
    let mut all = Vec::new();
    if adaptive.is_some() {
        all.extend([(Op::Pass, ADAPTIVE_PASSES * views), (Op::Interpolation, pixels)]);
    }
    match candidate.technique {
        Technique::Froxels(froxels) => {
            let tiles = pixels / f64::from(froxels.tile * froxels.tile);
            all.push((Op::Pass, 5.0 * views));
            all.push((Op::Froxel, tiles * f64::from(froxels.slices)));
        }
        _ if light.shadows == ShadowFacts::None && closed => {
            all.extend([(Op::Pass, views), (Op::ClosedForm, rays)]);
        }
        Technique::ExactShadowMap { surface } => {
            let block = if surface == MapSurface::Linear { Op::LinearBlock } else { Op::Block };
            all.extend([(Op::Pass, 1.0 + views), (Op::PyramidTexel, made)]);
            all.extend([(Op::Walk, rays), (block, rays * map_side.sqrt())]);
            if !closed {
                all.push((Op::VaryingStep, rays * PICTURE_PIECES));
            }
        }
        Technique::LightVolume { tessellation, .. } => {
            let (texel, passes) = match tessellation {
                Tessellation::Adaptive { .. } => (Op::TreeTexel, 6.0),
                _ => (Op::VolumeTexel, 2.0),
            };
            all.extend([(Op::Pass, passes + 2.0 * views), (texel, texels * views), (Op::VolumeRay, rays)]);
        }
        Technique::BruteForce { samples, .. } => {
            let step = if closed { Op::Step } else { Op::VaryingStep };
            all.extend([(Op::Pass, views), (Op::March, rays), (step, rays * f64::from(samples))]);
            if candidate.rays && light.shadows != ShadowFacts::None {
                all.push((Op::ShadowRay, rays * f64::from(samples)));
            }
        }
        Technique::Hybrid(hybrid) => {
            // found anew where the light or its casters moved
            let triangles = if changed || light.map().is_none() { facts.triangles as f64 } else { 0.0 };
            let steps = rays * f64::from(hybrid.samples);
            all.extend([(Op::Pass, 1.0 + 3.0 * views), (Op::SilhouetteTriangle, triangles)]);
            all.extend([(Op::Hybrid, rays), (Op::HybridStep, steps)]);
            if !closed {
                all.push((Op::VaryingStep, rays * f64::from(hybrid.samples + 2 * hybrid.lit_samples)));
            }
            if candidate.rays {
                all.push((Op::ShadowRay, steps));
            }
        }
    }
    all.into_iter()
}
