//! `wyman-fig7`: scenes of several depth complexities, and what the paper offers for those that are too complex.

use ground_truth::{ExactShadows, render_rows};
use hybrid_march::{FaceBounds, ShadowVolume};
use scene::{Interval, Light, LightId, LitIntervals};

use super::counts::for_all_pixels;
use super::equal_error::interpolate;
use super::measure::{self, Arena, Measured, Setting};
use super::references;
use super::shown::{self, clock_note, display_scale, slug};
use super::{Context, Preset, experiment, gpu_or_cpu, wyman_fig7_options};
use crate::failure::Outcome;
use crate::image_file::to_srgb8;
use crate::report::data::{Bound, Check, EqualError, Experiment};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Panel, PanelKind, PictureRow, Plot, Section, Series};
use crate::setups::Source;
use crate::technique::{Extruded, HybridOptions, Options, Technique};
use crate::volumes::extruded_mesh;

/// Share of what shadows change at which techniques are compared.
const TARGET: f64 = 0.01;

/// How many times more samples brute force takes in the paper's Table 1, for pictures as good.
const PAPER_RATIO: f64 = 3.0;

pub(super) const PLAIN: &str = "hybrid, plain";
pub(super) const REFINED: &str = "hybrid, refined";
pub(super) const BRUTE: &str = "brute force";

/// How much is done.
pub(super) struct Plan {
    pub(super) side: u32,
    pub(super) map: u32,
    scenes: &'static [&'static str],
    between: &'static [u32],
    refined: &'static [u32],
    along: &'static [u32],
    /// Scenes of simpler casters, lone objects; and those of casters near the viewer, which surround it.
    pub(super) lone: &'static [&'static str],
    pub(super) around: &'static [&'static str],
}

fn plan(preset: Preset) -> Plan {
    const ALL: &[&str] = &["sphere", "spring", "fairy", "buddha", "yeahright", "canopy", "fence"];
    let (side, map, lone, around) = match preset {
        Preset::Smoke => {
            return Plan {
                side: 64,
                map: 256,
                scenes: &["spring"],
                between: &[12, 50],
                refined: &[12],
                along: &[50, 150],
                lone: &["bunny"],
                around: &[],
            };
        }
        Preset::Quick => (256, 1024, &["bunny"][..], &["sponza"][..]),
        Preset::Standard => (512, 1024, &["spring", "bunny", "yeahright"][..], &["sponza", "fairy"][..]),
        Preset::Paper => (1024, 1024, &["spring", "bunny", "yeahright"][..], &["sponza", "fairy"][..]),
    };
    if preset == Preset::Quick {
        let scenes = &["spring", "fence"];
        return Plan {
            side,
            map,
            scenes,
            between: &[12, 50, 150, 400],
            refined: &[12, 50, 200],
            along: &[50, 150, 400, 1000],
            lone,
            around,
        };
    }
    Plan {
        side,
        map,
        scenes: ALL,
        between: &[3, 6, 12, 25, 50, 100, 200, 400],
        refined: &[3, 6, 12, 25, 50, 100, 200],
        along: &[10, 20, 50, 150, 300, 600, 1200, 2400],
        lone,
        around,
    }
}

/// How complex the shadows of a picture are.
struct Complexity {
    /// Boundaries of shadow on a ray, on average and at most.
    mean: f64,
    most: usize,
    /// Share of pixels on which a face of the shadow volume lies before the surface.
    covered: f64,
}

struct Case {
    arena: Arena,
    complexity: Complexity,
    shots: Vec<Measured>,
}

impl Case {
    /// Settings whose names start with `family`.
    fn family(&self, family: &str) -> impl Iterator<Item = &Measured> {
        self.shots.iter().filter(move |shot| shot.setting.name.starts_with(family))
    }

    /// The value of `x` at which a family reaches the target on the map.
    fn needs(&self, family: &str, x: impl Fn(&Measured) -> f64) -> Option<f64> {
        interpolate(self.family(family).map(|shot| (x(shot), shot.map_error())), TARGET)
    }

