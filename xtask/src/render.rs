//! `render`: one picture of one scene.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use gpu_backend::GpuContext;
use hybrid_march::Sampling;
use lightvolume::Criterion;
use scene::Bvh;
use serde_json::{Value, json};

use crate::airlight_gpu;
use crate::failure::{Failure, Outcome};
use crate::frame::{self, Picture};
use crate::froxels::{self, FroxelCost};
use crate::gpu;
use crate::image_file;
use crate::maps::{DEFAULT_SIDE, MapOptions, MapSurface};
use crate::metrics;
use crate::output_file;
use crate::planned::{self, Plan, Wish};
use crate::report::data::Adapter;
use crate::scene_args::{SceneArgs, Setup};
use crate::technique::{self, FroxelOptions, Options, Technique, Tessellation, VisibilitySource};

/// Longest side of a picture; units: pixels.
const MAX_SIDE: u32 = 16384;

/// Render a picture of a glTF or generated scene.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// A .glb or .gltf file, or procedural:NAME.
    #[arg(value_name = "SCENE")]
    input: String,
    /// The picture: .png, .exr or .npy (float32, height x width x 3).
    #[arg(short, long)]
    output: PathBuf,
    /// How airlight is computed; by default what the scene needs.
    #[arg(long, value_enum)]
    technique: Option<Technique>,
    /// Where it is computed.
    #[arg(long, value_enum, default_value_t)]
    backend: Backend,
    /// Part of the name of the GPU adapter to use.
    #[arg(long)]
    adapter: Option<String>,
    /// Width and height in pixels.
    #[arg(long, default_value = "512x512", allow_hyphen_values = true, value_parser = parse_size)]
    size: (u32, u32),
    /// Leave surfaces black.
    #[arg(long)]
    airlight_only: bool,
    /// Nothing casts a shadow in the medium.
    #[arg(long)]
    unshadowed: bool,
    /// What a march asks for visibility; on the CPU bvh by default.
    #[arg(long, value_enum)]
    visibility: Option<VisibilitySource>,
    /// What a shadow map's texels mean between their centres; step by default.
    #[arg(long, value_enum)]
    map_surface: Option<MapSurface>,
    /// How far a ray that hits nothing is integrated, in m; infinite by default.
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = parse_distance)]
    max_distance: Option<f64>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    quality: QualityArgs,
    /// Exposure of a PNG, in stops.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_finite)]
    exposure: f32,
    /// Also render with this technique, print how the two compare, and write an error picture beside the output.
    #[arg(long, value_enum, value_name = "TECHNIQUE")]
    against: Option<Technique>,
    /// Write what was done and what it cost as JSON.
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,
}

/// Flags that trade time for error; each says on stderr if the technique has no use for it.
#[derive(Debug, Args)]
struct QualityArgs {
    /// Steps along each ray for each light.
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    samples: Option<u32>,
    /// Side of the shadow map in texels, of each cube face for a point light; 1024 by default.
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=16384))]
    shadow_map: Option<u32>,
    /// `static`, `adaptive[:THRESHOLD]` or `delaunay[:METRES]`.
    #[arg(long, allow_hyphen_values = true, value_parser = parse_tessellation)]
    tessellation: Option<Tessellation>,
    /// Scattering is computed at this fraction of the resolution.
    #[arg(long, value_name = "1|2|4", allow_hyphen_values = true, value_parser = ["1", "2", "4"])]
    scattering_scale: Option<String>,
    /// Side of a voxel of the shared grid, in m.
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = parse_metres)]
    voxel_size: Option<f32>,
    /// Number of viewers that share a frame of froxels; the picture is the first one's.
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=256))]
    viewers: Option<u32>,
    /// Largest shadow_err that is accepted.
    #[arg(long, value_name = "E", allow_hyphen_values = true, value_parser = parse_positive)]
    target_error: Option<f64>,
}

/// `--backend`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Backend {
    /// A GPU if there is one and it has what is asked, else the CPU; `render` takes one of hardware, `repro` any.
    #[default]
    Auto,
    /// A GPU or nothing.
    Gpu,
    /// The CPU.
    Cpu,
}

