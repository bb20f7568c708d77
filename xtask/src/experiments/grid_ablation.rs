//! `grid-ablation`: what each choice of the shared grid is worth, and more lights than a mask has bits.

use froxel_grid::{GridReads, MaskWidth, Near, SharedGrid, Update};
use glam::Vec3;
use scene::{Light, PointLight};

use super::grid_bench::{Bench, Cast, Contender, Found, frames_note};
use super::grid_scenes::{SPONZA, Scale, adapter, clock_note, device, scene_notes, voxel};
use super::grid_stand::Stand;
use super::{Context, Preset, experiment};
use crate::failure::{Failure, Outcome};
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Section};
use crate::viewers::scattered;

/// Side of a voxel; units: m.
const VOXEL: f32 = 0.25;

/// Slices of the paper's frustum.
const SLICES: u32 = 43;

/// Numbers of lamps beyond the paper's eight.
const LAMPS: [usize; 2] = [9, 16];

/// How far a lamp hangs above a viewer's eyes; units: m.
const HANGS: f32 = 1.0;

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let mut scale = Scale::many(context);
    let viewers = match context.preset {
        Preset::Smoke | Preset::Quick => 2,
        Preset::Standard | Preset::Paper => 8,
    };
    scale.viewers = &[];
    let voxel = voxel(context, VOXEL);
    let title = "What each choice is worth";
    let mut found = experiment(
        context,
        "grid-ablation",
        title,
        "Stojanovic et al. 2023, §3.1.1, §3.1.2, §3.1.3 and §5.2",
    );
    found.adapter = adapter(context);
    let mut stand = SPONZA.stand(context, scale, viewers, 1)?;
    let cast = scale.cast(stand.range);
    let choices = measure(context, &stand, choices(cast, voxel), viewers)?;
    found.rows.extend(choices.iter().map(|found| found.row(&stand)));
    found.checks.extend(checks(&choices));
    let mut tables = vec![table(&format!("{viewers} viewers, voxels of {voxel} m"), &choices)];
    for lamps in LAMPS {
        hang(&mut stand, lamps)?;
        let all = measure(context, &stand, widths(cast, voxel), viewers)?;
        found.rows.extend(all.iter().map(|found| {
            let mut row = found.row(&stand);
            row.params.insert("lights".into(), lamps.into());
            row
        }));
        found.checks.extend(light_checks(lamps, &all));
        tables.push(table(&format!("{lamps} lamps, {viewers} viewers, voxels of {voxel} m"), &all));
    }
    found.notes = vec![
        scale.note(),
        frames_note(),
        "The finer grid of §5.2 has voxels four times smaller in bricks, in the place of the frustums. Where there are more lights than a mask has bits, a voxel keeps those that are strongest at its centre; the others count as dark, in pairs of a froxel and a light.".into(),
        format!("Lamps beyond the set-up's hang {HANGS} m above further viewers' places, as strong as the set-up's for each."),
    ];
    found.notes.extend(scene_notes(context));
    found.notes.extend(clock_note(context));
    Ok(Section { tables, experiment: found, ..Section::default() })
}

fn measure(
    context: &Context,
    stand: &Stand,
    contenders: Vec<Contender>,
    viewers: usize,
) -> Outcome<Vec<Found>> {
    Bench::new(device(context), contenders)?.measure(stand, viewers)
}

/// Everything that may be chosen, each beside the marked grid with the paper's frustum.
fn choices(cast: Cast, voxel: f32) -> Vec<Contender> {
    let frustum = |side: u32| {
        let name = format!("frustums of {} pixels", 8 * side);
        cast.near(&name, voxel, Near::Frustum { side, slices: SLICES })
    };
    let grid = |name: &str, grid: SharedGrid| Contender::new(name, cast.0.with_grid(grid));
    let (paper, marked) = (SharedGrid::paper(voxel), SharedGrid::marked(voxel));
    vec![
        cast.reference(),
        frustum(1),
        frustum(2),
        frustum(4),
        frustum(8),
        cast.near("no frustums", voxel, Near::Grid),
        cast.near("finer grid in the frustums' place", voxel, Near::FineGrid { ratio: 4, slices: SLICES }),
        grid("trilinear reads", SharedGrid { reads: GridReads::Trilinear, ..marked }),
        grid("marked in turns", SharedGrid { update: Update::Marked { alternate: true }, ..marked }),
        grid("all in sight", SharedGrid { update: Update::InFrustums { alternate: false }, ..paper }),
        grid("all in sight in turns, the paper's", paper),
        Contender { name: "in bricks".into(), ..cast.bricks(voxel) },
    ]
}

/// Masks of growing width.
fn widths(cast: Cast, voxel: f32) -> Vec<Contender> {
    let grid = |lights: MaskWidth| {
        let grid = SharedGrid { lights, ..SharedGrid::marked(voxel) };
        Contender::new(format!("masks of {} lights", lights.bits()), cast.0.with_grid(grid))
    };
    let mut all = vec![cast.reference()];
    all.extend([MaskWidth::Eight, MaskWidth::Sixteen, MaskWidth::ThirtyTwo].map(grid));
    all
}

