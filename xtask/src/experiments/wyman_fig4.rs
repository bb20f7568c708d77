//! `wyman-fig4`: where the steps lie, and what of their error neighbouring pixels share.

use glam::DVec3;
use hybrid_march::Placement;
use scene::AirlightModel;
use serde_json::json;

use super::measure::{Arena, Measured, Setting};
use super::shown::{Shown, clock_note, display_scale};
use super::wyman_bench::{self, lit, model_name, panels};
use super::wyman_boundary::{self, Boundary};
use super::wyman_placements::{self, Steps, Timed};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::image_file::Image;
use crate::metrics;
use crate::report::data::{Bound, Check, Experiment, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, PictureRow, Section};
use crate::technique::{Options, Technique};

/// Width of the box that keeps what neighbouring pixels share; units: pixels.
const BOX: i64 = 9;

/// An rms error below which there is nothing but rounding to f32.
const ROUNDING: f64 = 1e-6;

/// Largest deviation of a boundary from a straight motion; units: pixels.
const STEADY: f64 = 0.1;

struct Plan {
    side: u32,
    map: u32,
    samples: u32,
    /// Scenes under a point light.
    scenes: &'static [&'static str],
    /// Scenes under a textured one.
    textured: &'static [&'static str],
    /// Side of the pictures in which boundaries are located, and how many positions of the light.
    boundary: (u32, u32),
}

fn plan(preset: Preset) -> Plan {
    let scenes: &[&str] = &["sphere", "slats", "bunny", "sponza"];
    let textured: &[&str] = &["sphere", "bunny"];
    let boundary = (256, 64);
    let least =
        Plan { side: 64, map: 128, samples: 16, scenes: &scenes[..2], textured: &textured[..1], boundary };
    match preset {
        Preset::Smoke => least,
        Preset::Quick => Plan { side: 256, map: 1024, ..least },
        Preset::Standard => Plan { side: 512, map: 1024, scenes, textured, ..least },
        Preset::Paper => Plan { side: 1024, map: 1024, scenes, textured, ..least },
    }
}

/// What of a picture's error neighbouring pixels share, over the pixels that count.
#[derive(Debug, Clone, Copy)]
struct Banding {
    /// ‖e‖ / ‖b‖ over those pixels.
    rms: f64,
    /// The same for the error's mean over a box around each pixel.
    low: f64,
}

impl Banding {
    fn of(image: &Image, exact: &Image, counts: &[bool]) -> Self {
        let (width, height) = (i64::from(exact.width), i64::from(exact.height));
        let mean = |pixel: &[f32; 3]| pixel.iter().map(|&value| f64::from(value)).sum::<f64>() / 3.0;
        let errors: Vec<f64> =
            image.pixels.iter().zip(&exact.pixels).map(|(a, b)| mean(a) - mean(b)).collect();
        let boxed = |x: i64, y: i64| {
            let reach = BOX / 2;
            let (mut sum, mut count) = (0.0, 0.0);
            for v in (y - reach).max(0)..=(y + reach).min(height - 1) {
                for u in (x - reach).max(0)..=(x + reach).min(width - 1) {
                    sum += errors[(v * width + u) as usize];
                    count += 1.0;
                }
            }
            sum / count
        };
        let (mut all, mut low, mut norm) = (0.0, 0.0, 0.0);
        for (i, _) in counts.iter().enumerate().filter(|(_, counts)| **counts) {
            all += errors[i].powi(2);
            low += boxed(i as i64 % width, i as i64 / width).powi(2);
            norm += mean(&exact.pixels[i]).powi(2);
        }
        let share = |sum: f64| if norm > 0.0 { (sum / norm).sqrt() } else { 0.0 };
        Self { rms: share(all), low: share(low) }
    }

