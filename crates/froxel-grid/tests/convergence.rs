//! The reference converges to the exact picture, and to a converged march where there is none.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

mod support;

use froxel_grid::{FroxelFog, Froxels, GridReads, SharedGrid};
use glam::{DVec3, Vec3};
use ground_truth::{Reference, Settings};
use hybrid_march::{BruteForce, Occluders};
use media_math::PhaseFunction;
use scene::{
    Aabb, AirlightModel, BvhVisibility, Density, DensityGrid, DirectionalLight, Light, Medium, PointLight,
    SpotLight,
};
use support::{Stage, rel_rmse, shadow_err};

const SIZE: (u32, u32) = (128, 128);

/// Exact pictures with and without shadows.
fn exact(stage: &Stage, range: f32) -> [Vec<Vec3>; 2] {
    [true, false].map(|shadows_in_medium| {
        let settings = Settings {
            airlight_only: true,
            shadows_in_medium,
            max_distance: range.into(),
            model: stage.model,
        };
        let reference =
            Reference::new(&stage.scene.materials, &stage.bvh, &stage.medium, &stage.lights, settings)
                .unwrap();
        stage.pixels(range.into(), |ray, end| reference.airlight(ray, end))
    })
}

/// Errors at each refinement, which must all fall; returns the last `rel_rmse` and `shadow_err`.
fn converges(name: &str, stage: &Stage, range: f32, truths: &[Vec<Vec3>; 2]) -> [f64; 2] {
    converges_away(name, stage, range, truths, -1.0)
}

/// The same over pixels that are more than `pixels` away from every light.
fn converges_away(
    name: &str,
    stage: &Stage,
    range: f32,
    [truth, unshadowed]: &[Vec<Vec3>; 2],
    pixels: f32,
) -> [f64; 2] {
    let picture_of = |picture: &[Vec3]| stage.away_from_lights(picture, pixels);
    let (truth, unshadowed) = (&picture_of(truth), &picture_of(unshadowed));
    println!("{name}: shadows change {:.2}", rel_rmse(unshadowed, truth));
    let mut before: Option<[f64; 2]> = None;
    for (tile, slices) in [(16, 32), (8, 64), (4, 128), (2, 256)] {
        let froxels = Froxels { tile, slices, ..Froxels::new(range) };
        let picture = &picture_of(&stage.once(froxels).airlight[0]);
        let errors = [rel_rmse(picture, truth), shadow_err(picture, truth, unshadowed)];
        let order = before.map_or([f64::NAN; 2], |b| [0, 1].map(|i| (b[i] / errors[i]).log2()));
        println!(
            "{name} {tile} px x {slices}: rel_rmse {:.5} (order {:.2}), shadow_err {:.4} (order {:.2})",
            errors[0], order[0], errors[1], order[1]
        );
        if let Some(before) = before {
            assert!(errors[0] < before[0] && errors[1] < before[1], "{name}: {errors:?} after {before:?}");
        }
        before = Some(errors);
    }
    before.unwrap()
}

fn spot(position: Vec3, target: Vec3) -> Light {
    let (inner, outer) = (20_f32.to_radians(), 35_f32.to_radians());
    Light::Spot(
        SpotLight::new(position, target - position, inner, outer, Vec3::new(60.0, 40.0, 20.0)).unwrap(),
    )
}

#[test]
fn to_the_exact_picture() {
    let range = 12.0;
    for name in ["sphere", "slats"] {
        let stage = Stage::generated(name, SIZE);
        let [rmse, shadow] = converges(&format!("{name}, point"), &stage, range, &exact(&stage, range));
        assert!(rmse < 0.05 && shadow < 0.15, "{name}: {rmse} {shadow}");
    }
    // its light is seen: the few pixels next to it, where airlight is as 1/h, outweigh all others
    let stage = Stage::generated("lampshade", SIZE);
    let truths = exact(&stage, range);
    converges("lampshade, point", &stage, range, &truths);
    let [_, shadow] = converges_away("lampshade, 8 px from the point", &stage, range, &truths, 8.0);
    assert!(shadow < 0.15, "lampshade: {shadow}");
    let mut stage = Stage::generated("sphere", SIZE);
    let center = stage.bvh.bounds().center();
    stage.medium.phase = PhaseFunction::henyey_greenstein(0.5).unwrap();
    stage.lights = vec![spot(center + Vec3::new(1.0, 3.0, -1.0), center)];
    let [rmse, shadow] = converges("sphere, spot", &stage, range, &exact(&stage, range));
    assert!(rmse < 0.05 && shadow < 0.15, "{rmse} {shadow}");
    stage.lights = vec![Light::Directional(
        DirectionalLight::new(Vec3::new(-0.4, -1.0, 0.3), Vec3::new(3.0, 2.0, 1.0)).unwrap(),
    )];
    let [rmse, shadow] = converges("sphere, directional", &stage, range, &exact(&stage, range));
    assert!(rmse < 0.05 && shadow < 0.15, "{rmse} {shadow}");
    // bounded medium: the light's way is attenuated from the box on
    stage.medium.bounds = Some(Aabb { min: center - 3.0, max: center + 3.0 });
    let [rmse, _] = converges("sphere, bounded", &stage, range, &exact(&stage, range));
    assert!(rmse < 0.05, "{rmse}");
}

