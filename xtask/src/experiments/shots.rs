//! Pictures of one set-up by settings that take turns: each with its time, its lookups and its errors.

use scene::Bvh;
use serde_json::json;

use super::Context;
use super::equal_error::{interpolate, median};
use crate::airlight::{Airlight, Stage};
use crate::airlight_gpu::GpuFrame;
use crate::failure::Outcome;
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::maps::Maps;
use crate::metrics::{self, Metrics};
use crate::report::data::Row;
use crate::report::{Cost, Panel, PanelKind};
use crate::scene_args::Setup;
use crate::technique::{Options, Technique};
use crate::view_rays::ViewRays;

/// Frames after which a median counts for a ratio.
const WARM_FRAMES: usize = 5;

/// Lookups are counted on pictures with so many times fewer pixels a side.
const COUNTED: u32 = 4;

/// What is rendered, and the map whose exact picture the errors on the map refer to.
pub(super) struct Subject<'a> {
    pub(super) title: &'a str,
    pub(super) setup: &'a Setup,
    pub(super) bvh: &'a Bvh,
    pub(super) side: u32,
    pub(super) maps: &'a Maps,
}

/// A technique with its options and the maps that it reads.
pub(super) struct Setting<'a> {
    pub(super) name: String,
    pub(super) technique: Technique,
    pub(super) options: Options,
    pub(super) maps: &'a Maps,
}

/// One setting's airlight, and what it cost.
pub(super) struct Shot {
    pub(super) name: String,
    pub(super) technique: Technique,
    pub(super) options: Options,
    pub(super) image: Image,
    /// Sorted; units: ms.
    pub(super) times: Vec<f64>,
    /// Times that visibility was asked, bisections included, by pixel.
    pub(super) lookups: f64,
    /// Silhouette edges, where they were found on the GPU.
    pub(super) edges: Option<u64>,
    /// Against the exact picture of the same map.
    pub(super) on_map: Metrics,
    /// Against the exact picture of the geometry.
    pub(super) on_geometry: Metrics,
}

/// All settings of a subject, and their references.
pub(super) struct Shots {
    pub(super) shots: Vec<Shot>,
    pub(super) exact: Image,
    /// Time of the exact picture on the CPU; units: ms.
    pub(super) exact_ms: f64,
    pub(super) exact_on_map: Image,
    pub(super) unshadowed: Image,
}

impl Shot {
    /// Median; units: ms.
    pub(super) fn ms(&self) -> f64 {
        median(&self.times).unwrap_or(f64::NAN)
    }

    /// Share of what shadows change, against the exact picture of the same map.
    pub(super) fn map_error(&self) -> f64 {
        self.on_map.shadow_err.unwrap_or(f64::NAN)
    }

    /// The same against the exact picture of the geometry.
    pub(super) fn geometry_error(&self) -> f64 {
        self.on_geometry.shadow_err.unwrap_or(f64::NAN)
    }

    /// Its line among the measurements.
    pub(super) fn row(&self, subject: &Subject<'_>) -> Row {
        let mut row = Row::new(subject.title, &self.name);
        row.triangles = Some(subject.setup.scene.triangle_count() as u64);
        row.ms_scatter = Some(self.ms());
        row.ms_frame = Some(self.ms());
        row.ms_min = self.times.first().copied();
        row.ms_max = self.times.last().copied();
        row.frames = Some(self.times.len() as u32);
        row.set_errors(&self.on_geometry);
        row.shadow_err_map = self.on_map.shadow_err;
        row.map_surface = Some("step".into());
        row.params.insert("map".into(), json!(self.options.map.side));
        row.params.insert("lookups a pixel".into(), json!((10.0 * self.lookups).round() / 10.0));
        if let Some(edges) = self.edges {
            row.params.insert("silhouette edges".into(), json!(edges));
        }
        if let Some(samples) = self.options.samples {
            row.params.insert("samples".into(), json!(samples));
        }
        let pixels = f64::from(subject.side) * f64::from(subject.side);
        row.samples = Some((self.lookups * pixels) as u64);
        row.memory_bytes = Some(subject.maps.bytes() as u64);
        row
    }

    /// The picture with its cost; surfaces or none as `image` shows them, errors as `metrics` has them.
    pub(super) fn panel(
        &self,
        id: &str,
        alt: &str,
        image: &Image,
        scale: f32,
        metrics: &Metrics,
    ) -> Outcome<Panel> {
        Panel::new(
            format!("{id}-{}.png", slug(&self.name)),
            self.name.clone(),
            format!("{alt} by {}", self.name),
            &to_srgb8(image, scale),
            PanelKind::Measured(Cost::new(self.ms(), metrics)),
        )
    }

    /// Where it is off.
    pub(super) fn error_panel(&self, id: &str, image: &Image, reference: &Image) -> Outcome<Panel> {
        Panel::new(
            format!("{id}-{}-error.png", slug(&self.name)),
            format!("error of {}", self.name),
            format!("Error of {} against the exact picture, pixel by pixel", self.name),
            &error_picture(image, reference)?,
            PanelKind::ErrorMap,
        )
    }
}

impl Shots {
    /// The shot of that name.
    pub(super) fn of(&self, name: &str) -> Option<&Shot> {
        self.shots.iter().find(|shot| shot.name == name)
    }

    /// At which `x` the shots whose names start with `family`, in their order, reach an error on the map.
    pub(super) fn at_error(&self, family: &str, target: f64, x: impl Fn(&Shot) -> f64) -> Option<f64> {
        let shots = self.shots.iter().filter(|shot| shot.name.starts_with(family));
        interpolate(shots.map(|shot| (x(shot), shot.map_error())), target)
    }
}

