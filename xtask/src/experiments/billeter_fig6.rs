//! `billeter-fig6`: a point light with cube maps of three sizes.

use super::billeter_bench::{Division, linear, lit};
use super::billeter_seams::{SeamErrors, seam_errors};
use super::measure::{Arena, Measured};
use super::shown::{Shown, clock_note, display_scale};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::image_file::{Image, to_srgb8};
use crate::metrics;
use crate::report::data::{Bound, Check, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Panel, PanelKind, PictureRow, Section};
use crate::setups::LightKind;

/// Sides of a cube's faces and the paper's frames per second.
const SIDES: [(u32, u32); 3] = [(32, 230), (128, 165), (512, 25)];

/// Largest errors on the map: of the picture, and of what shadows change.
const EXACT: [f64; 2] = [1e-3, 2e-3];

/// Mean FLIP that few would see.
const UNSEEN: f64 = 0.05;

/// A scene with a map of one size.
struct Case {
    title: String,
    map: u32,
    fps: u32,
    triangles: u64,
    measured: Measured,
    seams: SeamErrors,
    exact: Image,
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let (side, sides, scenes): (u32, _, &[&str]) = match context.preset {
        Preset::Smoke => (64, &SIDES[..2], &["sphere"]),
        _ if context.gpu.is_none() => (64, &SIDES[..2], &["sphere"]),
        Preset::Quick => (256, &SIDES[..], &["sphere"]),
        Preset::Standard => (512, &SIDES[..], &["sphere", "lampshade"]),
        Preset::Paper => (1024, &SIDES[..], &["sphere", "lampshade"]),
    };
    let mut found = experiment(
        context,
        "billeter-fig6",
        "A point light with cube maps of three sizes",
        "Billeter, Sintorn & Assarsson 2010, Figure 6",
    );
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let mut table = table();
    for id in scenes {
        let cases = measure(context, id, side, sides)?;
        found.rows.extend(cases.iter().map(row));
        table.rows.extend(cases.iter().map(line));
        found.checks.extend(checks(&cases)?);
        section.pictures.extend(pictures(&cases)?);
    }
    section.tables.push(table);
    found.notes.push(format!("Pictures are {side}×{side}, airlight only, in the thin medium, all cells of the six faces drawn by indices; the paper's have surfaces. Errors of pictures and in the error maps are against the geometry, map errors against the exact picture of the same map. Near a seam is a pixel whose ray enters or leaves the light within two texels of the edge of a cube's face, where it meets triangles that join two faces; elsewhere are those that do so only farther away. Both errors are root mean squares as shares of the picture's."));
    found.notes.extend(clock_note(context));
    section.experiment = found;
    Ok(section)
}

fn measure(context: &Context, id: &str, side: u32, sides: &[(u32, u32)]) -> Outcome<Vec<Case>> {
    let mut cases = Vec::new();
    for &(map, fps) in sides {
        let Some((title, setup)) = lit(context, id, LightKind::Point)? else { continue };
        tracing::info!("{title}, map {map}²");
        let mut arena = Arena::new(&context.references, title, setup, linear(side, map))?;
        let setting = Division::Indexed.setting(&arena, arena.base);
        for measured in arena.measure(context.gpu.as_ref(), &[setting])? {
            let seams = seam_errors(&arena, &measured)?;
            let (title, exact) = (arena.title.clone(), arena.exact.clone());
            cases.push(Case { title, map, fps, triangles: arena.triangles(), measured, seams, exact });
        }
    }
    Ok(cases)
}

fn row(case: &Case) -> Row {
    let mut row = case.measured.row(&case.title, case.triangles);
    row.paper = Some([("fps".to_owned(), case.fps.into())].into_iter().collect());
    row.params.insert("error_near_seams".into(), case.seams.near.into());
    row.params.insert("error_elsewhere".into(), case.seams.elsewhere.into());
    row
}