#[test]
fn to_the_march_where_the_medium_varies() {
    let range = 12.0;
    let mut stage = Stage::generated("sphere", SIZE);
    let bounds = stage.bvh.bounds();
    let center = bounds.center();
    let Light::Point(lamp) = stage.lights[0] else { panic!("a point light") };
    let base =
        Medium { emission: [0.02, 0.01, 0.0], ..Medium::homogeneous([0.2, 0.15, 0.1], [0.05; 3]).unwrap() };
    let values = (0..6 * 6 * 6).map(|i| 0.5 + 0.5 * ((i * 37 % 101) as f32 / 100.0)).collect();
    let grid_box = Aabb { min: center - 2.5, max: center + 2.5 };
    let densities = [
        ("height", Density::height(bounds.min.y, 1.5).unwrap()),
        ("grid", Density::Grid(DensityGrid::new([6; 3], grid_box, values).unwrap())),
    ];
    stage.size = (64, 64);
    stage.look();
    for (name, density) in densities {
        stage.medium = Medium { density: Some(density), ..base.clone() };
        for light in [
            Light::Point(lamp),
            spot(lamp.position, center),
            Light::Directional(DirectionalLight::new(center - lamp.position, Vec3::ONE).unwrap()),
        ] {
            stage.lights = vec![light];
            let visibility = BvhVisibility::new(&stage.bvh, &stage.lights);
            let pictures = [true, false].map(|shadowed| {
                let occluders = Occluders { visibility: &visibility, bounds };
                let march = BruteForce {
                    medium: &stage.medium,
                    lights: &stage.lights,
                    occluders: shadowed.then_some(occluders),
                    samples: 600,
                    model: AirlightModel::Sun,
                };
                stage.pixels(range.into(), |ray, end| march.airlight(ray, end).airlight.as_dvec3())
            });
            let kind = match &stage.lights[0] {
                Light::Point(_) => "point",
                Light::Spot(_) => "spot",
                Light::Directional(_) => "directional",
            };
            let [rmse, shadow] = converges(&format!("{name}, {kind}"), &stage, range, &pictures);
            assert!(rmse < 0.05 && shadow < 0.2, "{name}, {kind}: {rmse} {shadow}");
        }
    }
}

#[test]
fn hoffman_and_preetham_too() {
    let mut stage = Stage::generated("sphere", SIZE);
    stage.model = AirlightModel::HoffmanPreetham;
    let [rmse, shadow] = converges("Hoffman-Preetham", &stage, 12.0, &exact(&stage, 12.0));
    assert!(rmse < 0.05 && shadow < 0.15, "{rmse} {shadow}");
}

#[test]
fn energy_without_occluders() {
    let mut stage = Stage::generated("empty", SIZE);
    let to = |end: f64| end.min(10.0);
    for sigma in [0.0, 1e-6, 0.12, 3.0, 100.0] {
        stage.medium = Medium::homogeneous([sigma; 3], [0.5 * sigma; 3]).unwrap();
        stage.lights = vec![Light::Directional(DirectionalLight::new(Vec3::NEG_Y, Vec3::ONE).unwrap())];
        // E p σ_s (1 − e^(−σ_t d))/σ_t: no error but rounding, since the source is constant
        let closed = stage.pixels(10.0, |_, end| {
            let (s, t) = (f64::from(sigma), 1.5 * f64::from(sigma));
            DVec3::splat(s * to(end) * media_math::phi(t * to(end)) / (4.0 * std::f64::consts::PI))
        });
        let picture = stage.once(Froxels::new(10.0)).airlight;
        let error = rel_rmse(&picture[0], &closed);
        println!("sun, sigma {sigma}: {error:.2e}");
        assert!(error < 1e-5, "{sigma}: {error}");
    }
    // a point light's source varies: the error falls with the slices
    stage.medium = Medium::homogeneous([0.12; 3], [0.0; 3]).unwrap();
    stage.lights = vec![Light::Point(PointLight::new(Vec3::new(0.4, 1.3, 0.0), Vec3::splat(8.0)).unwrap())];
    let [truth, _] = exact(&stage, 10.0);
    let mut before = [f64::INFINITY; 2];
    for (tile, slices) in [(8, 16), (4, 32), (2, 64), (1, 128)] {
        let froxels = Froxels { tile, slices, ..Froxels::new(10.0) };
        let picture = stage.render_as(&mut FroxelFog::new(froxels).unwrap(), false).airlight;
        let error = rel_rmse(&picture[0], &truth);
        let away = [&picture[0], &truth].map(|picture| stage.away_from_lights(picture, 8.0));
        let (error, away) = (error, rel_rmse(&away[0], &away[1]));
        println!("lamp, {tile} px x {slices}: {error:.5}, {away:.6} more than 8 px from it");
        assert!(error < before[0] && away < before[1], "{error} {away} after {before:?}");
        before = [error, away];
    }
    assert!(before[1] < 1e-3, "{before:?}");
}

#[test]
fn the_grid_comes_near_the_reference() {
    let stage = Stage::generated("slats", SIZE);
    let froxels = Froxels { tile: 4, slices: 128, ..Froxels::new(12.0) };
    let reference = stage.once(froxels).airlight;
    let unshadowed = stage.render_as(&mut FroxelFog::new(froxels).unwrap(), false).airlight;
    for reads in [GridReads::Nearest, GridReads::Trilinear] {
        let mut before = f64::INFINITY;
        for voxel_size in [0.4, 0.2, 0.1, 0.05] {
            let grid = SharedGrid { reads, ..SharedGrid::marked(voxel_size) };
            let rendered = stage.once(froxels.with_grid(grid));
            let error = shadow_err(&rendered.airlight[0], &reference[0], &unshadowed[0]);
            println!("slats, {reads:?}, {voxel_size} m: shadow_err {error:.4}, {:?}", rendered.counts);
            assert!(error < before, "{reads:?}, {voxel_size} m: {error} after {before}");
            before = error;
        }
        assert!(before < 0.15, "{reads:?}: {before}");
    }
}
