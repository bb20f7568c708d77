//! The signed sum against the integral over lit pieces, and lights with their volumes.

#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

mod common;

use common::{Random, Relief, map};
use glam::{DVec3, Vec3};
use ground_truth::{Reference, Settings};
use lightvolume::{Anchor, LightVolume, LightVolumeError, LightVolumes, Options, SignedAirlight};
use media_math::PhaseFunction;
use scene::{
    Aabb, AirlightModel, Bvh, DRay, Density, DirectionalLight, Interval, Light, LightId, LightTexture,
    LitIntervals, Medium, PointLight, Scene, SpotLight, TextureFilter,
};
use shadowmap::{Bias, DepthMap, ExactShadowMap, MapSurface, Projection, ProjectionKind};
use std::sync::Arc;

/// A point light, a soft spot and a sun.
fn lights() -> [Light; 3] {
    let spot = SpotLight::new(
        Vec3::new(0.3, 2.0, -0.4),
        Vec3::new(0.1, -1.0, 0.2),
        0.3,
        0.7,
        Vec3::new(2.0, 5.0, 3.0),
    );
    [
        Light::Point(PointLight::new(Vec3::new(0.5, 1.0, -0.3), Vec3::new(3.0, 2.0, 1.0)).unwrap()),
        Light::Spot(spot.unwrap()),
        Light::Directional(DirectionalLight::new(Vec3::new(0.2, -1.0, 0.3), Vec3::ONE).unwrap()),
    ]
}

/// A map of some relief as `light` would see it.
fn map_of(light: &Light, n: u32, relief: Relief, random: &mut Random) -> DepthMap {
    let kind = match light {
        Light::Point(_) => ProjectionKind::Cube,
        Light::Spot(_) => ProjectionKind::Perspective,
        Light::Directional(_) => ProjectionKind::Orthographic,
    };
    let depths = map(kind, (n, n), relief, random).depths().to_vec();
    let bounds = Aabb { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };
    let projection = Projection::of_light_for(light, &bounds, (n, n), MapSurface::Linear).unwrap();
    DepthMap::new(projection, (n, n), depths).unwrap()
}

fn ray(random: &mut Random) -> (DRay, f64) {
    let end = if random.unit() < 0.3 { f64::INFINITY } else { random.between(0.5, 12.0) };
    (DRay { origin: random.vector(3.0), direction: random.direction() }, end)
}

fn media() -> [Medium; 2] {
    let plain = Medium::homogeneous([0.1, 0.2, 0.05], [0.05, 0.0, 0.1]).unwrap();
    let forward = Medium { phase: PhaseFunction::henyey_greenstein(0.6).unwrap(), ..plain.clone() };
    [plain, forward]
}

#[test]
fn lights_have_the_pieces_of_the_exact_traversal() {
    let random = &mut Random::new(31);
    let lights = lights();
    for relief in [Relief::Noise, Relief::Spots] {
        // no hole in the sun's map: there the traversal has no surface at all
        let maps: Vec<Option<DepthMap>> = lights
            .iter()
            .map(|light| {
                let map = map_of(light, 20, relief, random);
                Some(if let Light::Directional(_) = light { map.clamped(50.0).unwrap() } else { map })
            })
            .collect();
        let volumes: Vec<_> = maps
            .iter()
            .map(|map| map.as_ref().map(|map| LightVolume::build(map, &Options::default()).unwrap()))
            .collect();
        let own = LightVolumes::new(&volumes, &lights).unwrap();
        assert!(own.bytes() > 0);
        let exact = ExactShadowMap::new(&maps, &lights, MapSurface::Linear, Bias::NONE).unwrap();
        let (mut a, mut b) = (Vec::new(), Vec::new());
        let mut pieces = 0;
        for _ in 0..1000 {
            let (ray, end) = ray(random);
            // the sun's shadow ends at the far plane here, and nowhere there
            let span = Interval::new(0.0, end.min(1e4));
            for id in (0..3).map(LightId) {
                own.lit_intervals(&ray, span, id, &mut a);
                exact.lit_intervals(&ray, span, id, &mut b);
                let total = |pieces: &[Interval]| pieces.iter().map(Interval::length).sum::<f64>();
                let common = a.iter().flat_map(|p| b.iter().map(|q| p.intersect(*q).length().max(0.0)));
                let apart = total(&a) + total(&b) - 2.0 * common.sum::<f64>();
                assert!(apart < 1e-8, "light {id:?} {ray:?} {span:?}: {a:?} {b:?}");
                assert!(a.windows(2).all(|pair| pair[0].end < pair[1].start));
                pieces += a.len();
            }
        }
        assert!(pieces > 2000, "{pieces}");
    }
}

