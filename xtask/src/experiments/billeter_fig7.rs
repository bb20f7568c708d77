//! `billeter-fig7`: the light volume against marching with 150 and 400 samples, and against marches of equal error.
//!
//! All techniques of a scene read maps of one size and take turns. A march is measured in both meanings of the map,
//! each against what is exact in its own, and the faster of the two is what the light volume is compared with.

use std::collections::BTreeMap;

use super::billeter_bench::{Division, fastest, linear, time_ratio};
use super::equal_error::interpolate;
use super::measure::{Arena, Measured, Rebuild, Setting};
use super::shown::{self, clock_note, display_scale, slug};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::image_file::Image;
use crate::maps::{MapOptions, MapSurface};
use crate::report::data::{Bound, Check, EqualError};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, PictureRow, Plot, Section, Series};
use crate::scene_args::Setup;
use crate::setups::LightKind;
use crate::technique::{Options, Technique};

/// Map errors at which times are compared, and how many times faster the light volume is to be there.
const TARGETS: [(f64, Option<f64>); 2] = [(0.01, None), (0.002, Some(6.0))];

/// Samples of the paper's marches, and how many times faster the light volume is to be than the second.
const SAMPLES: [u32; 2] = [150, 400];
const OVER_400: f64 = 4.0;

/// Thresholds of the quadtrees as shares of the scene's diagonal.
const SHARES: [f32; 2] = [1e-2, 3e-3];

#[derive(Clone, Copy)]
struct Plan {
    side: u32,
    map: u32,
    /// Samples of the marches that look steps up, and of those that look the linear surface up.
    samples: &'static [u32],
    linear: &'static [u32],
    kinds: &'static [LightKind],
}

fn plan(context: &Context) -> Plan {
    const SPOT: &[LightKind] = &[LightKind::Spot];
    const ALL: &[LightKind] = &[LightKind::Spot, LightKind::Point, LightKind::Directional];
    let all =
        Plan { side: 1024, map: 512, samples: &[50, 150, 400, 1300], linear: &[150, 400, 800], kinds: ALL };
    let few = Plan { side: 64, map: 128, samples: &[25, 150, 400], linear: &[150], kinds: SPOT };
    let plan = match context.preset {
        Preset::Smoke => few,
        Preset::Quick => {
            Plan { side: 256, samples: &[25, 50, 150, 400, 1200], linear: &[150, 400], kinds: SPOT, ..all }
        }
        Preset::Standard | Preset::Paper => all,
    };
    // marches of the CPU take some hundred times as long
    if context.gpu.is_some() { Plan { side: context.marched_side(plan.side), ..plan } } else { few }
}

/// A scene under a light.
struct Case {
    title: String,
    kind: LightKind,
    triangles: u64,
    results: Vec<Measured>,
    exact_on_map: Image,
}

fn is_volume(measured: &&Measured) -> bool {
    measured.setting.technique == Technique::LightVolume
}

impl Case {
    fn marches(&self, surface: MapSurface) -> impl Iterator<Item = &Measured> {
        self.results.iter().filter(move |measured| {
            let Setting { technique, options, .. } = &measured.setting;
            *technique == Technique::BruteForce && options.map.surface == surface
        })
    }

    /// The faster march of so many samples.
    fn march(&self, samples: u32) -> Option<&Measured> {
        let both = self.marches(MapSurface::Step).chain(self.marches(MapSurface::Linear));
        fastest(both.filter(|measured| measured.samples() == samples))
    }

