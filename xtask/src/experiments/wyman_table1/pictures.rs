//! Plots and pictures of `wyman-table1`.

use super::super::contest::Measured;
use super::{BRUTE, Case, LOW, Way};
use crate::failure::Outcome;
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::report::{Axis, Cost, Panel, PanelKind, PictureRow, Plot, Series};

/// Error against time, at full resolution.
pub(super) fn plot(case: &Case) -> Plot {
    let series = |label: &str, way| Series {
        label: label.into(),
        points: case.curve(way).iter().filter_map(|(r, _)| Some((r.ms()?, r.error()))).collect(),
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
                points: paper.and_then(|r| Some((r.ms()?, r.error()))).into_iter().collect(),
                joined: false,
            },
        ],
    }
}

fn slug(title: &str) -> String {
    title
        .replace("procedural:", "generated-")
        .replace('¼', "quarter")
        .replace([' ', ',', '\''], "-")
        .replace("--", "-")
}

/// The exact picture, brute force, the hybrid and the hybrid at low resolution, with their errors.
pub(super) fn row(case: &Case) -> Outcome<PictureRow> {
    let exact = &case.exact_on_map;
    let scale = exposure(exact);
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
        panels.extend(pair(case, result, &id, scale)?);
    }
    Ok(PictureRow { caption: format!("{}, airlight only; errors are on the map", case.title()), panels })
}

fn pair(case: &Case, result: &Measured, id: &str, scale: f32) -> Outcome<[Panel; 2]> {
    let name = &result.setting.name;
    let file = slug(name);
    Ok([
        Panel::new(
            format!("{id}-{file}.png"),
            name.clone(),
            format!("Airlight of {} by {name}", case.title()),
            &to_srgb8(&result.image, scale),
            PanelKind::Measured(Cost::new(result.ms().unwrap_or(f64::NAN), &result.on_map)),
        )?,
        Panel::new(
            format!("{id}-{file}-error.png"),
            format!("error of {name}"),
            format!("Error of {name} against the exact picture of the same map, pixel by pixel"),
            &error_picture(&result.image, &case.exact_on_map)?,
            PanelKind::ErrorMap,
        )?,
    ])
}

/// Scale that lands the 95th percentile at 0.8.
fn exposure(image: &Image) -> f32 {
    let mut values: Vec<f32> = image.pixels.iter().flatten().copied().collect();
    values.sort_by(f32::total_cmp);
    let bright = values.get(values.len() * 95 / 100).copied().unwrap_or(1.0);
    if bright > 0.0 { 0.8 / bright } else { 1.0 }
}
