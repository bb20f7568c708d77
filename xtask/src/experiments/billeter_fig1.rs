//! `billeter-fig1`: a cathedral under two spots, surfaces and all.

use glam::{DVec3, Vec3};
use scene::{Light, SpotLight};

use super::billeter_bench::{Division, linear};
use super::measure::{Arena, Measured};
use super::shown::{Shown, clock_note, display_scale, slug};
use super::wyman_bench::source;
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::airlight::Stage;
use crate::failure::{Failure, Outcome};
use crate::image_file::{Image, to_srgb8};
use crate::maps::Maps;
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Panel, PanelKind, PictureRow, Section};
use crate::scene_args::Setup;
use crate::setups::LightKind;
use crate::surfaces;
use crate::technique::{Options, Technique};

/// Threshold of the quadtree as a share of the scene's diagonal.
const SHARE: f32 = 3e-3;

/// Optical depth of the view.
const DEPTH: f32 = 0.6;

/// Least that shadows are to change, as a share of the picture's airlight.
const WEIGHT: f64 = 0.2;

/// Largest map error of the light volume.
const ERROR: f64 = 2e-3;

/// The strong yellow light's place and target (m), half-angles (degrees) and intensity (W/sr): at a side window.
struct Yellow {
    position: Vec3,
    target: Vec3,
    angles: [f32; 2],
    intensity: Vec3,
}

/// In sibenik, whose windows are solid: before one of an aisle, so that columns cut it.
const SIBENIK: Yellow = Yellow {
    position: Vec3::new(1.0, -9.0, 5.0),
    target: Vec3::new(-4.0, -10.5, -1.0),
    angles: [20.0, 30.0],
    intensity: Vec3::new(1000.0, 700.0, 150.0),
};

/// In the columned hall: outside of a high window.
const HALL: Yellow = Yellow {
    position: Vec3::new(12.5, 12.0, -2.0),
    target: Vec3::new(-3.0, 0.0, -1.0),
    angles: [15.0, 25.0],
    intensity: Vec3::new(20000.0, 14000.0, 3000.0),
};

/// Names of the lights, in their order.
const NAMES: [&str; 2] = ["white, from above", "yellow, from a window"];

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let (side, map) = match context.preset {
        Preset::Smoke => (64, 128),
        _ if context.gpu.is_none() => (64, 128),
        Preset::Quick => (256, 1024),
        Preset::Standard => (512, 1024),
        Preset::Paper => (1024, 1024),
    };
    let mut found = experiment(
        context,
        "billeter-fig1",
        "A cathedral with two lights",
        "Billeter, Sintorn & Assarsson 2010, Figure 1",
    );
    found.adapter = gpu_or_cpu(context);
    let (title, setup) = set_up(context)?;
    tracing::info!("{title}");
    let mut arena = Arena::new(&context.references, title, setup, linear(side, map))?;
    let divisions = [Division::Distance(SHARE), Division::Indexed];
    let settings = divisions.map(|division| division.setting(&arena, arena.base));
    let taken = arena.measure(context.gpu.as_ref(), &settings)?;
    let alone = alone(&arena)?;
    let mut section = finish(&arena, &taken, &alone)?;
    for measured in &taken {
        let mut row = measured.row(&arena.title, arena.triangles());
        row.paper = Some([("fps".to_owned(), 40.into())].into_iter().collect());
        found.rows.push(row);
    }
    section.tables.push(shares(&arena, &alone)?);
    found.checks = checks(&arena, &taken, &alone)?;
    found.notes = notes(context, &arena);
    section.experiment = found;
    Ok(section)
}

/// Sibenik with the white spot of its set-up and a yellow one, or the columned hall in its place.
fn set_up(context: &Context) -> Outcome<(String, Setup)> {
    let sibenik = context.setups.sources().into_iter().find(|source| source.entry.id == "sibenik");
    let (source, yellow) = match sibenik {
        Some(source) => (source, SIBENIK),
        None => (super::wyman_bench::generated(context, "sponza")?, HALL),
    };
    let setup = source.setup_lit(DEPTH, LightKind::Spot)?;
    let mut setup = setup.ok_or_else(|| Failure::program("scenes.toml: a cathedral without a spot_light"))?;
    let [inner, outer] = yellow.angles.map(f32::to_radians);
    let direction = yellow.target - yellow.position;
    let spot = SpotLight::new(yellow.position, direction, inner, outer, yellow.intensity);
    setup.lights.push(Light::Spot(spot.map_err(Failure::program)?));
    Ok((source.title(), setup))
}

/// The airlight of each light by itself, exact on its map, and the same where nothing shadows it.
fn alone(arena: &Arena) -> Outcome<Vec<[Image; 2]>> {
    let open = Options { shadows_in_medium: false, ..arena.base };
    let of = |index: usize| {
        let mut setup = arena.setup.clone();
        setup.lights = vec![arena.setup.lights[index].clone()];
        let maps = Maps { maps: vec![arena.map.maps.maps[index].clone()], ms: 0.0 };
        let run = |technique, options, maps| {
            let Arena { bvh, rays, .. } = arena;
            let stage = Stage { setup: &setup, bvh, options, rays, maps, further: &[], tick: &|_| () };
            Ok(arena.references.picture(&stage, technique)?.image)
        };
        let lit = run(Technique::ExactShadowMap, &arena.base, &maps)?;
        Ok([lit, run(Technique::Exact, &open, &Maps::none(1))?])
    };
    (0..arena.setup.lights.len()).map(of).collect()
}

