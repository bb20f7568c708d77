//! The tables: the paper's with ours beside it, and where the times go.

use super::super::measure::{Measured, Setting};
use super::{BRUTE, Case, HYBRID, LOW, NO_SHADOWS, Needs, POINT, TARGETS, Way, brute_name, hybrid_name};
use crate::median::median;
use crate::report;
use crate::report::data::EqualError;
use crate::report::table::{Column, Table};

/// Frames per second that the paper's table has for a setting of a case.
pub(super) fn fps(case: &Case, setting: &Setting) -> Option<f64> {
    let wyman = case.wyman.as_ref()?;
    let is = |name: String| setting.name == name;
    let columns = match case.light {
        POINT => vec![
            (NO_SHADOWS.to_owned(), wyman.no_shadows),
            (brute_name(BRUTE, 1), wyman.brute_full),
            (brute_name(BRUTE, LOW), wyman.brute_quarter),
            (hybrid_name(HYBRID, Way::Paper, 1), wyman.hybrid_full),
            (hybrid_name(HYBRID, Way::Paper, LOW), wyman.hybrid_quarter),
        ],
        light if light == super::TEXTURED => vec![
            (hybrid_name(HYBRID, Way::Paper, 1), wyman.textured_full),
            (hybrid_name(HYBRID, Way::Paper, LOW), wyman.textured_quarter),
        ],
        _ => Vec::new(),
    };
    columns.into_iter().find(|(name, _)| is(name.clone())).map(|(_, fps)| fps)
}

/// The settings of a table's row, with their headings.
fn columns() -> Vec<(&'static str, String)> {
    vec![
        ("no shadows", NO_SHADOWS.to_owned()),
        ("brute 150", brute_name(BRUTE, 1)),
        ("brute 150, ¼", brute_name(BRUTE, LOW)),
        ("hybrid 50, paper's way", hybrid_name(HYBRID, Way::Paper, 1)),
        ("the same, ¼", hybrid_name(HYBRID, Way::Paper, LOW)),
        ("hybrid 50, tiles, bisection", hybrid_name(HYBRID, Way::Bisected, 1)),
        ("the same, ¼", hybrid_name(HYBRID, Way::Bisected, LOW)),
    ]
}

fn heading() -> Vec<Column> {
    let fixed = [Column::left("scene"), Column::left("light"), Column::right("triangles")];
    fixed.into_iter().chain(columns().into_iter().map(|(heading, _)| Column::right(heading))).collect()
}

/// Each setting's time with its error.
pub(super) fn table1(cases: &[Case]) -> Table {
    let mut table = Table::new("Table 1: time of the fog, and shadow_err_map", heading());
    for case in cases {
        let cell = |result: Option<&Measured>| {
            result.map_or(report::MISSING.to_owned(), |result| {
                format!("{} ({})", report::time(result.ms()), report::error(result.map_error()))
            })
        };
        let cells = columns().into_iter().map(|(_, name)| cell(case.find(&name)));
        table.push(first(case).into_iter().chain(cells).collect());
    }
    table.note = Some("Error in brackets: shadow_err_map, against the exact picture of the same map. ¼: airlight for blocks of four pixels a side. Under the stained-glass spot the hybrid takes up to 50 steps each before, between and behind the faces: the paper's 150 within the spotlight's volume; brute force takes 150.".into());
    table
}

/// Times over the frame without shadows, the paper's ratios beside.
pub(super) fn ratios(cases: &[Case]) -> Table {
    let mut table = Table::new("Table 1 as ratios to no shadows: ours | paper's", heading());
    for case in cases {
        // the paper's frame without shadows is the one under the uncoloured light
        let point = cases.iter().find(|other| other.scene == case.scene && other.light == POINT);
        let none = point.and_then(|point| point.find(NO_SHADOWS));
        let paper_none = case.wyman.as_ref().map(|wyman| wyman.no_shadows);
        let cell = |result: Option<&Measured>| {
            let paper = result.and_then(|result| fps(case, &result.setting));
            let paper = paper_none.zip(paper).map(|(none, fps)| none / fps);
            match Case::ratio(result, none) {
                None => report::MISSING.to_owned(),
                Some(ours) => format!("{} | {}", report::ratio(ours), report::ratio(paper)),
            }
        };
        let cells = columns().into_iter().map(|(_, name)| cell(case.find(&name)));
        table.push(first(case).into_iter().chain(cells).collect());
    }
    table.note = Some("Errors of the same settings are in the table before. Ours are of the fog alone, in which no shadows is one closed form a pixel; the paper's are whole frames, whose surfaces and shadow map are in both parts of the ratio.".into());
    table
}

fn first(case: &Case) -> [String; 3] {
    [case.scene.clone(), case.light.to_owned(), report::count(case.triangles)]
}

