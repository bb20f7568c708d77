//! The hybrid march on the GPU against the one on the CPU, pixel by pixel, on the same map.
//!
//! With faces for every pixel both march between the same distances and see the same steps. With faces by tile the CPU's
//! bounds are a little tighter (it clips faces to the image), so steps lie elsewhere and what is left of each one's own error
//! differs: there enough steps are taken for that to be less than the bar.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "test code, and the figures behind its verdicts"
)]

mod common;

use std::sync::Arc;

use common::{Stage, compare, fog, gpu, gpus, render, upload};
use glam::Vec3;
use gpu_backend::{
    AirlightForm, Faces, Fog, Frame, GpuBvh, GpuContext, Hybrid, Lamp, LightPicture, Lookup, Placement,
    PrepareError, Sampling, SceneDepth, ShadowCasters, ShadowMap, ShadowVolume, Shadows, Technique, View,
};
use hybrid_march::{Adjacency, FaceBounds, LightMips, LowResolution, Occluders, Silhouette};
use scene::{
    Aabb, AirlightModel, BvhVisibility, Camera, Light, LightTexture, Material, Mesh, PointLight, Scene,
    SpotLight, TextureFilter, Visibility, WideBvh,
};
use shadowmap::{Bias, Filter, MapSurface, MapVisibility};

/// GPU against CPU, as a share of the picture.
const AGREE: f64 = 1e-3;

const KINDS: [&str; 3] = ["point", "spot", "directional"];

/// One light with its volume on both sides.
struct Case<'a> {
    stage: &'a Stage,
    light: &'a Light,
    mesh: Adjacency,
    hybrid: Hybrid,
    model: AirlightModel,
    scale: u32,
}

impl<'a> Case<'a> {
    fn new(stage: &'a Stage, light: &'a Light, hybrid: Hybrid) -> Self {
        let mesh = Adjacency::of_scene(&stage.scene).unwrap();
        Self { stage, light, mesh, hybrid, model: AirlightModel::Sun, scale: 1 }
    }

    fn on_gpu(&self, gpu: &GpuContext, fog: &mut Fog, shadows: Shadows<'_>) -> Vec<[f32; 3]> {
        let casters = ShadowCasters::upload(&gpu.device, &self.mesh).unwrap();
        let volume = ShadowVolume::new(&gpu.device, Arc::new(casters)).unwrap();
        self.with_volume(gpu, fog, shadows, &volume)
    }

    fn with_volume(
        &self,
        gpu: &GpuContext,
        fog: &mut Fog,
        shadows: Shadows<'_>,
        volume: &ShadowVolume,
    ) -> Vec<[f32; 3]> {
        let ends = self.stage.ends_f32();
        let view = View {
            camera: &self.stage.camera,
            size: self.stage.size,
            depth: SceneDepth::Distances(&ends),
            max_distance: f64::INFINITY,
        };
        let frame = Frame {
            views: &[view],
            medium: &self.stage.medium,
            lamps: &[Lamp { light: self.light, shadows: Some(shadows), volume: Some(volume) }],
            model: self.model,
            technique: Technique::Hybrid(self.hybrid),
            sampling: Sampling::Blocks { scale: self.scale, anew_at_edges: true },
        };
        render(gpu, fog, &frame)
    }