    /// Time and samples of the march that reaches an error first, and the meaning of its map.
    fn at_error(&self, target: f64) -> Option<(f64, f64, MapSurface)> {
        let of = |surface| {
            let at = |x: fn(&Measured) -> f64| {
                interpolate(self.marches(surface).map(|m| (x(m), m.map_error())), target)
            };
            Some((at(Measured::ms)?, at(|m| f64::from(m.samples()))?, surface))
        };
        let both = [MapSurface::Step, MapSurface::Linear].into_iter().filter_map(of);
        both.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The fastest light volume with at most this error.
    fn volume(&self, target: f64) -> Option<&Measured> {
        fastest(self.results.iter().filter(is_volume).filter(|measured| measured.map_error() <= target))
    }

    fn exact(&self) -> Option<&Measured> {
        self.results.iter().find(|measured| measured.setting.technique == Technique::ExactShadowMap)
    }

    /// Times faster than the march of equal error.
    fn speedup(&self, target: f64) -> Option<f64> {
        Some(self.at_error(target)?.0 / self.volume(target)?.ms())
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context);
    let mut found = experiment(
        context,
        "billeter-fig7",
        "The light volume against ray marching",
        "Billeter, Sintorn & Assarsson 2010, Figure 7",
    );
    found.adapter = gpu_or_cpu(context);
    let mut cases: Vec<Case> = Vec::new();
    for &kind in plan.kinds {
        for (title, setup) in halls(context, kind)? {
            cases.push(measure(context, &plan, format!("{title}, {} light", kind.name()), kind, setup)?);
        }
    }
    let mut section = Section { tables: vec![speedups(&cases), needed(&cases)], ..Section::default() };
    for case in &cases {
        found.rows.extend(case.results.iter().map(|result| {
            let mut row = result.row(&case.title, case.triangles);
            row.params.insert("light".into(), case.kind.name().into());
            row.paper =
                paper_fps(case, result).map(|fps| [("fps".to_owned(), fps.into())].into_iter().collect());
            row
        }));
        found.equal_error.extend(TARGETS.iter().map(|(target, _)| equal_error(case, *target)));
        found.checks.extend(checks(case));
        section.plots.push(plot(case, plan.map));
        section.pictures.push(pictures(case, plan.map)?);
    }
    found.notes = notes(context, &plan);
    section.experiment = found;
    Ok(section)
}

/// Sponza, where its file is there, and the columned hall, under a kind of light.
fn halls(context: &Context, kind: LightKind) -> Outcome<Vec<(String, Setup)>> {
    let mut halls = Vec::new();
    for source in super::map_traversal::sources(context) {
        let setup = source.setup_lit(super::wyman_bench::thin(context), kind)?;
        halls.extend(setup.map(|setup| (source.title(), setup)));
    }
    Ok(halls)
}

fn measure(context: &Context, plan: &Plan, title: String, kind: LightKind, setup: Setup) -> Outcome<Case> {
    tracing::info!("{title}");
    let base = linear(plan.side, plan.map);
    let mut arena = Arena::new(&context.references, title, setup, base)?;
    let march = |surface: MapSurface, samples: &'static [u32]| {
        samples.iter().map(move |&samples| {
            let map = MapOptions { surface, ..base.map };
            let options = Options { samples: Some(samples), map, ..base };
            let name = format!("march, {samples} samples, {} map", surface.name());
            Setting::new(name, Technique::BruteForce, options)
        })
    };
    let exact = Setting {
        rebuild: Rebuild::Both,
        ..Setting::new("exact traversal", Technique::ExactShadowMap, base)
    };
    let volumes = [
        Division::Indexed,
        Division::SixVertices,
        Division::Distance(SHARES[0]),
        Division::Distance(SHARES[1]),
    ];
    let mut settings = vec![exact];
    settings.extend(volumes.iter().map(|division| division.setting(&arena, base)));
    settings.extend(march(MapSurface::Linear, plan.linear).chain(march(MapSurface::Step, plan.samples)));
    let results = arena.measure(context.gpu.as_ref(), &settings)?;
    let triangles = arena.triangles();
    Ok(Case { title: arena.title, kind, triangles, results, exact_on_map: arena.map.exact })
}

/// The paper's frame rate beside a row, for its own scene and light.
fn paper_fps(case: &Case, result: &Measured) -> Option<u32> {
    let own = case.kind == LightKind::Spot && case.title.starts_with("sponza");
    let march = result.setting.technique == Technique::BruteForce;
    match result.samples() {
        _ if !own => None,
        150 if march => Some(25),
        400 if march => Some(10),
        _ => is_volume(&result).then_some(96),
    }
}