impl Backend {
    /// The GPU on which the techniques run, or none for the CPU.
    ///
    /// `auto` takes one of hardware, or the one that is named, where the GPU has all that is asked of it; a software
    /// adapter is the CPU once more, and is taken only by `gpu` or by its name.
    fn choose(
        self,
        adapter: Option<&str>,
        setup: &Setup,
        technique: Option<Technique>,
    ) -> Outcome<Option<GpuContext>> {
        let gpu = match (self, adapter) {
            (Self::Cpu, None) => return Ok(None),
            (_, wanted) => gpu::open(wanted)?,
        };
        let lacks = technique.and_then(|technique| airlight_gpu::lacks(setup, technique));
        match (self, gpu, lacks) {
            (Self::Gpu, None, _) => Err(Failure::input("--backend gpu: there is no GPU adapter")),
            (Self::Gpu, _, Some(lack)) => Err(Failure::input(format!("--backend gpu: {lack}"))),
            (Self::Cpu, ..) | (Self::Auto, None, _) | (Self::Auto, _, Some(_)) => Ok(None),
            (Self::Auto, Some(gpu), None) => {
                Ok(Some(gpu).filter(|gpu| gpu::is_hardware(gpu) || adapter.is_some()))
            }
            (Self::Gpu, gpu, None) => Ok(gpu),
        }
    }
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once(['x', 'X']).ok_or("expected WxH, such as 512x512")?;
    let side = |text: &str| match text.parse::<u32>() {
        Ok(side @ 1..=MAX_SIDE) => Ok(side),
        _ => Err(format!("each side must be a whole number from 1 to {MAX_SIDE}")),
    };
    Ok((side(width)?, side(height)?))
}

fn parse_distance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 => Ok(value),
        _ => Err("must be a number above 0".into()),
    }
}

/// A finite number above 0.
fn parse_positive(text: &str) -> Result<f64, String> {
    parse_distance(text)
        .ok()
        .filter(|value| value.is_finite())
        .ok_or("must be a finite number above 0".into())
}

/// A finite length above 0, also as an `f32`.
fn parse_metres(text: &str) -> Result<f32, String> {
    let metres = parse_positive(text)? as f32;
    if metres.is_finite() && metres > 0.0 {
        Ok(metres)
    } else {
        Err("must be a number of metres that fits".into())
    }
}

fn parse_tessellation(text: &str) -> Result<Tessellation, String> {
    let (kind, parameter) =
        text.split_once(':').map_or((text, None), |(kind, parameter)| (kind, Some(parameter)));
    let metres = |parameter: &str| {
        parse_positive(parameter).ok().map(|metres| metres as f32).filter(|metres| metres.is_finite())
    };
    let criterion = Criterion::Distance;
    match (kind, parameter.map(metres)) {
        ("static", None) => Some(Tessellation::Static { indexed: true }),
        ("adaptive", None) => Some(Tessellation::Adaptive { criterion, threshold: None }),
        ("adaptive", Some(Some(metres))) => {
            Some(Tessellation::Adaptive { criterion, threshold: Some(metres) })
        }
        ("delaunay", None) => Some(Tessellation::Delaunay { bound: None }),
        ("delaunay", Some(Some(metres))) => Some(Tessellation::Delaunay { bound: Some(metres) }),
        _ => None,
    }
    .ok_or("expected static, adaptive[:THRESHOLD] or delaunay[:METRES]".into())
}

fn parse_finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("must be a finite number".into()),
    }
}