/// Where the time goes.
pub(super) fn stages(cases: &[Case]) -> Table {
    let names = ["silhouette", "tiles", "faces", "merge", "downsample", "march", "upsample"];
    let fixed = ["light moves", "light stands still", "shadow_err_map", "silhouette edges"];
    let heading = ["scene", "light", "setting"].map(Column::left).into_iter();
    let heading = heading.chain(fixed.into_iter().chain(names).map(Column::right));
    let mut table = Table::new("Where the time goes, light moving", heading.collect());
    for case in cases {
        for (_, name) in columns().into_iter().filter(|(_, name)| name != NO_SHADOWS) {
            let Some(result) = case.find(&name) else { continue };
            let stages = result.stages();
            let still = median(&result.kept);
            let edges = result.mesh_triangles.map(|triangles| triangles / 2).filter(|edges| *edges > 0);
            let fixed = [
                report::time(result.ms()),
                report::time(still),
                report::error(result.map_error()),
                report::count(edges),
            ];
            let stages = names.iter().map(|name| report::time(stages.get(*name).copied()));
            let row = [case.scene.clone(), case.light.to_owned(), name];
            table.push(row.into_iter().chain(fixed).chain(stages).collect());
        }
    }
    table.note = Some("A dash where a setting has no such stage, and where the device's time stamps do not make up half of its frame, as those of some software adapters do not. With the light standing still silhouettes are kept; faces belong to the view and are drawn in every frame.".into());
    table
}

/// What an error takes of each technique.
pub(super) fn equal_error(cases: &[Case]) -> Table {
    let mut table = Table::new(
        "At equal error on the map",
        vec![
            Column::left("scene"),
            Column::left("light"),
            Column::right("covered"),
            Column::right("shadow_err_map"),
            Column::right("brute: time"),
            Column::right("samples"),
            Column::right("lookups"),
            Column::right("tiles: time"),
            Column::right("samples"),
            Column::right("lookups"),
            Column::right("tiles, bisection: time"),
            Column::right("samples"),
            Column::right("lookups"),
            Column::right("fewer lookups"),
            Column::right("less time"),
        ],
    );
    for case in cases.iter().filter(|case| case.light == POINT) {
        for target in TARGETS.map(|target| case.common(target)) {
            let needs = [None, Some(Way::Tiles), Some(Way::Bisected)].map(|way| case.needs(way, target));
            let cells = needs.iter().flat_map(|needs| {
                let figure = |of: fn(&Needs) -> f64| needs.as_ref().map(of);
                [
                    report::time(figure(|needs| needs.ms)),
                    report::figure(figure(|needs| needs.samples)),
                    report::figure(figure(|needs| needs.lookups)),
                ]
            });
            let first = [
                case.scene.clone(),
                case.light.to_owned(),
                report::error(case.covered as f64 / case.pixels as f64),
                report::error(target),
            ];
            let ratio = |of: fn(&Needs) -> f64| {
                report::ratio(needs[0].as_ref().zip(needs[2].as_ref()).map(|(a, b)| of(a) / of(b)))
            };
            let last = [ratio(|needs| needs.lookups), ratio(|needs| needs.ms)];
            table.push(first.into_iter().chain(cells).chain(last).collect());
        }
    }
    table.note = Some("Interpolated between the sample counts measured; a dash where none reaches the error; where the fewest samples are already below it, theirs stand. Lookups per covered pixel, bisections included. The last two columns: brute force over tiles with bisection.".into());
    table
}

/// The low resolution against the full one.
pub(super) fn low_resolution(cases: &[Case]) -> Table {
    let mut table = Table::new(
        "Quarter resolution of the hybrid (tiles, bisection)",
        vec![
            Column::left("scene"),
            Column::left("light"),
            Column::right("full"),
            Column::right("its shadow_err_map"),
            Column::right("¼"),
            Column::right("its shadow_err_map"),
            Column::right("less time"),
            Column::right("paper's frames"),
            Column::right("FLIP between the two"),
            Column::right("error at depth edges ÷ elsewhere"),
        ],
    );
    for case in cases {
        let (full, low) = (case.hybrid(Way::Bisected, 1), case.hybrid(Way::Bisected, LOW));
        let paper = |scale| fps(case, &case.hybrid(Way::Paper, scale)?.setting);
        table.push(vec![
            case.scene.clone(),
            case.light.to_owned(),
            report::time(full.map(Measured::ms)),
            report::error(full.map(Measured::map_error)),
            report::time(low.map(Measured::ms)),
            report::error(low.map(Measured::map_error)),
            report::ratio(Case::ratio(full, low)),
            report::ratio(paper(LOW).zip(paper(1)).map(|(low, full)| low / full)),
            report::figure(case.low.as_ref().map(|low| low.flip)),
            report::ratio(case.low.as_ref().map(|low| low.near_edges / low.elsewhere)),
        ]);
    }
    table.note = Some("Error at depth edges: root mean square of the difference of the two pictures within two pixels of where neighbouring depths differ by more than 5 %, over that of all other pixels. Paper's frames: frames per second at low over full resolution.".into());
    table
}

/// Times at equal error.
pub(super) fn equal_errors(case: &Case) -> Vec<EqualError> {
    if case.light != POINT {
        return Vec::new();
    }
    let of = |target: f64| {
        let ways = [
            ("brute-force", None),
            ("hybrid, tiles", Some(Way::Tiles)),
            ("hybrid, tiles and bisection", Some(Way::Bisected)),
        ];
        let ms = ways.map(|(name, way)| (name.to_owned(), case.needs(way, target).map(|needs| needs.ms)));
        let brute = ms[0].1;
        let speedup = ms[1..].iter().map(|(name, ms)| (name.clone(), brute.zip(*ms).map(|(b, h)| b / h)));
        EqualError {
            scene: case.title(),
            metric: "shadow_err_map".into(),
            target,
            speedup_over_brute_force: speedup.collect(),
            ms: ms.into_iter().collect(),
        }
    };
    TARGETS.into_iter().map(|target| of(case.common(target))).collect()
}
