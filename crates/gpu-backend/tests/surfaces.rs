//! Lit surfaces on the GPU equal the reference's: for every light, in every kind of medium, with and without a picture.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

mod common;

use std::sync::Arc;

use common::{Stage, compare, gpus};
use glam::{DVec2, Vec3};
use gpu_backend::{
    GpuBvh, GpuContext, Lamp, PrepareError, ReadError, Shadows, SurfaceFrame, SurfaceTriangle,
    SurfaceTriangles, Surfaces, VisibleSurfaces,
};
use ground_truth::{Reference, Settings};
use scene::{
    Aabb, Camera, Density, DensityGrid, DirectionalLight, Light, LightTexture, Medium, PointLight, SpotLight,
    TextureFilter, WideBvh,
};

/// A scene with what its view rays hit and its hierarchy on the GPU.
struct Seen {
    stage: Stage,
    distances: Vec<f32>,
    triangles: Vec<u32>,
    materials: SurfaceTriangles,
    bvh: GpuBvh,
}

impl Seen {
    fn new(gpu: &GpuContext, name: &str) -> Self {
        let stage = Stage::procedural(name, (96, 96), 1.0);
        let hit = |pixel: u32| {
            let ray = stage.camera.pixel_ray(pixel % 96, pixel / 96, stage.size);
            stage.bvh.closest_hit(&ray, f64::INFINITY).map_or(u32::MAX, |hit| hit.triangle as u32)
        };
        let triangles = (0..96 * 96).map(hit).collect();
        let materials = SurfaceTriangle::of_scene(stage.bvh.triangles(), &stage.scene.materials);
        let wide = WideBvh::build(&stage.scene).unwrap();
        Self {
            distances: stage.ends_f32(),
            triangles,
            materials: SurfaceTriangles::upload(&gpu.device, &materials).unwrap(),
            bvh: GpuBvh::upload(&gpu.device, &wide).unwrap(),
            stage,
        }
    }

