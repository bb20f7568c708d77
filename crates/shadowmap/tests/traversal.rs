//! Traversal against itself, and against marches on the same map.

#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

mod common;

use common::{KINDS, Random, Relief, contains, difference, map, near_end, ray, well_formed};
use hybrid_march::{BruteForce, Occluders};
use media_math::{Foot, PhaseFunction, airlight, directional_airlight};
use proptest::prelude::*;
use scene::{
    Aabb, AirlightModel, DRay, DirectionalLight, Interval, Light, LightId, LitIntervals, Medium, PointLight,
    SpotLight, Visibility,
};
use shadowmap::{
    Bias, DepthMap, ExactShadowMap, Filter, MapSurface, MapTraversal, MapVisibility, Outside, Projection,
    ProjectionKind, SurfaceVisibility,
};

const SURFACES: [MapSurface; 2] = [MapSurface::Step, MapSurface::Linear];
const RELIEFS: [Relief; 3] = [Relief::Noise, Relief::Holes, Relief::Blocks];

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn hierarchical_equals_flat(
        seed in any::<u64>(), kind in 0_usize..3, width in 1_u32..40, height in 1_u32..40,
        relief in 0_usize..3, linear in any::<bool>(), lit_outside in any::<bool>(),
        biased in any::<bool>(), infinite in any::<bool>(),
    ) {
        let mut random = Random::new(seed);
        let outside = if lit_outside { Outside::Lit } else { Outside::Dark };
        let map = map(KINDS[kind], (width, height), RELIEFS[relief], &mut random).with_outside(outside);
        let bias = if biased { Bias::constant(0.05).unwrap() } else { Bias::NONE };
        let traversal = MapTraversal::new(&map, SURFACES[usize::from(linear)], bias);
        let span = Interval::new(0.3, if infinite { f64::INFINITY } else { 7.0 });
        let (mut tree, mut flat) = (Vec::new(), Vec::new());
        for _ in 0..4 {
            let ray = ray(&mut random);
            traversal.lit(&ray, span, &mut tree);
            traversal.lit_flat(&ray, span, &mut flat);
            prop_assert!(well_formed(&tree, span) && well_formed(&flat, span));
            prop_assert!(difference(&tree, &flat) < 1e-10, "{:?}\n{:?}", tree, flat);
        }
    }

    #[test]
    fn rays_along_axes_borders_and_through_the_light(
        seed in any::<u64>(), kind in 0_usize..3, size in 1_u32..9, linear in any::<bool>(),
    ) {
        let mut random = Random::new(seed);
        let map = map(KINDS[kind], (size, size), Relief::Noise, &mut random);
        let traversal = MapTraversal::new(&map, SURFACES[usize::from(linear)], Bias::NONE);
        let face = map.projection().faces()[0];
        let axes = [face.right, face.down, face.forward];
        let span = Interval::new(0.0, f64::INFINITY);
        let (mut tree, mut flat) = (Vec::new(), Vec::new());
        let corner = |random: &mut Random| {
            let texel = |random: &mut Random| (random.unit() * 2.0 * f64::from(size)).floor() * 0.5;
            face.unproject(texel(random), texel(random), 2.0, map.size())
        };
        for i in 0..12 {
            let origin = match i % 3 {
                0 => face.origin - 2.0 * axes[i % 2],
                1 => corner(&mut random),
                _ => face.origin,
            };
            let target = corner(&mut random);
            let direction = if i < 6 { axes[i / 2] } else { (target - origin).normalize_or(axes[0]) };
            let ray = DRay { origin, direction };
            traversal.lit(&ray, span, &mut tree);
            traversal.lit_flat(&ray, span, &mut flat);
            prop_assert!(well_formed(&tree, span) && well_formed(&flat, span));
        }
    }
}

/// Every sample of a dense march agrees with the intervals, except next to their ends.
#[test]
fn intervals_equal_a_dense_march_of_lookups() {
    const SAMPLES: usize = 100_000;
    let mut random = Random::new(1);
    let (mut worst, mut disagreeing, mut lit_share, mut rays) = (0.0_f64, 0_usize, 0.0, 0_usize);
    for kind in KINDS {
        for surface in SURFACES {
            for (round, relief) in RELIEFS.into_iter().cycle().take(9).enumerate() {
                let size = [(64, 48), (17, 23), (5, 64)][round / 3];
                let outside = if round % 2 == 0 { Outside::Lit } else { Outside::Dark };
                let map = map(kind, size, relief, &mut random).with_outside(outside);
                let bias = Bias::constant(if round < 4 { 0.0 } else { 0.02 }).unwrap();
                let traversal = MapTraversal::new(&map, surface, bias);
                for _ in 0..4 {
                    let ray = ray(&mut random);
                    let span = Interval::new(0.0, 8.0);
                    let mut lit = Vec::new();
                    traversal.lit(&ray, span, &mut lit);
                    let mut marched = 0_usize;
                    for i in 0..SAMPLES {
                        let x = 8.0 * (i as f64 + 0.5) / SAMPLES as f64;
                        let point = ray.at(x);
                        let by_lookup = traversal.is_lit(point);
                        if surface == MapSurface::Step {
                            let visibility = map.visibility(point, Filter::Nearest, bias);
                            assert_eq!(visibility == 1.0, by_lookup);
                        }
                        marched += usize::from(by_lookup);
                        if by_lookup != contains(&lit, x) && !near_end(&lit, x, 1e-9) {
                            disagreeing += 1;
                        }
                    }
                    let exact: f64 = lit.iter().map(Interval::length).sum::<f64>() / 8.0;
                    worst = worst.max((exact - marched as f64 / SAMPLES as f64).abs());
                    lit_share += exact;
                    rays += 1;
                }
            }
        }
    }
    let lit_share = lit_share / rays as f64;
    println!(
        "{rays} rays: largest difference of the lit share {worst:e}, {disagreeing} samples disagree, lit {lit_share}"
    );
    assert_eq!(disagreeing, 0);
    assert!(worst < 1e-4, "{worst:e}");
    assert!(lit_share > 0.2 && lit_share < 0.8, "the test sees only one outcome: {lit_share}");
}

