//! Which dispatches a frame needs: nothing here touches a GPU.
//!
//! A scene pays for what it has. A light that nothing shadows is one closed-form evaluation a pixel; a medium whose
//! channels are attenuated alike is integrated once; what has no texture, bounds or density has no code for them, since
//! every pipeline is specialised by constants.

use scene::{AirlightModel, Density, Light, Medium, Refusal};
use shadowmap::Outside;

use super::frame::{AirlightForm, Frame, Hybrid, Lamp, Lookup, Placement, Sampling, Technique};
use crate::lightvolume::{USUALLY_KEPT, VolumeVariant};
use crate::{Faces, Tessellation};

/// Steps of a march, times what each loops over, in one dispatch: some drivers cut loops silently at 65,535 trips of a
/// group of threads.
const MOST_TRIPS: u32 = 30_000;

/// Loop trips of a shadow ray, at most, in all scenes that were tried (`shaders/shared/bvh.wgsl`).
const TRIPS_OF_A_RAY: u32 = 110;

/// Shadow rays along a view ray in one dispatch, at most.
const MOST_RAYS: u32 = MOST_TRIPS / TRIPS_OF_A_RAY;

/// Most steps of a hybrid march's segment: few are its point, and it comes in one dispatch.
const MOST_HYBRID_SAMPLES: u32 = 8192;

/// A scattering shader with its constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    pub(crate) shader: Shader,
    /// 0 point, 1 spot, 2 directional, 3 the medium's own glow.
    pub(crate) light: u8,
    pub(crate) textured: bool,
    pub(crate) shadowed: bool,
    /// Whether shadow rays are cast.
    pub(crate) rays: bool,
    pub(crate) linear: bool,
    /// 0 nearest, 1 percentage-closer, 2 variance, 3 linear surface.
    pub(crate) lookup: u8,
    pub(crate) achromatic: bool,
    pub(crate) isotropic: bool,
    pub(crate) bounded: bool,
    /// 0 none, 1 height, 2 grid.
    pub(crate) density: u8,
    pub(crate) hoffman_preetham: bool,
    /// Whether steps are of equal length instead of equal angle.
    pub(crate) equal_distance: bool,
    /// Whether the picture's mean over a step is read.
    pub(crate) mips: bool,
    /// Whether visibility is asked outside of the faces too.
    pub(crate) partial: bool,
    /// 0 none, 1 a table as printed, 2 one over angles.
    pub(crate) table: u8,
    /// Whether sums are in fixed point.
    pub(crate) fixed: bool,
    /// Whether pixels come from a list instead of all.
    pub(crate) listed: bool,
}

/// Which scattering shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Shader {
    Exact,
    March,
    MarchVarying,
    Hybrid,
    HybridTextured,
    /// Closes the sums of a light volume's crossings.
    LightVolume,
    /// Fills the table of a hybrid march.
    FrameTable,
}

impl Variant {
    /// The pass that fills the table that this one reads.
    pub(crate) fn of_table(self) -> Self {
        Self { shader: Shader::FrameTable, light: 0, textured: false, shadowed: false, rays: false, ..self }
    }

    /// The pass that gives the airlight of the same light without shadows.
    pub(crate) fn unshadowed(self) -> Self {
        Self { shader: Shader::Exact, shadowed: false, linear: false, fixed: false, ..self }
    }

    /// The pass over the pixels of a list.
    pub(crate) fn of_list(self) -> Self {
        Self { listed: true, ..self }
    }

    /// The pass over the pixels of a list that gives the airlight as if nothing cast a shadow: in closed form where there is
    /// one.
    pub(crate) fn unlit_list(self) -> Self {
        let open = Self { shadowed: false, rays: false, lookup: 0, partial: false, listed: true, ..self };
        match self.shader {
            Shader::MarchVarying | Shader::HybridTextured => open,
            _ => Self { shader: Shader::Exact, linear: false, table: 0, equal_distance: false, ..open },
        }
    }

