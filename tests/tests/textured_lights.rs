//! The march through a textured spot light answers to the exact reference, and takes fewer steps than the plain march
//! for the same error.
#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use std::sync::Arc;

use airlight_tests::picture::{Pixels, rel_rmse};
use airlight_tests::view::View;
use glam::Vec3;
use ground_truth::{ExactShadows, Reference, Settings, render_rows};
use hybrid_march::{BruteForce, LightMips, LowResolution, Marched, Occluders, Placement, TexturedMarch};
use scene::{
    AirlightModel, BvhVisibility, DRay, Interval, Light, LightId, LightTexture, LitIntervals, SpotLight,
    TextureFilter,
};

/// Side of the pictures.
const SIDE: u32 = 24;

/// Panes of coloured glass in a dark frame, `cells` a side.
fn window(side: u32, cells: u32) -> LightTexture {
    let pane = side / cells;
    let texels = (0..side * side).map(|i| {
        let (x, y) = (i % side, i / side);
        if x % pane == 0 || y % pane == 0 {
            return [0.02; 3];
        }
        let id = (x / pane) + 31 * (y / pane);
        [0, 1, 2].map(|channel| ((id * 7919 + channel * 104_729) % 17) as f32 / 16.0)
    });
    LightTexture::new(side, side, texels.collect(), TextureFilter::Linear).unwrap()
}

/// A window of light beside a scene's shadow casters, or as if there were none.
struct Case {
    view: View,
    model: AirlightModel,
    shadows: bool,
    mips: LightMips,
}

impl Case {
    fn new(name: &str, texture: LightTexture, model: AirlightModel, shadows: bool) -> Self {
        Self::lit_from(Vec3::new(-0.4, 2.6, -2.0), name, texture, model, shadows)
    }

    fn lit_from(
        position: Vec3,
        name: &str,
        texture: LightTexture,
        model: AirlightModel,
        shadows: bool,
    ) -> Self {
        let direction = Vec3::new(0.2, 0.9, 1.0) - position;
        let mut spot = SpotLight::new(position, direction, 0.35, 0.5, Vec3::new(20.0, 18.0, 15.0)).unwrap();
        let mips = LightMips::new(&texture, 0.0);
        spot.texture = Some(Arc::new(texture));
        let view = View { lights: vec![Light::Spot(spot)], ..View::procedural(name, SIDE) };
        Self { view, model, shadows, mips }
    }

    fn spot(&self) -> &SpotLight {
        let Light::Spot(spot) = &self.view.lights[0] else { unreachable!("the light is a spot") };
        spot
    }

    fn exact(&self) -> Pixels {
        let settings = Settings {
            airlight_only: true,
            shadows_in_medium: self.shadows,
            model: self.model,
            ..Settings::default()
        };
        let View { materials, bvh, medium, lights, camera, size } = &self.view;
        Reference::new(materials, bvh, medium, lights, settings).unwrap().render(camera, *size, &|_| ())
    }

    /// The picture of a march, and the steps of a ray that takes any, on average.
    fn picture(&self, march: &(dyn Fn(&DRay, f64) -> Marched + Sync)) -> (Pixels, f64) {
        let View { camera, bvh, size, .. } = &self.view;
        let totals = std::sync::Mutex::new((0_u64, 0_u64));
        let pixels = render_rows(*size, &|_| (), |x, y| {
            let ray = camera.pixel_ray(x, y, *size);
            let end = bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
            let marched = march(&ray, end);
            let mut totals = totals.lock().unwrap();
            totals.0 += marched.samples;
            totals.1 += u64::from(marched.samples > 0);
            marched.airlight.to_array()
        });
        let (samples, rays) = totals.into_inner().unwrap();
        (pixels, samples as f64 / rays as f64)
    }

    /// The distances between which shadows begin and end on a ray: what exact shadow volumes would draw.
    fn faces(&self, ray: &DRay, end: f64) -> Option<Interval> {
        let span = self.spot().clip(ray, Interval::new(0.0, end));
        let mut lit = Vec::new();
        ExactShadows::new(&self.view.bvh, &self.view.lights).lit_intervals(ray, span, LightId(0), &mut lit);
        let ends = lit.iter().flat_map(|piece| [piece.start, piece.end]);
        let inside: Vec<f64> = ends.filter(|&x| x > span.start && x < span.end).collect();
        Some(Interval::new(*inside.first()?, *inside.last()?))
    }

