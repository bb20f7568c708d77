//! What the paper offers for complex scenes, each with its artifact: simpler occluders, casters near the viewer alone,
//! shadows as a texture, variance shadow maps, and lights that shine beyond their map.

use glam::DVec2;
use ground_truth::render_rows;
use hybrid_march::{FaceBounds, Hybrid, Occluders, ShadowVolume, near_viewer};
use scene::{Bvh, Light, Mesh, PointLight, Visibility};
use shadowmap::{
    Bias, DepthMap, Filter, MapVisibility, Outside, Projection, ShadowMapError, VarianceMap,
    VarianceVisibility,
};

use super::Context;
use super::equal_error::median;
use super::shots::{self, Setting, Shots, Subject, display_scale, slug};
use super::wyman_fig7::{BRUTE, Plan, base, plain, source};
use crate::airlight::Stage;
use crate::failure::{Failure, Outcome};
use crate::image_file::Image;
use crate::maps::Maps;
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check, Experiment, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, PictureRow, Section};
use crate::scene_args::Setup;
use crate::setups::LightKind;
use crate::technique::{Extruded, HybridOptions, Options, Technique};
use crate::view_rays::ViewRays;
use crate::volumes::extruded_mesh;

/// Samples of every march here, as many as the paper has between faces.
const SAMPLES: u32 = 50;

/// Optical depth of what counts as near the viewer.
const NEAR_DEPTH: f32 = 1.5;

/// Optical depth of the view: thick, since that is where the paper drops what is far.
const DEPTH: f32 = 3.0;

/// Frames after which a median counts.
const WARM_FRAMES: usize = 5;

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
            casters(context, plan, kind, &title, &setup, found, section)?;
        }
    }
    // a scene around the viewer, where there is one: its map has a border inside the picture
    if let Some(source) = plan.around.first().or(plan.lone.first()).and_then(|id| source(context, id))
        && let Some(setup) = source.setup_lit(depth, LightKind::Spot)?
    {
        let title = format!("{}, spot light", source.title());
        tracing::info!("{title}: variance shadow map, beyond the map");
        let side = (plan.side / 2).max(32);
        Marches::new(plan, side, &title, &setup)?.variance(found, section)?;
        let title = format!("{}, point light", source.title());
        beyond_the_map(plan, side, &title, &setup, found, section)?;
        found.notes.push(format!("Variance shadow maps and what lies outside of a map are measured on the CPU, in pictures of {side}×{side}."));
    }
    found.notes.push(format!("Options are measured at {SAMPLES} samples in a view of optical depth {DEPTH}; near the viewer is what reaches within optical depth {NEAR_DEPTH} of the camera. \"Whole map\": volumes are those of the near casters, while the map, and the reference, have all. \"Also in the map\": the map is drawn with the near casters alone, and the errors on the map are still those against the map of all, so they hold what the far casters' missing shadows weigh."));
    Ok(())
}