fn equal_error(case: &Case, target: f64) -> EqualError {
    let march = case.at_error(target).map(|(ms, ..)| ms);
    let volume = case.volume(target).map(Measured::ms);
    let exact = case.exact().map(Measured::ms);
    let ms = [("light-volume", volume), ("exact-shadow-map", exact), ("brute-force", march)];
    let times = |ms: Option<f64>| march.zip(ms).map(|(march, ms)| march / ms);
    let speedup = [("light-volume", times(volume)), ("exact-shadow-map", times(exact))];
    let named = |figures: &[(&str, Option<f64>)]| {
        figures.iter().map(|(name, figure)| ((*name).to_owned(), *figure)).collect::<BTreeMap<_, _>>()
    };
    EqualError {
        scene: case.title.clone(),
        metric: "shadow_err_map".into(),
        target,
        ms: named(&ms),
        speedup_over_brute_force: named(&speedup),
    }
}

fn checks(case: &Case) -> Vec<Check> {
    let mut checks = Vec::new();
    for (target, bar) in TARGETS {
        let Some(bar) = bar else { continue };
        let claim = format!(
            "{}: light volume in times less time than the faster march of {} % map error",
            case.title,
            100.0 * target
        );
        let paper = "Figure 7: 96 FPS against 10 at equal quality";
        let mut check = Check::new(claim, paper, case.speedup(target), Bound::AtLeast, bar);
        let one = report::ratio(case.speedup(0.01));
        check.note = case.at_error(target).map(|(_, samples, surface)| {
            let name = case.volume(target).map_or("none", |volume| &volume.setting.name);
            format!(
                "{name}; the march needs {samples:.0} samples of the {} map; at 1 % it is {one}",
                surface.name()
            )
        });
        checks.push(check);
    }
    for (samples, bar) in SAMPLES.into_iter().zip([None, Some(OVER_400)]) {
        let Some(bar) = bar else { continue };
        let claim = format!(
            "{}: light volume in times less time than the faster march of {samples} samples",
            case.title
        );
        let ratio = time_ratio(case.march(samples), case.volume(0.002));
        let mut check = Check::new(claim, "Figure 7: 96 FPS against 10", ratio, Bound::AtLeast, bar);
        check.note = case.march(samples).map(|march| {
            let rate = report::ratio(time_ratio(Some(march), case.exact()));
            format!(
                "whose map error is {}; the exact traversal is {rate} faster than it",
                report::error(march.map_error())
            )
        });
        checks.push(check);
    }
    let claim = format!("{}: samples of a march with 1 % map error", case.title);
    let samples = case.at_error(0.01).map(|(_, samples, _)| samples);
    let mut check = Check::new(claim, "§6: about 400 for equal quality", samples, Bound::AtLeast, 400.0);
    check.note = case.at_error(0.002).map(|(_, samples, _)| format!("{samples:.0} for 0.2 %"));
    checks.push(check);
    checks
}

fn speedups(cases: &[Case]) -> Table {
    let mut table = Table::new(
        "The light volume against marches",
        vec![
            Column::left("scene"),
            Column::left("light volume"),
            Column::right("its time"),
            Column::right("map error"),
            Column::right("over 150 samples"),
            Column::right("over 400 samples"),
            Column::right("over the march at 1 %"),
            Column::right("over the march at 0.2 %"),
            Column::right("exact traversal"),
            Column::right("over 400 samples"),
            Column::right("at 0.2 %"),
        ],
    );
    for case in cases {
        let (volume, exact) = (case.volume(0.002), case.exact());
        let at = |target: f64| case.at_error(target).map(|(ms, ..)| ms);
        table.push(vec![
            case.title.clone(),
            volume.map_or_else(|| report::MISSING.into(), |volume| volume.setting.name.clone()),
            report::time(volume.map(Measured::ms)),
            report::error(volume.map(Measured::map_error)),
            report::ratio(time_ratio(case.march(SAMPLES[0]), volume)),
            report::ratio(time_ratio(case.march(SAMPLES[1]), volume)),
            report::ratio(case.speedup(0.01)),
            report::ratio(case.speedup(0.002)),
            report::time(exact.map(Measured::ms)),
            report::ratio(time_ratio(case.march(SAMPLES[1]), exact)),
            report::ratio(at(0.002).zip(exact).map(|(march, exact)| march / exact.ms())),
        ]);
    }
    table.note = Some("The paper: 96 FPS against 25 with 150 samples and 10 with 400, that is 3.8 and 9.6 times. The light volume is the fastest with at most 0.2 % map error, made anew in every frame; each march is the faster of those that look steps up and those that look the linear surface up.".into());
    table
}