pub(crate) fn run(args: &RenderArgs) -> Outcome {
    let error_path = args.against.map(|_| args.output.with_extension("error.png"));
    check_files(args, error_path.as_deref())?;
    let setup = args.scene.resolve(&args.input)?;
    let bvh = Bvh::build(&setup.scene).map_err(|e| Failure::input(format!("{}: {e}", args.input)))?;
    if let Some(technique) = args.technique {
        technique::check(&setup, technique, "--technique")?;
    }
    if let Some(against) = args.against {
        technique::check(&setup, against, "--against")?;
    }
    // the reference may run elsewhere
    let gpu = args.backend.choose(args.adapter.as_deref(), &setup, args.technique)?;
    let plan = args.plan(&setup, &bvh, gpu.as_ref())?;
    let technique = match (&plan, args.technique) {
        (Some(plan), _) => plan.technique,
        (None, Some(technique)) => technique,
        (None, None) => Technique::Exact,
    };
    let gpu = gpu.filter(|_| plan.as_ref().is_none_or(|plan| plan.on_gpu));
    let techniques: Vec<Technique> = std::iter::once(technique).chain(args.against).collect();
    let mut options = match &plan {
        Some(plan) => plan.options,
        None => args.options(gpu.is_some(), &techniques),
    };
    if techniques.iter().any(|technique| technique.has_froxels()) {
        let range = args.range(&setup, &bvh);
        // what froxels are compared with ends where they do
        (options.froxels.range, options.max_distance) = (Some(range), range.into());
        let mut all = techniques.iter().filter(|technique| technique.has_froxels());
        all.try_for_each(|&technique| froxels::check(technique, &setup, &bvh, &options))?;
    }
    if techniques.iter().any(|&technique| frame::draws_maps(&setup, technique, &options)) {
        techniques.iter().try_for_each(|&technique| options.of(technique).map.check(&setup))?;
        if techniques.contains(&Technique::LightVolume) {
            options.tessellation.check(&setup)?;
        }
    }
    let picture = frame::render(&setup, &bvh, technique, &options, gpu.as_ref(), &technique.name())?;
    // not before: what a GPU cannot hold is refused by then, in the only line there is
    setup.say_notes();
    args.say_unused(&techniques, &options);
    if let Some(plan) = plan.as_ref().filter(|plan| plan.misses()) {
        let error = plan.predicted_error.map_or(f64::NAN, |error| error.found);
        tracing::warn!("--target-error {}: the error is more likely {error:.2e}", plan.target_error);
    }
    if let Some(range) = options.froxels.range {
        tracing::info!("airlight ends with the froxels, {range:.4} m from the camera");
    }
    let unusable = picture.image.pixels.iter().flatten().filter(|value| !value.is_finite()).count();
    if unusable > 0 {
        return Err(Failure::program(format!(
            "{}: {unusable} values of the picture are not finite: a light, a length or a coefficient is too large",
            args.input
        )));
    }
    let mut files = vec![output_file::stage(
        &args.output,
        &image_file::encode(&args.output, &picture.image, args.exposure)?,
    )?];
    let mut figures = None;
    if let (Some(against), Some(path)) = (args.against, &error_path) {
        let (found, errors) = compare(&setup, &bvh, technique, against, &options, &picture)?;
        files.push(output_file::stage(path, &errors)?);
        figures = Some(found);
    }
    if let Some(path) = &args.json {
        let ran = Ran { technique, gpu: gpu.as_ref(), options: &options, plan: plan.as_ref() };
        let text = describe(args, &ran, &setup, &bvh, &picture, figures.as_ref());
        let text = serde_json::to_string_pretty(&text).map_err(Failure::program)?;
        files.push(output_file::stage(path, format!("{text}\n").as_bytes())?);
    }
    // all of it is written: only names are left to give
    files.into_iter().try_for_each(output_file::Staged::commit)?;
    if let Some(figures) = figures {
        crate::print(&format!("{figures}\n"));
    }
    Ok(())
}

/// Every file of the command is another one, and the outputs can be written.
fn check_files(args: &RenderArgs, error_picture: Option<&Path>) -> Outcome {
    image_file::check_writable(&args.output)?;
    let mut files = vec![("the scene", Path::new(&args.input)), ("--output", &*args.output)];
    files.extend(args.scene.light_texture.as_deref().map(|path| ("--light-texture", path)));
    for (name, path) in [("--json", args.json.as_deref()), ("the error picture", error_picture)] {
        if let Some(path) = path {
            output_file::check_writable(path)?;
            files.push((name, path));
        }
    }
    output_file::check_distinct(&files)
}

/// Renders with `other`; the figures of `compare` with the time that they belong to, and the error picture's PNG.
fn compare(
    setup: &Setup,
    bvh: &Bvh,
    technique: Technique,
    other: Technique,
    options: &Options,
    picture: &Picture,
) -> Outcome<(Value, Vec<u8>)> {
    // what is judged must not judge itself: rays that the picture left out are traced here
    let full = match options.sampling {
        Sampling::Adaptive(_) => Options { sampling: Sampling::Pixels, ..*options },
        _ => *options,
    };
    let reference = frame::render(setup, bvh, other, &full, None, &format!("{} (reference)", other.name()))?;
    let open = Options { shadows_in_medium: false, ..full };
    let unshadowed = frame::render(setup, bvh, other, &open, None, "unshadowed")?;
    let figures = metrics::compare(&picture.image, &reference.image, Some(&unshadowed.image), None)?;
    let errors = image_file::error_picture(&picture.image, &reference.image)?;
    let mut figures = serde_json::to_value(figures).map_err(Failure::program)?;
    figures["technique"] = json!(technique.name());
    figures["against"] = json!(other.name());
    figures["ms"] = json!(picture.ms);
    Ok((figures, image_file::encode_png(&errors)?))
}

