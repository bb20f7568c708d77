//! `wyman-fig8`: the hybrid against ground truth, for a point light in Sun's model and for stained glass in Hoffman and
//! Preetham's, at full and at a quarter of the resolution.

use hybrid_march::Sampling;
use scene::AirlightModel;

use super::counts::LIT_NOTE;
use super::measure::{Arena, Measured, Setting};
use super::references;
use super::shown::{clock_note, display_scale, slug};
use super::wyman_bench::{self, lit, model_name, panels};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::image_file::{Image, to_srgb8};
use crate::report::data::{Bound, Check, Row};
use crate::report::{Panel, PanelKind, PictureRow, Section};
use crate::scene_args::Setup;
use crate::setups::Source;
use crate::technique::{Options, Technique};

/// Steps of the paper's ray tracer.
const RAY_TRACER: u32 = 500;

/// Mean FLIP at which two pictures are taken to be comparable.
const COMPARABLE: f64 = 0.05;

/// The inset's side, as a part of the picture's.
const INSET: u32 = 6;

struct Plan {
    side: u32,
    map: u32,
    scenes: &'static [&'static str],
}

fn plan(preset: Preset) -> Plan {
    let scenes: &[&str] = &["bunny", "sponza"];
    match preset {
        Preset::Smoke => Plan { side: 64, map: 256, scenes: &scenes[1..] },
        Preset::Quick => Plan { side: 256, map: 1024, scenes },
        Preset::Standard => Plan { side: 512, map: 1024, scenes },
        Preset::Paper => Plan { side: 1024, map: 1024, scenes },
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let plan = Plan { side: context.marched_side(plan.side), ..plan };
    let mut found =
        experiment(context, "wyman-fig8", "The hybrid against ground truth", "Wyman & Ramsey 2008, Figure 8");
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    for id in plan.scenes {
        let source = wyman_bench::source(context, id)?;
        for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
            let Some((setup, light)) = lit_by(context, &source, model)? else { continue };
            let title = format!("{}, {light}, {}", source.title(), model_name(model));
            let mut lit = lit(context, title, setup, [plan.side, plan.map], f64::INFINITY)?;
            let settings = settings(lit.base);
            let results = wyman_bench::measure(context, &mut lit, &settings)?;
            found.rows.extend(results.iter().map(|result| result.row(&lit.title, lit.triangles())));
            found.rows.push(exact_row(&lit));
            found.checks.extend(checks(&lit, &results));
            section.pictures.push(pictures(&lit, &results)?);
            section.pictures.push(insets(&lit, &results)?);
        }
    }
    found.notes = notes(context, &plan);
    section.experiment = found;
    Ok(section)
}

/// A point light in Sun's model, a window of stained glass in Hoffman and Preetham's.
fn lit_by(
    context: &Context,
    source: &Source,
    model: AirlightModel,
) -> Outcome<Option<(Setup, &'static str)>> {
    let depth = wyman_bench::thin(context);
    match model {
        AirlightModel::Sun => Ok(Some((source.setup(depth)?, "point light"))),
        AirlightModel::HoffmanPreetham => {
            Ok(wyman_bench::textured(source, depth, model)?.map(|setup| (setup, "stained glass")))
        }
    }
}

/// The hybrid at both resolutions, and the march that the paper's ray tracer was.
fn settings(base: Options) -> [Setting; 3] {
    let hybrid = |name: &str, scale| {
        Setting::new(name, Technique::Hybrid, Options { sampling: Sampling::blocks(scale), ..base })
    };
    let march = Options { samples: Some(RAY_TRACER), ..base };
    [
        hybrid("hybrid", 1),
        hybrid("hybrid, quarter resolution", 4),
        Setting::new(format!("march, {RAY_TRACER} samples"), Technique::BruteForce, march),
    ]
}

/// The reference's own time; its error is none by definition.
fn exact_row(lit: &Arena) -> Row {
    let mut row = Row::new(&lit.title, "exact, on the CPU");
    row.triangles = Some(lit.triangles());
    (row.ms_scatter, row.ms_frame, row.frames) = (Some(lit.exact_ms), Some(lit.exact_ms), Some(1));
    (row.rel_rmse, row.shadow_err, row.nmae, row.p99, row.flip) =
        (Some(0.0), Some(0.0), Some(0.0), Some(0.0), Some(0.0));
    row
}

fn checks(lit: &Arena, results: &[Measured]) -> Vec<Check> {
    let paper = "Figure 8: comparable to ray tracing with the same model";
    let [full, quarter, march] = results else { return Vec::new() };
    let figures = |found: &Measured| {
        format!(
            "{}: rel_rmse {}, shadow error {}, in {}",
            found.setting.name,
            crate::report::error(found.on_geometry.rel_rmse),
            crate::report::error(found.on_geometry.shadow_err),
            crate::report::time(found.ms())
        )
    };
    let note = |found: &Measured| Some(format!("{}; {}", figures(found), figures(march)));
    let mut checks = Vec::new();
    for found in [full, quarter] {
        let claim = format!("{}, {}: FLIP against the exact picture", lit.title, found.setting.name);
        let mut check = Check::new(claim, paper, Some(found.on_geometry.flip), Bound::AtMost, COMPARABLE);
        check.note = note(found);
        checks.push(check);
    }
    let share = full.on_geometry.rel_rmse / march.on_geometry.rel_rmse;
    let claim = format!("{}: the hybrid's rel_rmse, as a share of the {RAY_TRACER}-step march's", lit.title);
    let mut check = Check::new(claim, paper, Some(share), Bound::AtMost, 1.0);
    check.note = note(full);
    checks.push(check);
    checks
}