    /// The share of the error's energy at low frequencies.
    fn share(self) -> f64 {
        if self.rms > 0.0 { (self.low / self.rms).powi(2) } else { 0.0 }
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let plan = Plan { side: context.marched_side(plan.side), ..plan };
    let mut found =
        experiment(context, "wyman-fig4", "Where the steps of a march lie", "Wyman & Ramsey 2008, Figure 4");
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let mut table = Table::new(
        "What neighbouring pixels share of the error",
        ["scene", "steps", "time", "rms error", "rms after a 9×9 box", "energy at low frequencies"]
            .iter()
            .enumerate()
            .map(|(i, &name)| if i < 2 { Column::left(name) } else { Column::right(name) })
            .collect(),
    );
    table.note = Some("Errors are shares of the exact picture's norm, over the pixels that the shadow volume (left) or the light's cone (right) covers. Noise without any correlation would keep 1/81 of its energy.".into());
    for id in plan.scenes {
        let source = wyman_bench::source(context, id)?;
        let mut setup = source.setup(wyman_bench::thin(context))?;
        let far = wyman_placements::far_enough(&setup);
        let mut title = format!("{}, point light", source.title());
        if *id == "sphere" {
            setup = wyman_boundary::VIEWS[0].lit(&setup)?;
            title = format!("{}, light before it", source.title());
        }
        let lit = lit(context, title, setup, [plan.side, plan.map], far)?;
        left(&plan, &lit, &mut found, &mut table, &mut section)?;
    }
    for id in plan.textured {
        let source = wyman_bench::source(context, id)?;
        for model in [AirlightModel::HoffmanPreetham, AirlightModel::Sun] {
            let Some(setup) = wyman_bench::textured(&source, wyman_bench::thin(context), model)? else {
                continue;
            };
            let title = format!("{}, stained glass, {}", source.title(), model_name(model));
            let mut lit = lit(context, title, setup, [plan.side, plan.map], f64::INFINITY)?;
            right(context, &plan, &mut lit, &mut found, &mut table, &mut section)?;
        }
    }
    section.tables.push(table);
    let mut steady = Table::new(
        "Boundaries while the light moves",
        ["scene", "row", "level", "technique", "found", "largest deviation (pixels)"]
            .iter()
            .enumerate()
            .map(|(i, &name)| if i == 0 || i == 3 { Column::left(name) } else { Column::right(name) })
            .collect(),
    );
    for view in &wyman_boundary::VIEWS {
        let source = wyman_bench::generated(context, view.id)?;
        tracing::info!("{}, boundary", source.title());
        let setup = source.setup(wyman_bench::thin(context))?;
        for boundary in wyman_boundary::measure(&setup, view, plan.boundary)? {
            steady.push(boundary_line(&source.title(), &boundary));
            found.checks.extend(boundary_check(&source.title(), &boundary));
        }
    }
    section.tables.push(steady);
    found.notes = notes(context, &plan);
    section.experiment = found;
    Ok(section)
}

/// Point light: three placements of as many steps, by the same march on the CPU.
fn left(
    plan: &Plan,
    lit: &Arena,
    found: &mut Experiment,
    table: &mut Table,
    section: &mut Section,
) -> Outcome {
    let (counts, timed) = wyman_placements::measure(lit, plan.samples)?;
    let mut bands = Vec::new();
    let mut panels = Vec::new();
    for result in &timed {
        let name = format!("{}, {} steps", result.steps.name(), plan.samples);
        let metrics = metrics::compare(&result.image, &lit.exact, Some(&lit.unshadowed), None)?;
        let band = Banding::of(&result.image, &lit.exact, &counts);
        let mut row = Row::new(&lit.title, &name);
        row.triangles = Some(lit.triangles());
        (row.ms_scatter, row.ms_frame) = (Some(result.ms()), Some(result.ms()));
        (row.ms_min, row.ms_max) = (result.times.first().copied(), result.times.last().copied());
        row.frames = Some(result.times.len() as u32);
        row.set_errors(&metrics);
        row.rays = Some(result.lookups);
        row.params.insert("samples".into(), json!(plan.samples));
        row.params.insert("low_frequency_share".into(), json!(band.share()));
        found.rows.push(row);
        table.push(banding_line(&lit.title, &name, result.ms(), band));
        let shown = Shown {
            scene: &lit.title,
            what: &format!("Airlight of {}", lit.title),
            name: &name,
            image: &result.image,
            scale: display_scale(&lit.exact, 95),
            ms: result.ms(),
            errors: &metrics,
            reference: &lit.exact,
        };
        panels.extend(shown.panels()?);
        bands.push((result, band));
    }
    section.pictures.push(PictureRow { caption: format!("{}, airlight only", lit.title), panels });
    let of = |steps| bands.iter().find(|(result, _)| result.steps == steps);
    let Some((faces, between)) = of(Steps::BetweenFaces) else { return Ok(()) };
    for other in [Steps::Planes, Steps::WholeRay] {
        let Some((result, band)) = of(other) else { continue };
        let paper =
            "section 3.4: planes parallel to the image and uniform sizes lead to visible coherency artifacts";
        let note = times_note(faces, result);
        for (what, ratio) in
            [("rms error", band.rms / between.rms), ("error after a 9×9 box", band.low / between.low)]
        {
            let claim = format!("{}: {what} of {}, times that between the faces", lit.title, other.name());
            let mut check = Check::new(claim, paper, Some(ratio), Bound::AtLeast, 1.0);
            check.note = Some(note.clone());
            found.checks.push(check);
        }
        let claim = format!(
            "{}: low frequencies' share of the error's energy, {}, times that between the faces",
            lit.title,
            other.name()
        );
        let mut check = Check::new(claim, paper, Some(band.share() / between.share()), Bound::AtLeast, 1.0);
        let mut note = format!("{} against {}", report::error(band.share()), report::error(between.share()));
        if between.rms < ROUNDING {
            note += ", of an error between the faces that is rounding";
        }
        check.note = Some(note);
        found.checks.push(check);
    }
    Ok(())
}

fn times_note(faces: &Timed, other: &Timed) -> String {
    format!("in {} against {}, on the CPU", report::time(other.ms()), report::time(faces.ms()))
}

/// Textured light: equal distance against equal angle, in the hybrid without bisections and mips.
fn right(
    context: &Context,
    plan: &Plan,
    lit: &mut Arena,
    found: &mut Experiment,
    table: &mut Table,
    section: &mut Section,
) -> Outcome {
    let placements = [(Placement::EqualDistance, "equal distance"), (Placement::EqualAngle, "equal angle")];
    let setting = |(placement, name): (Placement, &str)| {
        let mut options = Options { samples: Some(plan.samples), ..lit.base };
        options.hybrid.placement = Some(placement);
        options.hybrid.lit_samples = Some(plan.samples);
        (options.hybrid.tile, options.hybrid.refine, options.hybrid.mips) = (1, 0, None);
        Setting::new(format!("{name}, {} steps a segment", plan.samples), Technique::Hybrid, options)
    };
    let settings = placements.map(setting);
    let results = wyman_bench::measure(context, lit, &settings)?;
    let counts: Vec<bool> = lit
        .unshadowed
        .pixels
        .iter()
        .map(|pixel| DVec3::from(pixel.map(f64::from)).max_element() > 0.0)
        .collect();
    let bands: Vec<Banding> =
        results.iter().map(|result| Banding::of(&result.image, &lit.exact, &counts)).collect();
    let mut pictures = Vec::new();
    for (result, band) in results.iter().zip(&bands) {
        let mut row = result.row(&lit.title, lit.triangles());
        row.params.insert("low_frequency_share".into(), json!(band.share()));
        found.rows.push(row);
        table.push(banding_line(&lit.title, &result.setting.name, result.ms(), *band));
        pictures.extend(panels(lit, result)?);
    }
    section.pictures.push(PictureRow { caption: format!("{}, airlight only", lit.title), panels: pictures });
    let (Some([distance, angle]), Some([first, second])) =
        (bands.first_chunk::<2>(), results.first_chunk::<2>())
    else {
        return Ok(());
    };
    let paper = "section 3.4: equal steps bend at the frustum's boundaries, equal angles do not";
    for (what, ratio) in
        [("rms error", distance.rms / angle.rms), ("error after a 9×9 box", distance.low / angle.low)]
    {
        let claim = format!("{}: {what} of equal distances, times that of equal angles", lit.title);
        let mut check = Check::new(claim, paper, Some(ratio), Bound::AtLeast, 1.0);
        check.note = Some(right_note(first, second));
        found.checks.push(check);
    }
    Ok(())
}

fn right_note(distance: &Measured, angle: &Measured) -> String {
    format!(
        "{} in {} against {} in {}",
        report::error(distance.on_geometry.rel_rmse),
        report::time(distance.ms()),
        report::error(angle.on_geometry.rel_rmse),
        report::time(angle.ms())
    )
}

fn banding_line(scene: &str, name: &str, ms: f64, band: Banding) -> Vec<String> {
    vec![
        scene.to_owned(),
        name.to_owned(),
        report::time(ms),
        report::error(band.rms),
        report::error(band.low),
        report::error(band.share()),
    ]
}

fn boundary_line(scene: &str, boundary: &Boundary) -> Vec<String> {
    vec![
        scene.to_owned(),
        boundary.row.to_string(),
        report::error(boundary.level),
        boundary.technique.clone(),
        format!("{} of {}", boundary.found, boundary.positions),
        report::figure(boundary.deviation),
    ]
}

/// The hybrid is to be steady; the others stand beside it.
fn boundary_check(scene: &str, boundary: &Boundary) -> Option<Check> {
    if !boundary.is_judged {
        return None;
    }
    let claim = format!("{scene}: largest deviation of a shadow's boundary while the light moves, in pixels");
    let paper = "section 3.1: the frontmost and final shadow boundaries will not exhibit aliasing";
    let measured = boundary.deviation.filter(|_| boundary.found == boundary.positions);
    let mut check = Check::new(claim, paper, measured, Bound::AtMost, STEADY);
    check.note = Some(format!(
        "row {} of {}, where {} of the light are missing; {} of {} positions found",
        boundary.row,
        boundary.side,
        report::error(boundary.level),
        boundary.found,
        boundary.positions
    ));
    Some(check)
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only, in the thin medium.", plan.side),
        "Point light: one march on the CPU with shadow rays, whose steps alone differ: between the frontmost and the backmost face of each ray; on planes of equal depth between the nearest and the farthest face in the picture; of equal length from the eye to the ray's end. No boundary is bisected. Rays that hit nothing end behind the scene, so that all have equal steps. The set-up of the sphere has its light behind it, and the eye in its shadow; here the light stands before it. Between the faces of a convex caster all is dark, so that nothing is left of the error but rounding; among slats there is light between the faces.".into(),
        format!("Textured light: the hybrid with faces by pixel, map {}², without bisections and without mips.", plan.map),
        format!(
            "Boundaries: {0}×{0} pixels, shadow rays, 50 steps, faces by pixel, no bisection; the light moves in {1} equal steps parallel to the image by as much as moves the exact boundary by two pixels. Located by linear interpolation between pixels; the exact picture's own deviation, which is that of the interpolation, stands beside. The row is the one in which the exact boundary moves most evenly.",
            plan.boundary.0, plan.boundary.1
        ),
    ];
    notes.extend(clock_note(context));
    notes
}