/// What ran, and where.
struct Ran<'a> {
    technique: Technique,
    gpu: Option<&'a GpuContext>,
    options: &'a Options,
    plan: Option<&'a Plan>,
}

fn describe(
    args: &RenderArgs,
    ran: &Ran<'_>,
    setup: &Setup,
    bvh: &Bvh,
    picture: &Picture,
    comparison: Option<&Value>,
) -> Value {
    let name = ran.technique.name();
    let passes = picture.passes(&name).into_iter();
    let options = ran.options;
    let adapter = match ran.gpu {
        Some(gpu) => gpu::describe(gpu),
        None => Adapter { name: "CPU".into(), backend: "cpu".into(), kind: "cpu".into() },
    };
    let map = picture.ms_map.map(|_| {
        json!({
            "size": options.map.side,
            "surface": options.of(ran.technique).map.surface.name(),
            "bytes": picture.map_bytes,
            "pyramid_bytes": picture.pyramid_bytes,
        })
    });
    // the same for many lights of a kind
    let mut reasons = ran.plan.map_or(Vec::new(), |plan| plan.reasons.clone());
    reasons.dedup();
    let why = if args.technique.is_some() { "asked for".to_owned() } else { reasons.join("; ") };
    json!({
        "scene": args.input,
        "size": [args.size.0, args.size.1],
        "adapter": adapter,
        "technique": name,
        "why": why,
        "plan": ran.plan.map(|plan| plan.json(picture.ms)),
        "passes": passes.map(|(name, ms)| json!({"name": name, "ms": ms})).collect::<Vec<_>>(),
        // the technique's own; view rays, shadow map and surfaces belong to a frame without fog too
        "ms": picture.ms,
        "ms_view_rays": picture.ms_view_rays,
        "ms_map": picture.ms_map,
        "ms_frame": picture.ms_frame(),
        // a time stands beside its error: null says that it was not measured (--against measures it)
        "error": comparison,
        "triangles": setup.scene.triangle_count(),
        "lights": setup.lights.len(),
        "samples": picture.samples,
        "rays": picture.rays,
        "mesh_triangles": picture.mesh_triangles,
        "shadow_map": map,
        "froxels": picture.froxels.map(|cost| froxels_json(&cost)),
        "bytes": bvh.bytes() + picture.bytes(),
    })
}

/// What froxels cost, all viewers together.
fn froxels_json(cost: &FroxelCost) -> Value {
    let FroxelCost { froxels, viewers, counts, bytes } = cost;
    json!({
        "viewers": viewers,
        "range": froxels.range,
        "voxel_size": froxels.grid().map(|grid| grid.voxel_size),
        "froxels": counts.froxels,
        "rays_near": counts.near_rays,
        "rays_grid": counts.grid_rays,
        "voxels": counts.voxels,
        "bricks": counts.bricks,
        "missed": counts.missed,
        "dropped": counts.dropped,
        "not_finite": counts.not_finite,
        "bytes": bytes,
    })
}

impl RenderArgs {
    /// What the flags say of the picture, with the defaults of those that were not given.
    fn options(&self, on_gpu: bool, techniques: &[Technique]) -> Options {
        // what a light volume is compared with is to mean the same
        let enclosed = techniques.contains(&Technique::LightVolume);
        let defaults = Options::new(self.size);
        Options {
            airlight_only: self.airlight_only,
            shadows_in_medium: !self.unshadowed,
            max_distance: self.max_distance.unwrap_or(defaults.max_distance),
            samples: self.quality.samples,
            // clap allows 1, 2 and 4 alone
            sampling: Sampling::blocks(
                self.quality.scattering_scale.as_deref().and_then(|s| s.parse().ok()).unwrap_or(1),
            ),
            visibility: self.visibility.unwrap_or(if on_gpu {
                VisibilitySource::Map
            } else {
                defaults.visibility
            }),
            tessellation: self.quality.tessellation.unwrap_or_default(),
            froxels: FroxelOptions {
                voxel_size: self.quality.voxel_size,
                viewers: self.quality.viewers.unwrap_or(1),
                ..defaults.froxels
            },
            map: MapOptions {
                side: self.quality.shadow_map.unwrap_or(DEFAULT_SIDE),
                surface: self.map_surface.unwrap_or(if enclosed {
                    MapSurface::Linear
                } else {
                    MapSurface::Step
                }),
            },
            ..defaults
        }
    }

