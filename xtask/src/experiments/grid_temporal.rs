//! `grid-temporal`: what accumulation over frames gains where all is still, and how long what is past shows where something moves.

use froxel_grid::{Froxels, SharedGrid, Temporal};
use glam::Vec3;
use gpu_backend::GpuBvh;
use scene::{Aabb, AirlightModel, Bvh, Camera, Light, Material, Medium, PointLight, Scene};

use super::grid_scenes::{adapter, clock_note, device};
use super::grid_town::boxes;
use super::{Context, Preset, experiment};
use crate::failure::{Failure, Outcome};
use crate::froxels::{Casters, Engine, Eye, World, hierarchy};
use crate::report::data::{Bound, Check, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Plot, Section, Series};
use crate::view_rays::ViewRays;

/// Where froxels end; units: m.
const RANGE: f32 = 12.0;

/// Side of a voxel; units: m.
const VOXEL: f32 = 0.1;

/// A ghost below this share of the change is gone.
const GONE: f64 = 0.01;

/// Frames that settle a history, and those whose mean is what a new state comes to.
const SETTLED: u32 = 48;

/// Frames for which a ghost is followed.
const FOLLOWED: usize = 112;

/// What is there to be seen, and where from.
struct State {
    camera: Camera,
    rays: ViewRays,
    lights: Vec<Light>,
    medium: Medium,
    bvh: Bvh,
    hierarchy: Option<GpuBvh>,
}

/// A box over a floor, within a frame of posts that keeps the scene's box as it is.
#[derive(Debug, Clone, Copy)]
struct Things {
    /// Middle of the box that casts the shadow; units: m.
    block: Vec3,
    /// The lamp; units: m.
    lamp: Vec3,
    /// The eye; units: m.
    eye: Vec3,
}

const BEFORE: Things = Things {
    block: Vec3::new(0.0, 1.6, 0.0),
    lamp: Vec3::new(0.6, 3.2, -0.6),
    eye: Vec3::new(0.5, 1.4, 5.0),
};

impl State {
    fn new(context: &Context, things: Things, size: (u32, u32)) -> Outcome<Self> {
        let around = |middle: Vec3, half: Vec3| Aabb { min: middle - half, max: middle + half };
        let mut all = vec![
            around(Vec3::new(0.0, -0.1, 0.0), Vec3::new(3.0, 0.1, 3.0)),
            around(things.block, Vec3::new(0.6, 0.2, 0.6)),
        ];
        all.extend([-2.9, 2.9].map(|x| around(Vec3::new(x, 1.75, -2.9), Vec3::new(0.1, 1.75, 0.1))));
        let scene =
            Scene { meshes: vec![boxes(&all)?], materials: vec![Material::default()], ..Scene::default() };
        let bvh = Bvh::build(&scene).map_err(Failure::input)?;
        let hierarchy = device(context).map(|gpu| hierarchy(gpu, &scene)).transpose()?;
        let target = Vec3::new(0.0, 1.2, 0.0);
        let camera = Camera::look_at(things.eye, target, Vec3::Y, 0.9).map_err(Failure::program)?;
        let lamp = PointLight::new(things.lamp, Vec3::splat(20.0)).map_err(Failure::program)?;
        Ok(Self {
            rays: ViewRays::trace(&camera, &bvh, size).up_to(RANGE),
            camera,
            lights: vec![Light::Point(lamp)],
            medium: Medium::homogeneous([0.06; 3], [0.0; 3]).map_err(Failure::program)?,
            bvh,
            hierarchy,
        })
    }
}

/// What happens to a scene that had settled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    LampMoves,
    /// Within the casters' box, so that nothing tells of it but its shadow.
    BlockMoves,
    /// The same, and the fog is told to forget.
    BlockMovesTold,
    /// To another place, and the fog is told to forget.
    CameraCut,
    /// A little, so that most of what was is found again.
    CameraMoves,
}

impl Event {
    const ALL: [Self; 5] =
        [Self::LampMoves, Self::BlockMoves, Self::BlockMovesTold, Self::CameraCut, Self::CameraMoves];

