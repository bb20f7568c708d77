//! What the paper offers for complex scenes, each with its artifact: simpler occluders, casters near the viewer alone,
//! shadows as a texture, variance shadow maps, and lights that shine beyond their map.

use std::sync::Arc;

use glam::DVec2;
use ground_truth::render_rows;
use hybrid_march::{FaceBounds, Hybrid, Occluders, ShadowVolume, near_viewer};
use scene::{Light, Mesh, PointLight, Visibility};
use shadowmap::{
    Bias, DepthMap, Filter, MapVisibility, Outside, Projection, ShadowMapError, VarianceMap,
    VarianceVisibility,
};

use super::Context;
use super::counts::for_all_pixels;
use super::measure::{self, Arena, Measured, Setting, WARM_FRAMES, in_turns};
use super::shown::{self, display_scale};
use super::wyman_fig7::{BRUTE, Plan, base, plain, source};
use crate::failure::{Failure, Outcome};
use crate::image_file::Image;
use crate::maps::Maps;
use crate::median::median;
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check, Experiment, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, PictureRow, Section};
use crate::scene_args::Setup;
use crate::setups::LightKind;
use crate::technique::{Extruded, HybridOptions, Options, Technique};
use crate::volumes::extruded_mesh;

/// Samples of every march here, as many as the paper has between faces.
const SAMPLES: u32 = 50;

/// Optical depth of what counts as near the viewer.
const NEAR_DEPTH: f32 = 1.5;

/// Optical depth of the view: thick, since that is where the paper drops what is far.
const DEPTH: f32 = 3.0;

const DEFAULT: &str = "all triangles";
const BOX: &str = "bounding box";
const NEAR: &str = "near the viewer, whole map";
const NEAR_ALONE: &str = "near the viewer, also in the map";
const TEXTURE: &str = "near the viewer, the rest as a texture";
const COARSE: [(u32, &str); 2] = [(64, "coarse mesh, 64 cells"), (12, "coarse mesh, 12 cells")];

/// Which options make sense in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A lone object: simpler casters.
    Simpler,
    /// A scene around the viewer: casters that are near.
    Nearer,
}

/// Measures the options and adds what was found.
pub(super) fn run(
    context: &Context,
    plan: &Plan,
    depth: f32,
    found: &mut Experiment,
    section: &mut Section,
) -> Outcome {
    for (ids, kind) in [(plan.lone, Kind::Simpler), (plan.around, Kind::Nearer)] {
        for id in ids {
            let Some(source) = source(context, id) else { continue };
            // a lamp outside of the object, since a box around the lamp has no outline
            let setup = match kind {
                Kind::Simpler => Some(source.setup(DEPTH)?),
                Kind::Nearer => source.setup_lit(DEPTH, LightKind::Spot)?,
            };
            let Some(setup) = setup else { continue };
            let light = setup.lights.first().map_or("no", |light| LightKind::of(light).name());
            let title = format!("{}, {light} light, thick", source.title());
            tracing::info!("{title}: options");
            casters(
                context,
                kind,
                Arena::new(&context.references, title, setup, base(plan))?,
                found,
                section,
            )?;
        }
    }
    // a scene around the viewer, where there is one: its map has a border inside the picture
    if let Some(source) = plan.around.first().or(plan.lone.first()).and_then(|id| source(context, id))
        && let Some(setup) = source.setup_lit(depth, LightKind::Spot)?
    {
        let title = format!("{}, spot light", source.title());
        tracing::info!("{title}: variance shadow map, beyond the map");
        let side = (plan.side / 2).max(32);
        let base = measure::base(side, plan.map);
        variance(&Arena::new(&context.references, title, setup.clone(), base)?, found, section)?;
        beyond_the_map(context, base, format!("{}, point light", source.title()), &setup, found, section)?;
        found.notes.push(format!("Variance shadow maps and what lies outside of a map are measured on the CPU, in pictures of {side}×{side}."));
    }
    found.notes.push(format!("Options are measured at {SAMPLES} samples in a view of optical depth {DEPTH}; near the viewer is what reaches within optical depth {NEAR_DEPTH} of the camera. \"Whole map\": volumes are those of the near casters, while the map, and the reference, have all. \"Also in the map\": the map is drawn with the near casters alone, and the errors on the map are still those against the map of all, so they hold what the far casters' missing shadows weigh."));
    Ok(())
}