    fn lookups(&self, family: &str) -> Option<f64> {
        self.needs(family, Measured::lookups)
    }

    fn samples(&self, family: &str) -> Option<f64> {
        self.needs(family, |shot| f64::from(shot.samples()))
    }

    fn ms(&self, family: &str) -> Option<f64> {
        self.needs(family, Measured::ms)
    }

    fn edges(&self) -> Option<u64> {
        self.shots.iter().find_map(|shot| shot.mesh_triangles).map(|triangles| triangles / 2)
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let plan = Plan { side: context.marched_side(plan.side), ..plan };
    let mut found = experiment(
        context,
        "wyman-fig7",
        "Scenes of several depth complexities, and options for complex ones",
        "Wyman & Ramsey 2008, Figure 7 and sections 3.3 to 5",
    );
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let depth = depth(context);
    let mut cases = Vec::new();
    for id in plan.scenes {
        let Some(source) = source(context, id) else { continue };
        tracing::info!("{}", source.title());
        let setup = source.setup(depth)?;
        let arena = Arena::new(&context.references, source.title(), setup, base(&plan))?;
        cases.push(measure(context, &plan, arena, &mut found, &mut section)?);
    }
    section.tables.push(table(&cases));
    for case in &cases {
        found.checks.extend(checks(case));
        found.equal_error.push(equal_error(case));
        section.plots.push(plot(case));
    }
    wyman_fig7_options::run(context, &plan, depth, &mut found, &mut section)?;
    found.notes.extend(notes(&plan));
    found.notes.push(references::NOTE.into());
    found.notes.extend(clock_note(context));
    section.experiment = found;
    Ok(section)
}

/// Optical depth of the views.
fn depth(context: &Context) -> f32 {
    context.setups.media().find(|(name, _)| *name == "thin").map_or(0.3, |(_, depth)| depth)
}

/// A scene of the folder, or the one that is generated in its stead.
pub(super) fn source(context: &Context, id: &str) -> Option<Source> {
    let all = context.setups.sources().into_iter().chain(context.setups.stand_ins());
    all.into_iter().find(|source| source.entry.id == id)
}

/// What all pictures have in common.
pub(super) fn base(plan: &Plan) -> Options {
    measure::base(plan.side, plan.map)
}

/// A hybrid as the paper has it: faces by pixel, and no boundary looked for between two samples.
pub(super) fn plain(extruded: Extruded) -> HybridOptions {
    HybridOptions { extruded, tile: 1, refine: 0, ..HybridOptions::default() }
}

fn settings(plan: &Plan, base: Options) -> Vec<Setting> {
    let setting = |family: &str, technique, samples, hybrid| {
        let options = Options { samples: Some(samples), hybrid, ..base };
        Setting::new(format!("{family}, {samples} samples"), technique, options)
    };
    let hybrid = Technique::Hybrid;
    let plain = plan.between.iter().map(|&n| setting(PLAIN, hybrid, n, plain(Extruded::Scene)));
    let refined = plan.refined.iter().map(|&n| setting(REFINED, hybrid, n, HybridOptions::default()));
    let brute =
        plan.along.iter().map(|&n| setting(BRUTE, Technique::BruteForce, n, HybridOptions::default()));
    plain.chain(refined).chain(brute).collect()
}

fn measure(
    context: &Context,
    plan: &Plan,
    mut arena: Arena,
    found: &mut Experiment,
    section: &mut Section,
) -> Outcome<Case> {
    let mut shots = arena.measure(context.gpu.as_ref(), &settings(plan, arena.base))?;
    for_all_pixels(&arena, &mut shots)?;
    found.rows.extend(shots.iter().map(|shot| shot.row(&arena.title, arena.triangles())));
    let case = Case { complexity: complexity(&arena)?, arena, shots };
    section.pictures.push(pictures(&case)?);
    Ok(case)
}

/// Counts boundaries on every ray from the exact lit intervals, and pixels with faces.
fn complexity(arena: &Arena) -> Outcome<Complexity> {
    let Arena { setup, bvh, rays, base: Options { size, .. }, .. } = arena;
    let mesh = extruded_mesh(setup, Extruded::Scene)?;
    let bounds: Vec<FaceBounds> = setup
        .lights
        .iter()
        .map(|light| FaceBounds::draw(&ShadowVolume::new(&mesh, light), &setup.camera, *size, 1))
        .collect();
    let shadows = ExactShadows::new(bvh, &setup.lights);
    let counts = render_rows(*size, &|_| (), |x, y| {
        let end = rays.end(y as usize * size.0 as usize + x as usize, f64::INFINITY);
        let ray = setup.camera.pixel_ray(x, y, *size);
        let (mut boundaries, mut covered, mut lit) = (0, false, Vec::new());
        for (index, light) in setup.lights.iter().enumerate() {
            let whole = Interval::new(0.0, end);
            let span = if let Light::Spot(spot) = light { spot.clip(&ray, whole) } else { whole };
            shadows.lit_intervals(&ray, span, LightId(index), &mut lit);
            let inside = |x: f64| x > span.start && x < span.end;
            boundaries +=
                lit.iter().map(|i| usize::from(inside(i.start)) + usize::from(inside(i.end))).sum::<usize>();
            covered |= bounds[index].at(x, y).is_some_and(|faces| faces.start < end);
        }
        (boundaries, covered)
    });
    let pixels = counts.len() as f64;
    Ok(Complexity {
        mean: counts.iter().map(|(boundaries, _)| *boundaries).sum::<usize>() as f64 / pixels,
        most: counts.iter().map(|(boundaries, _)| *boundaries).max().unwrap_or(0),
        covered: counts.iter().filter(|(_, covered)| *covered).count() as f64 / pixels,
    })
}

fn table(cases: &[Case]) -> Table {
    let mut columns = vec![
        Column::left("scene"),
        Column::right("triangles"),
        Column::right("silhouette edges"),
        Column::right("boundaries a ray"),
        Column::right("at most"),
        Column::right("pixels with faces"),
    ];
    for family in ["plain", "refined", "brute"] {
        columns.push(Column::right(format!("{family}: samples for 1 %")));
        columns.push(Column::right("lookups a pixel"));
        columns.push(Column::right("time"));
    }
    columns.push(Column::right("plain: lookups a covered pixel"));
    let mut table = Table::new("Depth complexity, and what 1 % of error on the map takes", columns);
    for case in cases {
        let mut line = vec![
            case.arena.title.clone(),
            report::count(case.arena.triangles()),
            report::count(case.edges()),
            report::figure(case.complexity.mean),
            case.complexity.most.to_string(),
            report::error(case.complexity.covered),
        ];
        for family in [PLAIN, REFINED, BRUTE] {
            line.push(report::figure(case.samples(family)));
            line.push(report::figure(case.lookups(family)));
            line.push(report::time(case.ms(family)));
        }
        line.push(report::figure(case.lookups(PLAIN).map(|n| n / case.complexity.covered)));
        table.push(line);
    }
    table.note = Some("Boundaries of shadow on a view ray are those of the exact lit intervals. Samples, lookups and times are interpolated between the settings measured, to a shadow_err_map of 1 %; a dash where none reaches it. Lookups hold bisections and the questions at the ends of a ray.".into());
    table
}

fn checks(case: &Case) -> Vec<Check> {
    let ratio = |of: &dyn Fn(&str) -> Option<f64>, family| Some(of(BRUTE)? / of(family)?);
    let check = |claim: String, paper: &str, measured, bar| {
        Check::new(format!("{}: {claim}", case.arena.title), paper, measured, Bound::AtLeast, bar)
    };
    vec![
        check(
            "brute force takes this many times the samples of the plain hybrid for 1 %".into(),
            "§4: 150 against 50 for pictures without aliasing",
            ratio(&|family| case.samples(family), PLAIN),
            PAPER_RATIO,
        ),
        check(
            "brute force takes this many times the lookups of the refined hybrid for 1 %".into(),
            "§4: 150 against 50, here with bisections",
            ratio(&|family| case.lookups(family), REFINED),
            PAPER_RATIO,
        ),
        check(
            "the plain hybrid is this many times faster than brute force at 1 %".into(),
            "§5: at worst it is a march with the cost of shadow volumes",
            ratio(&|family| case.ms(family), PLAIN),
            1.0,
        ),
        check(
            "the refined hybrid is this many times faster than brute force at 1 %".into(),
            "§4: 3 to 8 times",
            ratio(&|family| case.ms(family), REFINED),
            PAPER_RATIO,
        ),
    ]
}

fn equal_error(case: &Case) -> EqualError {
    let march = case.ms(BRUTE);
    let families = [PLAIN, REFINED];
    EqualError {
        scene: case.arena.title.clone(),
        metric: "shadow_err_map".into(),
        target: TARGET,
        ms: [PLAIN, REFINED, BRUTE].map(|family| (family.to_owned(), case.ms(family))).into(),
        speedup_over_brute_force: families
            .map(|family| (family.to_owned(), march.zip(case.ms(family)).map(|(march, ms)| march / ms)))
            .into(),
    }
}

fn plot(case: &Case) -> Plot {
    let series = |family: &str| Series {
        label: family.into(),
        points: case.family(family).map(|shot| (shot.lookups(), shot.map_error())).collect(),
        joined: true,
    };
    Plot {
        file: format!("{}.svg", slug(&case.arena.title)),
        title: format!("{}: error on the map against lookups", case.arena.title),
        caption: format!(
            "{} boundaries a ray on average, faces on {} of the pixels.",
            report::figure(case.complexity.mean),
            report::error(case.complexity.covered)
        ),
        x: Axis::new("lookups a pixel", ""),
        y: Axis::new("shadow error on the map", ""),
        series: [PLAIN, REFINED, BRUTE].map(series).into(),
    }
}

fn pictures(case: &Case) -> Outcome<PictureRow> {
    let Case { arena, complexity, shots } = case;
    let title = &arena.title;
    let (id, scale) = (slug(title), display_scale(&arena.exact, 95));
    let exact = Panel::new(
        format!("{id}-exact.png"),
        format!("exact, {} on the CPU", report::time(arena.exact_ms)),
        format!("Airlight of {title}, exact"),
        &to_srgb8(&arena.exact, scale),
        PanelKind::Plain,
    )?;
    let mut panels = vec![exact];
    for (family, samples) in [(PLAIN, 50), (REFINED, 12), (BRUTE, 150)] {
        let name = format!("{family}, {samples} samples");
        let Some(shot) = shots.iter().find(|shot| shot.setting.name == name) else { continue };
        panels.extend(shown::panels(title, shot, (&arena.exact, &shot.on_geometry), scale)?);
    }
    let caption = format!(
        "{title}: {} boundaries of shadow a ray, {} at most",
        report::figure(complexity.mean),
        complexity.most
    );
    Ok(PictureRow { caption, panels })
}

fn notes(plan: &Plan) -> Vec<String> {
    vec![
        format!("Pictures are {0}×{0}, airlight only, in the thin medium; maps are {1}². Silhouettes are found anew in every frame; maps and view rays are no part of any time.", plan.side, plan.map),
        "The plain hybrid is the paper's: exact faces by pixel, samples of equal length between them, each step lit or not as its middle is. The refined one keeps faces for blocks of 8×8 pixels, a texel wider, and bisects each boundary six times.".into(),
        "Faces are those of the triangles, while visibility is the map's: a texel that reaches over a face is cut off there, which the exact picture of the same map has. So the plain hybrid's error on the map has a floor that more samples do not lower; against the exact picture of the geometry it may be the better.".into(),
    ]
}
