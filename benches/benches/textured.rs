//! A spot with a picture, on one core: the march in three segments, with the picture's texels and with its mips, beside the
//! brute-force march of the same light; and the hybrid for blocks of pixels beside that for each of them.
//!
//! Shadows are looked up in one map by all of them. A time means nothing without its error, so the error of every
//! picture is printed before it is timed: `shadow_err`, the share of what the shadows change at all, against the
//! quadrature over the exact pieces of that map.
#![expect(clippy::unwrap_used, reason = "a benchmark whose input is broken must stop")]
#![expect(clippy::print_stderr, reason = "the error that stands beside a time")]

use std::sync::Arc;
use std::time::Duration;

use airlight_benches::Stage;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use ground_truth::{Reference, Settings};
use hybrid_march::{
    Adjacency, BruteForce, FaceBounds, Hybrid, LightMips, LowResolution, Occluders, ShadowVolume,
};
use scene::{AirlightModel, DRay, Light, LightTexture, SpotLight, TextureFilter};
use shadowmap::{Bias, DepthMap, ExactShadowMap, Filter, MapSurface, MapVisibility, draw_maps};

const SCENE: &str = "hall";

/// Side of the pictures.
const SIDE: u32 = 64;

/// Side of the map.
const MAP: u32 = 1024;

/// Steps of the marches: those of the hybrid lie between the faces, and half as many in each lit segment.
const SAMPLES: [u32; 2] = [24, 96];

/// Bisections of each boundary that the hybrid finds.
const REFINE: u32 = 6;

/// Side of a tile of faces in pixels.
const TILE: u32 = 8;

/// Pixels along the side of a block.
const SCALE: u32 = 2;

/// Coloured panes with leads between them.
fn panes() -> LightTexture {
    let texel = |x: u32, y: u32| {
        let is_lead = x.is_multiple_of(8) || y.is_multiple_of(8);
        let colour = [(x / 8 % 3) as f32 * 0.5, (y / 8 % 4) as f32 / 3.0, ((x / 8 + y / 8) % 2) as f32];
        if is_lead { [0.0; 3] } else { colour }
    };
    let texels = (0..64).flat_map(|y| (0..64).map(move |x| texel(x, y))).collect();
    LightTexture::new(64, 64, texels, TextureFilter::Linear).unwrap()
}

/// The lamp of the benchmarks of light volumes, with or without a picture.
fn spot(picture: Option<LightTexture>) -> Light {
    let (from, to) = (Vec3::new(-6.33, 3.21, -7.16), Vec3::new(1.18, 0.48, 6.06));
    let [inner, outer] = [25.0_f32, 35.0].map(f32::to_radians);
    let spot = SpotLight::new(from, to - from, inner, outer, Vec3::splat(300.0)).unwrap();
    Light::Spot(SpotLight { texture: picture.map(Arc::new), ..spot })
}

/// A light with its map, its faces and every view ray.
struct Picture {
    stage: Stage,
    maps: Vec<Option<DepthMap>>,
    bounds: FaceBounds,
    rays: Vec<(DRay, f64)>,
}

impl Picture {
    fn new(light: Light) -> Self {
        let stage = Stage { lights: vec![light], ..Stage::new(SCENE) };
        let rays = (0..SIDE * SIDE)
            .map(|pixel| {
                let ray = stage.camera.pixel_ray(pixel % SIDE, pixel / SIDE, (SIDE, SIDE));
                let end =
                    stage.bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
                (ray, end)
            })
            .collect();
        let maps = draw_maps(&stage.lights, &stage.scene, MAP).unwrap();
        let mesh = Adjacency::of_scene(&stage.scene).unwrap();
        let volume = ShadowVolume::new(&mesh, &stage.lights[0]);
        // a map's shadows stick out of the geometry's by a texel
        let margin = maps[0].as_ref().map_or(0.0, |map| map.projection().texel(map.size()));
        let bounds = FaceBounds::draw_with_margin(&volume, &stage.camera, (SIDE, SIDE), TILE, margin);
        Self { stage, maps, bounds, rays }
    }

    fn all(&self, airlight: &dyn Fn(usize, &DRay, f64) -> DVec3) -> Vec<DVec3> {
        self.rays.iter().enumerate().map(|(index, (ray, end))| airlight(index, ray, *end)).collect()
    }

    /// The exact picture of the map, or that without shadows.
    fn exact(&self, shadows_in_medium: bool) -> Vec<DVec3> {
        let Stage { bvh, medium, lights, .. } = &self.stage;
        let settings = Settings { shadows_in_medium, ..Settings::default() };
        let reference = Reference::new(&[], bvh, medium, lights, settings).unwrap();
        let traversal = ExactShadowMap::new(&self.maps, lights, MapSurface::Step, Bias::NONE).unwrap();
        let reference = if shadows_in_medium { reference.with_shadows(&traversal) } else { reference };
        self.all(&|_, ray, end| reference.airlight(ray, end))
    }

    fn occluders<'a>(&self, visibility: &'a MapVisibility<'a>) -> Option<Occluders<'a>> {
        Some(Occluders { visibility, bounds: self.stage.bvh.bounds() })
    }