fn casters(
    context: &Context,
    plan: &Plan,
    kind: Kind,
    title: &str,
    setup: &Setup,
    found: &mut Experiment,
    section: &mut Section,
) -> Outcome {
    let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
    let base = base(plan);
    let maps = Maps::draw(setup, &base.map)?;
    let radius = NEAR_DEPTH / setup.medium.coefficients.sigma_t()[0];
    let near = Maps::draw(&only_near(setup, radius)?, &base.map)?;
    let hybrid = |name: &str, hybrid, maps| Setting {
        name: name.to_owned(),
        technique: Technique::Hybrid,
        options: Options { samples: Some(SAMPLES), hybrid, ..base },
        maps,
    };
    let mut settings = Vec::new();
    let refined = |extruded| HybridOptions { extruded, ..HybridOptions::default() };
    let mut both = |name: &str, extruded, maps| {
        settings.push(hybrid(name, plain(extruded), maps));
        settings.push(hybrid(&format!("{name}, refined"), refined(extruded), maps));
    };
    both(DEFAULT, Extruded::Scene, &maps);
    if kind == Kind::Simpler {
        for (cells, name) in COARSE {
            both(name, Extruded::Coarse(cells), &maps);
        }
        both(BOX, Extruded::BoundingBox, &maps);
    } else {
        both(NEAR, Extruded::NearViewer(radius), &maps);
        both(NEAR_ALONE, Extruded::NearViewer(radius), &near);
        both(TEXTURE, Extruded::RestAsTexture(radius), &maps);
    }
    settings.push(Setting {
        name: BRUTE.into(),
        technique: Technique::BruteForce,
        options: Options { samples: Some(SAMPLES), ..base },
        maps: &maps,
    });
    let subject = Subject { title, setup, bvh: &bvh, side: plan.side, maps: &maps };
    let shots = shots::take(context, &subject, &base, &settings)?;
    found.rows.extend(shots.shots.iter().map(|shot| shot.row(&subject)));
    found.checks.extend(checks(title, kind, &shots));
    section.tables.push(table(title, &shots));
    section.pictures.push(pictures(title, &shots)?);
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

fn checks(title: &str, kind: Kind, shots: &Shots) -> Vec<Check> {
    let error = |name: &str| Some(shots.of(name)?.map_error());
    let flip = |name: &str| Some(shots.of(name)?.on_map.flip);
    let ms = |name: &str| Some(shots.of(name)?.ms());
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

fn table(title: &str, shots: &Shots) -> Table {
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
    for shot in &shots.shots {
        table.push(vec![
            shot.name.clone(),
            report::count(shot.edges),
            report::figure(shot.lookups),
            report::time(shot.ms()),
            report::error(shot.map_error()),
            report::error(shot.geometry_error()),
            report::figure(shot.on_geometry.flip),
        ]);
    }
    table
}

fn pictures(title: &str, shots: &Shots) -> Outcome<PictureRow> {
    let (id, scale) = (slug(title), display_scale(&shots.exact, 95));
    let mut panels = Vec::new();
    for name in [DEFAULT, COARSE[0].1, COARSE[1].1, BOX, NEAR, NEAR_ALONE, TEXTURE, BRUTE] {
        let Some(shot) = shots.of(name) else { continue };
        let alt = format!("Airlight of {title}");
        panels.push(shot.panel(&id, &alt, &shot.image, scale, &shot.on_map)?);
        panels.push(shot.error_panel(&id, &shot.image, &shots.exact_on_map)?);
    }
    let caption = format!(
        "{title}: the plain hybrid with volumes of several casters, against the exact picture of the map"
    );
    Ok(PictureRow { caption, panels })
}

/// Plain hybrids on the CPU with a lookup of one's own, timed in turns.
struct Marches<'a> {
    title: &'a str,
    setup: &'a Setup,
    bvh: Bvh,
    base: Options,
    maps: Maps,
    rays: ViewRays,
    exact: Image,
    on_map: Image,
    open: Image,
}

impl<'a> Marches<'a> {
    fn new(plan: &Plan, side: u32, title: &'a str, setup: &'a Setup) -> Outcome<Self> {
        let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
        let base = Options { size: (side, side), ..base(plan) };
        let maps = Maps::draw(setup, &base.map)?;
        let rays = ViewRays::trace(&setup.camera, &bvh, base.size);
        let open = Options { shadows_in_medium: false, ..base };
        let none = Maps::none(setup.lights.len());
        let picture = |options: &Options, maps: &Maps, technique| -> Outcome<Image> {
            let stage = Stage { setup, bvh: &bvh, options, rays: &rays, maps, tick: &|_| () };
            Ok(shots::image(side, shots::narrow(&stage.run(technique)?)))
        };
        let exact = picture(&base, &maps, Technique::Exact)?;
        let on_map = picture(&base, &maps, Technique::ExactShadowMap)?;
        let open = picture(&open, &none, Technique::Exact)?;
        Ok(Self { title, setup, base, rays, exact, on_map, open, bvh, maps })
    }

    fn march(&self, faces: &[FaceBounds], visibility: &dyn Visibility, samples: u32) -> Outcome<Image> {
        let Setup { medium, lights, model, camera, .. } = self.setup;
        let occluders = Occluders { visibility, bounds: self.bvh.bounds() };
        let march =
            Hybrid::new(medium, lights, Some(occluders), samples, 0, *model).map_err(Failure::input)?;
        let size = self.base.size;
        let pixels = render_rows(size, &|_| (), |x, y| {
            let end = self.rays.end((y * size.0 + x) as usize, f64::INFINITY);
            let faces: Vec<_> = faces.iter().map(|bounds| bounds.at(x, y)).collect();
            march.airlight(&camera.pixel_ray(x, y, size), end, &faces).airlight.to_array()
        });
        Ok(shots::image(size.0, pixels))
    }

    /// Variance shadow maps against plain lookups, at as many samples.
    fn variance(&self, found: &mut Experiment, section: &mut Section) -> Outcome {
        let moments = |blur: u32, bleed: f32| -> Outcome<Vec<Option<VarianceMap>>> {
            let one = |map: &DepthMap| -> Result<VarianceMap, ShadowMapError> {
                let finite = map.depths().iter().copied().filter(|depth| depth.is_finite());
                let far = finite.fold(1e-3, f32::max);
                VarianceMap::new(map, far)?.with_bleed_reduction(bleed)?.blurred(blur)
            };
            let maps = self.maps.maps.iter().map(|map| map.as_ref().map(one).transpose());
            maps.collect::<Result<_, _>>().map_err(Failure::program)
        };
        let moments = [moments(0, 0.0)?, moments(2, 0.0)?, moments(2, 0.3)?];
        let lookup = MapVisibility::new(&self.maps.maps, Filter::Nearest, Bias::NONE);
        let variances = moments.each_ref().map(|maps| VarianceVisibility::new(maps));
        let named: [(&str, &dyn Visibility); 4] = [
            ("plain lookup", &lookup),
            ("variance", &variances[0]),
            ("variance, blurred by 5 texels", &variances[1]),
            ("variance, blurred by 5 texels, bleeding cut by 0.3", &variances[2]),
        ];
        let mesh = extruded_mesh(self.setup, Extruded::Scene)?;
        let (camera, size) = (&self.setup.camera, self.base.size);
        let faces: Vec<FaceBounds> = self
            .setup
            .lights
            .iter()
            .map(|light| FaceBounds::draw(&ShadowVolume::new(&mesh, light), camera, size, 1))
            .collect();
        let all: Vec<(String, &dyn Visibility, u32)> = [8, SAMPLES]
            .iter()
            .flat_map(|&n| named.map(|(name, visibility)| (format!("{name}, {n} samples"), visibility, n)))
            .collect();
        let mut images = Vec::new();
        for (_, visibility, samples) in &all {
            images.push(self.march(&faces, *visibility, *samples)?);
        }
        let mut times = vec![Vec::new(); all.len()];
        for _ in 0..WARM_FRAMES {
            for ((_, visibility, samples), times) in all.iter().zip(&mut times) {
                let started = std::time::Instant::now();
                self.march(&faces, *visibility, *samples)?;
                times.push(started.elapsed().as_secs_f64() * 1e3);
            }
        }
        let mut table = Table::new(
            format!("{}: variance shadow maps, on the CPU", self.title),
            vec![
                Column::left("lookup"),
                Column::right("time of the march"),
                Column::right("map error"),
                Column::right("shadow error"),
                Column::right("FLIP"),
            ],
        );
        let mut errors = Vec::new();
        for (((name, ..), image), mut times) in all.iter().zip(&images).zip(times) {
            times.sort_by(f64::total_cmp);
            let ms = median(&times).unwrap_or(f64::NAN);
            let [on_map, on_geometry] = self.compare(image)?;
            errors.push(on_geometry.flip);
            table.push(line(name, ms, Some(&on_map), &on_geometry));
            found.rows.push(cpu_row(
                self.title,
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
                self.title
            ),
            "§3.4: helps to remove aliasing at boundaries of shadow",
            best.zip(errors.first()).map(|(best, plain)| best / plain),
            Bound::AtMost,
            1.0,
        ));
        Ok(())
    }

    fn compare(&self, image: &Image) -> Outcome<[Metrics; 2]> {
        let against = |reference| metrics::compare(image, reference, Some(&self.open), None);
        Ok([against(&self.on_map)?, against(&self.exact)?])
    }
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
    plan: &Plan,
    side: u32,
    title: &str,
    spot: &Setup,
    found: &mut Experiment,
    section: &mut Section,
) -> Outcome {
    let Some(Light::Spot(light)) = spot.lights.first() else { return Ok(()) };
    let point = PointLight::new(light.position, light.intensity).map_err(Failure::program)?;
    let setup = Setup { lights: vec![Light::Point(point)], ..spot.clone() };
    let marches = Marches::new(plan, side, title, &setup)?;
    let tangent = DVec2::splat(f64::from(light.outer).tan());
    let (right, forward) = (light.right.as_dvec3(), light.direction.as_dvec3());
    let projection = Projection::perspective(light.position.as_dvec3(), forward, right, tangent);
    let projection = projection.map_err(Failure::program)?;
    let corners: Vec<_> = setup.scene.meshes.iter().flat_map(Mesh::corners).collect();
    let partial = DepthMap::draw(projection, (plan.map, plan.map), &corners).map_err(Failure::program)?;
    let of = |outside| Maps { maps: vec![Some(partial.clone().with_outside(outside))], ms: 0.0 };
    let named = [
        ("six faces all around", marches.maps.clone()),
        ("one face, lit outside", of(Outside::Lit)),
        ("one face, dark outside", of(Outside::Dark)),
    ];
    let options = Options { samples: Some(SAMPLES), hybrid: plain(Extruded::Scene), ..marches.base };
    let refined = Options { hybrid: HybridOptions::default(), ..options };
    let brute = Technique::BruteForce;
    let hybrid = Technique::Hybrid;
    let ways = [
        ("plain hybrid", hybrid, &options),
        ("refined hybrid", hybrid, &refined),
        ("brute force", brute, &options),
    ];
    let all: Vec<(String, Stage<'_>, Technique)> = named
        .iter()
        .flat_map(|(name, maps)| {
            ways.map(|(way, technique, options)| {
                let stage = Stage {
                    setup: &setup,
                    bvh: &marches.bvh,
                    options,
                    rays: &marches.rays,
                    maps,
                    tick: &|_| (),
                };
                (format!("{way}, {name}"), stage, technique)
            })
        })
        .collect();
    let mut times = vec![Vec::new(); all.len()];
    let mut images = Vec::new();
    for round in 0..=WARM_FRAMES {
        for ((_, stage, technique), times) in all.iter().zip(&mut times) {
            let airlight = stage.run(*technique)?;
            if round == 0 {
                images.push(shots::image(side, shots::narrow(&airlight)));
            } else {
                times.push(airlight.ms);
            }
        }
    }
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
    for (((name, ..), image), mut times) in all.iter().zip(&images).zip(times) {
        times.sort_by(f64::total_cmp);
        let ms = median(&times).unwrap_or(f64::NAN);
        let [on_map, on_geometry] = marches.compare(image)?;
        table.push(line(name, ms, Some(&on_map), &on_geometry));
        found.rows.push(cpu_row(title, name, ms, Some(&on_map), &on_geometry));
    }
    table.note = Some("Errors are against the exact pictures of the light that shines all around and is shadowed all around. The exact traversal takes a point light with six faces alone, so there is no exact picture of one face. The border of a map that is dark outside is a boundary of shadow without a face of the volume: between hybrid and brute force that is the difference.".into());
    section.tables.push(table);
    Ok(())
}