    fn name(self) -> &'static str {
        match self {
            Self::LampMoves => "the lamp moves",
            Self::BlockMoves => "a caster moves inside of the casters' box",
            Self::BlockMovesTold => "a caster moves, and the fog is told",
            Self::CameraCut => "the camera cuts",
            Self::CameraMoves => "the camera moves by 5 cm",
        }
    }

    fn after(self) -> Things {
        match self {
            Self::LampMoves => Things { lamp: BEFORE.lamp + Vec3::new(-1.2, 0.0, 0.4), ..BEFORE },
            Self::BlockMoves | Self::BlockMovesTold => {
                Things { block: BEFORE.block + Vec3::new(-0.8, 0.1, 0.3), ..BEFORE }
            }
            Self::CameraCut => Things { eye: Vec3::new(-4.0, 1.0, 3.0), ..BEFORE },
            Self::CameraMoves => Things { eye: BEFORE.eye + Vec3::new(0.05, 0.0, 0.0), ..BEFORE },
        }
    }

    fn is_told(self) -> bool {
        matches!(self, Self::BlockMovesTold | Self::CameraCut)
    }
}

/// A technique with a history.
struct Runner<'g> {
    name: String,
    keeps_changed: bool,
    engine: Engine<'g>,
    size: (u32, u32),
    not_finite: u64,
}

type Picture = Vec<Vec3>;

impl Runner<'_> {
    fn frame(&mut self, state: &State) -> Outcome<Picture> {
        let casters = Some(Casters { bvh: &state.bvh, on_gpu: state.hierarchy.as_ref() });
        let world =
            World { medium: &state.medium, lights: &state.lights, model: AirlightModel::Sun, casters };
        self.engine.frame(&world, &[Eye { camera: &state.camera, ends: &state.rays.ends }], self.size)?;
        self.not_finite += self.engine.counts()?.not_finite;
        let picture = self.engine.picture(0)?;
        self.not_finite +=
            picture.iter().filter(|pixel| !(pixel.is_finite() && pixel.min_element() >= 0.0)).count() as u64;
        Ok(picture)
    }

    /// Forgets, and renders frames until the history is as long as it gets; returns the last.
    fn settle(&mut self, state: &State) -> Outcome<Picture> {
        self.engine.forget();
        let mut last = Picture::new();
        for _ in 0..SETTLED {
            last = self.frame(state)?;
        }
        Ok(last)
    }
}

/// What became of one event.
struct Ghost {
    technique: String,
    keeps_changed: bool,
    event: Event,
    /// Share of the change that still shows, frame by frame.
    decay: Vec<f64>,
}

impl Ghost {
    /// Frames until it is gone for good; `None` if it never is.
    fn frames(&self) -> Option<usize> {
        let last = self.decay.iter().rposition(|share| share.abs() >= GONE);
        let frames = last.map_or(0, |last| last + 1);
        (frames < self.decay.len()).then_some(frames)
    }
}

/// What accumulation gains where all is still.
struct Still {
    technique: String,
    /// Difference of two settled frames as a share of the picture.
    flicker: f64,
    /// The same of two frames that only one frame each went into.
    alone: f64,
    not_finite: u64,
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let size = match context.preset {
        Preset::Smoke => (8, 8),
        Preset::Quick => (40, 40),
        Preset::Standard => (128, 128),
        Preset::Paper => (512, 512),
    };
    let title = "Accumulation over frames, and its ghosts";
    let source = "Stojanovic et al. 2023, §3.1.3; Hillaire 2015";
    let mut found = experiment(context, "grid-temporal", title, source);
    found.adapter = adapter(context);
    // on a picture of a few froxels the grid's size would be all the work
    let voxel = if context.preset == Preset::Smoke { 4.0 * VOXEL } else { VOXEL };
    let before = State::new(context, BEFORE, size)?;
    let after = Event::ALL.map(|event| State::new(context, event.after(), size));
    let after: Vec<State> = after.into_iter().collect::<Outcome<_>>()?;
    let (mut still, mut ghosts) = (Vec::new(), Vec::new());
    for (name, grid) in [("froxels", None), ("marked grid", Some(SharedGrid::marked(voxel)))] {
        for keeps_changed in [false, true] {
            let temporal = Some(Temporal { keeps_changed, ..Temporal::default() });
            let froxels = Froxels { temporal, tile: 4, ..Froxels::new(RANGE) };
            let froxels = grid.map_or(froxels, |grid| froxels.with_grid(grid));
            let engine = Engine::new(device(context), froxels)?;
            let mut runner = Runner { name: name.into(), keeps_changed, engine, size, not_finite: 0 };
            tracing::info!("{name}, history {}", if keeps_changed { "kept" } else { "forgotten" });
            if !keeps_changed {
                still.push(stillness(&mut runner, &before)?);
            }
            for (event, after) in Event::ALL.into_iter().zip(&after) {
                ghosts.push(follow(&mut runner, &before, after, event)?);
            }
            let bad = runner.not_finite;
            if let Some(still) = still.last_mut() {
                still.not_finite += bad;
            }
        }
    }
    found.rows = ghosts.iter().map(row).collect();
    found.checks = checks(&still, &ghosts);
    found.notes = notes(size);
    found.notes.extend(clock_note(context));
    let tables = vec![still_table(&still), ghost_table(&ghosts)];
    Ok(Section { tables, plots: vec![plot(&ghosts)], experiment: found, ..Section::default() })
}

fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.as_dvec3().dot(b.as_dvec3())).sum()
}

fn minus(a: &[Vec3], b: &[Vec3]) -> Picture {
    a.iter().zip(b).map(|(a, b)| *a - *b).collect()
}

fn stillness(runner: &mut Runner<'_>, state: &State) -> Outcome<Still> {
    runner.engine.forget();
    let first = runner.frame(state)?;
    // the jitter of a second frame alone: what it adds to the mean of two
    let second = runner.frame(state)?;
    let one: Picture = second.iter().zip(&first).map(|(mean, first)| 2.0 * *mean - *first).collect();
    let settled = runner.settle(state)?;
    let next = runner.frame(state)?;
    let share = |a: &[Vec3], b: &[Vec3]| {
        let difference = minus(a, b);
        (dot(&difference, &difference) / dot(b, b)).sqrt()
    };
    Ok(Still {
        technique: runner.name.clone(),
        flicker: share(&next, &settled),
        alone: share(&one, &first),
        not_finite: 0,
    })
}

fn follow(runner: &mut Runner<'_>, before: &State, after: &State, event: Event) -> Outcome<Ghost> {
    runner.settle(after)?;
    let mut target = vec![Vec3::ZERO; after.rays.ends.len()];
    for _ in 0..SETTLED {
        let frame = runner.frame(after)?;
        target.iter_mut().zip(&frame).for_each(|(sum, value)| *sum += *value / SETTLED as f32);
    }
    let old = runner.settle(before)?;
    let change = minus(&old, &target);
    let whole = dot(&change, &change);
    if event.is_told() {
        runner.engine.forget();
    }
    let mut decay = Vec::new();
    for _ in 0..FOLLOWED {
        // flicker has no share in the change, so that what is left of it is the ghost
        decay.push(dot(&minus(&runner.frame(after)?, &target), &change) / whole);
    }
    Ok(Ghost { technique: runner.name.clone(), keeps_changed: runner.keeps_changed, event, decay })
}

fn history(keeps_changed: bool) -> &'static str {
    if keeps_changed { "kept" } else { "forgotten" }
}

fn row(ghost: &Ghost) -> Row {
    let mut row = Row::new(ghost.event.name(), &ghost.technique);
    row.params.insert("history".into(), history(ghost.keeps_changed).into());
    row.params.insert("frames_until_gone".into(), ghost.frames().into());
    row.params.insert("first_frame".into(), ghost.decay.first().copied().into());
    row
}

fn still_table(all: &[Still]) -> Table {
    let columns = vec![
        Column::left("technique"),
        Column::right("flicker of single frames"),
        Column::right("flicker of the settled history"),
    ];
    let mut table = Table::new("Where all is still", columns);
    for still in all {
        table.push(vec![still.technique.clone(), report::error(still.alone), report::error(still.flicker)]);
    }
    table
}