    fn on_cpu(&self, visibility: &dyn Visibility, margin: f64) -> Vec<[f32; 3]> {
        let stage = self.stage;
        let volume = hybrid_march::ShadowVolume::new(&self.mesh, self.light);
        let tile = match self.hybrid.faces {
            Faces::Pixels => 1,
            Faces::Tiles(side) => side,
        };
        let margin = if tile == 1 { 0.0 } else { margin };
        let bounds = FaceBounds::draw_with_margin(&volume, &stage.camera, stage.size, tile, margin);
        let lights = std::slice::from_ref(self.light);
        let occluders = Occluders { visibility, bounds: stage.bvh.bounds() };
        let Hybrid { samples, refine, .. } = self.hybrid;
        let mut march =
            hybrid_march::Hybrid::new(&stage.medium, lights, Some(occluders), samples, refine, self.model)
                .unwrap();
        let mips = [match (self.light, self.hybrid.picture) {
            (Light::Spot(spot), LightPicture::Mips { blur }) => {
                spot.texture.as_ref().map(|picture| LightMips::new(picture, blur))
            }
            _ => None,
        }];
        march.mips = &mips;
        march.lit_samples = self.hybrid.lit_samples;
        march.placement = self.hybrid.placement;
        march.partial = self.hybrid.partial;
        let pixel = |x: u32, y: u32, ray: &scene::DRay, end: f64| {
            march.airlight(ray, end, &[bounds.at(x, y)]).airlight
        };
        let (width, height) = stage.size;
        if self.scale == 1 {
            let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            return pixels
                .map(|(x, y)| {
                    let ray = stage.camera.pixel_ray(x, y, stage.size);
                    pixel(x, y, &ray, stage.ends[(y * width + x) as usize]).to_array()
                })
                .collect();
        }
        let low = LowResolution::new(stage.size, self.scale).unwrap();
        let full = stage.ends_f32();
        let ends = low.ends(&stage.camera, &full).unwrap();
        let columns = low.low_size().0;
        let layers = ends.each_ref().map(|ends| {
            let blocks = ends.iter().zip(0..);
            let value = |(&end, index): (&f32, u32)| {
                let (x, y) = (index % columns, index / columns);
                let ray = low.low_ray(&stage.camera, x, y);
                // a light without shadows: its faces do not matter
                if end == 0.0 { Vec3::ZERO } else { march.airlight(&ray, end.into(), &[None]).airlight }
            };
            blocks.map(value).collect::<Vec<_>>()
        });
        let low_ends = [&ends[0][..], &ends[1][..]];
        let picture = low.upsample(&stage.camera, &full, low_ends, [&layers[0], &layers[1]]).unwrap();
        let edges = low.edges(&stage.camera, &full, low_ends).unwrap();
        assert!(edges.contains(&true) && edges.contains(&false));
        let anew = |index: u32| {
            let ray = stage.camera.pixel_ray(index % width, index / width, stage.size);
            march.airlight(&ray, stage.ends[index as usize], &[None]).airlight
        };
        let value = |((value, edge), index)| if edge { anew(index) } else { value };
        picture.into_iter().zip(edges).zip(0..).map(value).map(|value| value.to_array()).collect()
    }
}

/// On a map of 512 texels: what is beyond the bar.
fn agree(gpu: &GpuContext, case: &Case<'_>, name: &str) -> Option<String> {
    let map = [case.stage.map(case.light, 512, MapSurface::Step)];
    let visibility = MapVisibility::new(&map, Filter::Nearest, Bias::NONE);
    let map = map[0].as_ref().unwrap();
    let uploaded = upload(gpu, map);
    let shadows = Shadows::Map { map: &uploaded, casters: case.stage.bvh.bounds() };
    let got = case.on_gpu(gpu, &mut fog(gpu), shadows);
    let (rmse, p99) = compare(&got, &case.on_cpu(&visibility, map.projection().texel(map.size())));
    println!("{name}, {:?}: rel_rmse {rmse:.2e} p99 {p99:.2e}", case.stage.size);
    (rmse > AGREE).then(|| format!("{name}: rel_rmse {rmse:.2e}"))
}

const SCENES: [&str; 7] = ["sphere", "spring", "blob-24k", "hall", "fence", "slats", "lampshade"];