fn exact_panel(lit: &Arena) -> Outcome<Panel> {
    Panel::new(
        format!("{}-exact.png", slug(&lit.title)),
        "exact",
        format!("Airlight of {}, exact", lit.title),
        &to_srgb8(&lit.exact, display_scale(&lit.exact, 95)),
        PanelKind::Plain,
    )
}

fn pictures(lit: &Arena, results: &[Measured]) -> Outcome<PictureRow> {
    let mut pictures = vec![exact_panel(lit)?];
    for result in results {
        pictures.extend(panels(lit, result)?);
    }
    Ok(PictureRow { caption: format!("{}, airlight only", lit.title), panels: pictures })
}

/// Where the quarter-resolution picture is worst, enlarged, as it is and with its contrast raised.
fn insets(lit: &Arena, results: &[Measured]) -> Outcome<PictureRow> {
    let corner = results.get(1).map_or((0, 0), |quarter| worst(&quarter.image, &lit.exact));
    let cut = |image: &Image| crop(image, corner);
    let exact = cut(&lit.exact);
    let (low, high) = range(&exact);
    let mut panels = Vec::new();
    let shown = [("exact", &lit.exact)];
    let all =
        shown.into_iter().chain(results.iter().map(|result| (result.setting.name.as_str(), &result.image)));
    for (name, image) in all {
        let inset = cut(image);
        let raised = contrast(&inset, low, high);
        for (kind, picture, scale) in
            [("inset", &inset, display_scale(&lit.exact, 95)), ("raised contrast", &raised, 1.0)]
        {
            panels.push(Panel::new(
                format!("{}.png", slug(&format!("{} {name} {kind}", lit.title))),
                format!("{name}, {kind}"),
                format!("The same region of {} by {name}, enlarged", lit.title),
                &to_srgb8(picture, scale),
                PanelKind::Plain,
            )?);
        }
    }
    let caption = format!(
        "{}: the region from pixel ({}, {}) where the quarter-resolution picture is worst, enlarged; times and errors are those of the pictures above",
        lit.title, corner.0, corner.1
    );
    Ok(PictureRow { caption, panels })
}

/// Side of an inset in pixels.
fn inset_side(image: &Image) -> u32 {
    (image.width.min(image.height) / INSET).max(8).min(image.width.min(image.height))
}

/// Corner of the inset with the largest squared error.
fn worst(image: &Image, exact: &Image) -> (u32, u32) {
    let side = inset_side(image);
    let step = (side / 2).max(1);
    let error = |x: u32, y: u32| -> f64 {
        let pixels = (y..y + side).flat_map(|y| (x..x + side).map(move |x| (y * image.width + x) as usize));
        let squares = pixels.flat_map(|i| image.pixels[i].into_iter().zip(exact.pixels[i]));
        squares.map(|(a, b)| f64::from(a - b).powi(2)).sum()
    };
    let columns = (0..=image.width - side).step_by(step as usize);
    let corners = columns.flat_map(|x| (0..=image.height - side).step_by(step as usize).map(move |y| (x, y)));
    corners.max_by(|a, b| error(a.0, a.1).total_cmp(&error(b.0, b.1))).unwrap_or((0, 0))
}

/// A part of a picture, enlarged to about the whole's size without smoothing.
fn crop(image: &Image, corner: (u32, u32)) -> Image {
    let side = inset_side(image);
    let (width, height) = (side * INSET, side * INSET);
    let pixels = (0..height)
        .flat_map(|y| (0..width).map(move |x| (corner.0 + x / INSET, corner.1 + y / INSET)))
        .map(|(x, y)| image.pixels[(y * image.width + x) as usize])
        .collect();
    Image { width, height, pixels }
}

/// 2nd and 98th percentile of a picture's values.
fn range(image: &Image) -> (f32, f32) {
    let mut values: Vec<f32> = image.pixels.iter().flatten().copied().collect();
    values.sort_by(f32::total_cmp);
    let at =
        |share: usize| values.get((values.len() * share / 100).min(values.len().saturating_sub(1))).copied();
    (at(2).unwrap_or(0.0), at(98).unwrap_or(1.0))
}

/// A picture with [`low`, `high`] spread over [0, 1].
fn contrast(image: &Image, low: f32, high: f32) -> Image {
    let span = if high > low { high - low } else { 1.0 };
    let pixels = image.pixels.iter().map(|pixel| pixel.map(|value| (value - low) / span)).collect();
    Image { pixels, ..*image }
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only, in the thin medium; map {1}².", plan.side, plan.map),
        "The reference is exact: shadows are analytic, and integrals are closed forms or quadrature in f64. The paper's was a ray tracer that sampled scattering 500 times a pixel; a march with as many steps over the light's whole extent stands for it, on the same map as the hybrid.".into(),
        "What remains of both marches' errors at full resolution is mostly the map's: see rel_rmse_on_map beside rel_rmse.".into(),
        LIT_NOTE.into(),
    ];
    notes.push(references::NOTE.into());
    notes.extend(clock_note(context));
    notes
}