/// Renders all settings in turns and compares them with their references, which are computed on the CPU in f64.
pub(super) fn take(
    context: &Context,
    subject: &Subject<'_>,
    base: &Options,
    settings: &[Setting<'_>],
) -> Outcome<Shots> {
    let Subject { setup, bvh, side, maps, .. } = *subject;
    let tick = |_: u64| ();
    let rays = ViewRays::trace(&setup.camera, bvh, (side, side));
    let none = Maps::none(setup.lights.len());
    let open = Options { shadows_in_medium: false, ..*base };
    let stage = Stage { setup, bvh, options: base, rays: &rays, maps, tick: &tick };
    let unshadowed = Stage { options: &open, maps: &none, ..stage_copy(&stage) };
    let unshadowed = image(side, narrow(&unshadowed.run(Technique::Exact)?));
    let exact_on_map = image(side, narrow(&stage.run(Technique::ExactShadowMap)?));
    let exact = stage.run(Technique::Exact)?;
    let (exact_ms, exact) = (exact.ms, image(side, narrow(&exact)));

    let stages: Vec<Stage<'_>> = settings
        .iter()
        .map(|setting| Stage { options: &setting.options, maps: setting.maps, ..stage_copy(&stage) })
        .collect();
    let (mut shots, mut frames) = (Vec::new(), Vec::new());
    for (setting, stage) in settings.iter().zip(&stages) {
        let technique = setting.technique;
        let mut edges = None;
        let (pixels, lookups) = match &context.gpu {
            Some(gpu) => {
                let mut frame = GpuFrame::new(gpu, stage, technique)?;
                frame.render(true)?;
                if technique == Technique::Hybrid {
                    edges = Some(frame.silhouette_edges()?);
                }
                let pixels = frame.read()?;
                frames.push(Some(frame));
                (pixels, count_lookups(setup, bvh, setting, side)?)
            }
            None => {
                let airlight = stage.run(technique)?;
                frames.push(None);
                (narrow(&airlight), airlight.rays as f64 / f64::from(side * side))
            }
        };
        let image = image(side, pixels);
        shots.push(Shot {
            name: setting.name.clone(),
            technique,
            options: setting.options,
            on_map: metrics::compare(&image, &exact_on_map, Some(&unshadowed), None)?,
            on_geometry: metrics::compare(&image, &exact, Some(&unshadowed), None)?,
            image,
            times: Vec::new(),
            lookups,
            edges,
        });
    }
    // the first frame of each was its warm-up
    for _ in 0..WARM_FRAMES {
        for ((shot, frame), stage) in shots.iter_mut().zip(&mut frames).zip(&stages) {
            shot.times.push(match frame {
                Some(frame) => frame.render(true)?.ms,
                None => stage.run(shot.technique)?.ms,
            });
        }
    }
    shots.iter_mut().for_each(|shot| shot.times.sort_by(f64::total_cmp));
    Ok(Shots { shots, exact, exact_ms, exact_on_map, unshadowed })
}

fn stage_copy<'a>(stage: &Stage<'a>) -> Stage<'a> {
    let Stage { setup, bvh, options, rays, maps, tick } = *stage;
    Stage { setup, bvh, options, rays, maps, tick }
}

/// Lookups by pixel, counted by the CPU on a smaller picture.
fn count_lookups(setup: &Setup, bvh: &Bvh, setting: &Setting<'_>, side: u32) -> Outcome<f64> {
    if setting.technique == Technique::ExactShadowMap {
        return Ok(0.0);
    }
    let small = side.div_ceil(COUNTED).max(16);
    let options = Options { size: (small, small), ..setting.options };
    let rays = ViewRays::trace(&setup.camera, bvh, options.size);
    let stage = Stage { setup, bvh, options: &options, rays: &rays, maps: setting.maps, tick: &|_| () };
    Ok(stage.run(setting.technique)?.rays as f64 / f64::from(small * small))
}

/// A square picture.
pub(super) fn image(side: u32, pixels: Vec<[f32; 3]>) -> Image {
    Image { width: side, height: side, pixels }
}

/// Its pixels as a picture has them.
pub(super) fn narrow(airlight: &Airlight) -> Vec<[f32; 3]> {
    airlight.radiance.iter().map(|radiance| radiance.as_vec3().to_array()).collect()
}

/// The scale with which `percent` of a picture's values are at most 0.8.
pub(super) fn display_scale(image: &Image, percent: usize) -> f32 {
    let mut values: Vec<f32> = image.pixels.iter().flatten().copied().collect();
    values.sort_by(f32::total_cmp);
    let bright = values.get((values.len() * percent / 100).min(values.len().saturating_sub(1)));
    bright.filter(|bright| **bright > 0.0).map_or(1.0, |bright| 0.8 / bright)
}

/// A name as a part of a file's name.
pub(super) fn slug(name: &str) -> String {
    let plain = name.replace("procedural:", "generated-").replace('/', "-of-");
    let dashed: String = plain.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    dashed.split('-').filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-").to_lowercase()
}

/// What a reader must know of where the times come from.
pub(super) fn device_notes(context: &Context) -> Vec<String> {
    let note = match &context.gpu {
        Some(gpu) if !crate::gpu::is_hardware(gpu) => {
            "A software adapter: times are wall times around a submission, and only their ratios within this run mean anything."
        }
        Some(_) => return Vec::new(),
        None => "There is no GPU adapter: the CPU implementations were timed.",
    };
    vec![note.into()]
}