    fn plain(&self, samples: u32) -> (Pixels, f64) {
        let View { bvh, medium, lights, .. } = &self.view;
        let visibility = BvhVisibility::new(bvh, lights);
        let occluders = Occluders { visibility: &visibility, bounds: bvh.bounds() };
        let march = BruteForce {
            medium,
            lights,
            occluders: self.shadows.then_some(occluders),
            samples,
            model: self.model,
        };
        self.picture(&|ray, end| march.airlight(ray, end))
    }

    fn textured(&self, samples: [u32; 3], placement: Placement, mips: bool) -> (Pixels, f64) {
        let View { bvh, medium, lights, .. } = &self.view;
        let visibility = BvhVisibility::new(bvh, lights);
        let occluders = Occluders { visibility: &visibility, bounds: bvh.bounds() };
        let mut march = TexturedMarch::new(medium, self.spot(), LightId(0)).unwrap();
        march.mips = mips.then_some(&self.mips);
        march.occluders = self.shadows.then_some(occluders);
        (march.samples, march.placement, march.model) = (samples, placement, self.model);
        self.picture(&|ray, end| {
            let faces = if self.shadows { self.faces(ray, end) } else { None };
            march.airlight(ray, end, faces)
        })
    }
}

/// Order of convergence between the errors of two marches, one with `factor` times the steps.
fn order(coarse: f64, fine: f64, factor: f64) -> f64 {
    (coarse / fine).ln() / factor.ln()
}

#[test]
fn marches_converge_to_the_exact_picture() {
    for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
        for (name, shadows) in [("slats", false), ("slats", true), ("sphere", true)] {
            let case = Case::new(name, window(64, 8), model, shadows);
            let exact = case.exact();
            for placement in [Placement::EqualDistance, Placement::EqualAngle] {
                for mips in [false, true] {
                    let errors =
                        [8, 64, 512].map(|n| rel_rmse(&case.textured([n; 3], placement, mips).0, &exact));
                    let order = order(errors[0], errors[2], 64.0);
                    println!(
                        "{name}, shadows {shadows}, {model:?}, {placement:?}, mips {mips}: {errors:?}, \
                         order {order:.2}"
                    );
                    // a boundary within a march's step costs O(1/N), a smooth light O(1/N²)
                    let least = if name == "slats" && shadows { 0.7 } else { 1.1 };
                    assert!(errors[0] > errors[1] && errors[1] > errors[2], "{errors:?}");
                    assert!(order > least, "{errors:?}");
                }
            }
        }
    }
}

/// Steps along a ray at which a march's error falls to `target`, between those of a march and one with √2 times as
/// many.
fn steps_for(target: f64, exact: &Pixels, march: &dyn Fn(u32) -> (Pixels, f64)) -> f64 {
    let mut last = (0.0, f64::INFINITY);
    for k in 2..24 {
        let (picture, steps) = march(2_f64.powf(0.5 * f64::from(k)).round() as u32);
        let error = rel_rmse(&picture, exact);
        if error <= target {
            let share = if last.1.is_finite() { (last.1 / target).ln() / (last.1 / error).ln() } else { 1.0 };
            return last.0 + share * (steps - last.0);
        }
        last = (steps, error);
    }
    f64::INFINITY
}

#[test]
fn mips_and_even_angles_save_steps() {
    for (name, shadows, model, least) in [
        ("slats", false, AirlightModel::Sun, [6.0, 6.0]),
        ("sphere", true, AirlightModel::Sun, [6.0, 4.0]),
        // boundaries everywhere: most of the error is theirs, and at 0.5 % all of it
        ("slats", true, AirlightModel::Sun, [2.0, 1.0]),
    ] {
        let case = Case::new(name, window(64, 8), model, shadows);
        let exact = case.exact();
        for (target, least) in [0.02, 0.005].into_iter().zip(least) {
            let plain = steps_for(target, &exact, &|n| case.plain(n));
            // the lit segments see a picture without its finest detail, and take a quarter of the steps
            let samples = |n: u32| if shadows { [n.div_ceil(4), n, n.div_ceil(4)] } else { [n; 3] };
            let textured =
                steps_for(target, &exact, &|n| case.textured(samples(n), Placement::EqualAngle, true));
            let saved = plain / textured;
            println!(
                "{name}, shadows {shadows}, {target}: {plain:.0} and {textured:.0} steps, {saved:.1} times"
            );
            assert!(saved > least, "{name} at {target}: {plain:.0} steps and {textured:.0}");
        }
    }
}