/// Mean over pixels and channels.
fn mean(image: &Image) -> f64 {
    let values = image.pixels.iter().flatten();
    values.clone().map(|value| f64::from(*value)).sum::<f64>() / values.count().max(1) as f64
}

fn shares(arena: &Arena, alone: &[[Image; 2]]) -> Outcome<Table> {
    let mut table = Table::new(
        "Each light's share",
        vec![Column::left("light"), Column::right("of the airlight"), Column::right("its shadows change")],
    );
    for (name, [lit, open]) in NAMES.iter().zip(alone) {
        let weight = metrics::compare(open, lit, None, None)?.rel_rmse;
        let share = mean(lit) / mean(&arena.map.exact);
        table.push(vec![(*name).into(), report::error(share), report::error(weight)]);
    }
    table.note = Some("Shares of the mean radiance; what shadows change is the difference of the pictures with and without them, as a share of the one with them.".into());
    Ok(table)
}

fn checks(arena: &Arena, taken: &[Measured], alone: &[[Image; 2]]) -> Outcome<Vec<Check>> {
    let title = &arena.title;
    let weight = metrics::compare(&arena.unshadowed, &arena.exact, None, None)?.rel_rmse;
    let paper = "Figure 1: both lights cast volumetric shadows";
    let mut checks = vec![Check::new(
        format!("{title}: what shadows change of the airlight"),
        paper,
        Some(weight),
        Bound::AtLeast,
        WEIGHT,
    )];
    for (name, [lit, open]) in NAMES.iter().zip(alone) {
        let weight = metrics::compare(open, lit, None, None)?.rel_rmse;
        let claim = format!("{title}, {name}, alone: what shadows change of the airlight");
        checks.push(Check::new(claim, paper, Some(weight), Bound::AtLeast, WEIGHT));
    }
    for measured in taken {
        let claim = format!("{title}, {}: map error", measured.setting.name);
        let paper = "§6: exact with respect to the shadow map";
        checks.push(Check::new(claim, paper, Some(measured.map_error()), Bound::AtMost, ERROR));
    }
    Ok(checks)
}

/// The pictures with their surfaces.
fn finish(arena: &Arena, taken: &[Measured], alone: &[[Image; 2]]) -> Outcome<Section> {
    let lit = Options { airlight_only: false, ..arena.base };
    let surfaces = surfaces::run(&arena.setup, &arena.bvh, &arena.rays, &lit).radiance;
    let whole = |fog: &Image| {
        let sum = |(fog, surface): (&[f32; 3], &DVec3)| (Vec3::from(*fog) + surface.as_vec3()).to_array();
        Image { pixels: fog.pixels.iter().zip(&surfaces).map(sum).collect(), ..*fog }
    };
    let (exact, open) = (whole(&arena.map.exact), whole(&arena.unshadowed));
    let scale = display_scale(&exact, 97);
    let mut panels = Vec::new();
    for measured in taken {
        let image = whole(&measured.image);
        let errors: Metrics = metrics::compare(&image, &exact, Some(&open), None)?;
        let shown = Shown {
            scene: &arena.title,
            what: "A cathedral with two lights",
            name: &measured.setting.name,
            image: &image,
            scale,
            ms: measured.ms(),
            errors: &errors,
            reference: &exact,
        };
        panels.extend(shown.panels()?);
    }
    for (name, [fog, _]) in NAMES.iter().zip(alone) {
        let file = format!("{}-{}.png", slug(&arena.title), slug(name));
        let alt = format!("Airlight of the light that is {name}, exact on its map");
        let picture = to_srgb8(fog, display_scale(&arena.map.exact, 95));
        panels.push(Panel::new(file, format!("airlight, {name}"), alt, &picture, PanelKind::Plain)?);
    }
    let caption =
        format!("{}, maps {}²; errors of the whole picture on the maps", arena.title, arena.base.map.side);
    Ok(Section { pictures: vec![PictureRow { caption, panels }], ..Section::default() })
}

fn notes(context: &Context, arena: &Arena) -> Vec<String> {
    let (side, map) = (arena.base.size.0, arena.base.map.side);
    let mut notes = vec![
        format!("Pictures are {side}×{side}, maps {map}²; the paper's are 1024×1024 with maps of 1024², at about 40 frames per second, surfaces and maps included. Times here are of the fog alone. Errors in the table of measurements are those of the airlight, beside the pictures those of the whole picture."),
        "The white light is the spot of the set-up, the yellow one is strong and stands at a window: outside of one in the hall, before one of an aisle in sibenik, whose windows are solid.".into(),
    ];
    if arena.setup.lights.len() == 2 && source(context, "sibenik").is_err() {
        notes.push("The columned hall stands in for sibenik.".into());
    }
    notes.extend(clock_note(context));
    notes
}