    fn brute_force(&self, samples: u32) -> Vec<DVec3> {
        let Stage { medium, lights, .. } = &self.stage;
        let visibility = MapVisibility::new(&self.maps, Filter::Nearest, Bias::NONE);
        let occluders = self.occluders(&visibility);
        let march = BruteForce { medium, lights, occluders, samples, model: AirlightModel::Sun };
        self.all(&|_, ray, end| march.airlight(ray, end).airlight.as_dvec3())
    }

    fn hybrid(&self, samples: u32, mips: &[Option<LightMips>]) -> Vec<DVec3> {
        let visibility = MapVisibility::new(&self.maps, Filter::Nearest, Bias::NONE);
        let march = self.march(samples, mips, &visibility);
        self.all(&|index, ray, end| {
            let faces = self.bounds.at(index as u32 % SIDE, index as u32 / SIDE);
            march.airlight(ray, end, &[faces]).airlight.as_dvec3()
        })
    }

    fn march<'a>(
        &'a self,
        samples: u32,
        mips: &'a [Option<LightMips>],
        visibility: &'a MapVisibility<'a>,
    ) -> Hybrid<'a> {
        let Stage { medium, lights, .. } = &self.stage;
        let occluders = self.occluders(visibility);
        let mut march = Hybrid::new(medium, lights, occluders, samples, REFINE, AirlightModel::Sun).unwrap();
        (march.lit_samples, march.mips) = (samples / 2, mips);
        march
    }

    /// The hybrid for blocks of pixels, and the way back.
    fn in_blocks(&self, samples: u32) -> Vec<DVec3> {
        let visibility = MapVisibility::new(&self.maps, Filter::Nearest, Bias::NONE);
        let march = self.march(samples, &[], &visibility);
        let (camera, low) = (&self.stage.camera, LowResolution::new((SIDE, SIDE), SCALE).unwrap());
        let full: Vec<f32> = self.rays.iter().map(|(_, end)| *end as f32).collect();
        let ends = low.ends(camera, &full).unwrap();
        let columns = low.low_size().0;
        let layers = ends.each_ref().map(|ends| {
            let block = |(&end, index): (&f32, u32)| {
                // a block of one depth has no second layer
                if end == 0.0 {
                    return Vec3::ZERO;
                }
                let (x, y) = (index % columns, index / columns);
                let faces = self.bounds.at(x * SCALE, y * SCALE);
                march.airlight(&low.low_ray(camera, x, y), end.into(), &[faces]).airlight
            };
            ends.iter().zip(0..).map(block).collect::<Vec<_>>()
        });
        let picture = low.upsample(camera, &full, [&ends[0], &ends[1]], [&layers[0], &layers[1]]).unwrap();
        picture.into_iter().map(|value| value.as_dvec3()).collect()
    }
}

/// ‖a − b‖₂.
fn distance(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>().sqrt()
}

/// Prints the error of each way to draw a picture, and times it.
fn measure(
    criterion: &mut Criterion,
    group: &str,
    picture: &Picture,
    ways: &[(String, &dyn Fn() -> Vec<DVec3>)],
) {
    let (truth, open) = (picture.exact(true), picture.exact(false));
    let mut measured = criterion.benchmark_group(group);
    measured.throughput(Throughput::Elements(u64::from(SIDE).pow(2)));
    measured.sample_size(10).measurement_time(Duration::from_secs(3));
    for (name, way) in ways {
        let error = distance(&way(), &truth) / distance(&open, &truth);
        eprintln!("{group}/{name}: shadow_err {error:.2e}");
        measured.bench_function(name, |bencher| bencher.iter(way));
    }
    measured.finish();
}

fn textured(criterion: &mut Criterion) {
    let picture = Picture::new(spot(Some(panes())));
    let mips = [Some(LightMips::new(&panes(), 0.0))];
    let [few, many] = SAMPLES;
    let ways: [(String, &dyn Fn() -> Vec<DVec3>); 6] = [
        (format!("brute force, {few} steps"), &|| picture.brute_force(few)),
        (format!("brute force, {many} steps"), &|| picture.brute_force(many)),
        (format!("hybrid, {few} steps"), &|| picture.hybrid(few, &[])),
        (format!("hybrid, {few} steps, mips"), &|| picture.hybrid(few, &mips)),
        (format!("hybrid, {many} steps, mips"), &|| picture.hybrid(many, &mips)),
        ("exact traversal".into(), &|| picture.exact(true)),
    ];
    measure(criterion, "textured_spot", &picture, &ways);
}

fn blocks(criterion: &mut Criterion) {
    let picture = Picture::new(spot(None));
    let [few, _] = SAMPLES;
    let ways: [(String, &dyn Fn() -> Vec<DVec3>); 4] = [
        (format!("brute force, {few} steps"), &|| picture.brute_force(few)),
        (format!("hybrid, {few} steps"), &|| picture.hybrid(few, &[])),
        (format!("hybrid, {few} steps, blocks of 2 x 2"), &|| picture.in_blocks(few)),
        ("unshadowed".into(), &|| picture.exact(false)),
    ];
    measure(criterion, "scattering_in_blocks", &picture, &ways);
}

criterion_group!(benches, textured, blocks);
criterion_main!(benches);