/// Detail finer than any step must average out: neither form may make the light brighter or darker.
#[test]
fn a_fine_picture_is_not_biased() {
    let side = 256;
    let noise = |i: u32| {
        let i = i.wrapping_mul(0x9E37_79B9);
        if (i ^ (i >> 15)).wrapping_mul(0x85EB_CA6B) >> 31 == 0 { [0.0; 3] } else { [2.0, 1.0, 0.5] }
    };
    for filter in [TextureFilter::Linear, TextureFilter::Nearest] {
        let texels = (0..side * side).map(noise).collect();
        let texture = LightTexture::new(side, side, texels, filter).unwrap();
        let case = Case::new("slats", texture, AirlightModel::Sun, false);
        let exact = case.exact();
        let total = |pixels: &Pixels| pixels.as_flattened().iter().map(|&v| f64::from(v)).sum::<f64>();
        for (mips, bar) in [(false, 0.02), (true, 0.01)] {
            let (picture, _) = case.textured([24; 3], Placement::EqualAngle, mips);
            let (share, error) = (total(&picture) / total(&exact), rel_rmse(&picture, &exact));
            println!("{filter:?}, mips {mips}: {share:.4} of the light, rel_rmse {error:.2e}");
            assert!((share - 1.0).abs() < bar, "{filter:?}, mips {mips}: {share} of the light");
        }
    }
}

/// A picture whose airlight is marched at a fraction of its resolution, and the rays marched for each of its pixels.
fn at_low_resolution(
    low: &LowResolution,
    case: &Case,
    ends: &[f32],
    airlight: &dyn Fn(&DRay, f32) -> Vec3,
) -> (Pixels, f64) {
    let camera = &case.view.camera;
    let (columns, rows) = low.low_size();
    let [near, far] = low.ends(camera, ends).unwrap();
    let rays = near.iter().chain(&far).filter(|&&end| end > 0.0).count();
    let layers = [&near, &far].map(|ends| {
        let blocks = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        let marched = blocks.zip(ends).map(|((x, y), &end)| airlight(&low.low_ray(camera, x, y), end));
        marched.collect::<Vec<Vec3>>()
    });
    let picture = low.upsample(camera, ends, [&near, &far], [&layers[0], &layers[1]]).unwrap();
    (picture.iter().map(|pixel| pixel.to_array()).collect(), rays as f64 / ends.len() as f64)
}

/// Scattering at a half and a quarter of the resolution, against all pixels marched alike.
#[test]
fn low_resolution_keeps_the_picture() {
    // the light is out of view: next to it no block holds the slope of 1/h
    let position = Vec3::new(-0.6, 4.6, -1.5);
    for name in ["sphere", "slats"] {
        let mut case = Case::lit_from(position, name, window(64, 8), AirlightModel::Sun, true);
        case.view.size = (96, 96);
        let View { camera, bvh, medium, lights, size, .. } = &case.view;
        let visibility = BvhVisibility::new(bvh, lights);
        let mut march = TexturedMarch::new(medium, case.spot(), LightId(0)).unwrap();
        march.mips = Some(&case.mips);
        march.occluders = Some(Occluders { visibility: &visibility, bounds: bvh.bounds() });
        let airlight = |ray: &DRay, end: f32| {
            let end = f64::from(end);
            march.airlight(ray, end, case.faces(ray, end)).airlight
        };
        let rays: Vec<DRay> =
            (0..size.0 * size.1).map(|i| camera.pixel_ray(i % size.0, i / size.0, *size)).collect();
        let end_of = |ray| bvh.closest_hit(ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
        let ends: Vec<f32> = rays.iter().map(|ray| end_of(ray) as f32).collect();
        let full: Pixels = rays.iter().zip(&ends).map(|(ray, &end)| airlight(ray, end).to_array()).collect();
        for (scale, bar) in [(1, 1e-6), (2, 0.05), (4, 0.09)] {
            let low = LowResolution::new(*size, scale).unwrap();
            let (picture, share) = at_low_resolution(&low, &case, &ends, &airlight);
            let error = rel_rmse(&picture, &full);
            println!("{name}, scale {scale}: rel_rmse {error:.2e} with {share:.3} rays a pixel");
            assert!(error < bar, "{name}, scale {scale}: {error}");
        }
    }
}