fn casters(
    context: &Context,
    kind: Kind,
    mut arena: Arena,
    found: &mut Experiment,
    section: &mut Section,
) -> Outcome {
    let base = Options { samples: Some(SAMPLES), ..arena.base };
    let radius = NEAR_DEPTH / arena.setup.medium.coefficients.sigma_t()[0];
    let near = Arc::new(Maps::draw(&only_near(&arena.setup, radius)?, &base.map)?);
    let hybrid = |name: &str, hybrid, own_maps| {
        let setting = Setting::new(name, Technique::Hybrid, Options { hybrid, ..base });
        Setting { own_maps, ..setting }
    };
    let mut settings = Vec::new();
    let refined = |extruded| HybridOptions { extruded, ..HybridOptions::default() };
    let mut both = |name: &str, extruded, own_maps: Option<Arc<Maps>>| {
        settings.push(hybrid(name, plain(extruded), own_maps.clone()));
        settings.push(hybrid(&format!("{name}, refined"), refined(extruded), own_maps));
    };
    both(DEFAULT, Extruded::Scene, None);
    if kind == Kind::Simpler {
        for (cells, name) in COARSE {
            both(name, Extruded::Coarse(cells), None);
        }
        both(BOX, Extruded::BoundingBox, None);
    } else {
        both(NEAR, Extruded::NearViewer(radius), None);
        both(NEAR_ALONE, Extruded::NearViewer(radius), Some(near));
        both(TEXTURE, Extruded::RestAsTexture(radius), None);
    }
    settings.push(Setting::new(BRUTE, Technique::BruteForce, base));
    let mut shots = arena.measure(context.gpu.as_ref(), &settings)?;
    for_all_pixels(&arena, &mut shots)?;
    found.rows.extend(shots.iter().map(|shot| shot.row(&arena.title, arena.triangles())));
    found.checks.extend(checks(&arena.title, kind, &shots));
    section.tables.push(table(&arena.title, &shots));
    section.pictures.push(pictures(&arena, &shots)?);
    Ok(())
}

/// The set-up without what is far from the camera.
fn only_near(setup: &Setup, radius: f32) -> Outcome<Setup> {
    let all: Vec<_> = setup.scene.meshes.iter().flat_map(Mesh::corners).collect();
    let near = near_viewer(&all, setup.camera.position, radius);
    let positions = near.iter().flatten().copied().collect();
    let triangles = (0..near.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut reduced = setup.clone();
    reduced.scene.meshes = vec![Mesh::new(positions, triangles, 0).map_err(Failure::program)?];
    Ok(reduced)
}

/// The setting of that name.
fn of<'a>(shots: &'a [Measured], name: &str) -> Option<&'a Measured> {
    shots.iter().find(|shot| shot.setting.name == name)
}