#[test]
fn marches_between_exact_faces_agree() {
    let mut beyond = Vec::new();
    // with float32 blending and without: faces are found by one draw, or by two and a merge
    for gpu in gpus() {
        for scene in SCENES {
            let stage = Stage::procedural(scene, (64, 64), 1.0);
            for (kind, light) in KINDS.iter().zip(stage.lights()) {
                let hybrid = Hybrid { samples: 50, faces: Faces::Pixels, ..Hybrid::default() };
                beyond.extend(agree(&gpu, &Case::new(&stage, &light, hybrid), &format!("{scene} {kind}")));
            }
        }
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
}

#[test]
fn marches_between_faces_by_tile_agree() {
    let Some(gpu) = gpu() else { return };
    let mut beyond = Vec::new();
    for scene in SCENES {
        let stage = Stage::procedural(scene, (64, 64), 1.0);
        for (kind, light) in KINDS.iter().zip(stage.lights()) {
            let hybrid = Hybrid { samples: 1000, refine: 10, ..Hybrid::default() };
            beyond.extend(agree(&gpu, &Case::new(&stage, &light, hybrid), &format!("{scene} {kind}")));
        }
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
}

#[test]
fn marches_by_shadow_rays_agree() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::procedural("sphere", (48, 48), 1.0);
    let wide = WideBvh::build(&stage.scene).unwrap();
    let bvh = GpuBvh::upload(&gpu.device, &wide).unwrap();
    for (kind, light) in KINDS.iter().zip(stage.lights()) {
        let hybrid = Hybrid { samples: 50, faces: Faces::Pixels, ..Hybrid::default() };
        let case = Case::new(&stage, &light, hybrid);
        let shadows = Shadows::Rays { bvh: &bvh, casters: stage.bvh.bounds() };
        let got = case.on_gpu(&gpu, &mut fog(&gpu), shadows);
        let lights = [light.clone()];
        let want = case.on_cpu(&BvhVisibility::new(&stage.bvh, &lights), 0.0);
        let (rmse, _) = compare(&got, &want);
        println!("{kind}: rel_rmse {rmse:.2e}");
        assert!(rmse <= AGREE, "{kind}: rel_rmse {rmse:.2e}");
    }
}

/// A light in a closed box, which one pixel looks straight at: so near to its ray that beside a right angle single precision
/// leaves nothing of the distances along it. Nothing is lit.
#[test]
fn a_boxed_light_stays_dark_where_a_ray_leads_straight_to_it() {
    let Some(gpu) = gpu() else { return };
    let corners = Aabb::around([Vec3::splat(-0.5), Vec3::splat(0.5)]);
    let positions = hybrid_march::bounding_box(&corners).concat();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let scene = Scene {
        meshes: vec![Mesh::new(positions, triangles, 0).unwrap()],
        materials: vec![Material::default()],
        ..Scene::default()
    };
    let camera = Camera::look_at(Vec3::new(0.3, 0.4, 4.0), Vec3::ZERO, Vec3::Y, 0.8).unwrap();
    // odd, so that one pixel looks exactly where the camera does
    let stage = Stage::new("box", scene, camera, (9, 9), 1.0);
    let light = Light::Point(PointLight::new(Vec3::ZERO, Vec3::splat(10.0)).unwrap());
    let bvh = GpuBvh::upload(&gpu.device, &WideBvh::build(&stage.scene).unwrap()).unwrap();
    for faces in [Faces::Pixels, Hybrid::default().faces] {
        let case = Case::new(&stage, &light, Hybrid { faces, ..Hybrid::default() });
        let shadows = Shadows::Rays { bvh: &bvh, casters: stage.bvh.bounds() };
        let got = case.on_gpu(&gpu, &mut fog(&gpu), shadows);
        let lit: Vec<_> = got.iter().enumerate().filter(|(_, value)| value[0] > 0.0).collect();
        assert!(lit.is_empty(), "{faces:?}: {lit:?}");
    }
}

/// Hills on four metres a side.
fn hills(side: u32) -> Scene {
    let at = |i: u32| {
        let [x, z] = [i % side, i / side].map(|k| 4.0 * (k as f32 / side as f32 - 0.5));
        Vec3::new(x, 0.35 * ((5.0 * x).sin() * (4.0 * z).cos()) + 0.02 * (90.0 * x).sin() - 0.3, z)
    };
    let cells = (0..side * (side - 1)).filter(|i| (i + 1) % side != 0);
    let triangles = cells.flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]).collect();
    let mesh = Mesh::new((0..side * side).map(at).collect(), triangles, 0).unwrap();
    Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() }
}

/// View rays without an end over a large mesh, with faces thousands of scenes away: to a shadow ray from there the whole
/// hierarchy is one line. It would visit all of it, and some drivers end all loops of a ray after 65,535 trips: what came
/// after would be lit.
#[test]
fn nothing_is_asked_where_no_light_is_left() {
    let Some(gpu) = gpu() else { return };
    let camera = Camera::look_at(Vec3::new(0.3, 0.4, 4.0), Vec3::ZERO, Vec3::Y, 0.8).unwrap();
    let stage = Stage::new("hills", hills(200), camera, (17, 17), 1.0);
    let light = Light::Point(PointLight::new(Vec3::new(0.3, 0.35, -1.2), Vec3::splat(10.0)).unwrap());
    let bvh = GpuBvh::upload(&gpu.device, &WideBvh::build(&stage.scene).unwrap()).unwrap();
    let case = Case::new(&stage, &light, Hybrid { samples: 48, ..Hybrid::default() });
    let shadows = Shadows::Rays { bvh: &bvh, casters: stage.bvh.bounds() };
    let got = case.on_gpu(&gpu, &mut fog(&gpu), shadows);
    let lights = [light.clone()];
    let want = case.on_cpu(&BvhVisibility::new(&stage.bvh, &lights), 0.0);
    let (rmse, _) = compare(&got, &want);
    println!("rel_rmse {rmse:.2e}");
    assert!(rmse <= AGREE, "rel_rmse {rmse:.2e}");
}

