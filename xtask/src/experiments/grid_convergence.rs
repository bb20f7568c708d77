//! `grid-convergence`: froxels against the exact picture as they shrink, and against the converged march where the medium varies.

use froxel_grid::Froxels;
use scene::{Aabb, Bvh, Density, DensityGrid, Medium};

use super::grid_bench::exponent;
use super::grid_scenes::{adapter, clock_note, device};
use super::measure::{WARM_FRAMES, in_turns, picture};
use super::wyman_bench::{generated, thin};
use super::{Context, Preset, experiment};
use crate::airlight::Stage;
use crate::failure::{Failure, Outcome};
use crate::froxels::{self, Casters, Engine, Eye, World, hierarchy};
use crate::image_file::Image;
use crate::maps::Maps;
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Plot, Section, Series};
use crate::scene_args::Setup;
use crate::technique::{FroxelOptions, Options, Technique};
use crate::view_rays::ViewRays;

/// Pixels along the side of a froxel and slices, each half of the ones before.
const LEVELS: &[(u32, u32)] = &[(16, 16), (8, 32), (4, 64), (2, 128), (1, 256)];

/// A medium and what its pictures are compared with.
struct Case {
    medium: &'static str,
    against: String,
    setup: Setup,
    reference: Image,
    open: Image,
    levels: Vec<Level>,
}

/// Froxels of one size.
struct Level {
    froxels: Froxels,
    /// Units: ms.
    times: Vec<f64>,
    rays: u64,
    not_finite: u64,
    errors: Metrics,
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let (side, levels, samples) = match context.preset {
        Preset::Smoke => (32, &LEVELS[..3], 256),
        Preset::Quick => (64, LEVELS, 1024),
        Preset::Standard => (192, LEVELS, 2048),
        Preset::Paper => (512, LEVELS, 4096),
    };
    let title = "Froxels against the exact picture as they shrink";
    let mut found =
        experiment(context, "grid-convergence", title, "Hillaire 2015; Stojanovic et al. 2023, §4");
    found.adapter = adapter(context);
    let source = generated(context, "sponza")?;
    let scene = source.title();
    let setup = source.setup(thin(context))?;
    let bvh = Bvh::build(&setup.scene).map_err(Failure::input)?;
    let mut cases = Vec::new();
    for (medium, density) in media(&bvh.bounds())? {
        tracing::info!("{scene}, {medium}");
        let setup = Setup { medium: Medium { density, ..setup.medium.clone() }, ..setup.clone() };
        cases.push(measure(context, medium, setup, &bvh, side, levels, samples)?);
    }
    found.rows = cases.iter().flat_map(|case| rows(&scene, case)).collect();
    found.checks = cases.iter().flat_map(checks).collect();
    found.checks.push(finite(&cases));
    found.notes = vec![
        format!("{scene} under its lamp, {side}×{side} pixels, airlight only, up to the range of the froxels. Froxels are halved along all three axes at once. Orders are slopes of the error over the side of a froxel in logarithms: how many halvings of the error a halving of the froxels brings."),
        "Froxels have one value each, and shadows have edges: an edge crosses a share of the froxels that falls as they shrink, so that first order is the most there can be in shadow.".into(),
    ];
    found.notes.extend(clock_note(context));
    let tables = vec![table(&scene, &cases)];
    Ok(Section { tables, plots: vec![plot(&scene, &cases)], experiment: found, ..Section::default() })
}

/// The homogeneous medium, one that thins out upwards, and one of clouds on a grid.
fn media(bounds: &Aabb) -> Outcome<Vec<(&'static str, Option<Density>)>> {
    let size = bounds.max - bounds.min;
    let height = Density::height(bounds.min.y + 0.05 * size.y, 0.25 * size.y).map_err(Failure::program)?;
    let cells = [24_u32, 12, 16];
    let mut values = Vec::new();
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let [x, y, z] = [x, y, z].map(|i| i as f32);
                let wave = (0.9 * x).sin() * (1.1 * y + 0.5).cos() + (0.7 * z + 0.3 * x).sin();
                values.push((1.0 + 0.5 * wave).max(0.0));
            }
        }
    }
    let grid = DensityGrid::new(cells, *bounds, values).map_err(Failure::program)?;
    Ok(vec![
        ("homogeneous", None),
        ("thinning out upwards", Some(height)),
        ("clouds", Some(Density::Grid(grid))),
    ])
}