    /// The shader's file.
    pub(crate) const fn file(&self) -> &'static str {
        match (self.shader, self.rays) {
            (Shader::FrameTable, _) => "scatter/frame_table",
            (Shader::Exact, _) => "scatter/exact",
            (Shader::LightVolume, _) => "scatter/light_volume",
            (Shader::March, false) => "scatter/march",
            (Shader::March, true) => "scatter/march_rays",
            (Shader::MarchVarying, false) => "scatter/march_varying",
            (Shader::MarchVarying, true) => "scatter/march_varying_rays",
            (Shader::Hybrid, false) => "scatter/hybrid",
            (Shader::Hybrid, true) => "scatter/hybrid_rays",
            (Shader::HybridTextured, false) => "scatter/hybrid_textured",
            (Shader::HybridTextured, true) => "scatter/hybrid_textured_rays",
        }
    }

    /// The shader's override constants.
    pub(crate) fn constants(&self) -> Vec<(&'static str, f64)> {
        let flag = |value: bool| f64::from(u8::from(value));
        let mut constants = vec![
            ("LIGHT", f64::from(self.light)),
            ("TEXTURED", flag(self.textured)),
            ("SHADOWED", flag(self.shadowed)),
            ("LINEAR", flag(self.linear)),
            ("LOOKUP", f64::from(self.lookup)),
            ("ACHROMATIC", flag(self.achromatic)),
            ("ISOTROPIC", flag(self.isotropic)),
        ];
        if self.shader == Shader::MarchVarying {
            constants.extend([
                ("BOUNDED", flag(self.bounded)),
                ("DENSITY", f64::from(self.density)),
                ("HOFFMAN_PREETHAM", flag(self.hoffman_preetham)),
            ]);
        }
        if self.shader == Shader::LightVolume {
            constants.retain(|(name, _)| *name != "SHADOWED" && *name != "LINEAR" && *name != "LOOKUP");
            constants.push(("FIXED", flag(self.fixed)));
        }
        if matches!(self.shader, Shader::Hybrid | Shader::HybridTextured | Shader::FrameTable) {
            constants.push(("TABLE", f64::from(self.table)));
        }
        if matches!(self.shader, Shader::Hybrid | Shader::HybridTextured) {
            constants.push(("EQUAL_DISTANCE", flag(self.equal_distance)));
        }
        if self.shader == Shader::Hybrid && self.rays {
            constants.push(("MOST_LOOKUPS", f64::from(MOST_RAYS)));
        }
        if self.shader == Shader::HybridTextured {
            constants.extend([
                ("HOFFMAN_PREETHAM", flag(self.hoffman_preetham)),
                ("MIPS", flag(self.mips)),
                ("PARTIAL", flag(self.partial)),
            ]);
        }
        constants
    }
}

/// What one light, or the medium's glow, costs each view.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Work {
    pub(crate) variant: Variant,
    /// The light, by its index; `None` for the medium's own glow.
    pub(crate) lamp: Option<usize>,
    pub(crate) label: String,
    /// Steps of the whole march along a ray; 0 without one.
    pub(crate) samples: u32,
    /// First step and the one after the last, for each dispatch.
    pub(crate) parts: Vec<(u32, u32)>,
    /// Width of a filter kernel; units: texels.
    pub(crate) kernel: u32,
    /// For which pixels the faces of the light's shadow volume are found, where they are.
    pub(crate) faces: Option<Faces>,
    /// Bisections of each boundary that a march has found.
    pub(crate) refine: u32,
    /// Steps of each lit segment beside the faces.
    pub(crate) lit_samples: u32,
    /// Entries along the side of the frame's table, where there is one.
    pub(crate) table_size: u32,
    /// How the light's volume is tessellated, where one is drawn.
    pub(crate) tessellation: Option<Tessellation>,
    /// Crossings of each pixel with that volume that are kept.
    pub(crate) kept: u32,
}

impl Work {
    /// What the draws of the light's volume are specialised by.
    pub(crate) fn volume_variant(&self) -> VolumeVariant {
        let Variant { light, achromatic, isotropic, .. } = self.variant;
        VolumeVariant { light, achromatic, isotropic }
    }
}

/// The work of a frame, light by light.
///
/// # Errors
/// [`Refusal`] if the technique cannot take the medium or a light.
pub(crate) fn plan(frame: &Frame<'_>) -> Result<Vec<Work>, Refusal> {
    if let (Technique::LightVolume { .. }, Sampling::Adaptive(_)) = (frame.technique, frame.sampling) {
        // its rays are drawn all at once
        return Err(Refusal {
            technique: "light-volume",
            feature: "adaptive sampling",
            instead: "blocks of pixels",
        });
    }
    let mut work = Vec::new();
    if frame.medium.emission != [0.0; 3] {
        match frame.technique {
            Technique::ExactShadowMap { .. } => {
                return Err(refused("an emitting medium"));
            }
            Technique::Hybrid(_) => return Err(refused_by_hybrid("an emitting medium")),
            Technique::LightVolume { .. } => return Err(refused_by_volume("an emitting medium")),
            Technique::Froxels(_) => return Err(UNPLANNED),
            Technique::BruteForce { samples, .. } => {
                let variant = Variant { light: 3, ..variant(frame, Shader::MarchVarying) };
                work.push(march(variant, None, "glow".into(), samples, 0, 0));
            }
        }
    }
    if frame.medium.coefficients.is_clear() {
        return Ok(work);
    }
    for (index, lamp) in frame.lamps.iter().enumerate() {
        work.push(of_lamp(frame, index, lamp)?);
    }
    Ok(work)
}

