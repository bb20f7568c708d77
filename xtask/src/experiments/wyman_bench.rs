//! The lights and scenes of Wyman and Ramsey's figures, and their marches on one shadow map, measured in turns.

use std::sync::Arc;

use scene::{AirlightModel, Light};

use super::Context;
use super::counts::for_lit_pixels;
use super::equal_error::interpolate;
use super::measure::{Arena, Measured, Setting, base};
use super::shown::{self, display_scale};
use crate::failure::{Failure, Outcome};
use crate::report::Panel;
use crate::scene_args::Setup;
use crate::setups::{LightKind, Source};
use crate::stained_glass::stained_glass;
use crate::technique::Options;

/// A scene with its light and a map; rays that hit nothing end after `max_distance` metres.
pub(super) fn lit(
    context: &Context,
    title: String,
    setup: Setup,
    [side, map]: [u32; 2],
    max_distance: f64,
) -> Outcome<Arena> {
    tracing::info!("{title}");
    Arena::new(&context.references, title, setup, Options { max_distance, ..base(side, map) })
}

/// Measures settings in turns, on the GPU where there is one, and counts what they cost each pixel in the light.
pub(super) fn measure(context: &Context, lit: &mut Arena, settings: &[Setting]) -> Outcome<Vec<Measured>> {
    let mut measured = lit.measure(context.gpu.as_ref(), settings)?;
    for_lit_pixels(lit, &mut measured)?;
    Ok(measured)
}

/// The value that `x` has where the error of a series first reaches `target`.
pub(super) fn at_error<'a>(
    series: impl Iterator<Item = &'a Measured>,
    x: impl Fn(&Measured) -> f64,
    target: f64,
) -> Option<f64> {
    interpolate(series.map(|found| (x(found), found.on_geometry.rel_rmse)), target)
}

/// The picture with its time and errors, and its error map.
pub(super) fn panels(lit: &Arena, found: &Measured) -> Outcome<[Panel; 2]> {
    let scale = display_scale(&lit.exact, 95);
    shown::panels(&lit.title, found, (&lit.exact, &found.on_geometry), scale)
}

/// A scene's spot with a window of stained glass in front of it; `None` where the scene has no spot.
pub(super) fn textured(source: &Source, depth: f32, model: AirlightModel) -> Outcome<Option<Setup>> {
    let Some(mut setup) = source.setup_lit(depth, LightKind::Spot)? else { return Ok(None) };
    let window = Arc::new(stained_glass());
    for light in &mut setup.lights {
        if let Light::Spot(spot) = light {
            spot.texture = Some(Arc::clone(&window));
        }
    }
    setup.model = model;
    Ok(Some(setup))
}

/// Optical depth of the view in the thin medium.
pub(super) fn thin(context: &Context) -> f32 {
    context.setups.media().find(|(name, _)| *name == "thin").map_or(0.3, |(_, depth)| depth)
}

/// The scene of an entry: from the folder where it is there, else the generated one.
pub(super) fn source(context: &Context, id: &str) -> Outcome<Source> {
    let setups = &context.setups;
    let mut all = setups.sources().into_iter().chain(setups.stand_ins());
    all.find(|source| source.entry.id == id).ok_or_else(|| Failure::program(format!("scenes.toml: no {id}")))
}

/// The generated scene of an entry.
pub(super) fn generated(context: &Context, id: &str) -> Outcome<Source> {
    let mut all = context.setups.stand_ins().into_iter();
    all.find(|source| source.entry.id == id)
        .ok_or_else(|| Failure::program(format!("scenes.toml: no stand-in for {id}")))
}

/// Name of a model of airlight.
pub(super) fn model_name(model: AirlightModel) -> &'static str {
    match model {
        AirlightModel::Sun => "Sun",
        AirlightModel::HoffmanPreetham => "Hoffman-Preetham",
    }
}
