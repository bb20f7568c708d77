//! How measured pictures are shown, and what is said beside them.

use super::Context;
use super::measure::Measured;
use crate::failure::Outcome;
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::metrics::Metrics;
use crate::report::{Cost, Panel, PanelKind};

/// A picture and where it is off.
pub(super) struct Shown<'a> {
    pub(super) scene: &'a str,
    /// What the picture is of, as in "Airlight of a scene".
    pub(super) what: &'a str,
    pub(super) name: &'a str,
    pub(super) image: &'a Image,
    /// Times this the picture is bright enough to look at.
    pub(super) scale: f32,
    /// Time that the picture took; units: ms.
    pub(super) ms: f64,
    pub(super) errors: &'a Metrics,
    pub(super) reference: &'a Image,
}

impl Shown<'_> {
    /// The picture with its cost, and its error map.
    pub(super) fn panels(&self) -> Outcome<[Panel; 2]> {
        let Self { what, name, .. } = self;
        let file = slug(&format!("{} {name}", self.scene));
        Ok([
            Panel::new(
                format!("{file}.png"),
                *name,
                format!("{what} by {name}"),
                &to_srgb8(self.image, self.scale),
                PanelKind::Measured(Cost::new(self.ms, self.errors)),
            )?,
            Panel::new(
                format!("{file}-error.png"),
                format!("error of {name}"),
                format!("Error of {name} against the exact picture, pixel by pixel"),
                &error_picture(self.image, self.reference)?,
                PanelKind::ErrorMap,
            )?,
        ])
    }
}

/// A setting's airlight and where it is off from `reference`, from which it has `errors`.
pub(super) fn panels(
    scene: &str,
    measured: &Measured,
    (reference, errors): (&Image, &Metrics),
    scale: f32,
) -> Outcome<[Panel; 2]> {
    Shown {
        scene,
        what: &format!("Airlight of {scene}"),
        name: &measured.setting.name,
        image: &measured.image,
        scale,
        ms: measured.ms(),
        errors,
        reference,
    }
    .panels()
}

/// The scale with which `percent` of a picture's values are at most 0.8.
pub(super) fn display_scale(image: &Image, percent: usize) -> f32 {
    let mut values: Vec<f32> = image.pixels.iter().flatten().copied().collect();
    values.sort_by(f32::total_cmp);
    let bright = values.get((values.len() * percent / 100).min(values.len().saturating_sub(1)));
    bright.filter(|bright| **bright > 0.0).map_or(1.0, |bright| 0.8 / bright)
}

/// A name as a part of a file's name.
pub(super) fn slug(name: &str) -> String {
    let plain = name.replace("procedural:", "generated-").replace('/', "-of-").replace('¼', "quarter");
    let dashed: String = plain.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    dashed.split('-').filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-").to_lowercase()
}

/// What a reader must know of where the times come from.
pub(super) fn clock_note(context: &Context) -> Option<String> {
    match &context.gpu {
        Some(gpu) if crate::gpu::is_hardware(gpu) => None,
        Some(_) => Some("A software adapter: times are wall times around a submission, and only their ratios within this run mean anything.".into()),
        None => Some("There is no GPU adapter: the CPU implementations were timed.".into()),
    }
}