fn refused(feature: &'static str) -> Refusal {
    Refusal { technique: "exact-shadow-map on the GPU", feature, instead: "brute-force, or the CPU" }
}

fn refused_by_hybrid(feature: &'static str) -> Refusal {
    Refusal { technique: "hybrid", feature, instead: "brute-force" }
}

/// Froxels are lit by all lights at once, and their frames are made in `froxel/frame.rs`.
const UNPLANNED: Refusal =
    Refusal { technique: "froxels", feature: "a pass for each light", instead: "Fog::prepare" };

fn refused_by_volume(feature: &'static str) -> Refusal {
    Refusal { technique: "light-volume", feature, instead: "brute-force" }
}

/// What all lights of a frame have in common.
fn variant(frame: &Frame<'_>, shader: Shader) -> Variant {
    let sigma_t = frame.medium.coefficients.sigma_t();
    Variant {
        shader,
        light: 0,
        textured: false,
        shadowed: false,
        rays: false,
        linear: false,
        lookup: 0,
        achromatic: sigma_t[0] == sigma_t[1] && sigma_t[1] == sigma_t[2],
        isotropic: frame.medium.phase.is_isotropic(),
        bounded: frame.medium.bounds.is_some() && shader == Shader::MarchVarying,
        density: match (&frame.medium.density, shader) {
            (Some(Density::Height { .. }), Shader::MarchVarying) => 1,
            (Some(Density::Grid(_)), Shader::MarchVarying) => 2,
            _ => 0,
        },
        hoffman_preetham: matches!(shader, Shader::MarchVarying | Shader::HybridTextured)
            && frame.model == AirlightModel::HoffmanPreetham,
        equal_distance: false,
        mips: false,
        partial: false,
        table: 0,
        fixed: false,
        listed: false,
    }
}

/// Whether a light has no closed form between boundaries.
fn varies(frame: &Frame<'_>, light: &Light) -> bool {
    let local_model = frame.model == AirlightModel::HoffmanPreetham;
    let Medium { bounds, .. } = frame.medium;
    !frame.medium.is_homogeneous()
        || bounds.is_some()
        || match light {
            Light::Point(_) => local_model,
            Light::Spot(spot) => local_model || spot.texture.is_some(),
            Light::Directional(_) => false,
        }
}