fn checks(title: &str, kind: Kind, shots: &[Measured]) -> Vec<Check> {
    let error = |name: &str| Some(of(shots, name)?.map_error());
    let flip = |name: &str| Some(of(shots, name)?.on_map?.flip);
    let ms = |name: &str| Some(of(shots, name)?.ms());
    let more = |name: &str| Some(flip(name)? - flip(DEFAULT)?);
    let check = |claim: &str, paper: &str, measured, bound, bar| {
        Check::new(format!("{title}: {claim}"), paper, measured, bound, bar)
    };
    let ratio = |a: Option<f64>, b: Option<f64>| Some(a? / b?);
    if kind == Kind::Simpler {
        return vec![
            check(
                "a bounding box makes the error on the map this many times that of all triangles",
                "§3.3: its faces do not mark where shadow starts, which introduces aliasing",
                ratio(error(BOX), error(DEFAULT)),
                Bound::AtLeast,
                1.0,
            ),
            check(
                "FLIP that a mesh of 64 cells adds",
                "§3.3: exact boundaries of shadow are not so important",
                more(COARSE[0].1),
                Bound::AtMost,
                0.02,
            ),
            check(
                "volumes of a mesh of 64 cells are this many times faster than those of all triangles",
                "§3.3: to improve performance",
                ratio(ms(DEFAULT), ms(COARSE[0].1)),
                Bound::AtLeast,
                1.0,
            ),
        ];
    }
    vec![
        check(
            "FLIP that is added where casters are those near the viewer, also in the map",
            "§5: distant shadows may be extraneous",
            more(NEAR_ALONE),
            Bound::AtMost,
            0.02,
        ),
        check(
            "volumes of what is near the viewer are this many times faster than those of all triangles",
            "§5: an alternative for complex scenes",
            ratio(ms(DEFAULT), ms(NEAR)),
            Bound::AtLeast,
            1.0,
        ),
        check(
            "the error on the map where far casters are a texture, as a share of that of all triangles",
            "§5: quality shadows in regions where they are vital",
            ratio(error(TEXTURE), error(DEFAULT)),
            Bound::AtMost,
            1.0,
        ),
    ]
}

fn table(title: &str, shots: &[Measured]) -> Table {
    let mut table = Table::new(
        format!("{title}: what volumes are made of"),
        vec![
            Column::left("casters"),
            Column::right("silhouette edges"),
            Column::right("lookups a pixel"),
            Column::right("time"),
            Column::right("map error"),
            Column::right("shadow error"),
            Column::right("FLIP"),
        ],
    );
    for shot in shots {
        table.push(vec![
            shot.setting.name.clone(),
            report::count(shot.mesh_triangles.map(|triangles| triangles / 2)),
            report::figure(shot.lookups()),
            report::time(shot.ms()),
            report::error(shot.map_error()),
            report::error(shot.on_geometry.shadow_err),
            report::figure(shot.on_geometry.flip),
        ]);
    }
    table
}

fn pictures(arena: &Arena, shots: &[Measured]) -> Outcome<PictureRow> {
    let (title, scale) = (&arena.title, display_scale(&arena.exact, 95));
    let mut panels = Vec::new();
    for name in [DEFAULT, COARSE[0].1, COARSE[1].1, BOX, NEAR, NEAR_ALONE, TEXTURE, BRUTE] {
        let Some(shot) = of(shots, name) else { continue };
        panels.extend(shown::panels(title, shot, (&arena.map.exact, shot.nearest_errors()), scale)?);
    }
    let caption = format!(
        "{title}: the plain hybrid with volumes of several casters, against the exact picture of the map"
    );
    Ok(PictureRow { caption, panels })
}

/// A plain hybrid on the CPU with a lookup of one's own.
fn march(arena: &Arena, faces: &[FaceBounds], visibility: &dyn Visibility, samples: u32) -> Outcome<Image> {
    let Setup { medium, lights, model, camera, .. } = &arena.setup;
    let occluders = Occluders { visibility, bounds: arena.bvh.bounds() };
    let march = Hybrid::new(medium, lights, Some(occluders), samples, 0, *model).map_err(Failure::input)?;
    let size @ (width, height) = arena.base.size;
    let pixels = render_rows(size, &|_| (), |x, y| {
        let end = arena.rays.end((y * width + x) as usize, f64::INFINITY);
        let faces: Vec<_> = faces.iter().map(|bounds| bounds.at(x, y)).collect();
        march.airlight(&camera.pixel_ray(x, y, size), end, &faces).airlight.to_array()
    });
    Ok(Image { width, height, pixels })
}