#[test]
fn the_signed_sum_is_the_integral_over_lit_pieces() {
    let random = &mut Random::new(32);
    let scene = Scene::default();
    let bvh = Bvh::build(&scene).unwrap();
    for light in lights() {
        // near and far anchor, f64 and f32: error as a share of the unshadowed airlight
        let mut worst = [[0.0_f64; 2]; 2];
        let lights = [light];
        for (relief, medium) in [Relief::Noise, Relief::Spots].into_iter().zip(media()) {
            let map = map_of(&lights[0], 32, relief, random);
            let volumes = [Some(LightVolume::build(&map, &Options::default()).unwrap())];
            let own = LightVolumes::new(&volumes, &lights).unwrap();
            let reference = |shadows_in_medium| {
                let settings = Settings { shadows_in_medium, ..Settings::default() };
                Reference::new(&scene.materials, &bvh, &medium, &lights, settings).unwrap()
            };
            let (open, shadowed) = (reference(false), reference(true).with_shadows(&own));
            for (i, anchor) in [Anchor::Near, Anchor::Far].into_iter().enumerate() {
                let wide = SignedAirlight::<f64>::new(&medium, &own, anchor).unwrap();
                let narrow = SignedAirlight::<f32>::new(&medium, &own, anchor).unwrap();
                for _ in 0..500 {
                    let (ray, end) = ray(random);
                    let (unshadowed, exact) = (open.airlight(&ray, end), shadowed.airlight(&ray, end));
                    if unshadowed.min_element() < 1e-12 {
                        continue;
                    }
                    let error = |got: DVec3| ((got - exact) / unshadowed).abs().max_element();
                    let (f64, f32) = (wide.airlight(&ray, end), narrow.airlight(&ray, end).map(f64::from));
                    worst[i][0] = worst[i][0].max(error(f64.into()));
                    worst[i][1] = worst[i][1].max(error(f32.into()));
                }
            }
        }
        println!("{:?}: {worst:?}", lights[0]);
        for [f64, f32] in worst {
            assert!(f64 < 1e-10 && f32 < 2e-5 && f32 > 1e-8, "{f64:e} {f32:e}");
        }
    }
}

#[test]
fn lights_and_volumes_belong_together() {
    let random = &mut Random::new(33);
    let lights = lights();
    let volume = |i: usize, random: &mut Random| {
        let map = map_of(&lights[i], 4, Relief::Ramp, random);
        Some(LightVolume::build(&map, &Options::default()).unwrap())
    };
    let error =
        |volumes: &[Option<LightVolume>]| LightVolumes::new(volumes, &lights).map(|_| ()).unwrap_err();
    assert_eq!(error(&[None]), LightVolumeError::Count { lights: 3, volumes: 1 });
    let wrong = error(&[None, None, volume(0, random)]);
    assert_eq!(wrong.to_string(), "light 2: the volume of a cube map cannot serve a directional light");
    assert!(matches!(
        error(&[volume(1, random), None, None]),
        LightVolumeError::WrongVolume { light: 0, .. }
    ));
    // a spot may stand in a cube
    let volumes = [None, volume(0, random), None];
    let own = LightVolumes::new(&volumes, &lights).unwrap();
    let mut out = Vec::new();
    let ray = DRay { origin: DVec3::new(0.0, 9.0, 0.0), direction: DVec3::X };
    own.lit_intervals(&ray, Interval::new(0.0, 5.0), LightId(0), &mut out);
    assert_eq!(out, [Interval::new(0.0, 5.0)]);
    own.lit_intervals(&ray, Interval::new(0.0, 5.0), LightId(1), &mut out);
    assert!(out.is_empty(), "above the spot");
}

#[test]
fn refusals_name_the_technique() {
    let [medium, _] = media();
    let [point, spot, sun] = lights();
    let Light::Spot(mut spot) = spot else { panic!() };
    spot.texture = Some(Arc::new(LightTexture::new(1, 1, vec![[1.0; 3]], TextureFilter::Linear).unwrap()));
    let check = |medium: &Medium, light: &Light, model| {
        SignedAirlight::<f32>::check(medium, std::slice::from_ref(light), model)
    };
    let sun_model = AirlightModel::Sun;
    assert!(check(&medium, &point, sun_model).is_ok());
    let refusal = check(&medium, &Light::Spot(spot), sun_model).unwrap_err();
    assert_eq!(refusal.to_string(), "light-volume cannot take a textured spot light; use brute-force");
    let fog = Medium { density: Some(Density::height(0.0, 1.0).unwrap()), ..medium.clone() };
    let glow = Medium { emission: [0.1; 3], ..medium.clone() };
    let boxed = Medium { bounds: Some(Aabb { min: Vec3::ZERO, max: Vec3::ONE }), ..medium.clone() };
    for medium in [&fog, &glow, &boxed] {
        assert_eq!(check(medium, &point, sun_model).unwrap_err().technique, "light-volume");
    }
    assert!(check(&medium, &point, AirlightModel::HoffmanPreetham).is_err());
    assert!(check(&medium, &sun, AirlightModel::HoffmanPreetham).is_ok());
}