fn of_lamp(frame: &Frame<'_>, index: usize, lamp: &Lamp<'_>) -> Result<Work, Refusal> {
    let (light, kind, textured) = match lamp.light {
        Light::Point(_) => (0, "point light", false),
        Light::Spot(spot) => (1, "spot light", spot.texture.is_some()),
        Light::Directional(_) => (2, "directional light", false),
    };
    let shadowed = lamp.shadows.is_some();
    let rays = lamp.shadows.is_some_and(|shadows| shadows.bvh().is_some());
    let with = |shader: Shader| Variant { light, textured, shadowed, rays, ..variant(frame, shader) };
    let label = |how: &str| format!("{kind} {index}, {how}");
    let exact = |linear: bool| {
        let how = if shadowed { "exact" } else { "closed form" };
        Work {
            variant: Variant { linear: linear && shadowed, ..with(Shader::Exact) },
            lamp: Some(index),
            label: label(how),
            samples: 0,
            parts: vec![(0, 0)],
            kernel: 0,
            faces: None,
            refine: 0,
            lit_samples: 0,
            table_size: 0,
            tessellation: None,
            kept: 0,
        }
    };
    match frame.technique {
        Technique::ExactShadowMap { surface } => {
            if frame.medium.density.is_some() {
                return Err(refused("a heterogeneous density"));
            }
            if frame.medium.bounds.is_some() {
                return Err(refused("a bounded medium"));
            }
            if rays {
                return Err(refused("shadow rays"));
            }
            if frame.model == AirlightModel::HoffmanPreetham && !matches!(lamp.light, Light::Directional(_)) {
                return Err(refused("Hoffman and Preetham's model for a local light"));
            }
            Ok(exact(surface == shadowmap::MapSurface::Linear))
        }
        Technique::Froxels(_) => Err(UNPLANNED),
        Technique::LightVolume { tessellation, kept } => {
            check_light_volume(frame, lamp)?;
            if !shadowed {
                return Ok(exact(false));
            }
            let (label, kept) = (label("light volume"), kept.unwrap_or(USUALLY_KEPT));
            let work = Work { tessellation: Some(tessellation), kept, label, ..exact(false) };
            Ok(Work { variant: with(Shader::LightVolume), ..work })
        }
        Technique::Hybrid(hybrid) => {
            check_hybrid(frame, lamp.light, &hybrid)?;
            // it comes in one dispatch
            if rays && hybrid.samples > MOST_RAYS - 3 {
                return Err(refused_by_hybrid("so many samples with shadow rays"));
            }
            let textured = varies(frame, lamp.light) || (shadowed && hybrid.partial);
            if !textured && !shadowed {
                return Ok(exact(false));
            }
            let (lookup, kernel) = if rays || !shadowed { (0, 0) } else { lookup_code(hybrid.lookup) };
            let shader = if textured { Shader::HybridTextured } else { Shader::Hybrid };
            let (table, table_size) = table_of(frame, lamp.light, &hybrid, textured);
            let variant = Variant {
                lookup,
                equal_distance: hybrid.placement == Placement::EqualDistance,
                mips: textured && hybrid.picture.blur().is_some(),
                partial: textured && hybrid.partial,
                table,
                ..with(shader)
            };
            Ok(Work {
                variant,
                lamp: Some(index),
                label: label("hybrid"),
                samples: hybrid.samples,
                parts: vec![(0, hybrid.samples)],
                kernel,
                faces: shadowed.then_some(hybrid.faces),
                refine: hybrid.refine,
                lit_samples: if textured { hybrid.lit_samples } else { 0 },
                table_size,
                tessellation: None,
                kept: 0,
            })
        }
        Technique::BruteForce { samples, lookup } => {
            if !varies(frame, lamp.light) && !shadowed {
                return Ok(exact(false));
            }
            let (lookup, kernel) = lookup_code(lookup);
            let shader = if varies(frame, lamp.light) { Shader::MarchVarying } else { Shader::March };
            let lookup = if shadowed && !rays { lookup } else { 0 };
            let variant = Variant { lookup, ..with(shader) };
            let mut inner = match (shadowed, rays) {
                (false, _) => 0,
                (true, false) => (kernel + 1).pow(2),
                (true, true) => TRIPS_OF_A_RAY,
            };
            if let (Some(Density::Grid(grid)), Shader::MarchVarying) = (&frame.medium.density, shader) {
                // the light's way through the grid, four steps to a cell
                inner += 4 * grid.size.iter().sum::<u32>();
            }
            Ok(march(variant, Some(index), label("march"), samples, kernel, inner))
        }
    }
}

/// What a light volume cannot take.
fn check_light_volume(frame: &Frame<'_>, lamp: &Lamp<'_>) -> Result<(), Refusal> {
    if frame.medium.density.is_some() {
        return Err(refused_by_volume("a heterogeneous density"));
    }
    if frame.medium.bounds.is_some() {
        return Err(refused_by_volume("a bounded medium"));
    }
    if frame.model == AirlightModel::HoffmanPreetham && !matches!(lamp.light, Light::Directional(_)) {
        return Err(refused_by_volume("Hoffman and Preetham's model for a local light"));
    }
    if matches!(lamp.light, Light::Spot(spot) if spot.texture.is_some()) {
        return Err(refused_by_volume("a textured spot light"));
    }
    let Some(shadows) = lamp.shadows else { return Ok(()) };
    let Some(map) = shadows.map() else {
        return Err(refused_by_volume("shadow rays"));
    };
    let own = match lamp.light {
        Light::Spot(_) => Outside::Dark,
        Light::Point(_) | Light::Directional(_) => Outside::Lit,
    };
    if map.outside() != own {
        return Err(refused_by_volume("another answer for what a map does not see than its light's own"));
    }
    Ok(())
}

/// What the hybrid march cannot take.
fn check_hybrid(frame: &Frame<'_>, light: &Light, hybrid: &Hybrid) -> Result<(), Refusal> {
    if frame.medium.density.is_some() {
        return Err(refused_by_hybrid("a heterogeneous density"));
    }
    if frame.medium.bounds.is_some() {
        return Err(refused_by_hybrid("a bounded medium"));
    }
    if frame.model == AirlightModel::HoffmanPreetham && matches!(light, Light::Point(_)) {
        return Err(refused_by_hybrid("Hoffman and Preetham's model for a point light"));
    }
    if hybrid.partial && !matches!(light, Light::Spot(_)) {
        return Err(refused_by_hybrid("the shadow volume of a part of the casters, but for a spot"));
    }
    if let AirlightForm::FrameTable { size } | AirlightForm::AngleTable { size } = hybrid.form
        && !(2..=2048).contains(&size)
    {
        return Err(refused_by_hybrid("a table of that size"));
    }
    // its march is one dispatch
    if hybrid.samples.max(hybrid.lit_samples) > MOST_HYBRID_SAMPLES {
        return Err(refused_by_hybrid("more than 8192 samples"));
    }
    Ok(())
}

