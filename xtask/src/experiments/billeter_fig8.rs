//! `billeter-fig8`: the views of the table, and what the tessellation looks like from the light.

use lightvolume::LightVolume;

use super::billeter_bench::{Division, SCENES, linear, lit};
use super::billeter_mesh::{Cutout, busiest, tessellation};
use super::measure::{Arena, Measured};
use super::shown::{self, clock_note, display_scale, slug};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::{Failure, Outcome};
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Panel, PanelKind, PictureRow, Section};
use crate::setups::LightKind;

/// Threshold of the quadtrees as a share of the scene's diagonal.
const SHARE: f32 = 3e-3;

/// Cells a side from which a leaf is coarse.
const COARSE: u32 = 8;

/// Share of the map that is to lie in coarse leaves.
const FLAT: f64 = 0.5;

/// Pixels of a picture of the tessellation, at most.
const MOST: u32 = 1024;

/// A scene, its tessellations and pictures.
struct Case {
    title: String,
    map: u32,
    triangles: u64,
    results: Vec<(Division, Measured)>,
    /// Shares of the map in coarse leaves and of the triangles in leaves of one cell, of each quadtree.
    leaves: Vec<(Division, Leaves)>,
    pictures: PictureRow,
}

#[derive(Debug, Clone, Copy, Default)]
struct Leaves {
    /// Triangles that the CPU makes.
    triangles: usize,
    /// Leaves of one cell as a share of all.
    finest: f64,
    /// Share of the map that is in coarse leaves.
    coarse: f64,
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let (side, map, scenes) = match context.preset {
        Preset::Smoke => (64, 128, 1),
        _ if context.gpu.is_none() => (64, 128, 2),
        Preset::Quick => (256, 512, 2),
        Preset::Standard => (512, 1024, 2),
        Preset::Paper => (1024, 4096, 2),
    };
    let mut found = experiment(
        context,
        "billeter-fig8",
        "The tessellated light volume",
        "Billeter, Sintorn & Assarsson 2010, Figure 8",
    );
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let mut table = table();
    for id in SCENES.iter().take(scenes) {
        let Some((title, setup)) = lit(context, id, LightKind::Spot)? else { continue };
        tracing::info!("{title}, map {map}²");
        let case = measure(context, Arena::new(&context.references, title, setup, linear(side, map))?)?;
        found.rows.extend(case.results.iter().map(|(_, measured)| measured.row(&case.title, case.triangles)));
        found.checks.extend(checks(&case));
        table.rows.extend(case.results.iter().map(|result| line(&case, result)));
        section.pictures.push(case.pictures);
    }
    section.tables.push(table);
    found.notes = vec![
        format!(
            "Pictures are {side}×{side}, airlight only, under a spot in the thin medium, with maps of {map}²; the paper's are 1024×1024 with surfaces and maps of 4096², whose tessellation it shows as a cut-out, as here."
        ),
        format!(
            "Tessellations are drawn on the map, a line each edge of a triangle, over depths that are brighter the nearer they are; those of the CPU, which is the GPU's twin. Leaves are coarse from {COARSE} cells a side."
        ),
    ];
    found.notes.extend(clock_note(context));
    section.experiment = found;
    Ok(section)
}

fn measure(context: &Context, mut arena: Arena) -> Outcome<Case> {
    let divisions = [Division::Indexed, Division::Distance(SHARE), Division::Laplacian(SHARE)];
    let settings: Vec<_> = divisions.iter().map(|division| division.setting(&arena, arena.base)).collect();
    let measured = arena.measure(context.gpu.as_ref(), &settings)?;
    let exact = &arena.map.exact;
    let mut panels = Vec::new();
    let mut leaves = Vec::new();
    for (division, measured) in divisions.iter().zip(&measured).filter(|(division, _)| division.is_adaptive())
    {
        let errors = (exact, measured.nearest_errors());
        panels.extend(shown::panels(&arena.title, measured, errors, display_scale(exact, 95))?);
        let (found, drawn) = from_the_light(&arena, measured)?;
        panels.extend(drawn);
        leaves.push((*division, found));
    }
    let map = arena.base.map.side;
    let caption = format!("{}, map {map}²; errors on the map", arena.title);
    let pictures = PictureRow { caption, panels };
    let results = divisions.into_iter().zip(measured).collect();
    Ok(Case { triangles: arena.triangles(), title: arena.title, map, results, leaves, pictures })
}