/// Variance shadow maps against plain lookups, at as many samples.
fn variance(arena: &Arena, found: &mut Experiment, section: &mut Section) -> Outcome {
    let moments = |blur: u32, bleed: f32| -> Outcome<Vec<Option<VarianceMap>>> {
        let one = |map: &DepthMap| -> Result<VarianceMap, ShadowMapError> {
            let finite = map.depths().iter().copied().filter(|depth| depth.is_finite());
            let far = finite.fold(1e-3, f32::max);
            VarianceMap::new(map, far)?.with_bleed_reduction(bleed)?.blurred(blur)
        };
        let maps = arena.map.maps.maps.iter().map(|map| map.as_ref().map(one).transpose());
        maps.collect::<Result<_, _>>().map_err(Failure::program)
    };
    let moments = [moments(0, 0.0)?, moments(2, 0.0)?, moments(2, 0.3)?];
    let lookup = MapVisibility::new(&arena.map.maps.maps, Filter::Nearest, Bias::NONE);
    let variances = moments.each_ref().map(|maps| VarianceVisibility::new(maps));
    let named: [(&str, &dyn Visibility); 4] = [
        ("plain lookup", &lookup),
        ("variance", &variances[0]),
        ("variance, blurred by 5 texels", &variances[1]),
        ("variance, blurred by 5 texels, bleeding cut by 0.3", &variances[2]),
    ];
    let mesh = extruded_mesh(&arena.setup, Extruded::Scene)?;
    let (camera, size) = (&arena.setup.camera, arena.base.size);
    let faces: Vec<FaceBounds> = arena
        .setup
        .lights
        .iter()
        .map(|light| FaceBounds::draw(&ShadowVolume::new(&mesh, light), camera, size, 1))
        .collect();
    let mut all: Vec<(String, &dyn Visibility, u32)> = [8, SAMPLES]
        .iter()
        .flat_map(|&n| named.map(|(name, visibility)| (format!("{name}, {n} samples"), visibility, n)))
        .collect();
    let mut images = Vec::new();
    for (_, visibility, samples) in &all {
        images.push(march(arena, &faces, *visibility, *samples)?);
    }
    let times = in_turns(&mut all, |(_, visibility, samples)| {
        let started = std::time::Instant::now();
        march(arena, &faces, *visibility, *samples)?;
        Ok(started.elapsed().as_secs_f64() * 1e3)
    })?;
    let mut table = Table::new(
        format!("{}: variance shadow maps, on the CPU", arena.title),
        vec![
            Column::left("lookup"),
            Column::right("time of the march"),
            Column::right("map error"),
            Column::right("shadow error"),
            Column::right("FLIP"),
        ],
    );
    let mut errors = Vec::new();
    for (((name, ..), image), times) in all.iter().zip(&images).zip(times) {
        let ms = median(&times).unwrap_or(f64::NAN);
        let against = |reference| metrics::compare(image, reference, Some(&arena.unshadowed), None);
        let (on_map, on_geometry) = (against(&arena.map.exact)?, against(&arena.exact)?);
        errors.push(on_geometry.flip);
        table.push(line(name, ms, Some(&on_map), &on_geometry));
        found.rows.push(cpu_row(
            &arena.title,
            &format!("hybrid, plain, {name}"),
            ms,
            Some(&on_map),
            &on_geometry,
        ));
    }
    table.note = Some("Plain hybrids by the CPU; making moments and blurring them, once a map, is no part of the time, and drawing faces, which all have alike, is not either. A variance map is asked as many times as the plain one.".into());
    section.tables.push(table);
    // of the 8 samples, where aliasing shows
    let best = errors.iter().take(4).skip(1).copied().reduce(f64::min);
    found.checks.push(Check::new(
        format!(
            "{}: least FLIP of the variance maps at 8 samples, as a share of that of plain lookups",
            arena.title
        ),
        "§3.4: helps to remove aliasing at boundaries of shadow",
        best.zip(errors.first()).map(|(best, plain)| best / plain),
        Bound::AtMost,
        1.0,
    ));
    Ok(())
}

