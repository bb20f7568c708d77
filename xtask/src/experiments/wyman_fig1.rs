//! `wyman-fig1`: the teaser, surfaces and all, by the hybrid at quarter resolution and at full.

use hybrid_march::Sampling;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use scene::{AirlightModel, Light, SpotLight};

use super::counts::for_all_pixels;
use super::measure::{Arena, Measured, Setting, base};
use super::references;
use super::shown::{Shown, clock_note, display_scale, slug};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::{Failure, Outcome};
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Panel, PanelKind, PictureRow, Section};
use crate::scene_args::Setup;
use crate::setups::Source;
use crate::stained_glass::stained_glass;
use crate::surfaces;
use crate::technique::{Options, Technique};

/// Mean FLIP that few would see.
const UNSEEN: f64 = 0.05;

const FULL: &str = "hybrid";
const QUARTER: &str = "hybrid, 1/4 resolution";
const BRUTE: &str = "brute force, 150 samples";

/// A picture of the figure.
struct Scene {
    id: &'static str,
    caption: &'static str,
    /// Optical depth of the view.
    depth: f32,
    /// How much of the picture is below white.
    percent: usize,
    /// What is changed of the set-up.
    change: fn(&mut Setup) -> Outcome,
}

const SCENES: [Scene; 3] = [
    Scene {
        id: "sponza",
        caption: "a hall under a stained-glass window",
        depth: 0.8,
        percent: 97,
        change: window,
    },
    Scene { id: "bunny", caption: "a body before a lamp", depth: 1.0, percent: 97, change: as_it_is },
    Scene { id: "lampshade", caption: "a perforated lampshade", depth: 0.6, percent: 95, change: as_it_is },
];

fn as_it_is(_: &mut Setup) -> Outcome {
    Ok(())
}

/// Half-angle of the window's light; units: rad.
const WINDOW: f32 = 0.56;

/// Hangs a lit window high up in the hall, shining towards the viewer, in the model that the paper's coloured pictures
/// have.
fn window(setup: &mut Setup) -> Outcome {
    let (camera, bounds) = (&setup.camera, setup.scene.bounds());
    // in the nave, ahead of the viewer and under the roof
    let ahead = Vec3::new(camera.forward.x, 0.0, camera.forward.z).normalize_or_zero();
    let height = bounds.max.y - bounds.min.y;
    let position = camera.position + 15.0 * ahead + Vec3::Y * (0.42 * height);
    let target = camera.position + 9.0 * ahead - Vec3::Y * 1.6;
    let mut glazed = SpotLight::new(position, target - position, 0.95 * WINDOW, WINDOW, Vec3::splat(30.0))
        .map_err(Failure::program)?;
    glazed.texture = Some(Arc::new(stained_glass()));
    setup.lights = vec![Light::Spot(glazed)];
    setup.model = AirlightModel::HoffmanPreetham;
    Ok(())
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let (side, map, count) = match context.preset {
        Preset::Smoke => (64, 256, 1),
        Preset::Quick => (256, 1024, 2),
        Preset::Standard => (512, 1024, 3),
        Preset::Paper => (1024, 1024, 3),
    };
    let side = context.marched_side(side);
    let mut found = experiment(
        context,
        "wyman-fig1",
        "Volumetric shadows by the hybrid, with surfaces",
        "Wyman & Ramsey 2008, Figure 1",
    );
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let mut table = table();
    for scene in SCENES.iter().take(count) {
        let Some((title, setup)) = set_up(context, scene)? else { continue };
        tracing::info!("{title}");
        let done = measure(context, scene, Arena::new(&context.references, title, setup, base(side, map))?)?;
        table.rows.extend(done.lines);
        found.rows.extend(done.rows);
        found.checks.extend(done.checks);
        section.pictures.push(done.pictures);
    }
    section.tables.push(table);
    found.notes.push(format!(
        "Pictures are {side}×{side}, surfaces lit with shadow rays and weakened by the fog; times are those of the fog alone, with silhouettes found anew in every frame, and the same surfaces are in every picture. Errors are those of the whole pictures; shadow error is a share of what shadows in the fog change."
    ));
    found.notes.push("The hall is lit through a window in Hoffman and Preetham's model, as the paper's coloured pictures are; the others in Sun's. The hybrid takes 48 steps between faces and 24 in light before and behind them, brute force 150 through the whole cone: what the hybrid errs in the hall is the window's picture in light, of which it takes fewer steps, and little of it is shadow. Lookups are questions for visibility alone.".into());
    found.notes.push(references::NOTE.into());
    found.notes.extend(clock_note(context));
    section.experiment = found;
    Ok(section)
}

/// The set-up of a scene: from the folder where it has the file, else the generated one.
fn set_up(context: &Context, scene: &Scene) -> Outcome<Option<(String, Setup)>> {
    let given = context.setups.sources();
    let all = given.into_iter().chain(context.setups.stand_ins());
    let Some(source) = all.into_iter().find(|source: &Source| source.entry.id == scene.id) else {
        return Ok(None);
    };
    let spot = scene.id == "sponza";
    let setup = if spot {
        source.setup_lit(scene.depth, crate::setups::LightKind::Spot)?
    } else {
        Some(source.setup(scene.depth)?)
    };
    let Some(mut setup) = setup else { return Ok(None) };
    (scene.change)(&mut setup)?;
    Ok(Some((source.title(), setup)))
}