/// The leaves of a measured quadtree, and its pictures: the whole map where it fits, and a cut-out.
fn from_the_light(arena: &Arena, measured: &Measured) -> Outcome<(Leaves, Vec<Panel>)> {
    let wanted = measured.setting.options.tessellation.of_scene(arena.bvh.bounds().diagonal());
    let options = lightvolume::Options::new(wanted);
    let (mut found, mut panels) = (Leaves::default(), Vec::new());
    // a spot has one map
    for map in arena.map.maps.maps.iter().flatten().take(1) {
        let volume = LightVolume::build(map, &options).map_err(Failure::program)?;
        found = leaves(&volume);
        let name = slug(&format!("{} {}", arena.title, measured.setting.name));
        let mut add = |what: &str, cutout: Cutout| -> Outcome {
            let alt = format!("Triangles of {} on the map of {}, {what}", measured.setting.name, arena.title);
            let picture = tessellation(map, &volume, cutout);
            let (file, title) = (format!("{name}-{}.png", slug(what)), format!("tessellation, {what}"));
            panels.push(Panel::new(file, title, alt, &picture, PanelKind::Plain)?);
            Ok(())
        };
        let side = map.size().0;
        if side <= MOST {
            add("the whole map", Cutout { first: [0, 0], texels: side, zoom: (MOST / side).clamp(1, 4) })?;
        }
        add("a cut-out", busiest(map, &volume, (side / 4).min(128), 6))?;
    }
    Ok((found, panels))
}

fn leaves(volume: &LightVolume) -> Leaves {
    let all = volume.leaves();
    let cells = |level: u32| 4f64.powi(level as i32);
    let area: f64 = all.iter().map(|leaf| cells(leaf.level)).sum();
    let coarse: f64 = all.iter().filter(|leaf| 1 << leaf.level >= COARSE).map(|leaf| cells(leaf.level)).sum();
    let finest = all.iter().filter(|leaf| leaf.level == 0).count();
    let count = all.len().max(1) as f64;
    Leaves {
        triangles: volume.triangles().len(),
        finest: finest as f64 / count,
        coarse: coarse / area.max(1.0),
    }
}

fn checks(case: &Case) -> Vec<Check> {
    let title = format!("{}, map {}²", case.title, case.map);
    let mut checks = Vec::new();
    for (division, leaves) in &case.leaves {
        let claim = format!(
            "{title}, {}: share of the map in leaves of at least {COARSE} cells a side",
            division.name()
        );
        let paper = "§6: flat surfaces use a quite low tessellation level";
        let mut flat = Check::new(claim, paper, Some(leaves.coarse), Bound::AtLeast, FLAT);
        flat.note = Some("edges take leaves of a cell or two beside them whatever the map's size, so the share grows with the map; the paper's is 4096²".into());
        checks.push(flat);
        let drawn = case.results.iter().find(|(own, _)| own == division);
        let drawn = drawn.and_then(|(_, measured)| measured.mesh_triangles);
        let claim = format!("{title}, {}: triangles drawn, of the CPU's, off by", division.name());
        let off = drawn.map(|drawn| (drawn as f64 / leaves.triangles.max(1) as f64 - 1.0).abs());
        checks.push(Check::new(claim, "the pictures show what is drawn", off, Bound::AtMost, 0.01));
    }
    checks
}

fn table() -> Table {
    Table::new(
        "Triangles",
        vec![
            Column::left("scene"),
            Column::right("map"),
            Column::left("tessellation"),
            Column::right("triangles"),
            Column::right("of static"),
            Column::right("leaves of one cell"),
            Column::right("map in coarse leaves"),
            Column::right("map error"),
            Column::right("time"),
        ],
    )
}

fn line(case: &Case, (division, measured): &(Division, Measured)) -> Vec<String> {
    let leaves = case.leaves.iter().find(|(own, _)| own == division).map(|(_, leaves)| *leaves);
    let all = case.results.iter().find(|(division, _)| division.is_static());
    let all = all.and_then(|(_, measured)| measured.mesh_triangles);
    let share = measured.mesh_triangles.zip(all).map(|(few, all)| few as f64 / all as f64);
    vec![
        case.title.clone(),
        format!("{}²", case.map),
        division.name(),
        report::count(measured.mesh_triangles),
        report::error(share),
        report::error(leaves.map(|leaves| leaves.finest)),
        report::error(leaves.map(|leaves| leaves.coarse)),
        report::error(measured.map_error()),
        report::time(measured.ms()),
    ]
}
