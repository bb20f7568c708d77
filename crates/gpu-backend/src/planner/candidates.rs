//! The techniques and settings among which a frame's is chosen.

use froxel_grid::Froxels;
use shadowmap::MapSurface;

use super::{Facts, LightKind, ShadowFacts};
use crate::{Adaptive, Criterion, DEFAULT_MOST_LEAVES, Hybrid, Lookup, Sampling, Technique, Tessellation};

/// Steps of a march along all of a light's extent.
const MARCH: [u32; 9] = [8, 16, 32, 64, 128, 256, 512, 1024, 2048];

/// Steps between the faces of shadow volumes.
const HYBRID: [u32; 7] = [4, 8, 16, 32, 64, 128, 256];

/// Thresholds of quadtrees around what a light reaches, as shares of the casters' diagonal.
const THRESHOLDS: [f32; 2] = [1e-2, 1e-3];

/// What interpolation is allowed to err by where few rays are traced, as shares of the target: what is left over is the
/// technique's own. Pictures err by a tenth to all of what they may; the larger shares are for who measures which.
const ADAPTIVE_SHARES: [f32; 6] = [0.4, 0.7, 0.95, 1.5, 2.5, 5.0];

/// One way to make a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// How airlight with shadows is computed.
    pub technique: Technique,
    /// Whether shadows are asked of a hierarchy ([`Shadows::Rays`](crate::Shadows::Rays)) instead of a map.
    pub rays: bool,
    /// For which view rays airlight is computed.
    pub sampling: Sampling,
}

/// All that can make the frame, in no order.
///
/// `froxels` is what a host would fill for any medium and number of views; a frame without a hierarchy has none.
/// Each technique by ray is there for every pixel and for those around which airlight changes. Blocks of pixels
/// ([`Sampling::Blocks`]) are not: their error at depth edges depends on the picture, and nothing bounds it.
pub fn candidates(facts: &Facts<'_>, froxels: Option<Froxels>) -> Vec<Candidate> {
    let mut all = of_every_pixel(facts, froxels);
    if facts.is_shadowed() {
        let side = (facts.pixels as f64 / f64::from(facts.views.max(1))).sqrt() as u32;
        let by_ray = |candidate: &Candidate| {
            !matches!(candidate.technique, Technique::LightVolume { .. } | Technique::Froxels(_))
        };
        let whole: Vec<Candidate> = all.iter().copied().filter(by_ray).collect();
        for share in ADAPTIVE_SHARES {
            let sampling = Sampling::Adaptive(Adaptive::new(share * facts.target_error, (side, side)));
            all.extend(whole.iter().map(|candidate| Candidate { sampling, ..*candidate }));
        }
    }
    all
}

fn of_every_pixel(facts: &Facts<'_>, froxels: Option<Froxels>) -> Vec<Candidate> {
    let sampling = Sampling::Pixels;
    let by_map = |technique| Candidate { technique, rays: false, sampling };
    let mut all = Vec::new();
    let mapped = facts.lights.iter().all(|light| !matches!(light.shadows, ShadowFacts::Rays));
    let closed = facts.lights.iter().all(|light| facts.medium.is_closed(light.kind));
    if closed && mapped {
        let exact = |surface| by_map(Technique::ExactShadowMap { surface });
        all.push(exact(MapSurface::Step));
        if facts.is_shadowed() {
            all.push(exact(MapSurface::Linear));
        }
    }
    let textured = facts.lights.iter().any(|light| light.textured);
    if closed && mapped && facts.is_shadowed() && !textured {
        let adaptive = THRESHOLDS.map(|share| Tessellation::Adaptive {
            criterion: Criterion::Distance,
            threshold: share * facts.diagonal,
            most_leaves: DEFAULT_MOST_LEAVES,
        });
        let volume = |tessellation| by_map(Technique::LightVolume { tessellation, kept: None });
        all.extend(adaptive.into_iter().chain([Tessellation::IndexedGrid]).map(volume));
    }
    if closed && !facts.is_shadowed() && !textured {
        return all;
    }
    let sources = [mapped, facts.casts_rays && facts.is_shadowed()];
    for (rays, _) in [false, true].into_iter().zip(sources).filter(|(_, there)| *there) {
        let march = |samples| Technique::BruteForce { samples, lookup: Lookup::Nearest };
        all.extend(MARCH.into_iter().map(|samples| Candidate { technique: march(samples), rays, sampling }));
        if takes_hybrid(facts) {
            // the GPU marches between faces in one dispatch, which shadow rays must fit into
            let most = if rays { 200 } else { u32::MAX };
            let hybrid = |samples: u32| {
                let lit_samples = samples.div_ceil(2);
                Technique::Hybrid(Hybrid { samples, lit_samples, ..Hybrid::default() })
            };
            let few = HYBRID.into_iter().filter(|samples| *samples <= most);
            all.extend(few.map(|samples| Candidate { technique: hybrid(samples), rays, sampling }));
        }
    }
    if let Some(froxels) = froxels.filter(|_| facts.casts_rays || !facts.is_shadowed()) {
        all.push(Candidate { technique: Technique::Froxels(froxels), rays: true, sampling });
    }
    all
}

/// Whether the hybrid takes all lights in this medium.
fn takes_hybrid(facts: &Facts<'_>) -> bool {
    let medium = &facts.medium;
    let has_point = facts.lights.iter().any(|light| light.kind == LightKind::Point);
    let refused = medium.heterogeneous || medium.bounded || (medium.without_falloff && has_point);
    !refused
}