/// The kind of table that a light's hybrid march reads, and its size; none where it has no use for one.
fn table_of(frame: &Frame<'_>, light: &Light, hybrid: &Hybrid, textured: bool) -> (u8, u32) {
    let sun = frame.model == AirlightModel::Sun && frame.medium.phase.is_isotropic();
    let takes = match light {
        Light::Point(_) => sun,
        Light::Spot(_) => sun && textured,
        Light::Directional(_) => false,
    };
    match hybrid.form {
        AirlightForm::FrameTable { size } if takes => (1, size),
        AirlightForm::AngleTable { size } if takes => (2, size),
        _ => (0, 0),
    }
}

/// The number by which shaders know a lookup, and the width of its kernel.
fn lookup_code(lookup: Lookup) -> (u8, u32) {
    match lookup {
        Lookup::Nearest => (0, 0),
        Lookup::PercentageCloser { width } => (1, width),
        Lookup::Variance => (2, 0),
        Lookup::LinearSurface => (3, 0),
    }
}

/// A march in as many dispatches as its loops need, `inner` trips for each step.
fn march(
    variant: Variant,
    lamp: Option<usize>,
    label: String,
    samples: u32,
    kernel: u32,
    inner: u32,
) -> Work {
    let most = (MOST_TRIPS / inner.saturating_add(1)).clamp(1, 8192);
    let parts = (0..samples.max(1).div_ceil(most)).map(|i| (i * most, ((i + 1) * most).min(samples)));
    Work {
        variant,
        lamp,
        label,
        samples,
        parts: parts.collect(),
        kernel,
        faces: None,
        refine: 0,
        lit_samples: 0,
        table_size: 0,
        tessellation: None,
        kept: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SceneDepth, View};
    use glam::Vec3;
    use scene::{Camera, PointLight};
    use shadowmap::MapSurface;

    fn of(medium: &Medium, lights: &[Light], technique: Technique) -> Result<Vec<Work>, Refusal> {
        let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.8).unwrap();
        let view =
            View { camera: &camera, size: (4, 4), depth: SceneDepth::Nothing, max_distance: f64::INFINITY };
        let lamps: Vec<Lamp<'_>> =
            lights.iter().map(|light| Lamp { light, shadows: None, volume: None }).collect();
        plan(&Frame {
            views: &[view],
            medium,
            lamps: &lamps,
            model: AirlightModel::Sun,
            technique,
            sampling: Sampling::Pixels,
        })
    }

    fn lamp() -> [Light; 1] {
        [Light::Point(PointLight::new(Vec3::ONE, Vec3::ONE).unwrap())]
    }

    #[test]
    fn a_light_without_shadows_is_a_closed_form() {
        let medium = Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap();
        let march = Technique::BruteForce { samples: 100, lookup: Lookup::Nearest };
        for technique in [march, Technique::ExactShadowMap { surface: MapSurface::Step }] {
            let work = of(&medium, &lamp(), technique).unwrap();
            assert_eq!((work.len(), work[0].variant.shader, work[0].samples), (1, Shader::Exact, 0));
            assert!(work[0].variant.achromatic && work[0].variant.isotropic && !work[0].variant.shadowed);
        }
        assert!(of(&Medium::homogeneous([0.0; 3], [0.0; 3]).unwrap(), &lamp(), march).unwrap().is_empty());
    }

    #[test]
    fn long_marches_come_in_parts() {
        let grey = Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap();
        let fog = Medium { density: Some(Density::height(0.0, 1.0).unwrap()), ..grey };
        let march = |samples| Technique::BruteForce { samples, lookup: Lookup::Nearest };
        let parts = |samples| of(&fog, &lamp(), march(samples)).unwrap()[0].parts.clone();
        assert_eq!(parts(100), [(0, 100)]);
        assert_eq!(parts(8193), [(0, 8192), (8192, 8193)]);
        assert!(of(&fog, &lamp(), Technique::ExactShadowMap { surface: MapSurface::Step }).is_err());
    }
}