fn airlight_over(medium: &Medium, light: &Light, ray: &DRay, lit: &[Interval]) -> f64 {
    let wide = |c: [f32; 3]| c.map(f64::from);
    let coefficients = media_math::HomogeneousMedium::<f64, [f64; 3]>::new(
        wide(medium.coefficients.sigma_s()),
        wide(medium.coefficients.sigma_a()),
    )
    .unwrap();
    let phase: PhaseFunction<f64> = medium.phase.widen();
    let sum = |piece: &Interval| match light {
        Light::Point(light) => {
            let to = light.position.as_dvec3() - ray.origin;
            let foot = Foot::new(to.to_array(), ray.direction.to_array());
            airlight(&coefficients, &phase, [1.0; 3], &foot, piece.start, piece.end)[0]
        }
        Light::Directional(light) => {
            let to_light = -light.direction.as_dvec3();
            let phase = phase.value_between(to_light.to_array(), ray.direction.to_array());
            directional_airlight(&coefficients, phase, [1.0; 3], piece.start, piece.end)[0]
        }
        Light::Spot(spot) => {
            // Simpson's rule: the falloff has no closed form
            let to = spot.position.as_dvec3() - ray.origin;
            let foot = Foot::new(to.to_array(), ray.direction.to_array());
            let steps = 2000;
            let width = piece.length() / f64::from(steps);
            (0..steps)
                .map(|i| {
                    let (a, b) = (piece.start + width * f64::from(i), piece.start + width * f64::from(i + 1));
                    let w = ray.at(0.5 * (a + b)) - spot.position.as_dvec3();
                    let intensity = spot.intensity_towards(w).x;
                    airlight(&coefficients, &phase, [intensity; 3], &foot, a, b)[0]
                })
                .sum()
        }
    };
    lit.iter().map(sum).sum()
}

/// Airlight of the exact intervals against the brute-force march with 10⁵ lookups, for every kind of light.
#[test]
fn airlight_equals_the_brute_force_march_on_the_same_map() {
    let mut random = Random::new(2);
    let medium = Medium::homogeneous([0.1; 3], [0.05; 3]).unwrap();
    let one = glam::Vec3::ONE;
    let mut worst = 0.0_f64;
    for kind in KINDS {
        for surface in SURFACES {
            for relief in RELIEFS {
                let depths = map(kind, (48, 48), relief, &mut random);
                let at = random.vector(1.0).as_vec3();
                let towards = random.direction().as_vec3();
                let light = match kind {
                    ProjectionKind::Perspective => {
                        Light::Spot(SpotLight::new(at, towards, 0.2, 0.7, one).unwrap())
                    }
                    ProjectionKind::Orthographic => {
                        Light::Directional(DirectionalLight::new(towards, one).unwrap())
                    }
                    ProjectionKind::Cube => Light::Point(PointLight::new(at, one).unwrap()),
                };
                let bounds = Aabb { min: at - 4.0, max: at + 4.0 };
                let projection = Projection::of_light(&light, &bounds, depths.size()).unwrap();
                let maps =
                    [Some(DepthMap::new(projection, depths.size(), depths.depths().to_vec()).unwrap())];
                let lights = [light];
                let exact = ExactShadowMap::new(&maps, &lights, surface, Bias::NONE).unwrap();
                let lookups: Box<dyn Visibility> = match surface {
                    MapSurface::Step => Box::new(MapVisibility::new(&maps, Filter::Nearest, Bias::NONE)),
                    MapSurface::Linear => Box::new(SurfaceVisibility::new(&maps, surface, Bias::NONE)),
                };
                let march = BruteForce {
                    medium: &medium,
                    lights: &lights,
                    occluders: Some(Occluders {
                        visibility: &*lookups,
                        bounds: Aabb { min: at - 60.0, max: at + 60.0 },
                    }),
                    samples: 100_000,
                    model: AirlightModel::Sun,
                };
                for _ in 0..6 {
                    let ray = ray(&mut random);
                    let mut lit = Vec::new();
                    exact.lit_intervals(&ray, Interval::new(0.0, 8.0), LightId(0), &mut lit);
                    let ours = airlight_over(&medium, &lights[0], &ray, &lit);
                    let whole = match &lights[0] {
                        Light::Spot(spot) => spot.clip(&ray, Interval::new(0.0, 8.0)),
                        _ => Interval::new(0.0, 8.0),
                    };
                    let unshadowed = airlight_over(&medium, &lights[0], &ray, &[whole]);
                    if unshadowed > 0.0 {
                        let marched = f64::from(march.airlight(&ray, 8.0).airlight.x);
                        worst = worst.max((ours - marched).abs() / unshadowed);
                    }
                }
            }
        }
    }
    println!("largest difference {worst:e} of the unshadowed airlight");
    assert!(worst < 1e-4, "{worst:e}");
}