/// Panes with leads between them.
fn window(filter: TextureFilter) -> Arc<LightTexture> {
    let colour = |x: u32, y: u32| {
        let pane = (x / 5 + 3 * (y / 7)) % 5;
        let lead = u32::is_multiple_of(x, 5) || u32::is_multiple_of(y, 7);
        if lead {
            [0.02; 3]
        } else {
            [pane as f32 * 0.2, 1.0 - pane as f32 * 0.15, 0.3 + (y % 3) as f32 * 0.2]
        }
    };
    // no power of two: levels are rounded down
    let texels = (0..37).flat_map(|y| (0..45).map(move |x| colour(x, y))).collect();
    Arc::new(LightTexture::new(45, 37, texels, filter).unwrap())
}

#[test]
fn textured_spots_agree() {
    let mut beyond = Vec::new();
    for gpu in gpus() {
        let stage = Stage::procedural("sphere", (48, 48), 1.0);
        let Light::Spot(spot) = stage.lights().remove(1) else { panic!("a spot") };
        for filter in [TextureFilter::Linear, TextureFilter::Nearest] {
            let light = Light::Spot(SpotLight { texture: Some(window(filter)), ..spot.clone() });
            for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
                for placement in [Placement::EqualAngle, Placement::EqualDistance] {
                    for picture in [LightPicture::Point, LightPicture::Mips { blur: 0.0 }] {
                        let hybrid = Hybrid {
                            samples: 48,
                            lit_samples: 24,
                            placement,
                            picture,
                            faces: Faces::Pixels,
                            partial: placement == Placement::EqualDistance,
                            ..Hybrid::default()
                        };
                        let case = Case { model, ..Case::new(&stage, &light, hybrid) };
                        let name = format!("{filter:?} {model:?} {placement:?} {picture:?}");
                        beyond.extend(agree(&gpu, &case, &name));
                    }
                }
            }
        }
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
}

/// A light that nothing shadows, so that only the blocks and the way back from them are compared.
#[test]
fn lower_resolutions_agree() {
    for gpu in gpus() {
        // sides that blocks do not divide
        let stage = Stage::procedural("sphere", (61, 43), 1.0);
        let light = stage.lights().remove(0);
        for scale in [2, 3, 4] {
            let case = Case { scale, ..Case::new(&stage, &light, Hybrid::default()) };
            let ends = stage.ends_f32();
            let view = View {
                camera: &stage.camera,
                size: stage.size,
                depth: SceneDepth::Distances(&ends),
                max_distance: f64::INFINITY,
            };
            let frame = Frame {
                views: &[view],
                medium: &stage.medium,
                lamps: &[Lamp { light: &light, shadows: None, volume: None }],
                model: AirlightModel::Sun,
                technique: Technique::Hybrid(case.hybrid),
                sampling: Sampling::Blocks { scale, anew_at_edges: true },
            };
            let got = render(&gpu, &mut fog(&gpu), &frame);
            let want = case.on_cpu(&scene::Unoccluded, 0.0);
            let (rmse, p99) = compare(&got, &want);
            println!("scale {scale}: rel_rmse {rmse:.2e} p99 {p99:.2e}");
            assert!(rmse <= AGREE, "scale {scale}: rel_rmse {rmse:.2e}");
        }
    }
}

#[test]
fn a_silhouette_is_found_once_for_a_light_that_stays() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::procedural("knot-188k", (32, 32), 1.0);
    let lights = stage.lights();
    let map = upload(&gpu, &stage.map(&lights[0], 64, MapSurface::Step).unwrap());
    let mut fog = fog(&gpu);
    let mut case = Case::new(&stage, &lights[0], Hybrid::default());
    let casters = Arc::new(ShadowCasters::upload(&gpu.device, &case.mesh).unwrap());
    let volume = ShadowVolume::new(&gpu.device, Arc::clone(&casters)).unwrap();
    let shadows = Shadows::Map { map: &map, casters: stage.bvh.bounds() };
    let mut found = Vec::new();
    for moves in [false, false, true] {
        if moves {
            volume.touch();
        }
        case.with_volume(&gpu, &mut fog, shadows, &volume);
        found.push(fog.stats().silhouettes_found);
        assert_eq!(fog.stats().passes.iter().filter(|pass| *pass == "silhouette").count(), found.len() % 2);
    }
    assert_eq!(found, [1, 0, 1]);
    // the same edges as on the CPU, but for triangles that the light lies in the plane of
    let count = volume.read_edge_count(&gpu.device, &gpu.queue).unwrap();
    let exact = Silhouette::of(&case.mesh, &lights[0]).edges.len();
    println!("{count} silhouette edges, {exact} on the CPU");
    assert!(exact > 1000 && (i64::from(count) - exact as i64).unsigned_abs() < 20, "{count} {exact}");
    // another light needs another silhouette
    let moved = lights[1].clone();
    let map = upload(&gpu, &stage.map(&moved, 64, MapSurface::Step).unwrap());
    case.light = &moved;
    let shadows = Shadows::Map { map: &map, casters: stage.bvh.bounds() };
    case.with_volume(&gpu, &mut fog, shadows, &volume);
    assert_eq!(fog.stats().silhouettes_found, 1);
}