/// Lights the scene by `count` lamps: its own, and others above places where viewers could stand.
fn hang(stand: &mut Stand, count: usize) -> Outcome {
    let own: Vec<Light> =
        stand.setup.lights.iter().filter(|light| matches!(light, Light::Point(_))).take(1).cloned().collect();
    let intensity = own.iter().find_map(|light| match light {
        Light::Point(light) => Some(light.intensity),
        _ => None,
    });
    let intensity = intensity.unwrap_or(Vec3::splat(100.0));
    let places = scattered(&stand.setup.cameras(), &stand.bvh, 2 * count);
    let lamp = |place: &scene::Camera| {
        PointLight::new(place.position + HANGS * Vec3::Y, intensity)
            .map(Light::Point)
            .map_err(Failure::program)
    };
    let others = places.iter().rev().take(count - own.len()).map(lamp).collect::<Outcome<Vec<_>>>()?;
    stand.setup.lights = own.into_iter().chain(others).collect();
    let cameras = stand.viewers.iter().map(|viewer| viewer.camera.clone()).collect();
    stand.look(cameras, 1)
}

fn table(title: &str, all: &[Found]) -> Table {
    let columns = vec![
        Column::left("choice"),
        Column::right("time"),
        Column::right("over the reference"),
        Column::right("shadow error"),
        Column::right("FLIP"),
        Column::right("rays of frustums"),
        Column::right("rays of the grid"),
        Column::right("bricks"),
        Column::right("dropped"),
        Column::right("memory"),
    ];
    let mut table = Table::new(title, columns);
    let Some(reference) = all.first() else { return table };
    for found in all {
        // the reference's errors are from the exact picture, which is another question
        let errors = found.errors.filter(|_| found.contender.voxel_size().is_some());
        let some = |count: u64| if count > 0 { report::count(count) } else { String::new() };
        table.push(vec![
            found.contender.name.clone(),
            report::time(found.ms()),
            report::ratio(found.ms() / reference.ms()),
            report::error(errors.and_then(|errors| errors.shadow_err)),
            report::figure(errors.map(|errors| errors.flip)),
            some(found.counts.near_rays),
            some(found.counts.grid_rays),
            some(found.counts.bricks),
            some(found.counts.dropped),
            report::bytes(found.bytes),
        ]);
    }
    table.note = Some(
        "Errors are against the reference; its own, against the exact picture, stand among the measurements."
            .into(),
    );
    table.without_empty_columns()
}

fn named<'a>(all: &'a [Found], name: &str) -> Option<&'a Found> {
    all.iter().find(|found| found.contender.name == name)
}

fn checks(all: &[Found]) -> Vec<Check> {
    let shadow = |name: &str| named(all, name)?.errors?.shadow_err;
    let ratio = |a: &str, b: &str| Some(shadow(a)? / shadow(b)?);
    let rays = |a: &str, b: &str| Some(named(all, a)?.rays() / named(all, b)?.rays());
    vec![
        Check::new(
            "shadow error of frustums of 32 pixels over that of 16",
            "§3.1.2: beyond 16 pixels quality degrades noticeably",
            ratio("frustums of 32 pixels", "frustums of 16 pixels"),
            Bound::AtLeast,
            1.0,
        ),
        Check::new(
            "shadow error of frustums of 16 pixels over that without frustums",
            "§3.1.2: frustums capture shadows next to the viewer",
            ratio("frustums of 16 pixels", "no frustums"),
            Bound::AtMost,
            1.0,
        ),
        Check::new(
            "shadow rays of voxels in turns over those of all, in sight",
            "§3.1.1: turns halve the rays",
            rays("all in sight in turns, the paper's", "all in sight"),
            Bound::AtMost,
            0.75,
        ),
        Check::new(
            "shadow error of the finer grid over that of frustums",
            "§5.2: it improves the quality",
            ratio("finer grid in the frustums' place", "frustums of 16 pixels"),
            Bound::AtMost,
            1.0,
        ),
    ]
}

fn light_checks(lamps: usize, all: &[Found]) -> Vec<Check> {
    let paper = "§3.1.1: the eight strongest, or a wider mask";
    let wide = named(all, "masks of 16 lights").map(|found| found.counts.dropped as f64);
    let mut checks = vec![Check::new(
        format!("{lamps} lamps: pairs that masks of 16 lights drop"),
        paper,
        wide,
        Bound::AtMost,
        0.0,
    )];
    let worse = named(all, "masks of 8 lights")
        .and_then(|found| found.errors?.shadow_err)
        .zip(named(all, "masks of 16 lights").and_then(|found| found.errors?.shadow_err));
    let mut check = Check::new(
        format!("{lamps} lamps: shadow error of masks of 8 lights"),
        paper,
        worse.map(|(narrow, _)| narrow),
        Bound::AtMost,
        1.0,
    );
    check.note = worse.map(|(_, wide)| {
        let dropped = named(all, "masks of 8 lights").map(|found| found.counts.dropped);
        format!("masks of 16: {}; masks of 8 drop {} pairs", report::error(wide), report::count(dropped))
    });
    checks.push(check);
    checks
}
