//! `wyman-fig1`: the teaser, surfaces and all, by the hybrid at quarter resolution and at full.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use scene::{AirlightModel, Bvh, Light, SpotLight};

use super::shots::{self, Setting, Shots, Subject, display_scale, slug};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::{Failure, Outcome};
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::maps::{MapOptions, MapSurface, Maps};
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Panel, PanelKind, PictureRow, Section};
use crate::scene_args::Setup;
use crate::setups::Source;
use crate::stained_glass::stained_glass;
use crate::surfaces;
use crate::technique::{HybridOptions, Options, Technique, VisibilitySource};
use crate::view_rays::ViewRays;

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
        let done = measure(context, scene, &title, &setup, (side, map))?;
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
    found.notes.extend(shots::device_notes(context));
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

fn measure(
    context: &Context,
    scene: &Scene,
    title: &str,
    setup: &Setup,
    (side, map): (u32, u32),
) -> Outcome<Done> {
    let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
    let base = Options {
        airlight_only: true,
        visibility: VisibilitySource::Map,
        map: MapOptions { side: map, surface: MapSurface::Step },
        ..Options::new((side, side))
    };
    let maps = Maps::draw(setup, &base.map)?;
    let hybrid = |name: &str, scale| Setting {
        name: name.into(),
        technique: Technique::Hybrid,
        options: Options { scattering_scale: scale, hybrid: HybridOptions::default(), ..base },
        maps: &maps,
    };
    let brute = Setting {
        name: BRUTE.into(),
        technique: Technique::BruteForce,
        options: Options { samples: Some(150), ..base },
        maps: &maps,
    };
    let settings = [hybrid(QUARTER, 4), hybrid(FULL, 1), brute];
    let subject = Subject { title, setup, bvh: &bvh, side, maps: &maps };
    let taken = shots::take(context, &subject, &base, &settings)?;
    let rays = ViewRays::trace(&setup.camera, &bvh, base.size);
    let lit = surfaces::run(setup, &bvh, &rays, &Options { airlight_only: false, ..base });
    finish(scene, &subject, &taken, &lit.radiance)
}

/// Adds the surfaces to all pictures and compares them as a whole.
fn finish(scene: &Scene, subject: &Subject<'_>, taken: &Shots, surfaces: &[DVec3]) -> Outcome<Done> {
    let whole = |fog: &Image| {
        let pixels = fog.pixels.iter().zip(surfaces);
        let sum = |(fog, surface): (&[f32; 3], &DVec3)| (Vec3::from(*fog) + surface.as_vec3()).to_array();
        shots::image(subject.side, pixels.map(sum).collect())
    };
    let (exact, open) = (whole(&taken.exact), whole(&taken.unshadowed));
    let (scale, id) = (display_scale(&exact, scene.percent), slug(subject.title));
    let mut panels = Vec::new();
    let mut metrics_of: Vec<Metrics> = Vec::new();
    let (mut rows, mut lines) = (Vec::new(), Vec::new());
    for shot in &taken.shots {
        let image = whole(&shot.image);
        let metrics = metrics::compare(&image, &exact, Some(&open), None)?;
        panels.push(shot.panel(&id, scene.caption, &image, scale, &metrics)?);
        panels.push(shot.error_panel(&id, &image, &exact)?);
        let mut row = shot.row(subject);
        row.set_errors(&metrics);
        rows.push(row);
        lines.push(vec![
            subject.title.into(),
            shot.name.clone(),
            report::time(shot.ms()),
            report::error(metrics.shadow_err),
            report::error(metrics.rel_rmse),
            report::figure(metrics.flip),
            report::figure(shot.lookups),
        ]);
        metrics_of.push(metrics);
    }
    panels.insert(
        0,
        Panel::new(
            format!("{id}-exact.png"),
            format!("exact, {} on the CPU", report::time(taken.exact_ms)),
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
        checks: checks(subject.title, taken, &metrics_of),
        pictures: PictureRow { caption: format!("{}: {}", subject.title, scene.caption), panels },
    })
}

fn checks(title: &str, taken: &Shots, metrics: &[Metrics]) -> Vec<Check> {
    let flip = |name: &str| {
        taken.shots.iter().zip(metrics).find(|(shot, _)| shot.name == name).map(|(_, metrics)| metrics.flip)
    };
    let ms = |name: &str| taken.of(name).map(shots::Shot::ms);
    let ratio = |slow: &str, fast: &str| Some(ms(slow)? / ms(fast)?);
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
