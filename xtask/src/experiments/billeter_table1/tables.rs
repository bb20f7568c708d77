//! The paper's table with ours beside it.

use super::super::billeter_bench::{Division, time_ratio};
use super::{Case, Volume};
use crate::median::median;
use crate::report;
use crate::report::table::{Column, Table};

/// Frames per second of static and adaptive tessellation by scene and map.                                (Table 1)
const FPS: [(&str, u32, [u32; 2]); 6] = [
    ("sponza", 1024, [86, 64]),
    ("sponza", 2048, [35, 35]),
    ("sponza", 4096, [10, 18]),
    ("yeahright-188k", 1024, [32, 29]),
    ("yeahright-188k", 2048, [21, 21]),
    ("yeahright-188k", 4096, [8, 12]),
];

/// Both frame rates of the paper.
fn rates(case: &Case) -> Option<[u32; 2]> {
    FPS.iter().find(|(id, map, _)| *id == case.id && *map == case.map).map(|(_, _, fps)| *fps)
}

/// The paper's frame rate of a division; it has one static volume and the Laplacian.
pub(super) fn fps(case: &Case, division: Division) -> Option<u32> {
    let [fixed, adaptive] = rates(case)?;
    match division {
        Division::Indexed | Division::SixVertices => Some(fixed),
        Division::Laplacian(_) => Some(adaptive),
        _ => None,
    }
}

/// The paper's speed-up of whole frames by tessellating adaptively.
pub(super) fn paper_speedup(case: &Case) -> Option<f64> {
    rates(case).map(|[fixed, adaptive]| f64::from(adaptive) / f64::from(fixed))
}

/// Every division of every map; its stages where `stamped`.
pub(super) fn table(cases: &[Case], stamped: bool) -> Table {
    let mut table = Table::new(
        "Tessellations",
        vec![
            Column::left("scene"),
            Column::right("map"),
            Column::left("tessellation"),
            Column::left("chosen"),
            Column::right("triangles"),
            Column::right("of static"),
            Column::right("map error"),
            Column::right("added error"),
            Column::right("time"),
            Column::right("light still"),
            Column::right("criterion"),
            Column::right("hierarchy"),
            Column::right("leaves"),
            Column::right("surface"),
            Column::right("memory"),
            Column::right("paper, FPS"),
        ],
    );
    for case in cases {
        table.rows.extend(case.volumes.iter().map(|volume| line(case, volume, stamped)));
    }
    table.note = Some("The stages are criterion (the paper's Laplacian), hierarchy (its edge map), leaves (tessellate) and surface (render volume), where the adapter has time stamps of its own work; the time less that of a still light is what makes the quadtree. Memory is that of the whole frame.".into());
    table.without_empty_columns()
}

fn line(case: &Case, volume: &Volume, stamped: bool) -> Vec<String> {
    let Volume { division, measured, added } = volume;
    let chosen = case.candidates().any(|candidate| candidate.division == *division);
    let stages = if stamped { measured.stages() } else { Default::default() };
    let stage = |name: &str| report::time(stages.get(name).copied());
    vec![
        case.title.clone(),
        format!("{}²", case.map),
        division.name(),
        if chosen { "yes" } else { "" }.into(),
        report::count(measured.mesh_triangles),
        report::error(case.share(volume)),
        report::error(measured.map_error()),
        report::error(*added),
        report::time(measured.ms()),
        report::time(median(&measured.kept)),
        stage("criterion"),
        stage("hierarchy"),
        stage("leaves"),
        stage("surface"),
        report::bytes(measured.row("", 0).memory_bytes),
        fps(case, *division).map_or_else(String::new, |fps| fps.to_string()),
    ]
}

/// The faster static volume against the chosen quadtree.
pub(super) fn summary(cases: &[Case]) -> Table {
    let mut table = Table::new(
        "Static against adaptive, at little added error",
        vec![
            Column::left("scene"),
            Column::right("map"),
            Column::left("faster static"),
            Column::right("its time"),
            Column::left("adaptive"),
            Column::right("its time"),
            Column::right("of the triangles"),
            Column::right("faster by"),
            Column::right("light still, by"),
            Column::right("paper, whole frames"),
        ],
    );
    for case in cases {
        let (fixed, adaptive) = (case.fixed(), case.adaptive());
        let chosen = adaptive.map(|volume| &volume.measured);
        table.push(vec![
            case.title.clone(),
            format!("{}²", case.map),
            fixed.map_or_else(String::new, |fixed| fixed.setting.name.clone()),
            report::time(fixed.map(|fixed| fixed.ms())),
            adaptive.map_or_else(|| report::MISSING.into(), |volume| volume.division.name()),
            report::time(chosen.map(|chosen| chosen.ms())),
            report::error(adaptive.and_then(|volume| case.share(volume))),
            report::ratio(time_ratio(fixed, chosen)),
            report::ratio(kept_ratio(case)),
            report::ratio(paper_speedup(case)),
        ]);
    }
    table.note = Some("A dash where no threshold adds little enough.".into());
    table
}

/// Time of the faster static volume over that of the chosen quadtree where it is kept from frame to frame.
pub(super) fn kept_ratio(case: &Case) -> Option<f64> {
    // the quadtree that is fastest made anew need not be so kept
    let kept = case.candidates().filter_map(|volume| median(&volume.measured.kept)).reduce(f64::min)?;
    Some(case.fixed()?.ms() / kept)
}