fn line(name: &str, ms: f64, on_map: Option<&Metrics>, on_geometry: &Metrics) -> Vec<String> {
    vec![
        name.into(),
        report::time(ms),
        report::error(on_map.and_then(|m| m.shadow_err)),
        report::error(on_geometry.shadow_err),
        report::figure(on_geometry.flip),
    ]
}

fn cpu_row(scene: &str, name: &str, ms: f64, on_map: Option<&Metrics>, on_geometry: &Metrics) -> Row {
    let mut row = Row::new(scene, name);
    row.params.insert("backend".into(), "cpu".into());
    row.ms_scatter = Some(ms);
    row.ms_frame = Some(ms);
    row.frames = Some(WARM_FRAMES as u32);
    row.set_errors(on_geometry);
    row.shadow_err_map = on_map.and_then(|m| m.shadow_err);
    row
}

/// A point light whose map is a spot's: what lies outside is lit, as in the paper's fairy scene, or dark.
fn beyond_the_map(
    context: &Context,
    base: Options,
    title: String,
    spot: &Setup,
    found: &mut Experiment,
    section: &mut Section,
) -> Outcome {
    let Some(Light::Spot(light)) = spot.lights.first() else { return Ok(()) };
    let point = PointLight::new(light.position, light.intensity).map_err(Failure::program)?;
    let setup = Setup { lights: vec![Light::Point(point)], ..spot.clone() };
    let tangent = DVec2::splat(f64::from(light.outer).tan());
    let (right, forward) = (light.right.as_dvec3(), light.direction.as_dvec3());
    let projection = Projection::perspective(light.position.as_dvec3(), forward, right, tangent);
    let projection = projection.map_err(Failure::program)?;
    let corners: Vec<_> = setup.scene.meshes.iter().flat_map(Mesh::corners).collect();
    let side = base.map.side;
    let partial = DepthMap::draw(projection, (side, side), &corners).map_err(Failure::program)?;
    let of = |outside| Maps { maps: vec![Some(partial.clone().with_outside(outside))], ms: 0.0 };
    let named = [
        ("six faces all around", None),
        ("one face, lit outside", Some(Arc::new(of(Outside::Lit)))),
        ("one face, dark outside", Some(Arc::new(of(Outside::Dark)))),
    ];
    let options = Options { samples: Some(SAMPLES), hybrid: plain(Extruded::Scene), ..base };
    let refined = Options { hybrid: HybridOptions::default(), ..options };
    let ways = [
        ("plain hybrid", Technique::Hybrid, options),
        ("refined hybrid", Technique::Hybrid, refined),
        ("brute force", Technique::BruteForce, options),
    ];
    let of_map = |(name, own_maps): &(&str, Option<Arc<Maps>>)| {
        ways.map(|(way, technique, options)| {
            let setting = Setting::new(format!("{way}, {name}"), technique, options);
            Setting { own_maps: own_maps.clone(), ..setting }
        })
    };
    let settings: Vec<Setting> = named.iter().flat_map(of_map).collect();
    let mut table = Table::new(
        format!("{title}: what lies outside of a map, on the CPU"),
        vec![
            Column::left("map"),
            Column::right("time"),
            Column::right("error on the map of six faces"),
            Column::right("shadow error"),
            Column::right("FLIP"),
        ],
    );
    // a map of one face for a point light is the CPU's alone
    for shot in Arena::new(&context.references, &*title, setup, base)?.measure(None, &settings)? {
        let name = &shot.setting.name;
        table.push(line(name, shot.ms(), shot.on_map.as_ref(), &shot.on_geometry));
        found.rows.push(cpu_row(&title, name, shot.ms(), shot.on_map.as_ref(), &shot.on_geometry));
    }
    table.note = Some("Errors are against the exact pictures of the light that shines all around and is shadowed all around. The exact traversal takes a point light with six faces alone, so there is no exact picture of one face. The border of a map that is dark outside is a boundary of shadow without a face of the volume: between hybrid and brute force that is the difference.".into());
    section.tables.push(table);
    Ok(())
}