fn ghost_table(all: &[Ghost]) -> Table {
    let mut columns = vec![
        Column::left("event"),
        Column::left("technique"),
        Column::left("history of what changed"),
        Column::right("frames until gone"),
    ];
    let at = [0, 1, 8, 16, 32, 64];
    columns.extend(at.map(|frame| Column::right(format!("left in frame {frame}"))));
    let mut table = Table::new("What is left of the change", columns);
    for ghost in all {
        let frames = ghost.frames().map_or_else(|| format!("more than {FOLLOWED}"), |n| n.to_string());
        let mut cells = vec![
            ghost.event.name().to_owned(),
            ghost.technique.clone(),
            history(ghost.keeps_changed).to_owned(),
            frames,
        ];
        cells.extend(at.map(|frame| report::error(ghost.decay.get(frame).copied())));
        table.push(cells);
    }
    table
}

fn plot(all: &[Ghost]) -> Plot {
    let of = all.iter().filter(|ghost| ghost.technique == "froxels" && ghost.decay.iter().any(|d| *d > GONE));
    Plot {
        file: "decay.svg".into(),
        title: "What is left of a change".into(),
        caption: "Share of the change that still shows, by frames since; froxel reference".into(),
        x: Axis::new("frame", ""),
        y: Axis::new("left", ""),
        series: of
            .map(|ghost| Series {
                label: format!("{}, history {}", ghost.event.name(), history(ghost.keeps_changed)),
                points: ghost.decay.iter().enumerate().map(|(i, share)| (i as f64 + 1.0, *share)).collect(),
                joined: true,
            })
            .collect(),
    }
}

fn checks(still: &[Still], ghosts: &[Ghost]) -> Vec<Check> {
    let paper = "§3.1.1: no issues regarding temporal inconsistencies";
    let frames = |event: Event, keeps: bool| {
        let of = ghosts.iter().filter(move |ghost| ghost.event == event && ghost.keeps_changed == keeps);
        of.map(|ghost| ghost.frames().map_or(f64::INFINITY, |frames| frames as f64)).reduce(f64::max)
    };
    // (1 − 1/16)ⁿ falls below a hundredth after 72 frames
    let kept = (GONE.ln() / (1.0 - 1.0 / f64::from(Temporal::default().frames)).ln()).ceil();
    let check = |event: Event, keeps: bool, bar: f64| {
        let claim = format!(
            "{}, history {}: frames until less than {} of the change shows",
            event.name(),
            history(keeps),
            report::error(GONE)
        );
        Check::new(claim, paper, frames(event, keeps), Bound::AtMost, bar)
    };
    let mut checks = vec![
        check(Event::LampMoves, false, 0.0),
        check(Event::LampMoves, true, kept),
        check(Event::BlockMoves, false, kept),
        check(Event::BlockMovesTold, false, 0.0),
        check(Event::CameraCut, false, 0.0),
        check(Event::CameraMoves, false, kept),
    ];
    let bad: u64 = still.iter().map(|still| still.not_finite).sum();
    let claim = "froxels and pixels of all frames that are negative or not finite";
    checks.push(Check::new(claim, "impossible by construction", Some(bad as f64), Bound::AtMost, 0.0));
    let calmer = still.iter().map(|still| still.flicker / still.alone).reduce(f64::max);
    let claim = "flicker of the settled history over that of single frames";
    checks.push(Check::new(claim, "§3.1.3: reduces noise and aliasing", calmer, Bound::AtMost, 1.0));
    checks
}

fn notes((width, height): (u32, u32)) -> Vec<String> {
    let frames = Temporal::default().frames;
    vec![
        format!("A box over a floor under a lamp, {width}×{height} pixels, a history of {frames} frames. Nothing is timed."),
        format!("A ghost is the difference from what the picture comes to, as far as it points towards what was before: its share of the change. What it comes to is the mean of {SETTLED} frames after {SETTLED}. A single frame's own jitter differs from that, which is a bias of the first frames and no ghost where it is below {}.", report::error(GONE)),
        "By default the history is forgotten where lights, medium or the casters' box change; a caster that moves within that box must be told, or its shadow fades as a kept history does.".into(),
    ]
}