    /// What is rendered, where that is not all said by flags: which technique, or how it gets within the target error.
    fn plan(&self, setup: &Setup, bvh: &Bvh, gpu: Option<&GpuContext>) -> Outcome<Option<Plan>> {
        let quality = &self.quality;
        let plannable = |technique: Technique| !technique.has_froxels() && technique != Technique::Exact;
        let wanted = match self.technique {
            Some(technique) => plannable(technique) && quality.target_error.is_some(),
            None => true,
        };
        if !wanted {
            return Ok(None);
        }
        let wish = Wish {
            technique: self.technique,
            target_error: quality.target_error,
            samples: quality.samples,
            map_side: quality.shadow_map,
            surface: self.map_surface,
            visibility: self.visibility,
            tessellated: quality.tessellation.is_some(),
            on_map: false,
        };
        let techniques: Vec<Technique> = self.technique.iter().chain(&self.against).copied().collect();
        let mut options = self.options(gpu.is_some(), &techniques);
        if techniques.iter().any(|technique| technique.has_froxels()) {
            let range = self.range(setup, bvh);
            (options.froxels.range, options.max_distance) = (Some(range), range.into());
        }
        // the error that is asked for is that of the fog
        options.surfaces_on_cpu = true;
        let plan = planned::plan(setup, bvh, &options, &wish, gpu)?;
        Ok(Some(plan))
    }

    /// Where froxels end; units: m.
    fn range(&self, setup: &Setup, bvh: &Bvh) -> f32 {
        let given = self.max_distance.map(|metres| metres as f32);
        given
            .filter(|metres| metres.is_finite() && *metres > 0.0)
            .unwrap_or_else(|| froxels::range(setup, bvh))
    }

    /// Says which of the given flags none of the techniques that run has a use for.
    fn say_unused(&self, techniques: &[Technique], options: &Options) {
        let quality = &self.quality;
        let given = [
            ("--visibility", self.visibility.is_some()),
            ("--map-surface", self.map_surface.is_some()),
            ("--samples", quality.samples.is_some()),
            ("--shadow-map", quality.shadow_map.is_some()),
            ("--tessellation", quality.tessellation.is_some()),
            ("--scattering-scale", quality.scattering_scale.is_some()),
            ("--voxel-size", quality.voxel_size.is_some()),
            ("--viewers", quality.viewers.is_some()),
            ("--target-error", quality.target_error.is_some()),
        ];
        let visibility = options.visibility;
        let names: Vec<String> = techniques.iter().map(|technique| technique.name()).collect();
        for (flag, given) in given {
            if given && !techniques.iter().any(|technique| technique.uses(flag, visibility)) {
                tracing::warn!("{flag}: no use for it in {}", names.join(" and "));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_parse() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        for bad in ["0x0", "512", "1x0", "-1x4", "99999x2", "4294967297x1", "x", "axb", "1e3x2"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn distances_parse() {
        assert_eq!(parse_distance("inf"), Ok(f64::INFINITY));
        for bad in ["0", "-1", "nan", "m"] {
            assert!(parse_distance(bad).is_err(), "{bad}");
        }
        assert!(parse_positive("inf").is_err() && parse_positive("0.5").is_ok());
    }

    #[test]
    fn tessellations_parse() {
        for good in ["static", "adaptive", "adaptive:0.02", "delaunay:1e-3"] {
            assert!(parse_tessellation(good).is_ok(), "{good}");
        }
        for bad in ["", "bogus", "static:1", "adaptive:", "delaunay:-1", "adaptive:inf"] {
            assert!(parse_tessellation(bad).is_err(), "{bad}");
        }
    }
}