fn measure(
    context: &Context,
    medium: &'static str,
    setup: Setup,
    bvh: &Bvh,
    side: u32,
    levels: &[(u32, u32)],
    samples: u32,
) -> Outcome<Case> {
    let (size, range) = ((side, side), froxels::range(&setup, bvh));
    let rays = ViewRays::trace(&setup.camera, bvh, size).up_to(range);
    let options = Options {
        airlight_only: true,
        max_distance: range.into(),
        froxels: FroxelOptions { range: Some(range), ..FroxelOptions::default() },
        ..Options::new(size)
    };
    let none = Maps::none(setup.lights.len());
    let run = |technique, options: &Options| -> Outcome<Image> {
        let stage =
            Stage { setup: &setup, bvh, options, rays: &rays, maps: &none, further: &[], tick: &|_| () };
        Ok(picture(size, &stage.run(technique)?))
    };
    let march = |samples| Options { samples: Some(samples), ..options };
    let (technique, best) = match medium {
        "homogeneous" => (Technique::Exact, options),
        _ => (Technique::BruteForce, march(samples)),
    };
    let reference = run(technique, &best)?;
    let open = run(technique, &Options { shadows_in_medium: false, ..best })?;
    let against = if technique == Technique::Exact {
        "the exact picture".to_owned()
    } else {
        let coarser = run(technique, &march(samples / 2))?;
        let change = metrics::compare(&coarser, &reference, Some(&open), None)?;
        format!(
            "a march of {samples} steps, from which one of half as many differs by {} ({} of what shadows change)",
            report::error(change.rel_rmse),
            report::error(change.shadow_err)
        )
    };
    let gpu = device(context);
    let hierarchy = gpu.map(|gpu| hierarchy(gpu, &setup.scene)).transpose()?;
    let casters = Some(Casters { bvh, on_gpu: hierarchy.as_ref() });
    let world = World { medium: &setup.medium, lights: &setup.lights, model: setup.model, casters };
    let eyes = [Eye { camera: &setup.camera, ends: &rays.ends }];
    let mut engines = Vec::new();
    for &(tile, slices) in levels {
        let froxels = Froxels { tile, slices, ..Froxels::new(range) };
        let mut engine = Engine::new(gpu, froxels)?;
        engine.frame(&world, &eyes, size)?;
        engines.push((froxels, engine));
    }
    let times = in_turns(&mut engines, |(_, engine)| Ok(engine.frame(&world, &eyes, size)?.ms))?;
    let level = |((froxels, engine), times): ((Froxels, Engine<'_>), Vec<f64>)| {
        let pixels = engine.picture(0)?.into_iter().map(Into::into).collect();
        let image = Image { width: side, height: side, pixels };
        let errors = metrics::compare(&image, &reference, Some(&open), None)?;
        let counts = engine.counts()?;
        Ok(Level { froxels, times, rays: counts.rays(), not_finite: counts.not_finite, errors })
    };
    let levels = engines.into_iter().zip(times).map(level).collect::<Outcome<_>>()?;
    Ok(Case {
        medium,
        against,
        setup: setup.clone(),
        reference: reference.clone(),
        open: open.clone(),
        levels,
    })
}

fn rows<'a>(scene: &'a str, case: &'a Case) -> impl Iterator<Item = Row> + 'a {
    case.levels.iter().map(move |level| {
        let mut row = Row::new(format!("{scene}, {}", case.medium), "froxels");
        row.triangles = Some(case.setup.scene.triangle_count() as u64);
        let ms = crate::median::median(&level.times);
        (row.ms_scatter, row.ms_frame) = (ms, ms);
        (row.ms_min, row.ms_max) = (level.times.first().copied(), level.times.last().copied());
        row.frames = Some(WARM_FRAMES as u32);
        row.set_errors(&level.errors);
        row.rays = Some(level.rays);
        row.params.insert("tile".into(), level.froxels.tile.into());
        row.params.insert("slices".into(), level.froxels.slices.into());
        row
    })
}

fn rmse(level: &Level) -> f64 {
    level.errors.rel_rmse
}

fn shadow(level: &Level) -> f64 {
    level.errors.shadow_err.unwrap_or(f64::NAN)
}

/// An error by its name.
type Named = (&'static str, fn(&Level) -> f64);

const ERRORS: [Named; 2] = [("relative RMSE", rmse), ("shadow error", shadow)];

/// The order of an error in the side of a froxel.
fn order(case: &Case, error: fn(&Level) -> f64) -> Option<f64> {
    exponent(case.levels.iter().map(|level| (level.froxels.tile.into(), error(level))))
}

fn checks(case: &Case) -> Vec<Check> {
    ERRORS
        .into_iter()
        .map(|(name, error)| {
            let falls = |pair: &[Level]| error(&pair[1]) < error(&pair[0]);
            let not = case.levels.windows(2).filter(|pair| !falls(pair)).count();
            let claim = format!("{}: refinements at which the {name} does not fall", case.medium);
            let paper = "§4: close to what can be achieved with path tracing";
            let mut check = Check::new(claim, paper, Some(not as f64), Bound::AtMost, 0.0);
            let order = report::figure(order(case, error));
            let each: Vec<String> = case.levels.iter().map(|level| report::error(error(level))).collect();
            check.note = Some(format!("against {}; {}; order {order}", case.against, each.join(", ")));
            check
        })
        .collect()
}

fn finite(cases: &[Case]) -> Check {
    let levels = || cases.iter().flat_map(|case| &case.levels);
    let bad: u64 = levels().map(|level| level.not_finite + level.errors.nan).sum();
    let dark = |image: &Image| image.pixels.iter().flatten().all(|value| *value == 0.0);
    let claim = "froxels and pixels that are negative or not finite";
    let mut check = Check::new(claim, "impossible by construction", Some(bad as f64), Bound::AtMost, 0.0);
    let empty = cases.iter().filter(|case| dark(&case.reference) || dark(&case.open)).count();
    check.note = (empty > 0).then(|| format!("{empty} references are black"));
    check
}

fn table(scene: &str, cases: &[Case]) -> Table {
    let mut columns = vec![Column::right("froxel"), Column::right("slices")];
    for case in cases {
        columns.push(Column::right(format!("{}: relative RMSE", case.medium)));
        columns.push(Column::right("shadow error"));
        columns.push(Column::right("time"));
    }
    let mut table = Table::new(format!("{scene}: error by the size of froxels"), columns);
    let levels = cases.first().map_or(0, |case| case.levels.len());
    for index in 0..levels {
        let mut cells = Vec::new();
        for level in cases.iter().filter_map(|case| case.levels.get(index)) {
            if cells.is_empty() {
                cells = vec![format!("{} px", level.froxels.tile), level.froxels.slices.to_string()];
            }
            cells.push(report::error(rmse(level)));
            cells.push(report::error(shadow(level)));
            cells.push(report::time(crate::median::median(&level.times)));
        }
        table.push(cells);
    }
    let mut cells = vec!["order".to_owned(), String::new()];
    for case in cases {
        cells.extend([report::figure(order(case, rmse)), report::figure(order(case, shadow)), String::new()]);
    }
    table.push(cells);
    table
}

fn plot(scene: &str, cases: &[Case]) -> Plot {
    let series = cases.iter().flat_map(|case| {
        ERRORS.map(|(name, error)| Series {
            label: format!("{}: {name}", case.medium),
            points: case.levels.iter().map(|level| (level.froxels.tile.into(), error(level))).collect(),
            joined: true,
        })
    });
    Plot {
        file: "convergence.svg".into(),
        title: format!("{scene}: error by the size of froxels"),
        caption: "Error of the froxel reference against the exact picture or the converged march".into(),
        x: Axis::new("side of a froxel", "pixels"),
        y: Axis::new("error", ""),
        series: series.collect(),
    }
}