    fn frame<'a>(&'a self, medium: &'a Medium, lamps: &'a [Lamp<'a>]) -> SurfaceFrame<'a> {
        SurfaceFrame {
            camera: &self.stage.camera,
            size: self.stage.size,
            visible: VisibleSurfaces { distances: &self.distances, triangles: &self.triangles },
            triangles: &self.materials,
            medium,
            lamps,
        }
    }

    fn lamp<'a>(&'a self, light: &'a Light) -> Lamp<'a> {
        let casters = self.stage.bvh.bounds();
        Lamp { light, shadows: Some(Shadows::Rays { bvh: &self.bvh, casters }), volume: None }
    }

    fn on_gpu(
        &self,
        gpu: &GpuContext,
        surfaces: &mut Surfaces,
        medium: &Medium,
        lights: &[Light],
    ) -> Vec<[f32; 3]> {
        let lamps: Vec<Lamp<'_>> = lights.iter().map(|light| self.lamp(light)).collect();
        render(gpu, surfaces, &self.frame(medium, &lamps))
    }

    /// The reference's radiance around a pixel's centre.
    fn around(&self, medium: &Medium, lights: &[Light], pixel: usize) -> Vec<[f32; 3]> {
        let Stage { scene, bvh, camera, size, .. } = &self.stage;
        let reference = Reference::surfaces(&scene.materials, bvh, medium, lights, Settings::default());
        let center = DVec2::new((pixel % 96) as f64 + 0.5, (pixel / 96) as f64 + 0.5);
        let radiance = |step: u32| {
            let at = center + EDGE * DVec2::from_angle(f64::from(step) * std::f64::consts::TAU / 16.0);
            let ray = camera.ray(at, *size);
            let hit = bvh.closest_hit(&ray, f64::INFINITY);
            hit.map_or([0.0; 3], |hit| reference.surface_radiance(&ray, &hit).as_vec3().to_array())
        };
        (0..16).map(radiance).collect()
    }

    fn on_cpu(&self, medium: &Medium, lights: &[Light]) -> Vec<[f32; 3]> {
        let Stage { scene, bvh, camera, size, ends, .. } = &self.stage;
        let reference = Reference::surfaces(&scene.materials, bvh, medium, lights, Settings::default());
        let radiance = |pixel: usize| {
            let ray = camera.pixel_ray(pixel as u32 % size.0, pixel as u32 / size.0, *size);
            bvh.hit_on(self.triangles[pixel] as usize, ends[pixel])
                .map_or([0.0; 3], |hit| reference.surface_radiance(&ray, &hit).as_vec3().to_array())
        };
        (0..ends.len()).map(radiance).collect()
    }
}

fn render(gpu: &GpuContext, surfaces: &mut Surfaces, frame: &SurfaceFrame<'_>) -> Vec<[f32; 3]> {
    surfaces.prepare(&gpu.device, &gpu.queue, frame).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    surfaces.encode(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    surfaces.read(&gpu.device, &gpu.queue).unwrap()
}

/// A homogeneous medium, one with bounds, one that thins out with height, and a density grid.
fn media(stage: &Stage) -> [(&'static str, Medium); 4] {
    let homogeneous = stage.medium.clone();
    let sigma = stage.medium.coefficients.sigma_t()[0];
    let coloured = Medium::homogeneous([0.5 * sigma, sigma, 1.5 * sigma], [0.2 * sigma; 3]).unwrap();
    let Aabb { min, max } = stage.bvh.bounds();
    let part = Aabb { min: min + 0.2 * (max - min), max: max - 0.3 * (max - min) };
    let height = Density::height(min.y + 0.3 * (max.y - min.y), 0.4 * (max.y - min.y)).unwrap();
    let grid = DensityGrid::new([3, 2, 2], part, (0..12).map(|i| i as f32 / 6.0).collect()).unwrap();
    [
        ("homogeneous", homogeneous),
        ("bounded", Medium { bounds: Some(part), ..coloured.clone() }),
        ("height", Medium { density: Some(height), ..coloured.clone() }),
        ("grid", Medium { density: Some(Density::Grid(grid)), ..coloured }),
    ]
}

/// A point and a spot light beside the eye, and a directional light from above.
fn lights(stage: &Stage) -> [Light; 3] {
    let Camera { position, right, up, forward, .. } = &stage.camera;
    let mut ends: Vec<f64> = stage.ends.iter().copied().filter(|end| end.is_finite()).collect();
    ends.sort_by(f64::total_cmp);
    let far = ends[ends.len() / 2] as f32;
    let power = far * far * Vec3::new(10.0, 8.0, 6.0);
    let beside = *position + far * (0.2 * right + 0.15 * up);
    let target = *position + far * forward;
    let sun = Vec3::new(0.35, -1.0, 0.28);
    [
        Light::Point(PointLight::new(beside, power).unwrap()),
        Light::Spot(SpotLight::new(beside, target - beside, 0.2, 0.5, power).unwrap()),
        Light::Directional(DirectionalLight::new(sun, power).unwrap()),
    ]
}

/// Largest distance of a pixel whose shadow ray may be decided differently from the shadow's edge; units: pixels.
const EDGE: f64 = 0.02;

/// Checks that pictures differ by rounding only, but for a thousandth of the pixels, which must lie at edges of shadows.
/// Returns whether anything is lit.
fn assert_alike(what: &str, seen: &Seen, medium: &Medium, lights: &[Light], gpu: &[[f32; 3]]) -> bool {
    let mut cpu = seen.on_cpu(medium, lights);
    let mean = cpu.iter().flatten().map(|&v| f64::from(v)).sum::<f64>() / (3 * cpu.len()) as f64;
    let (with_edges, _) = compare(gpu, &cpu);
    let mut off = 0;
    for (index, (a, b)) in gpu.iter().zip(&mut cpu).enumerate() {
        if a.iter().zip(&*b).any(|(a, b)| f64::from((a - b).abs()) > 0.01 * mean) {
            let around = seen.around(medium, lights, index);
            let within = |c: usize| {
                let values = || around.iter().map(|radiance| radiance[c]);
                let low = values().fold(f32::INFINITY, f32::min);
                let high = values().fold(0.0, f32::max);
                a[c] >= 0.999 * low && a[c] <= 1.001 * high
            };
            assert!((0..3).all(within), "{what}: pixel {index} is {a:?}, and {b:?} on the CPU, at no edge");
            off += 1;
            *b = *a;
        }
    }
    let (rel_rmse, _) = compare(gpu, &cpu);
    println!("{what}: rel_rmse {rel_rmse:.2e}, {with_edges:.2e} with {off} pixels at edges");
    assert!(rel_rmse <= 1e-3, "{what}: rel_rmse {rel_rmse:.2e}");
    assert!(1000 * off <= gpu.len(), "{what}: {off} pixels are off");
    mean > 0.0
}

#[test]
fn the_gpu_lights_surfaces_as_the_reference_does() {
    for gpu in gpus() {
        let mut surfaces = Surfaces::new(&gpu.device).unwrap();
        for name in ["hall", "sphere", "slats"] {
            let seen = Seen::new(&gpu, name);
            for (kind, medium) in media(&seen.stage) {
                for (light, of) in lights(&seen.stage).iter().zip(["point", "spot", "directional"]) {
                    let lights = std::slice::from_ref(light);
                    let picture = seen.on_gpu(&gpu, &mut surfaces, &medium, lights);
                    let what = format!("{name}, {kind}, {of}");
                    let lit = assert_alike(&what, &seen, &medium, lights, &picture);
                    // the sun does not come into the hall
                    assert!(lit || (name, of) == ("hall", "directional"), "{what} is dark");
                }
            }
        }
    }
}

#[test]
fn lights_add_up_and_a_spot_has_a_picture() {
    for gpu in gpus() {
        let mut surfaces = Surfaces::new(&gpu.device).unwrap();
        let seen = Seen::new(&gpu, "slats");
        let mut lamps = lights(&seen.stage);
        let texels = (0..12).map(|i| [i as f32 / 12.0, 1.0, 1.0 - i as f32 / 12.0]).collect();
        let picture = LightTexture { width: 4, height: 3, texels, filter: TextureFilter::Linear };
        if let Light::Spot(spot) = &mut lamps[1] {
            spot.texture = Some(Arc::new(picture));
        }
        let medium = &seen.stage.medium;
        for count in 1..=3 {
            let lights = &lamps[3 - count..];
            let picture = seen.on_gpu(&gpu, &mut surfaces, medium, lights);
            assert_alike(&format!("{count} lights"), &seen, medium, lights, &picture);
        }
        let dark = seen.on_gpu(&gpu, &mut surfaces, medium, &[]);
        assert!(dark.len() == 96 * 96 && dark.iter().flatten().all(|&v| v == 0.0));
    }
}

#[test]
fn without_casters_a_face_turned_to_the_light_is_lit() {
    for gpu in gpus() {
        let mut surfaces = Surfaces::new(&gpu.device).unwrap();
        let seen = Seen::new(&gpu, "slats");
        let light = &lights(&seen.stage)[2];
        let medium = Medium::homogeneous([0.0; 3], [0.0; 3]).unwrap();
        let open =
            render(&gpu, &mut surfaces, &seen.frame(&medium, &[Lamp { light, shadows: None, volume: None }]));
        let shadowed = render(&gpu, &mut surfaces, &seen.frame(&medium, &[seen.lamp(light)]));
        let lit = |picture: &[[f32; 3]]| picture.iter().filter(|pixel| pixel[0] > 0.0).count();
        assert!(open.iter().zip(&shadowed).all(|(a, b)| b == a || *b == [0.0; 3]));
        assert!(lit(&open) > lit(&shadowed) && lit(&shadowed) > 0);
    }
}

#[test]
fn what_cannot_be_lit_is_refused() {
    for gpu in gpus() {
        let mut surfaces = Surfaces::new(&gpu.device).unwrap();
        let seen = Seen::new(&gpu, "sphere");
        let (medium, light) = (&seen.stage.medium, &lights(&seen.stage)[0]);
        let mut try_frame = |frame: &SurfaceFrame<'_>| surfaces.prepare(&gpu.device, &gpu.queue, frame);
        let lamps = [seen.lamp(light)];
        let good = seen.frame(medium, &lamps);
        try_frame(&good).unwrap();
        let visible = VisibleSurfaces { triangles: &seen.triangles[1..], ..good.visible };
        let error = try_frame(&SurfaceFrame { visible, ..good }).unwrap_err();
        assert_eq!(error, PrepareError::Triangles { pixels: 96 * 96, got: 96 * 96 - 1 });
        let visible = VisibleSurfaces { distances: &seen.distances[1..], ..good.visible };
        assert!(matches!(try_frame(&SurfaceFrame { visible, ..good }), Err(PrepareError::Distances { .. })));
        let many = [seen.lamp(light); 9];
        assert!(matches!(
            try_frame(&seen.frame(medium, &many)),
            Err(PrepareError::TooManyLights { got: 9, most: 8 })
        ));
        let map = seen.stage.map(light, 16, shadowmap::MapSurface::Step).unwrap();
        let map = common::upload(&gpu, &map);
        let casters = seen.stage.bvh.bounds();
        let mapped = [Lamp { light, shadows: Some(Shadows::Map { map: &map, casters }), volume: None }];
        assert!(matches!(try_frame(&seen.frame(medium, &mapped)), Err(PrepareError::Refused(_))));
        // nothing is left of the frame before
        assert_eq!(surfaces.read(&gpu.device, &gpu.queue), Err(ReadError::Nothing("such surfaces")));
    }
}
