//! What the table is to show.

use super::super::billeter_bench::{Division, time_ratio};
use super::super::equal_error::interpolate;
use super::{ADDED, Case, Volume, tables};
use crate::report::data::{Bound, Check};

/// Largest errors of a static volume on its map: of the picture, and of what shadows change.
const STATIC: [f64; 2] = [1e-3, 2e-3];

/// How many times faster the quadtree is to be, and the largest share of the triangles that it may have, by map.
const SPONZA: [(u32, f64, f64); 4] =
    [(512, 1.0, 0.12), (1024, 1.3, 0.06), (2048, 3.0, 0.03), (4096, 5.0, 0.015)];

/// How many times faster where the light stands still, on the largest map.
const STILL: f64 = 10.0;

/// How many times faster on Yeah Right's largest map.
const YEAH_RIGHT: f64 = 3.0;

/// Delaunay triangles over those of the quadtree.
const DELAUNAY: f64 = 0.5;

/// Added error at which they are compared: more than [`ADDED`], which Delaunay triangles do not reach on small maps.
const DELAUNAY_ADDED: f64 = 3e-3;

const LARGEST: u32 = 4096;

/// All of them.
pub(super) fn checks(cases: &[Case]) -> Vec<Check> {
    let mut checks = exactness(cases);
    for case in cases {
        checks.extend(speed(case));
        checks.extend(delaunay(case));
    }
    checks
}

fn exactness(cases: &[Case]) -> Vec<Check> {
    let fixed = || cases.iter().flat_map(|case| case.of(Division::is_static)).map(|volume| &volume.measured);
    let rmse = fixed().filter_map(|measured| Some(measured.on_map?.rel_rmse)).reduce(f64::max);
    let shadow = fixed().map(|measured| measured.map_error()).reduce(f64::max);
    let paper = "§6: exact with respect to the shadow map";
    let claim =
        |figure: &str| format!("static volumes against the exact picture of the same map: largest {figure}");
    vec![
        Check::new(claim("relative RMSE"), paper, rmse, Bound::AtMost, STATIC[0]),
        Check::new(claim("map error"), paper, shadow, Bound::AtMost, STATIC[1]),
    ]
}

/// The bars on time and triangles of a scene and a map.
fn speed(case: &Case) -> Vec<Check> {
    let title = format!("{}, map {}²", case.title, case.map);
    let paper = tables::paper_speedup(case).map_or_else(
        || "Table 1 begins at 1024²".to_owned(),
        |ratio| format!("Table 1, whole frames: {ratio:.2} times"),
    );
    let adaptive = case.adaptive();
    let measured = time_ratio(case.fixed(), adaptive.map(|volume| &volume.measured));
    let claim =
        format!("{title}: adaptive in times less time than the faster static, adding at most {ADDED}");
    let faster = |bar| Check {
        note: note(case, adaptive),
        ..Check::new(&claim, &paper, measured, Bound::AtLeast, bar)
    };
    if case.id != "sponza" {
        return (case.map == LARGEST).then(|| faster(YEAH_RIGHT)).into_iter().collect();
    }
    let Some(&(_, times, share)) = SPONZA.iter().find(|(map, ..)| *map == case.map) else {
        return Vec::new();
    };
    let triangles = adaptive.and_then(|volume| case.share(volume));
    let claim = format!("{title}: triangles of adaptive as a share of static, adding at most {ADDED}");
    let mut checks = vec![
        faster(times),
        Check::new(claim, "§4.1: flat regions take few triangles", triangles, Bound::AtMost, share),
    ];
    if case.map == LARGEST {
        let claim =
            format!("{title}: adaptive kept from frame to frame in times less time than the faster static");
        checks.push(Check::new(claim, &paper, tables::kept_ratio(case), Bound::AtLeast, STILL));
    }
    checks
}

/// What bounds the chosen quadtree, or why there is none.
fn note(case: &Case, adaptive: Option<&Volume>) -> Option<String> {
    let Some(volume) = adaptive else {
        return Some("no threshold of the list adds little enough".into());
    };
    let share = 100.0 * case.share(volume)?;
    let still = crate::median::median(&volume.measured.kept);
    let made = still.map_or(f64::NAN, |still| 100.0 * (1.0 - still / volume.measured.ms()));
    Some(format!(
        "{} with {share:.1} % of the triangles; making it is {made:.0} % of its time, drawing it the rest",
        volume.division.name()
    ))
}

/// Triangles by Delaunay against the quadtree's, at equal error on the map and at equal error of the picture.
fn delaunay(case: &Case) -> Vec<Check> {
    let irregular = |division| matches!(division, Division::Delaunay(_));
    let quadtree = |division| matches!(division, Division::Distance(_));
    let Some(finest) = case.of(irregular).last() else { return Vec::new() };
    let title = format!("{}, map {}²: Delaunay triangles over the quadtree's", case.title, case.map);
    let check = |claim: String, error: &dyn Fn(&Volume) -> f64, target: f64| {
        let needed = |belongs: fn(Division) -> bool| {
            let points = case.of(belongs).filter_map(|v| Some((v.measured.mesh_triangles? as f64, error(v))));
            interpolate(points, target)
        };
        let (few, many) = (needed(irregular), needed(quadtree));
        let ratio = few.zip(many).map(|(few, many)| few / many);
        let mut check = Check::new(claim, "not in the paper", ratio, Bound::AtMost, DELAUNAY);
        check.note = Some(few.zip(many).map_or_else(
            || format!("the finest adds {:.5}: it is bounded at the nodes alone, and cuts the cells at depth edges its own way", finest.added),
            |(few, many)| format!("{few:.0} against {many:.0}, interpolated between thresholds; the coarsest of the list where that errs less"),
        ));
        check
    };
    let mut checks = vec![check(
        format!("{title} where both add {DELAUNAY_ADDED}"),
        &|volume| volume.added,
        DELAUNAY_ADDED,
    )];
    if let Some(chosen) = case.of(quadtree).find(|volume| volume.added <= ADDED) {
        let error = |volume: &Volume| volume.measured.on_geometry.shadow_err.unwrap_or(f64::NAN);
        let target = error(chosen);
        let claim = format!("{title} where both err by {target:.5} against the geometry");
        checks.push(check(claim, &error, target));
    }
    checks
}
