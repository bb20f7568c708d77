//! Plots and pictures of `wyman-table1`.

use super::super::shown::{self, display_scale, slug};
use super::{BRUTE, Case, LOW, Way};
use crate::failure::Outcome;
use crate::image_file::to_srgb8;
use crate::report::{Axis, Panel, PanelKind, PictureRow, Plot, Series};

/// Error against time, at full resolution.
pub(super) fn plot(case: &Case) -> Plot {
    let series = |label: &str, way| Series {
        label: label.into(),
        points: case.curve(way).iter().map(|(r, _)| (r.ms(), r.map_error())).collect(),
        joined: true,
    };
    let paper = case.hybrid(Way::Paper, 1);
    Plot {
        file: format!("{}.svg", slug(&case.title())),
        title: format!("{}: error on the map against time", case.title()),
        caption: "Full resolution, the light moving in every frame.".into(),
        x: Axis::new("time of the fog", "ms"),
        y: Axis::new("shadow error on the map", ""),
        series: vec![
            series("brute force", None),
            series("hybrid, tiles", Some(Way::Tiles)),
            series("hybrid, tiles and bisection", Some(Way::Bisected)),
            Series {
                label: "hybrid 50, the paper's way".into(),
                points: paper.map(|r| (r.ms(), r.map_error())).into_iter().collect(),
                joined: false,
            },
        ],
    }
}

/// The exact picture, brute force, the hybrid and the hybrid at low resolution, with their errors.
pub(super) fn row(case: &Case) -> Outcome<PictureRow> {
    let exact = &case.exact_on_map;
    let scale = display_scale(exact, 95);
    let id = slug(&case.title());
    let mut panels = vec![Panel::new(
        format!("{id}-exact.png"),
        "exact on the map",
        format!("Airlight of {}, exact with respect to the shadow map", case.title()),
        &to_srgb8(exact, scale),
        PanelKind::Plain,
    )?];
    let shown = [
        case.brute(BRUTE, 1),
        case.hybrid(Way::Paper, 1),
        case.hybrid(Way::Bisected, 1),
        case.hybrid(Way::Bisected, LOW),
    ];
    for result in shown.into_iter().flatten() {
        panels.extend(shown::panels(&case.title(), result, (exact, result.nearest_errors()), scale)?);
    }
    Ok(PictureRow { caption: format!("{}, airlight only; errors are on the map", case.title()), panels })
}