#[test]
fn what_is_missing_is_said() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::procedural("sphere", (8, 8), 1.0);
    let lights = stage.lights();
    let map: ShadowMap = upload(&gpu, &stage.map(&lights[0], 16, MapSurface::Step).unwrap());
    let shadows = Some(Shadows::Map { map: &map, casters: stage.bvh.bounds() });
    let ends = stage.ends_f32();
    let view = View {
        camera: &stage.camera,
        size: stage.size,
        depth: SceneDepth::Distances(&ends),
        max_distance: f64::INFINITY,
    };
    let mut fog = fog(&gpu);
    let mut prepare = |hybrid: Hybrid, scale: u32, model: AirlightModel| {
        let frame = Frame {
            views: &[view],
            medium: &stage.medium,
            lamps: &[Lamp { light: &lights[0], shadows, volume: None }],
            model,
            technique: Technique::Hybrid(hybrid),
            sampling: Sampling::Blocks { scale, anew_at_edges: true },
        };
        fog.prepare(&gpu.device, &gpu.queue, &frame).unwrap_err()
    };
    let (plain, sun) = (Hybrid::default(), AirlightModel::Sun);
    assert!(matches!(prepare(plain, 1, sun), PrepareError::NoVolume { light: 0 }));
    for scale in [0, 65] {
        assert!(matches!(prepare(plain, scale, sun), PrepareError::ScatteringScale { .. }));
    }
    let refused = |error: PrepareError, text: &str| {
        assert!(matches!(error, PrepareError::Refused(_)) && error.to_string().contains(text), "{error}");
    };
    refused(prepare(Hybrid { partial: true, ..plain }, 1, sun), "a part of the casters");
    refused(prepare(Hybrid { samples: 9000, ..plain }, 1, sun), "8192");
    refused(prepare(plain, 1, AirlightModel::HoffmanPreetham), "point light");
    let variance = Hybrid { lookup: Lookup::Variance, ..plain };
    let error = prepare(variance, 1, sun);
    assert!(matches!(error, PrepareError::NoVolume { .. } | PrepareError::NoMoments { .. }), "{error}");
}

/// Tables against the interval form: what they cost in accuracy with the light in view, and out of it.
#[test]
fn tables_come_close_to_the_interval_form() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        let stage = Stage::procedural("sphere", (64, 64), 1.0);
        let light = stage.lights().remove(0);
        let map = upload(&gpu, &stage.map(&light, 256, MapSurface::Step).unwrap());
        let shadows = Shadows::Map { map: &map, casters: stage.bvh.bounds() };
        let mut with = |form| {
            let hybrid = Hybrid { faces: Faces::Pixels, form, ..Hybrid::default() };
            let picture = Case::new(&stage, &light, hybrid).on_gpu(&gpu, &mut fog, shadows);
            let filled = fog.stats().passes.iter().filter(|pass| pass.ends_with("table")).count();
            assert_eq!(filled, usize::from(form != AirlightForm::Interval), "{:?}", fog.stats().passes);
            picture
        };
        let exact = with(AirlightForm::Interval);
        let (angles, _) = compare(&with(AirlightForm::AngleTable { size: 256 }), &exact);
        let (printed, _) = compare(&with(AirlightForm::FrameTable { size: 256 }), &exact);
        println!("rel_rmse over angles {angles:.2e}, as printed {printed:.2e}");
        assert!(angles < 1e-3 && printed < 0.1 && angles < printed, "{angles:.2e} {printed:.2e}");
    }
}