/// What marches need.
fn needed(cases: &[Case]) -> Table {
    let mut table = Table::new(
        "What a march needs",
        vec![
            Column::left("scene"),
            Column::right("map error of 150 samples"),
            Column::right("of 400 samples"),
            Column::right("samples for 1 %"),
            Column::right("time"),
            Column::right("samples for 0.2 %"),
            Column::right("time"),
            Column::left("meaning of the map"),
        ],
    );
    for case in cases {
        let error = |samples| report::error(case.march(samples).map(Measured::map_error));
        let at = TARGETS.map(|(target, _)| case.at_error(target));
        let samples = |i: usize| report::figure(at[i].map(|(_, samples, _)| samples));
        let ms = |i: usize| report::time(at[i].map(|(ms, ..)| ms));
        let surface = at[1].or(at[0]).map_or(report::MISSING, |(.., surface)| surface.name());
        table.push(vec![
            case.title.clone(),
            error(SAMPLES[0]),
            error(SAMPLES[1]),
            samples(0),
            ms(0),
            samples(1),
            ms(1),
            surface.into(),
        ]);
    }
    table.note = Some("Interpolated in logarithms between the sample counts measured; a dash where none reaches the error. The paper says that about 400 samples are needed for equal quality.".into());
    table
}

fn plot(case: &Case, map: u32) -> Plot {
    let point = |measured: &Measured| (measured.ms(), measured.map_error());
    let march = |surface: MapSurface| Series {
        label: format!("march, {} map", surface.name()),
        points: case.marches(surface).map(point).collect(),
        joined: true,
    };
    let volumes = case.results.iter().filter(is_volume).chain(case.exact()).map(|measured| Series {
        label: measured.setting.name.clone(),
        points: vec![point(measured)],
        joined: false,
    });
    Plot {
        file: format!("{}.svg", slug(&case.title)),
        title: format!("{}: error on the map against time", case.title),
        caption: format!(
            "Map {map}². Errors of light volumes and of the traversal are rounding, and the quadtree's threshold."
        ),
        x: Axis::new("time of the airlight", "ms"),
        y: Axis::new("shadow error on the map", ""),
        series: [march(MapSurface::Linear), march(MapSurface::Step)].into_iter().chain(volumes).collect(),
    }
}

fn pictures(case: &Case, map: u32) -> Outcome<PictureRow> {
    let exact = &case.exact_on_map;
    let marches = SAMPLES.iter().filter_map(|samples| {
        case.marches(MapSurface::Linear).find(|measured| measured.samples() == *samples)
    });
    let mut panels = Vec::new();
    for measured in marches.chain(case.volume(0.002)) {
        let errors = (exact, measured.nearest_errors());
        panels.extend(shown::panels(&case.title, measured, errors, display_scale(exact, 95))?);
    }
    Ok(PictureRow {
        caption: format!("{}, map {map}², airlight only; errors on the map", case.title),
        panels,
    })
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0} and maps {1}², airlight only, in the thin medium; the paper's are 1024×1024 and 512², with surfaces.", plan.side, plan.map),
        "Each march is an honest one: the same compute path and airlight form as the exact traversal, clipped to scene depth, light extent and to what occluders can shadow, one lookup a step, adjoining lit steps one evaluation. The paper's was not optimised, as it says. A linear map is looked up in four texels and compared with the exact picture of the linear surface; a step map in one, and compared with that of its steps, which is cheaper.".into(),
        "Map errors are shares of what shadows change. Light volumes and the traversal's pyramid are made anew in every frame; times with a light that stands still are in the rows.".into(),
        "The claim about samples holds where even 1 % takes 400; the paper names no error.".into(),
    ];
    notes.extend(clock_note(context));
    notes
}