struct Done {
    rows: Vec<report::data::Row>,
    lines: Vec<Vec<String>>,
    checks: Vec<Check>,
    pictures: PictureRow,
}

fn measure(context: &Context, scene: &Scene, mut arena: Arena) -> Outcome<Done> {
    let base = arena.base;
    let hybrid = |name, scale| {
        Setting::new(name, Technique::Hybrid, Options { sampling: Sampling::blocks(scale), ..base })
    };
    let brute = Setting::new(BRUTE, Technique::BruteForce, Options { samples: Some(150), ..base });
    let settings = [hybrid(QUARTER, 4), hybrid(FULL, 1), brute];
    let mut taken = arena.measure(context.gpu.as_ref(), &settings)?;
    for_all_pixels(&arena, &mut taken)?;
    let lit = Options { airlight_only: false, ..base };
    let lit = surfaces::run(&arena.setup, &arena.bvh, &arena.rays, &lit);
    finish(scene, &arena, &taken, &lit.radiance)
}

/// Adds the surfaces to all pictures and compares them as a whole.
fn finish(scene: &Scene, arena: &Arena, taken: &[Measured], surfaces: &[DVec3]) -> Outcome<Done> {
    let whole = |fog: &Image| {
        let sum = |(fog, surface): (&[f32; 3], &DVec3)| (Vec3::from(*fog) + surface.as_vec3()).to_array();
        Image { pixels: fog.pixels.iter().zip(surfaces).map(sum).collect(), ..*fog }
    };
    let (exact, open) = (whole(&arena.exact), whole(&arena.unshadowed));
    let (scale, id) = (display_scale(&exact, scene.percent), slug(&arena.title));
    let mut panels = Vec::new();
    let mut metrics_of: Vec<Metrics> = Vec::new();
    let (mut rows, mut lines) = (Vec::new(), Vec::new());
    for shot in taken {
        let image = whole(&shot.image);
        let metrics = metrics::compare(&image, &exact, Some(&open), None)?;
        let name = &shot.setting.name;
        let shown = Shown {
            scene: &arena.title,
            what: scene.caption,
            name,
            image: &image,
            scale,
            ms: shot.ms(),
            errors: &metrics,
            reference: &exact,
        };
        panels.extend(shown.panels()?);
        let mut row = shot.row(&arena.title, arena.triangles());
        row.set_errors(&metrics);
        rows.push(row);
        lines.push(vec![
            arena.title.clone(),
            name.clone(),
            report::time(shot.ms()),
            report::error(metrics.shadow_err),
            report::error(metrics.rel_rmse),
            report::figure(metrics.flip),
            report::figure(shot.lookups()),
        ]);
        metrics_of.push(metrics);
    }
    panels.insert(
        0,
        Panel::new(
            format!("{id}-exact.png"),
            format!("exact, {} on the CPU", report::time(arena.exact_ms)),
            format!("{}: the exact picture", scene.caption),
            &to_srgb8(&exact, scale),
            PanelKind::Plain,
        )?,
    );
    panels.insert(
        1,
        Panel::new(
            format!("{id}-unshadowed.png"),
            "nothing shadows the fog",
            format!("{}: without shadows in the fog", scene.caption),
            &to_srgb8(&open, scale),
            PanelKind::Plain,
        )?,
    );
    panels.insert(
        2,
        Panel::new(
            format!("{id}-shadows.png"),
            "what the shadows in the fog change",
            "Difference of the pictures with and without shadows in the fog",
            &error_picture(&open, &exact)?,
            PanelKind::ErrorMap,
        )?,
    );
    Ok(Done {
        rows,
        lines,
        checks: checks(&arena.title, taken, &metrics_of),
        pictures: PictureRow { caption: format!("{}: {}", arena.title, scene.caption), panels },
    })
}

fn checks(title: &str, taken: &[Measured], metrics: &[Metrics]) -> Vec<Check> {
    let of = |name: &str| taken.iter().zip(metrics).find(|(shot, _)| shot.setting.name == name);
    let flip = |name: &str| of(name).map(|(_, metrics)| metrics.flip);
    let ratio = |slow: &str, fast: &str| Some(of(slow)?.0.ms() / of(fast)?.0.ms());
    let mut checks: Vec<Check> = [FULL, QUARTER]
        .map(|name| {
            let claim = format!("{title}, {name}: mean FLIP of the whole picture against the exact one");
            Check::new(claim, "§3.3: a modest drop in quality", flip(name), Bound::AtMost, UNSEEN)
        })
        .into();
    checks.push(Check::new(
        format!("{title}: the hybrid in times less time than the march of 150 samples"),
        "§4: 3 to 8 times",
        ratio(BRUTE, FULL),
        Bound::AtLeast,
        3.0,
    ));
    checks.push(Check::new(
        format!("{title}: a quarter of the resolution in times less time than all of it"),
        "§4: adds 25 to 100 %",
        ratio(FULL, QUARTER),
        Bound::AtLeast,
        1.25,
    ));
    checks
}

fn table() -> Table {
    Table::new(
        "The pictures",
        vec![
            Column::left("scene"),
            Column::left("technique"),
            Column::right("time of the fog"),
            Column::right("shadow error"),
            Column::right("relative RMSE"),
            Column::right("FLIP"),
            Column::right("lookups a pixel"),
        ],
    )
}