fn table() -> Table {
    Table::new(
        "Cube maps of three sizes",
        vec![
            Column::left("scene"),
            Column::right("map"),
            Column::right("triangles"),
            Column::right("time"),
            Column::right("paper, FPS"),
            Column::right("shadow error"),
            Column::right("map error"),
            Column::right("near seams"),
            Column::right("elsewhere"),
            Column::right("pixels near"),
        ],
    )
}

fn line(case: &Case) -> Vec<String> {
    let Case { measured, seams, .. } = case;
    vec![
        case.title.clone(),
        format!("6 × {}²", case.map),
        report::count(measured.mesh_triangles),
        report::time(measured.ms()),
        case.fps.to_string(),
        report::error(measured.on_geometry.shadow_err),
        report::error(measured.map_error()),
        report::error(seams.near),
        report::error(seams.elsewhere),
        report::count(Some(seams.pixels as u64)),
    ]
}

fn checks(cases: &[Case]) -> Outcome<Vec<Check>> {
    let Some(last) = cases.last() else { return Ok(Vec::new()) };
    let worst = |error: fn(&Case) -> f64| cases.iter().map(error).reduce(f64::max);
    let paper = "§6: exact with respect to the shadow map";
    let rmse = worst(|case| case.measured.on_map.map_or(f64::NAN, |on_map| on_map.rel_rmse));
    let shadow = worst(|case| case.measured.map_error());
    let claim =
        |figure| format!("{}: largest {figure} against the exact picture of the same map", last.title);
    let mut checks = vec![
        Check::new(claim("relative RMSE"), paper, rmse, Bound::AtMost, EXACT[0]),
        Check::new(claim("map error"), paper, shadow, Bound::AtMost, EXACT[1]),
    ];
    for case in cases {
        let claim = format!(
            "{}, 6 × {}²: error within two texels of a seam over that elsewhere",
            case.title, case.map
        );
        // without an error near them none elsewhere matters, and there may be none
        let over = |near: f64| if near == 0.0 { 0.0 } else { near / case.seams.elsewhere };
        let ratio = (case.seams.pixels > 0).then(|| over(case.seams.near));
        let mut check = Check::new(claim, "§4: six grids form the volume", ratio, Bound::AtMost, 1.0);
        check.note = Some(format!(
            "{} against {}: both are rounding where they are below a millionth",
            report::error(case.seams.near),
            report::error(case.seams.elsewhere)
        ));
        checks.push(check);
    }
    if let Some(before) = cases.len().checked_sub(2).and_then(|index| cases.get(index)) {
        let flip = metrics::compare(&before.measured.image, &last.measured.image, None, None)?.flip;
        let claim =
            format!("{}: mean FLIP between maps of 6 × {}² and 6 × {}²", last.title, before.map, last.map);
        let paper = "Figure 6: (c) is mostly indistinguishable from (b)";
        checks.push(Check::new(claim, paper, Some(flip), Bound::AtMost, UNSEEN));
    }
    Ok(checks)
}

fn pictures(cases: &[Case]) -> Outcome<Option<PictureRow>> {
    let Some(first) = cases.first() else { return Ok(None) };
    let scale = display_scale(&first.exact, 95);
    let alt = format!("Airlight of {}: the exact picture", first.title);
    let file = format!("{}-exact.png", super::shown::slug(&first.title));
    let mut panels = vec![Panel::new(file, "exact", alt, &to_srgb8(&first.exact, scale), PanelKind::Plain)?];
    for case in cases {
        let shown = Shown {
            scene: &case.title,
            what: &format!("Airlight of {}", case.title),
            name: &format!("map 6 × {}²", case.map),
            image: &case.measured.image,
            scale,
            ms: case.measured.ms(),
            errors: &case.measured.on_geometry,
            reference: &case.exact,
        };
        panels.extend(shown.panels()?);
    }
    let caption = format!("{}, airlight only; errors against the geometry", first.title);
    Ok(Some(PictureRow { caption, panels }))
}
